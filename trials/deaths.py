"""A companion that dies, on a circle or in a sidestep, in OFFBOARD or in a flight mode of its own: what follows."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.config.world.world import load_world
from companion.daemon.conductor import Conductor, Orders
from companion.flight.conduct import Conduct, ControlAuthority
from companion.flight.phases import Phase
from companion.law.gains import law_level
from companion.library.lockstep import fly
from companion.library.simulation import start_of
from companion.mission import Origin
from companion.profiles import ConstantSpeed
from companion.vehicle import (
    AttitudeSetpoint,
    Mode,
    MotorSetpoint,
    OutputLevel,
    RateSetpoint,
    Setpoint,
    TorqueSetpoint,
)
from companion.world import World
from companion.xrce.commands import Commands
from companion.xrce.flight_mode import MODE_LEVELS, FlightMode
from sim_bridge.autopilot.xrce import Release
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Truth
from sim_bridge.world_events import XRCE

FOLLOWS = 6.0
"""s on the path before it dies."""
AFTER = 6.0
"""s that are looked at then."""
LOOKS = 0.1
"""s between two looks of PX4 at whether offboard setpoints come."""
TIME_OUT = 60.0
"""s a flight may take until then."""


class Death(NamedTuple):
    """What followed. ``took``: s until PX4 flew ``mode``; NaN: it did not. ``tilt_before``, ``tilt_max``: degrees when
    it died, and at most until a second after ``took``. ``lost``: m of height, at most. ``fell``: it lies on the
    ground."""

    took: float
    mode: Mode
    tilt_before: float
    tilt_max: float
    lost: float
    fell: bool


class _Dead(Exception):
    """The companion is."""


def selecting(bridge: Bridge, conductor: Conductor) -> None:
    """The pilot: takes our mode as soon as it stands by."""
    memory, xrce = conductor.memory, conductor.xrce
    own = None if xrce is None or xrce.flight_mode is None else xrce.flight_mode.mode
    if memory is not None and memory.phase is Phase.STAND_BY and own is not None:
        bridge.autopilot.request_mode(own, aloud=False)


def placed(
    level: OutputLevel, *, own_mode: bool, duration: float, speed: float = 3.0,
    mode_levels: frozenset[OutputLevel] = MODE_LEVELS, world: str = "sih",
    seed: int = 0,
) -> tuple[Bridge, Conductor]:  # fmt: skip
    """A vehicle in a hover on the circle, and a companion that is to fly it; nothing has been said yet."""
    machine = load_vehicle("sih")
    mission = dataclasses.replace(load_mission("circle_r5", law_level(level)), speed=ConstantSpeed(speed))
    start = start_of(mission, held=False)
    bridge = Bridge(machine, load_world(world), seed=seed, start=start, endpoints=1, xrce=Release.MAIN)
    bridge.autopilot.parameters["UXRCE_DDS_SYNCT"] = 0
    orders = Orders(
        mission, machine, level, duration, Origin.LOCAL, set_parameters=True, has_xrce=True,
        over_xrce=own_mode or level.without_rate_loop, mode_levels=mode_levels,
        conduct=Conduct(ControlAuthority.PILOT, own_mode="Path") if own_mode else Conduct(),
    )  # fmt: skip
    return bridge, Conductor(orders, None, 0.0)


def death(level: OutputLevel, *, own_mode: bool, after_look: float = 0.04, speed: float = 3.0) -> Death:
    """Fly until it dies, ``after_look`` s after one of PX4's looks, and on."""
    every = frozenset(OutputLevel)  # what is refused is what is measured
    bridge, conductor = placed(level, own_mode=own_mode, speed=speed, duration=TIME_OUT, mode_levels=every)
    following: list[float] = []

    def watch(conductor: Conductor, truth: Truth) -> None:
        conductor.notes.clear()
        if own_mode:
            selecting(bridge, conductor)
        if conductor.memory is not None and conductor.memory.phase is Phase.FOLLOW:
            following.append(bridge.now)
        if following and bridge.now - following[0] > FOLLOWS and abs(truth.t_boot % LOOKS - after_look) < 1e-3:
            raise _Dead

    try:
        fly(conductor, bridge, watch, TIME_OUT)
    except _Dead:
        return _what_follows(bridge)
    raise AssertionError(f"{level.value}: it did not get to the path: {conductor.refusal}")


LOSS_TIME = {OutputLevel.MOTORS: 0.1, OutputLevel.TORQUES: 0.1}
"""s, COM_OF_LOSS_T as it is set for a flight at a level; the others: 0.3."""
STEP = 0.12
"""s into the sidestep at which it dies, as on PX4."""
LEAN = 0.05
"""Share of its thrust by which each motor differs then: 20 degrees at most where PX4 acts after 0.18 s, as measured."""


BANK = math.radians(30.0)
"""rad that an attitude leans in the sidestep (engineering choice)."""
ROLL_RATE = 1.5
"""rad/s in the sidestep: on PX4 33 degrees after 0.38 s."""


def aside(level: OutputLevel, hover: float) -> tuple[Setpoint, Setpoint]:
    """The setpoint of a hover at a share of thrust, and of a sidestep of 4 m to the right, at its beginning."""
    level_, bent = (1.0, 0.0, 0.0, 0.0), (math.cos(0.5 * BANK), math.sin(0.5 * BANK), 0.0, 0.0)
    match level:
        case OutputLevel.MOTORS:
            less, more = hover - LEAN, hover + LEAN
            return MotorSetpoint((hover,) * 4), MotorSetpoint((less, more, more, less))
        case OutputLevel.TORQUES:
            torque = LEAN * math.sqrt(2.0)
            return TorqueSetpoint((0.0,) * 3, hover), TorqueSetpoint((torque, 0.0, 0.0), hover)
        case OutputLevel.RATES:
            return RateSetpoint((0.0,) * 3, hover), RateSetpoint((ROLL_RATE, 0.0, 0.0), hover)
        case OutputLevel.ATTITUDE:
            return AttitudeSetpoint(level_, hover), AttitudeSetpoint(bent, hover)


def sidestep(level: OutputLevel, *, own_mode: bool, after_look: float = 0.04) -> Death:
    """Hover on our setpoints, step aside, die ``STEP`` s later; no law, what the setpoints are is what counts."""
    bridge = Bridge(load_vehicle("sih"), World(), endpoints=1, xrce=Release.MAIN)
    bridge.autopilot.parameters.update(UXRCE_DDS_SYNCT=0, COM_OF_LOSS_T=LOSS_TIME.get(level, 0.3), COM_OBL_RC_ACT=5)
    mode = FlightMode("Path", level, can_run=True) if own_mode else None
    commands = Commands(level, flight_mode=mode)
    hovering, stepping = aside(level, bridge.autopilot.cascade.hover)

    def step(setpoint: Setpoint | None) -> None:
        bridge.step()
        if setpoint is not None and round(bridge.now / bridge.step_s) % 2 == 0:
            commands.send(setpoint, bridge.now, bridge.now, True)
        while said := [data for endpoint, data in bridge.datagrams() if endpoint == XRCE]:
            for data in said:
                commands.receive(data, bridge.now)
            for data in commands.datagrams(bridge.now):
                bridge.receive(data, XRCE)
        for data in commands.datagrams(bridge.now):
            bridge.receive(data, XRCE)

    while commands.missing is not None:
        step(None)
    wanted = Mode.OFFBOARD if mode is None or mode.mode is None else mode.mode
    while bridge.autopilot.commander.mode is not wanted:
        step(hovering)
        bridge.autopilot.request_mode(wanted, aloud=False)
    settled = bridge.now + 1.0
    while bridge.now < settled or abs((bridge.truth.t_boot + STEP) % LOOKS - after_look) > 1e-3:
        step(hovering)
    begun = bridge.now
    while bridge.now - begun < STEP - 1e-6:
        step(stepping)
    return _what_follows(bridge)


def _what_follows(bridge: Bridge) -> Death:
    flown = bridge.autopilot.commander.mode
    before, height, began = tilt_of(bridge.truth), -bridge.truth.p_n[2], bridge.now
    took, most, lowest = math.nan, before, height
    while bridge.now - began < AFTER:
        bridge.step()
        bridge.datagrams()
        if math.isnan(took) and bridge.autopilot.commander.mode is not flown:
            took, flown = bridge.now - began, bridge.autopilot.commander.mode
        if math.isnan(took) or bridge.now - began < took + 1.0:
            most = max(most, tilt_of(bridge.truth))
        lowest = min(lowest, -bridge.truth.p_n[2])
    return Death(took, flown, before, most, height - lowest, bridge.truth.on_ground)


def tilt_of(truth: Truth) -> float:
    """Degrees that the thrust axis leans."""
    _, x, y, _ = truth.q_nb
    return math.degrees(math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y)))))
