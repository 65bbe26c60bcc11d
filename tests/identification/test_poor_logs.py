"""Logs that tell little or nothing: what is found all the same, and what is said of the rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from companion.cli.commands import app, main
from companion.identification.flight_data import SETTLING, flown_parts
from companion.identification.from_log import Findings, better_log, identify, with_findings, words_of
from companion.identification.parameters import describe_parameters
from companion.identification.picture import picture
from companion.identification.ulog import Log, Series, read
from companion.vehicle import CompanionError
from tests.support.identified import TRUE, near
from tests.support.ulog import written


def changed(log: Log, name: str, columns: slice, value: float, after: float) -> Log:
    """A log in whose topic these columns are ``value`` from ``after`` (s) on."""
    t, x = log.topics[name]
    x = x.copy()
    x[t > after, columns] = value
    return log._replace(topics={**log.topics, name: Series(t, x)})


def saturated(found: Findings, telling: float) -> Log:
    """The flight of ``found`` with its motors at a limit but for ``telling`` s."""
    after = found.parts[0].t[0] + SETTLING + telling
    return changed(found.log, "vehicle_torque_setpoint", slice(0, 1), 2.0, after)


def test_the_log_of_another_kind_of_vehicle_is_refused_before_the_fit_whatever_is_written_over(
    log_file: Path, found: Findings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hexa = found.log._replace(parameters={**found.log.parameters, "CA_ROTOR_COUNT": 6.0})
    monkeypatch.setattr("companion.cli.vehicle_making.read_log", lambda file, name: hexa)
    monkeypatch.setattr("companion.cli.vehicle_making.identify", lambda log: pytest.fail("it was fitted"))
    file = tmp_path / "mine.yaml"
    file.write_text(Path("configs/vehicles/sih.yaml").read_text())
    before = file.read_text()
    for options in (
        [str(tmp_path / "new.yaml")],
        [str(file), "--force"],
        [str(tmp_path / "new.yaml"), "--vehicle", "sih"],
    ):
        told = CliRunner().invoke(app, ["vehicle", "from-log", str(log_file), *options])
        assert isinstance(told.exception, CompanionError) and "no quadrotor" in str(told.exception)
    assert file.read_text() == before and list(tmp_path.iterdir()) == [file]


def test_a_log_that_tells_too_little_is_refused_and_nothing_written(
    log_file: Path, found: Findings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for seconds in (0.0, 0.05):
        log = saturated(found, seconds)
        monkeypatch.setattr("companion.cli.vehicle_making.read_log", lambda file, name, log=log: log)
        file = tmp_path / "mine.yaml"
        monkeypatch.setattr("sys.argv", ["companion", "vehicle", "from-log", str(log_file), str(file)])
        with pytest.raises(SystemExit) as ended:
            main()
        said = capsys.readouterr().err
        assert ended.value.code == 2 and not file.exists()
        assert "too little of the log" in said and f"{found.flown:.1f} s in the air" in said
        assert "Nothing was written. Fly longer and gentler" in said


def test_what_is_found_is_told_though_the_rest_is_not(found: Findings, tmp_path: Path) -> None:
    short = identify(saturated(found, 2.0))
    near(short.forces.hover_thrust, TRUE.hover, within=0.1)
    assert not any(each.is_found for axis in short.axes for each in axis[:4])
    words = words_of(short)
    assert "yaw: rate loop lag not found, gain not found; what torque does: not found" in words
    assert any(line.startswith("more roll") for line in better_log(short))
    picture(short).savefig(tmp_path / "short.png")
    base = describe_parameters(short.log.parameters, name="mine")
    file = with_findings(base, short, ())
    assert file.data["rate_loop_lag_s"] == base.data["rate_loop_lag_s"]
    assert "rate_loop_lag_s (not found)" in file.text and "inf" not in file.text.split("The log:")[1]
    longer = identify(saturated(found, 3.5))
    assert all(axis.lag.is_found and not axis.authority.is_found for axis in longer.axes)


def test_an_axis_that_nobody_moved_is_not_found(found: Findings) -> None:
    still = identify(changed(found.log, "vehicle_rates_setpoint", slice(2, 3), 0.0, 0.0))
    assert not any(each.is_found for each in still.axes[2][:4])
    near(still.axes[0].authority, TRUE.authority[0])


def test_where_no_topic_or_no_height_is_nothing_was_flown(found: Findings) -> None:
    """A topic that ends early ends the flight, and so does a height that nothing tells."""
    t, x = found.log.topics["vehicle_acceleration"]
    half = t < t[0] + 0.5 * (t[-1] - t[0])
    parts = flown_parts(
        found.log._replace(topics={**found.log.topics, "vehicle_acceleration": Series(t[half], x[half])})
    )
    assert parts[-1].t[-1] <= t[half][-1]
    t, x = found.log.topics["vehicle_local_position"]
    ends = np.array([0, len(t) - 1])
    with pytest.raises(CompanionError, match="no 5 s of flight"):
        flown_parts(found.log._replace(topics={**found.log.topics, "vehicle_local_position": Series(t[ends], x[ends])}))


@pytest.mark.parametrize(
    ("topics", "release", "system", "words"),
    [
        (
            ("vehicle_attitude", "vehicle_rates_setpoint"),
            0x010C03FF,
            "PX4",
            "is of PX4 1.12.3: before 1.14 PX4 logs no",
        ),
        (("vehicle_attitude", "actuator_controls_0"), 0, "PX4", "vehicle from --connect LINK writes a vehicle file"),
        (("vehicle_attitude",), 0x010E00FF, "PX4", "lacks vehicle_angular_velocity, .*SDLOG_PROFILE 25"),
        (("cell",), 0x010E00FF, "PX4", "no log of PX4's flight: it has no vehicle_. topics. Give a log that PX4 wrote"),
        (("vehicle_attitude",), 0x010E00FF, "Copter", "no log of PX4's flight: it was written by Copter"),
    ],
)
def test_a_log_that_cannot_be_fitted_says_why_and_what_to_do(
    tmp_path: Path, topics: tuple[str, ...], release: int, system: str, words: str
) -> None:
    widths = {"actuator_controls_0": 8, "vehicle_attitude": 5, "cell": 1}
    rows = {name: [(i, (0.0,) * widths.get(name, 3)) for i in range(3)] for name in topics}
    for name in rows:
        if name == "vehicle_attitude":
            rows[name] = [(i, (i, 1.0, 0.0, 0.0, 0.0)) for i in range(3)]
    file = written(tmp_path / "poor.ulg", rows, {}, release, system)
    with file.open("rb") as opened, pytest.raises(CompanionError, match=words) as refused:
        read(opened, file.name)
    assert ("SDLOG_PROFILE" in str(refused.value)) is ("SDLOG_PROFILE" in words)
