"""The twist heading in flight: a turn that is so steep that nothing could hold the projected heading."""

from __future__ import annotations

import dataclasses
import math

import pytest

from companion.config.mission.mission import mission_from
from companion.config.syntax.document import parse
from companion.daemon.conductor import Conductor
from companion.feasibility.report import check
from companion.frames import Heading
from companion.law.gains import Level
from companion.mission import Mission
from companion.vehicle import Limits, OutputLevel, Vehicle
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Truth
from trials.measured import Measured, course, machine, measure_flight, world

SPEED, RADIUS = 8.5, 5.0
STEEP = math.radians(80.0)


def strong() -> Vehicle:
    """An x500 with rotors of twice the thrust, which may lean by 65 degrees."""
    x500 = machine("x500")
    return dataclasses.replace(
        x500,
        rotors=tuple(dataclasses.replace(rotor, thrust_max=2.0 * rotor.thrust_max) for rotor in x500.rotors),
        hover_thrust=0.5 * (x500.hover_thrust or 0.0),
        limits=Limits(tilt=math.radians(65.0), failure_detector=STEEP),
    )


def steep(heading: Heading, level: OutputLevel) -> Mission:
    return dataclasses.replace(course("circle_r5", SPEED, level), heading=heading)


OVER_MAVLINK = [level for level in OutputLevel if level is not OutputLevel.TORQUES]


def flown(heading: Heading, level: OutputLevel) -> tuple[Measured, list[float]]:
    """The flight, and the body yaw rates (rad/s) that it had once it was settled."""
    yawing: list[float] = []

    def prepare(conductor: Conductor, bridge: Bridge) -> None:
        for name in ("FD_FAIL_R", "FD_FAIL_P"):
            bridge.autopilot.parameters[name] = 80

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        memory = conductor.memory
        if memory is not None and memory.path.follow_from is not None and truth.t_boot - memory.path.follow_from > 12.0:
            yawing.append(truth.w_b[2])

    done = measure_flight(
        steep(heading, level), strong(), world("ideal"), level, duration=16.0, settle=12.0, prepare=prepare, watch=watch
    )  # fmt: skip
    return done, yawing


@pytest.mark.parametrize("level", OVER_MAVLINK)
def test_a_steep_turn(level: OutputLevel) -> None:
    """The body turns steadily at v/r (1 - cos(tilt)); path, speed and heading are kept."""
    done, yawing = flown(Heading.TWIST, level)
    assert done.reason is None
    assert done.true is not None
    assert done.tilt_max > math.radians(53.0)
    assert done.true.path < 0.015
    assert done.true.speed < 0.05 * SPEED  # at rates and attitude the speed gives way to the path
    assert done.true.yaw < math.radians(1.3)
    steady = (SPEED - done.true.speed) / RADIUS * (1.0 - math.cos(done.tilt_max))
    assert [abs(r) for r in yawing] == pytest.approx([steady] * len(yawing), rel=0.02)


def test_the_projected_heading_is_lost_there() -> None:
    """It would need 2 rad/s of yaw, and none a quarter of a turn later: the path is kept, the heading is not."""
    done, yawing = flown(Heading.PROJECTED, OutputLevel.RATES)
    assert done.reason is None
    assert done.true is not None
    assert done.true.path < 0.015
    assert done.true.yaw > math.radians(3.0)
    assert max(yawing) - min(yawing) > 1.3


def test_check_says_so_before() -> None:
    reports = {kind: check(steep(kind, OutputLevel.RATES), strong()) for kind in Heading}
    projected, twist = ({limit.name: limit for limit in reports[kind].limits} for kind in Heading)
    assert not reports[Heading.PROJECTED].feasible
    assert projected["body_rate_dps"].part == "yaw"
    assert projected["body_rate_dps"].worst == pytest.approx(119.8, abs=0.1)
    assert reports[Heading.TWIST].feasible
    tilt = math.radians(twist["tilt_deg"].worst)
    yawing = math.degrees(SPEED / RADIUS * (1.0 - math.cos(tilt)))
    assert twist["body_rate_dps"].part == "yaw"
    assert twist["body_rate_dps"].worst == pytest.approx(yawing, rel=1e-6)
    assert twist["thrust_n"].worst == pytest.approx(projected["thrust_n"].worst, rel=1e-9)
    assert twist["motor"].used < projected["motor"].used


def test_the_mission_file_says_which() -> None:
    text = "mission: m\nframe: ned\npath: {kind: circle, center: [0, 0, -10], radius: 5}\nspeed: 3.0\nyaw: 0.0\n"
    for line, kind in (("", Heading.PROJECTED), ("heading: twist\n", Heading.TWIST)):
        assert mission_from(parse(text + line, "m.yaml"), Level.RATES).heading is kind
