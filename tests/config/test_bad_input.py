"""Spoilt files: a line and words for every fault, never a traceback; and units that are mixed up."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from companion.config.mission.mission import mission_from
from companion.config.syntax.document import parse
from companion.config.syntax.faults import ConfigError
from companion.config.vehicle import vehicle_from
from companion.law.gains import Level
from tests.config.test_files import VEHICLE
from trials.mutated import SOON, cases, outcome

CASES = cases(200, 0)[::10]


@pytest.mark.parametrize("case", CASES, ids=[f"{i}-{what}" for i, (what, _, _) in enumerate(CASES)])
def test_a_spoilt_file_gets_a_message_or_a_check(case: tuple[str, str | None, str | None], tmp_path: Path) -> None:
    """A tenth of what bench/bad_input.py does."""
    _, mission, plan = case
    begun = time.process_time()
    word, said = outcome(mission, plan, tmp_path)
    took = time.process_time() - begun
    assert word in ("faults", "feasible", "not feasible"), said
    assert took < 5.0 * SOON  # generous: the bench holds it to SOON


def vehicle_faults(old: str, new: str) -> str:
    assert old in VEHICLE
    with pytest.raises(ConfigError) as caught:
        vehicle_from(parse(VEHICLE.replace(old, new), "v.yaml"))
    return str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[0.02, 0.02, 0.04]", "[200, 200, 400]", "expected kg m^2, is this in another unit?"),
        ("[0.02, 0.02, 0.04]", "[2.0e-7, 2.0e-7, 4.0e-7]", "expected kg m^2, is this in another unit?"),
        ("mass_kg: 2.0", "mass_kg: 2000", "(in g? 2 would fit)"),
        ("[0.17, 0.17, 0.0], spin: ccw", "[170, 0.17, 0.0], spin: ccw", "(in mm? 0.17 would fit)"),
        ("thrust_max_n: 8.5", "thrust_max_n: 0.87", "(thrust_max_n in kgf? 1 kgf is 9.81 N)"),
        ("thrust_max_n: 8.5", "thrust_max_n: 867", "(thrust_max_n in gram-force? 867 gf is 8.5 N)"),
        ("name: test", "name: test\nhover_thrust: 0.2", "contradicts mass and rotors, which hover at 0.5"),
        ("name: test", "name: test\nmotor_lag_s: 25", "(in ms? 0.025 would fit)"),
        ("name: test", "name: test\nmotor_lag_s: 0.3", "contradicts rate_loop_lag_s, 0.06"),
        ("name: test", "name: test\nlink_delay_s: 12", "(in ms? 0.012 would fit)"),
        ("name: test", "name: test\nhover_thrust: 55", "(in percent? 0.55 would fit)"),
        ("name: test", "name: test\nlimits: {tilt_deg: 0.78}", "is this in radians?"),
        ("name: test", "name: test\nlimits: {body_rate_dps: [3.8, 3.8, 1.5]}", "is this in rad/s?"),
    ],
)  # fmt: skip
def test_units_of_a_vehicle_that_are_mixed_up(old: str, new: str, said: str) -> None:
    assert said in vehicle_faults(old, new)


MISSION = "mission: m\nframe: ned\npath: {kind: circle, center: [0, 0, -9], radius: 5}\nspeed: 2\nyaw: 0\n"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("yaw: 0", "yaw: 1.5708", "m.yaml:5: yaw: 1.5708 looks like radians; expected degrees, 90 perhaps"),
        ("yaw: 0", "yaw: {tangent: -0.7854}", "m.yaml:5: yaw.tangent: -0.7854 looks like radians; expected degrees, -45 perhaps"),
        ("yaw: 0", "yaw: pi/2", "m.yaml:5: yaw: 1.5708 looks like radians; expected degrees, 90 perhaps"),
        ("speed: 2", "speed: 4 + atan2(sin(s/5), cos(s/5))", "m.yaml:4: speed: jumps 15.71 m along the path"),
        ("yaw: 0", "yaw: 90*atan2(sin(s/5), cos(s/5))/pi", "m.yaml:5: yaw: jumps 15.71 m along the path"),
        ("yaw: 0", "rotate_deg: 3.14159", "expected degrees, 180 perhaps"),
        ("yaw: 0", "origin: [473977420, 85455940, 488000]", "473977420 is no latitude (in 1e-7 degrees? 47.3977 would fit)"),
        ("yaw: 0", "yaw: tangnt", "m.yaml:5: yaw: 'tangnt' is not known; did you mean tangent?"),
        ("yaw: 0", "yaw: north", "m.yaml:5: yaw: 'north' is not known; expected tangent, a number, or an expression"),
        ("speed: 2", "speed: fast", "m.yaml:4: speed: 'fast' is not known; expected auto, a number, or an expression"),
        ("yaw: 0", "yaw: 0\norigin: here", "m.yaml:6: origin: 'here' is not known; expected 'local', 'takeoff' or 'home'"),
        ("speed: 2", "  speed: 2", "m.yaml:4: not valid YAML"),
        ("speed: 2", "speed: 2: 3", "m.yaml:4: not valid YAML: a second colon on one line"),
        ("radius: 5}", "radius: 5", "a comma or a closing } is missing here"),
        ("yaw: 0", "yaw: '0", "a quote that is not closed"),
        ("yaw: 0", "yaw: 0\n\tlaps: 2", "a character that nothing begins with (a tab"),
        ("yaw: 0", "yaw: \x00", "m.yaml:5: not valid YAML: the character '\\x00' is not allowed"),
        ("mission: m", "mission: ''", "m.yaml:1: mission: '' is too short; expected text: the mission's name"),
    ],
)  # fmt: skip
def test_what_is_said_of_a_mission(old: str, new: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        mission_from(parse(MISSION.replace(old, new), "m.yaml"), Level.MOTORS)
    assert said in str(caught.value)


def test_a_heading_that_only_goes_round_does_not_jump() -> None:
    mission_from(parse(MISSION.replace("yaw: 0", "yaw: degrees(atan2(sin(s/5), cos(s/5)))"), "m.yaml"), Level.MOTORS)


def test_angles_that_are_near_a_right_one_are_degrees() -> None:
    for degrees in ("1.5", "1.6", "3", "0.8", "90"):
        mission_from(parse(MISSION.replace("yaw: 0", f"yaw: {degrees}"), "m.yaml"), Level.MOTORS)
