"""Which findings go into a vehicle file, and what the file says of the others."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.cli.finish import BAD_INPUT, COMPLETED
from companion.cli.vehicle_making import keep
from companion.identification.description import Description, Entry, Source
from companion.identification.from_log import SPEED_WANTED, Findings, better_log, with_findings
from companion.identification.parameters import describe_parameters
from companion.identification.rate_fit import Found
from companion.identification.ulog import Series


@pytest.fixture
def base(found: Findings) -> Description:
    """What PX4's parameters in the log say."""
    return describe_parameters(found.log.parameters, name="mine")


def kept_line(text: str) -> str:
    """What the file says of what it did not take; empty where it took everything."""
    return next((line for line in text.splitlines() if "left as it was" in line), "")


def test_drag_of_a_slow_flight_stays_as_it_was(base: Description, found: Findings) -> None:
    """The advice and the file go by the same speed."""
    sure = found.forces._replace(drag=Found(0.3, 0.01))
    for speed, taken in ((0.5, False), (SPEED_WANTED, True)):
        flight = found._replace(forces=sure._replace(speed=speed))
        file = with_findings(base, flight, ())
        assert any("tell little of drag" in line for line in better_log(flight)) is not taken
        assert file.data["drag_per_s"] == (0.3 if taken else base.data["drag_per_s"])
        assert (file.entries["drag_per_s"].source is Source.LOG) is taken
        assert ("drag_per_s (0.3 +- 0.01; 0.5 m/s RMS, 2.5 tell it)" in kept_line(file.text)) is not taken


@pytest.mark.parametrize(
    ("every", "excitation", "lag", "said"),
    [
        (1, 0.5, 0.05, ""),
        (5, 0.5, 0.03, "0.03 +- 0.0012; samples every 20 ms tell none under 50 ms"),
        (5, 0.5, 0.055, ""),
        (1, 0.08, 0.05, "0.05 +- 0.0012; roll or pitch moved by 0.08 rad/s RMS, 0.15 tell it"),
    ],
)
def test_a_motor_lag_that_the_log_cannot_tell_stays_as_it_was(
    base: Description, found: Findings, every: int, excitation: float, lag: float, said: str
) -> None:
    """PX4's default profile logs the gyro every 20 ms: a fit of that is surer than it is right."""
    t, x = found.log.topics["vehicle_angular_velocity"]
    thinned = Series(t[::every], x[::every])
    roll, pitch, yaw = (axis._replace(motor_lag=Found(lag, 0.002)) for axis in found.axes)
    flight = found._replace(
        log=found.log._replace(topics={**found.log.topics, "vehicle_angular_velocity": thinned}),
        axes=(roll._replace(excitation=excitation), pitch, yaw),
        forces=found.forces._replace(motor_lag=Found(lag, 0.002)),
    )
    file = with_findings(base, flight, ())
    assert f"motor_lag_s ({said})" in kept_line(file.text) if said else "motor_lag_s" not in kept_line(file.text)
    assert file.data["motor_lag_s"] == (base.data["motor_lag_s"] if said else lag)


def test_a_file_that_would_not_load_is_not_written_over_another(
    base: Description, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    slow = dataclasses.replace(base, entries={**base.entries, "rate_loop_lag_s": Entry(1.26, Source.LOG, "+- 0.09 s")})
    file = tmp_path / "mine.yaml"
    assert keep(slow, file) == BAD_INPUT
    assert "written, but it cannot all be true; correct it" in capsys.readouterr().err
    assert "rate_loop_lag_s: 1.26" in file.read_text()  # to be corrected by hand
    assert keep(base, file) == COMPLETED
    before = file.read_text()
    assert keep(slow, file) == BAD_INPUT
    said = capsys.readouterr().err
    assert "is left as it was" in said and "rate_loop_lag_s: 1.26 is too large" in said
    assert file.read_text() == before


def test_a_value_at_its_bound_stays_as_it_was(base: Description, found: Findings) -> None:
    beyond = Found(1.5, math.inf)
    roll, pitch, yaw = (axis._replace(lag=beyond) for axis in found.axes)
    one = with_findings(base, found._replace(axes=(roll, found.axes[1], yaw)), ())
    assert one.data["rate_loop_lag_s"] == pytest.approx(found.axes[1].lag.value, rel=0.01)
    assert "roll not found" in one.text
    none = with_findings(base, found._replace(axes=(roll, pitch, yaw)), ())
    assert none.data["rate_loop_lag_s"] == base.data["rate_loop_lag_s"]
    assert "rate_loop_lag_s (not found)" in kept_line(none.text)


def test_a_simulators_figures_are_told_as_a_simulators(
    found: Findings, log_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("companion.cli.vehicle_making.identify", lambda log: found)
    for hardware, parameters, words in (
        ("PX4_FMU_V5", {}, ""), ("PX4_SITL", {}, "PX4_SITL"), ("PX4_FMU_V5", {"SYS_HITL": 1.0}, "SYS_HITL 1"),
        ("PX4_FMU_V5", {"SYS_AUTOSTART": 1100.0}, "SYS_AUTOSTART 1100"),
    ):  # fmt: skip
        real = {"SYS_HITL": 0.0, "SYS_AUTOSTART": 4052.0}
        log = found.log._replace(hardware=hardware, parameters={**found.log.parameters, **real, **parameters})
        assert log.simulator == words
        monkeypatch.setattr("companion.cli.vehicle_making.read_log", lambda file, name, log=log: log)
        file = tmp_path / "mine.yaml"
        told = CliRunner().invoke(app, ["vehicle", "from-log", str(log_file), str(file), "--force"])
        assert told.exit_code == 0
        said = f"The log is of a simulator ({words}): its figures are the simulator's, not your vehicle's."
        for text in (told.output, file.read_text()):
            assert (said in text) is bool(words)
        file.unlink()
