"""A log of the stand-in with PX4's own noise: what it was flown with is found, and how well is said."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.config.vehicle import load_vehicle
from companion.identification.flight_data import STEP, Array, Part
from companion.identification.force_fit import fit_forces
from companion.identification.from_log import Findings, better_log, identify, unit_torques, words_of
from companion.identification.rate_fit import Found, first_order
from companion.identification.ulog import read
from companion.vehicle import GRAVITY, CompanionError
from tests.support.identified import TRUE, near
from tests.support.ulog import Logger, logged, written
from trials.measured import machine, world


def test_what_it_was_flown_with_is_found_within_five_percent(found: Findings) -> None:
    near(found.forces.hover_thrust, TRUE.hover)
    near(found.forces.drag, TRUE.drag)
    near(found.motor_lag, TRUE.motor_lag)
    near(found.rate_loop_lag, TRUE.loop_lag)
    for axis, authority in zip(found.axes, TRUE.authority, strict=True):
        near(axis.authority, authority)
    assert np.hypot(found.forces.disturbance_n[0] - 2.0, found.forces.disturbance_n[1] + 1.0) < 0.3


def test_a_log_of_px4s_own_simulation_is_read(tmp_path: Path) -> None:
    """14 s of figure8 at 2 m/s at rates on PX4 main of March 2026 in its own simulation, its sensors shaking; of its log
    the topics and parameters that identification reads, some of them thinned. SIH integrates its motors' 50 ms by Euler's
    method in steps of 4 ms: they act as 48, and turn the vehicle half a step sooner than one that is integrated exactly."""
    file = tmp_path / "px4.ulg"
    file.write_bytes(gzip.decompress((Path(__file__).parents[1] / "data" / "px4_sitl.ulg.gz").read_bytes()))
    with file.open("rb") as opened:
        found = identify(read(opened, file.name))
    assert found.log.identity.startswith("PX4 1.17.0")
    near(found.forces.hover_thrust, 0.4905)
    near(found.forces.drag, 1.0)
    near(found.motor_lag, 0.046)
    # measured by steps of 0.5 to 1 rad/s on another version; a flight turns slower
    assert found.rate_loop_lag.value == pytest.approx(0.071, rel=0.07)
    for axis, authority in zip(found.axes, (113.14, 113.14, 13.33), strict=True):
        near(axis.authority, authority)


@pytest.fixture
def fitted_once(found: Findings, monkeypatch: pytest.MonkeyPatch) -> None:
    """The fit takes seconds; what becomes of it is what is looked at."""
    monkeypatch.setattr("companion.cli.vehicle_making.identify", lambda log: found)


@pytest.mark.usefixtures("fitted_once")
def test_the_command_writes_a_file_and_a_picture_and_updates_it(
    log_file: Path, tmp_path: Path, found: Findings
) -> None:
    file, plot = tmp_path / "mine.yaml", tmp_path / "fit.png"
    runner = CliRunner()
    told = runner.invoke(app, ["vehicle", "from-log", str(log_file), str(file), "--plot", str(plot)])
    assert told.exit_code == 0, told.output
    hover = found.forces.hover_thrust
    assert f"hover thrust {hover.value:.4f}" in told.output  # which is near the true one: see above
    assert "+-" in told.output and "a better log: " in told.output
    assert plot.stat().st_size > 10_000
    vehicle = load_vehicle(str(file))
    true = load_vehicle("sih")
    assert vehicle.thrust_max / vehicle.mass == pytest.approx(true.thrust_max / true.mass, rel=0.05)
    assert vehicle.rotors[0].torque_per_thrust == pytest.approx(0.02, rel=0.05)
    again = runner.invoke(app, ["vehicle", "from-log", str(log_file), str(file)])
    assert again.exit_code != 0
    # who weighed it, and says so in the file, keeps that; the rest is taken from the log again
    file.write_text(
        file.read_text()
        .replace("mass_kg: 1 # PX4: kg, SIH_MASS", "mass_kg: 1.2")
        .replace("drag_per_s: 0.9", "drag_per_s: 0.4")
    )
    assert runner.invoke(app, ["vehicle", "from-log", str(log_file), str(file), "--force"]).exit_code == 0
    updated = load_vehicle(str(file))
    assert updated.mass == 1.2 and updated.drag == pytest.approx(1.0, rel=0.05)
    assert updated.thrust_max == pytest.approx(1.2 * vehicle.thrust_max, rel=1e-3)


@pytest.mark.usefixtures("fitted_once")
def test_inertia_is_found_where_nobody_knows_it(log_file: Path, tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    text = Path("configs/vehicles/sih.yaml").read_text()
    file.write_text(
        text.replace("[0.025, 0.025, 0.030]", "[0.05, 0.05, 0.08] # MEASURE: a guess").replace(
            "hover_thrust: 0.5", "hover_thrust: auto"
        )
    )
    told = CliRunner().invoke(app, ["vehicle", "from-log", str(log_file), str(file), "--force"])
    assert told.exit_code == 0, told.output
    vehicle = load_vehicle(str(file))
    assert vehicle.inertia[:2] == pytest.approx((0.025, 0.025), rel=0.05)
    # of yaw only the ratio shows
    assert vehicle.rotors[0].torque_per_thrust / vehicle.inertia[2] == pytest.approx(0.02 / 0.03, rel=0.05)


def test_a_short_slow_log_is_told_what_it_lacks(tmp_path: Path) -> None:
    every = dict.fromkeys(("vehicle_angular_velocity", "vehicle_rates_setpoint", "vehicle_torque_setpoint"), 5)
    file = logged(
        tmp_path / "slow.ulg", machine("sih"), world("ideal"), mission="circle_r5", speed=1.0, duration=8.0, every=every
    )
    with file.open("rb") as opened:
        found = identify(read(opened, file.name))
    said = " ".join(better_log(found))
    for words in ("SDLOG_PROFILE 25", "fly longer", "more yaw", "tell little of drag", "THR_MDL_FAC"):
        assert words in said, said
    assert any(line.startswith("motor lag") for line in words_of(found))
    for name in ("vehicle_angular_velocity", "vehicle_rates_setpoint"):  # each with its own
        assert f"{name} came every {1e3 * found.log.topics[name].period:.0f} ms" in said
    for per_volt, said in (
        (Found(-0.031, 0.018), ": no sign of the battery in the thrust"), (Found(0.06, 0.005), ""),
        (Found(0.042, 0.016), ": this flight does not tell"), (Found(-0.01, 0.04), ": this flight does not tell"),
    ):  # fmt: skip
        with_battery = found._replace(forces=found.forces._replace(per_volt=per_volt))
        (line,) = [line for line in words_of(with_battery) if line.startswith("thrust per volt")]
        assert line.split(" V", 1)[1] == said
        advised = any("fly the battery down" in line for line in better_log(with_battery))
        assert advised is ("does not tell" in said)


def hovered(volts: Array, per_volt: float, thrust_std: float, curve: float) -> Part:
    """40 s level, thrust moving up and down, on a battery of which thrust knows the voltage without its ripple."""
    rng = np.random.default_rng(3)
    n = 10_000
    thrust = np.clip(0.5 + first_order(rng.normal(0.0, thrust_std, n), 0.3), 0.15, 0.9)
    lifted = GRAVITY * (curve * thrust**2 + (1.0 - curve) * thrust) / (curve * 0.45**2 + (1.0 - curve) * 0.45)
    force = np.zeros((n, 3))
    force[:, 2] = -first_order(lifted, 0.03, lifted[0]) * (1.0 + per_volt * (volts - volts.mean()))
    force[:, 2] += rng.normal(0.0, 0.5, n)
    level = np.broadcast_to(np.eye(3), (n, 3, 3))
    still, yes = np.zeros((n, 3)), np.ones(n, dtype=bool)
    # the motors pull at it, and PX4 measures it every 0.2 s
    pulled = np.repeat(rng.uniform(-0.4, 0.4, n // 50), 50)
    return Part(STEP * np.arange(n), still, still, still, thrust, force, yes, level, still, volts + pulled, yes)


EMPTYING = np.linspace(16.0, 14.5, 10_000)
"""V: 1.5 in 40 s."""


def test_thrust_curve_and_battery_are_found() -> None:
    found = fit_forces([hovered(EMPTYING, 0.06, 2.5, 0.3)], {"IMU_ACCEL_CUTOFF": 1e6}, Found(0.03, 0.005))
    assert found.curve is not None and found.per_volt is not None
    near(found.hover_thrust, 0.45)
    assert found.curve.value == pytest.approx(0.3, abs=0.05) and found.per_volt.value == pytest.approx(0.06, rel=0.1)
    assert found.per_volt.std < 0.015


def test_a_voltage_that_only_jumps_with_the_load_tells_nothing_of_the_battery() -> None:
    for range_v, tells in ((0.0, False), (0.2, False), (1.5, True)):
        volts = np.linspace(16.0, 16.0 - range_v, 10_000)
        found = fit_forces([hovered(volts, 0.0, 0.5, 0.0)], {"IMU_ACCEL_CUTOFF": 1e6}, Found(0.03, 0.005))
        assert (found.per_volt is not None) is tells
    assert found.per_volt is not None and abs(found.per_volt.value) < 2.0 * found.per_volt.std < 0.03


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    for name, raw in (
        ("text.ulg", b"name: x500\n" * 50),
        ("cut.ulg", b"ULog\x01\x12\x35\x01" + bytes(8)),
        ("none.ulg", b""),
    ):
        file = tmp_path / name
        file.write_bytes(raw)
        with file.open("rb") as opened, pytest.raises(CompanionError, match=r"no ULog|no log of PX4|lacks"):
            read(opened, name)
    file = written(
        tmp_path / "part.ulg", {name: [(i, (0.0,) * 3) for i in range(3)] for name in ("vehicle_torque_setpoint",)}, {}
    )
    with file.open("rb") as opened, pytest.raises(CompanionError, match="lacks vehicle_angular_velocity"):
        read(opened, "part.ulg")
    assert Logger().every == {}


def test_a_unit_of_torque_is_px4s() -> None:
    rows = [{"position_m": list(rotor.position_b), "spin": rotor.spin.value} for rotor in load_vehicle("sih").rotors]
    each = 5.0
    roll, pitch, yaw = unit_torques(rows)
    assert (each * roll / 0.025, each * pitch / 0.025, each * 0.02 * yaw / 0.03) == pytest.approx(
        TRUE.authority, rel=1e-3
    )
