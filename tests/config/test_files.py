"""Files people write: every fault at once, each with its line and key, in words."""

from __future__ import annotations

import math
import random
from pathlib import Path

import pytest

from companion.config.mission.mission import load_mission, mission_from
from companion.config.syntax.document import parse, scalar
from companion.config.syntax.faults import ConfigError
from companion.config.syntax.file_lookup import names
from companion.config.vehicle import load_vehicle, vehicle_from
from companion.law.gains import Level
from companion.mission import GlobalOrigin, Origin
from companion.vehicle import MotorInterface, Spin

MISSION = """\
mission: test
frame: ned
origin: local
path:
  kind: implicit
  constants: {r: 10.0, z0: -20.0}
  h1: x**2 + y**2 - r**2
  h2: z - z0
  near: [0, 10, -20]
speed: 3.0
yaw: 0.0
gains: {poles: {path: [-2, -2, -2, -2], speed: [-2, -2, -2], yaw: [-2, -2]}}
"""

VEHICLE = """\
name: test
mass_kg: 2.0
inertia_kgm2: [0.02, 0.02, 0.04]
rotors:
  - {position_m: [0.17, 0.17, 0.0], spin: ccw, thrust_max_n: 8.5, torque_per_thrust_m: 0.016}
  - {position_m: [-0.17, -0.17, 0.0], spin: ccw, thrust_max_n: 8.5, torque_per_thrust_m: 0.016}
  - {position_m: [0.17, -0.17, 0.0], spin: cw, thrust_max_n: 8.5, torque_per_thrust_m: 0.016}
  - {position_m: [-0.17, 0.17, 0.0], spin: cw, thrust_max_n: 8.5, torque_per_thrust_m: 0.016}
"""


def mission_faults(text: str, level: Level = Level.MOTORS) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        mission_from(parse(text, "m.yaml"), level)
    return [str(fault) for fault in caught.value.faults]


def vehicle_faults(text: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        vehicle_from(parse(text, "v.yaml"))
    return [str(fault) for fault in caught.value.faults]


def line_of(text: str, start: str) -> int:
    return next(i for i, line in enumerate(text.splitlines(), 1) if line.strip().startswith(start))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e3", 1000.0), ("1", 1), ("-2.5", -2.5), (".5", 0.5), ("5.", 5.0), ("0o17", 15), ("0x1F", 31), ("+3", 3),
        ("12:30", "12:30"), ("yes", "yes"), ("on", "on"), ("true", True), ("False", False), ("~", None), ("", None),
        ("1_000", "1_000"), ("2026-01-01", "2026-01-01"), (".inf", math.inf), ("-.INF", -math.inf), ("010", 10),
        ("1e", "1e"), ("0b1", "0b1"),
    ],
)  # fmt: skip
def test_scalars_are_those_of_yaml_1_2(text: str, value: object) -> None:
    assert scalar(text) == value
    assert type(scalar(text)) is type(value)


def test_a_good_mission() -> None:
    mission = mission_from(parse(MISSION, "m.yaml"), Level.MOTORS)
    assert mission.name == "test"
    assert mission.origin is Origin.LOCAL
    assert mission.gains is not None
    assert mission.gains.h1 == (16.0, 32.0, 24.0, 8.0)
    assert mission.alpha(0.0) == 3.0
    assert mission.path.table.length == pytest.approx(20.0 * math.pi)


def test_a_good_vehicle() -> None:
    vehicle = vehicle_from(parse(VEHICLE, "v.yaml"))
    assert vehicle.motors is MotorInterface.PX4
    assert vehicle.rotors[2].spin is Spin.CW
    assert vehicle.limits is not None
    assert vehicle.limits.tilt == pytest.approx(math.radians(45.0))
    assert vehicle.hover_thrust is None


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        ("mission: test", "mision: test", "mission", "missing"),
        ("mission: test", "mision: test", "mision", "did you mean mission"),
        ("mission: test", "mission: 7", "mission", "7 is not text"),
        ("frame: ned", "frame: nwu", "frame", "expected 'ned' or 'enu'"),
        ("origin: local", "origin: here", "origin", "expected 'local', 'takeoff' or 'home'"),
        ("origin: local", "origin: [47.0, 8.0]", "origin", "at least 3"),
        ("  kind: implicit", "  kind: spiral", "path.kind", "spiral"),
        ("  h1: x**2 + y**2 - r**2", "  h1: x^2 + y^2 - r^2", "path.h1", r"expected **"),
        ("  h1: x**2 + y**2 - r**2", "  h1: x**2 + y**2 - q**2", "path.h1", "'q' is unknown here"),
        ("  h1: x**2 + y**2 - r**2", "  h1: [1, 2]", "path.h1", "not text"),
        ("  h2: z - z0", "  h2: open('/etc/passwd')", "path.h2", "no function here"),
        ("  h2: z - z0", "  h2: y - x**2", "path", "not regular"),
        ("  near: [0, 10, -20]", "  near: [0, 10]", "path.near", "at least 3"),
        ("  near: [0, 10, -20]", "  near: [0, ten, -20]", "path.near[1]", "'ten' is not a number"),
        ("  constants: {r: 10.0, z0: -20.0}", "  constants: {x: 10.0, z0: -20.0}", "path.constants", "means nothing else"),
        ("speed: 3.0", "speed: 12:30", "speed", "not an expression"),
        ("speed: 3.0", "speed: 0", "speed", "never moves"),
        ("speed: 3.0", "speed: x", "speed", "everywhere"),
        ("speed: 3.0", "speed: .nan", "speed", "finite"),
        ("speed: 3.0", "speed: log(x)", "speed", "not defined at"),
        ("speed: 3.0", "speed: true", "speed", "true"),
        ("speed: 3.0", "speed:", "speed", "nothing is not a number"),
        ("yaw: 0.0", "yaw: 400", "yaw", "at most 360"),
        ("yaw: 0.0", "yaw: {look_at: [0, 10, 0]}", "yaw", "point to face"),
        ("yaw: 0.0", "yaw: {look: [0, 10, 0]}", "yaw.look", "unknown key"),
        ("yaw: 0.0", "yaw: 0.0\nlaps: 0", "laps", "more than 0"),
        ("yaw: 0.0", "yaw: 0.0\nstart: {position: [0, 10, -20], pitch_deg: 120}", "start.pitch_deg", "at most 89"),
        ("path: [-2, -2, -2, -2]", "path: [-2, -2, -2]", "gains.poles.path", "3 numbers; expected 4"),
        ("path: [-2, -2, -2, -2]", "path: [-2, -2, -2, 2]", "gains.poles.path", "not stable"),
        ("path: [-2, -2, -2, -2]", "path: [-0.5, -2, -2, -2]", "gains.poles.path", "-1.5 or faster"),
        ("path: [-2, -2, -2, -2]", "path: [-99, -2, -2, -2]", "gains.poles.path", "or slower"),
        ("path: [-2, -2, -2, -2]", 'path: ["-2+1j", -2, -2, -2]', "gains.poles.path", "stands alone"),
        ("path: [-2, -2, -2, -2]", 'path: ["minus two", -2, -2, -2]', "gains.poles.path[0]", "is no root"),
    ],
)  # fmt: skip
def test_faults_of_a_mission(old: str, new: str, key: str, said: str) -> None:
    text = MISSION.replace(old, new)
    assert text != MISSION
    faults = mission_faults(text)
    match = [fault for fault in faults if f": {key}: " in fault and said in fault]
    assert match, faults
    line = int(match[0].split(":")[1])
    inner = key.split("[")[0].split(".")[-1]
    assert f"{inner}:" in text.splitlines()[line - 1] or "missing" in match[0], match


def test_a_list_of_gains_that_does_not_fit_names_poles() -> None:
    text = MISSION.replace(
        "gains: {poles: {path: [-2, -2, -2, -2], speed: [-2, -2, -2], yaw: [-2, -2]}}", "gains: {h1: [16, 32, 24, 8]}"
    )
    assert mission_from(parse(text, "m.yaml"), Level.MOTORS).gains is not None
    (fault,) = mission_faults(text, Level.RATES)
    assert "gains.h1" in fault
    assert "poles" in fault


def test_slow_poles_are_noted_in_simulation_and_refused_in_flight() -> None:
    text = MISSION.replace("path: [-2, -2, -2, -2]", 'path: ["-1+1j", "-1-1j", -2, -2]')
    simulated = mission_from(parse(text, "m.yaml"), Level.MOTORS, simulated=True)
    assert [note for note in simulated.notes if "slowest root -1" in note and "-1.5 or faster is advised" in note]
    assert simulated.gains is not None and simulated.gains.h1 == pytest.approx((8.0, 16.0, 14.0, 6.0))
    (fault,) = mission_faults(text)
    assert "-1.5 or faster" in fault


def test_all_faults_come_at_once() -> None:
    text = (
        MISSION.replace("frame: ned", "frame: up")
        .replace("speed: 3.0", "speed: fast(")
        .replace("h2: z - z0", "h2: z @ 3")
    )
    keys = [fault.split(": ")[1] for fault in mission_faults(text)]
    assert keys == ["frame", "path.h2", "speed"]


def test_duplicate_keys_anchors_and_tags_are_faults() -> None:
    (fault,) = mission_faults(MISSION + "speed: 4.0\n")
    assert fault == "m.yaml:13: speed: given twice, first on line 10; expected once"
    assert "anchor" in mission_faults(MISSION.replace("speed: 3.0", "speed: &v 3.0"))[0]
    assert "tag" in mission_faults(MISSION.replace("speed: 3.0", "speed: !!python/name:os.system"))[0]


@pytest.mark.parametrize(
    "text", ["", "- 1\n- 2\n", "just words", "a: [1, 2", "\t- x", "a: b: c", "\x00", "? [a]\n: 1\n"]
)
def test_what_is_no_mission_at_all(text: str) -> None:
    assert all(fault.startswith("m.yaml:") for fault in mission_faults(text))


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        ("mass_kg: 2.0", "mass: 2.0", "mass_kg", "missing"),
        ("mass_kg: 2.0", "mass_kg: -2.0", "mass_kg", "more than 0"),
        ("mass_kg: 2.0", "mass_kg: 2000", "mass_kg", "at most 500"),
        ("mass_kg: 2.0", "mass_kg: 4", "mass_kg", "rotors lift"),
        ("[0.02, 0.02, 0.04]", "[0.02, 0.02, 0.5]", "inertia_kgm2", "no rigid body"),
        ("[0.02, 0.02, 0.04]", "[0.02, 0.02]", "inertia_kgm2", "at least 3"),
        ("[0.02, 0.02, 0.04]", "[200, 200, 400]", "inertia_kgm2[0]", "is this in another unit?"),
        ("[0.02, 0.02, 0.04]", "[2e-5, 2e-5, 4e-5]", "inertia_kgm2[0]", "is this in another unit?"),
        ("[0.17, 0.17, 0.0], spin: ccw", "[170, 170, 0], spin: ccw", "rotors[0].position_m[0]", "in m"),
        ("[0.17, 0.17, 0.0], spin: ccw", "[0.17, 0.17, 0.0], spin: left", "rotors[0].spin", "'ccw' or 'cw'"),
        ("name: test", "name: test\nlimits: {tilt_deg: 0.78}", "limits.tilt_deg", "radians"),
        ("name: test", "name: test\nlimits: {body_rate_dps: [3.8, 3.8, 1.5]}", "limits.body_rate_dps", "rad/s"),
        ("name: test", "name: test\nlimits: nothing", "limits", "nothing"),
        ("name: test", "name: test\nmotor_lag_s: 25", "motor_lag_s", "at most 1"),
        ("name: test", "name: test\nlink_delay_s: 12", "link_delay_s", "at most 1"),
        ("name: test", "name: test\nmotors: yes", "motors", "'px4' or 'direct'"),
        ("name: test", "name: test\nhover_thrust: 1.5", "hover_thrust", "less than 1"),
        ("name: test", "name: test\ndrag: 0.2", "drag", "did you mean drag_per_s"),
    ],
)
def test_faults_of_a_vehicle(old: str, new: str, key: str, said: str) -> None:
    text = VEHICLE.replace(old, new)
    assert text != VEHICLE
    faults = vehicle_faults(text)
    assert any(f": {key}: " in fault and said in fault for fault in faults), faults
    named = [fault.split(": ")[1] for fault in faults]
    assert len(set(named)) == len(named), faults  # one line a fault, whatever else a value might have been


def test_origins_frames_and_yaws() -> None:
    def read(text: str) -> object:
        return mission_from(parse(text, "m.yaml"), Level.MOTORS)

    mission = mission_from(parse(MISSION.replace("origin: local", "origin: [47.4, 8.5, 490]"), "m"), Level.MOTORS)
    assert mission.origin == GlobalOrigin(47.4, 8.5, 490)
    enu = MISSION.replace("frame: ned", "frame: enu").replace("z0: -20.0", "z0: 20.0").replace("10, -20]", "10, 20]")
    up = mission_from(parse(enu, "m"), Level.MOTORS)
    assert up.path.table.at(0.0)[0] == pytest.approx((10.0, 0.0, -20.0))  # y = 10 is north, z = 20 is up
    for yaw in ("tangent", "{tangent: 90}", "{look_at: [0, 0, 0]}", "90", "atan2(y, x)*180/pi"):
        read(MISSION.replace("yaw: 0.0", f"yaw: {yaw}"))
    facing = mission_from(parse(MISSION.replace("yaw: 0.0", "yaw: {look_at: [0, 0, 0]}"), "m"), Level.MOTORS)
    assert facing.beta(0.0) == pytest.approx(-math.pi / 2)  # from the east, look west
    assert facing.placed((0.0, 5.0, 0.0)).beta(0.0) == pytest.approx(-math.pi / 2)  # the point moves with the path
    assert abs(facing.beta(5.0 * math.pi)) == pytest.approx(math.pi)  # from the north, look south
    along = mission_from(parse(MISSION.replace("yaw: 0.0", "yaw: {tangent: 90}"), "m"), Level.MOTORS)
    assert along.beta(0.0) == pytest.approx(math.pi / 2)
    backwards = MISSION.replace("yaw: 0.0", "yaw: tangent").replace("speed: 3.0", "speed: -3.0")
    reverse = mission_from(parse(backwards, "m"), Level.MOTORS)
    assert abs(reverse.beta(0.0)) == pytest.approx(math.pi)  # the way it travels


@pytest.mark.parametrize("name", names("missions"))
def test_shipped_missions_are_good(name: str) -> None:
    mission = load_mission(name, Level.MOTORS)
    assert mission.table.length > 10.0


@pytest.mark.parametrize("name", names("vehicles"))
def test_shipped_vehicles_are_good(name: str) -> None:
    assert load_vehicle(name).name == name


def test_files_that_are_not_there(tmp_path: Path) -> None:
    for load in (lambda n: load_mission(n, None), load_vehicle):
        with pytest.raises(ConfigError, match="no such file"):
            load(str(tmp_path / "none.yaml"))
        with pytest.raises(ConfigError, match="of this name"):
            load("none")
        (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x00")
        with pytest.raises(ConfigError, match="UTF-8"):
            load(str(tmp_path / "binary.yaml"))


@pytest.mark.parametrize("seed", range(8))
def test_mutated_files_give_faults_and_never_anything_else(seed: int) -> None:
    rng = random.Random(seed)
    for _ in range(25):
        text = list(MISSION if rng.random() < 0.5 else VEHICLE)
        for _ in range(rng.randrange(1, 5)):
            at = rng.randrange(len(text))
            action = rng.randrange(3)
            if action == 0:
                del text[at : at + rng.randrange(1, 8)]
            elif action == 1:
                text[at:at] = rng.choice(
                    ["9", ":", "-", "[", "]", "{", "x", "\n", " ", "'", "#", "**", "e9", "\t", "~"]
                )
            else:
                other = rng.randrange(len(text))
                text[at], text[other] = text[other], text[at]
        document_text = "".join(text)
        for read in (
            lambda t: mission_from(parse(t, "f.yaml"), Level.MOTORS),
            lambda t: vehicle_from(parse(t, "f.yaml")),
        ):
            try:
                read(document_text)
            except ConfigError as error:
                count = document_text.count("\n") + 2
                assert all(1 <= fault.line <= count for fault in error.faults), error  # noqa: PT017
