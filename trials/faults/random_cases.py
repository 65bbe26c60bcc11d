"""A flight drawn from a seed: where it begins, who flies it, which faults strike in which phases, what is mutated."""

from __future__ import annotations

import dataclasses
import math
import random
from collections.abc import Callable, Iterator

from companion import mavlink_common as c
from companion.flight.conduct import ControlAuthority, Finish
from companion.flight.phases import Phase
from companion.vehicle import OutputLevel
from companion.world import Link, Way
from companion.world import events as e
from companion.world.events import Event, Order, When
from trials.faults.case import Begin, Case, End, Strike

PHASES = (
    Phase.PREFLIGHT, Phase.ARM, Phase.TAKE_OFF, Phase.TAKE_OVER, Phase.SETTLE, Phase.JOIN, Phase.FOLLOW, Phase.REST,
    Phase.HAND_BACK, Phase.LAND, Phase.RETURN, Phase.DISARM, Phase.ABORT, Phase.RELEASE, Phase.STAND_BY,
)  # fmt: skip
"""Where a strike may wait; what is never entered never strikes."""
LIKELY = (Phase.FOLLOW, Phase.JOIN, Phase.TAKE_OVER, Phase.SETTLE, Phase.HAND_BACK)
KINDS = (
    "ODOMETRY", "HEARTBEAT", "CURRENT_MODE", "COMMAND_ACK", "EXTENDED_SYS_STATE", "TIMESYNC", "COMMAND_LONG",
    "SET_ATTITUDE_TARGET", "ESTIMATOR_STATUS", "BATTERY_STATUS",
)  # fmt: skip
ORDERS = tuple(Order)
TIME_OUT = 450.0
"""s in which a flight must be over: the longest phases wait 300 s, for a vehicle that flies home in a failsafe."""
LONGEST = 12.0
"""s that a fault lasts at most, where it ends."""
QUADROTOR = (c.MAV_COMP_ID_AUTOPILOT1, c.MAV_TYPE_QUADROTOR, c.MAV_AUTOPILOT_PX4)
FIXED_WING = (c.MAV_COMP_ID_AUTOPILOT1, c.MAV_TYPE_FIXED_WING, c.MAV_AUTOPILOT_PX4)
COMPANION = (c.MAV_COMP_ID_ONBOARD_COMPUTER, c.MAV_TYPE_ONBOARD_CONTROLLER, c.MAV_AUTOPILOT_INVALID)
GROUND_STATION = (c.MAV_COMP_ID_MISSIONPLANNER, c.MAV_TYPE_GCS, c.MAV_AUTOPILOT_INVALID)
"""Component, type and autopilot of who speaks on a link."""
TYPES = (c.MAV_TYPE_FIXED_WING, c.MAV_TYPE_QUADROTOR, c.MAV_TYPE_GROUND_ROVER, c.MAV_TYPE_HEXAROTOR)
AUTOPILOTS = (c.MAV_AUTOPILOT_ARDUPILOTMEGA, c.MAV_AUTOPILOT_INVALID, c.MAV_AUTOPILOT_PX4)
"""What the vehicle may say of itself all at once."""
FAILSAFES = (5.0, 5.0, 4.0, 0.0)
"""COM_OBL_RC_ACT: hold, land, position (which is return without sticks)."""


def drawn(seed: int) -> tuple[Case, OutputLevel]:
    """The flight of a seed and its output level."""
    rng = random.Random(f"fault flights {seed}")
    begin = rng.choice((Begin.ON_THE_PATH, Begin.ON_THE_PATH, Begin.BESIDE, Begin.ON_THE_GROUND))
    pilot = rng.random() < 0.15
    strikes = tuple(Strike(_phase(rng), _events(rng)) for _ in range(rng.choice((1, 1, 2, 2, 3))))
    if pilot:
        begins = Strike(Phase.STAND_BY, (e.Operator(When(0.3, 0.3), Order.OFFBOARD),))
        takes = Strike(Phase.HAND_BACK, (e.Operator(When(2.0, 2.0), Order.HOLD),))
        strikes = (begins, takes, *strikes)
    case = Case(
        f"seed {seed}", End.ENDED, strikes=strikes, begin=begin, link=_link(rng), duration=rng.uniform(0.5, 6.0),
        authority=ControlAuthority.PILOT if pilot else ControlAuthority.COMPANION,
        finish=rng.choice((Finish.HOLD, Finish.HOLD, Finish.AS_BEGUN, Finish.LAND, Finish.RETURN)),
        mission=rng.choice(("circle_r5", "circle_r5", "figure8", "line")),
        parameters={"COM_OBL_RC_ACT": rng.choice(FAILSAFES), "RTL_RETURN_ALT": 12.0, "RTL_DESCEND_ALT": 5.0},
        mutated=rng.choice((0.0, 0.0, 0.0, 0.002, 0.02)), stop_at=rng.uniform(20.0, 60.0), watched_for=0.0,
        time_out=TIME_OUT,
    )  # fmt: skip
    return case, rng.choice((OutputLevel.RATES, OutputLevel.RATES, OutputLevel.ATTITUDE, OutputLevel.MOTORS))


def simpler(case: Case) -> Iterator[Case]:
    """The case with one thing less, each in turn."""
    for i, strike in enumerate(case.strikes):
        yield dataclasses.replace(case, strikes=case.strikes[:i] + case.strikes[i + 1 :])
        for j in range(len(strike.events)) if len(strike.events) > 1 else ():
            fewer = dataclasses.replace(strike, events=strike.events[:j] + strike.events[j + 1 :])
            yield dataclasses.replace(case, strikes=(*case.strikes[:i], fewer, *case.strikes[i + 1 :]))
    if case.link.down or case.link.up:
        yield dataclasses.replace(case, link=Link())
    if case.mutated:
        yield dataclasses.replace(case, mutated=0.0)


def _phase(rng: random.Random) -> Phase:
    return rng.choice(LIKELY if rng.random() < 0.5 else PHASES)


def _link(rng: random.Random) -> Link:
    if rng.random() < 0.5:
        return Link()
    return Link(*(
        Way(
            delay=rng.choice((0.0, 0.01, 0.03)), jitter=rng.choice((0.0, 0.0, 0.02)), loss=rng.choice((0.0, 0.01, 0.2)),
            duplicated=rng.choice((0.0, 0.0, 0.1, 1.0)), reordered=rng.choice((0.0, 0.0, 0.1)),
            duplicate_delay=rng.choice((0.0, 0.003, 0.015, 0.3)),
        )
        for _ in range(2)
    ))  # fmt: skip


def _events(rng: random.Random) -> tuple[Event, ...]:
    return tuple(rng.choice(EVENTS)(rng) for _ in range(rng.choice((1, 1, 2, 3))))


def _when(rng: random.Random) -> When:
    begin = rng.choice((0.0, rng.uniform(0.0, 0.3), rng.uniform(0.0, 3.0)))
    lasts = rng.choice((rng.uniform(0.01, 0.5), rng.uniform(0.1, LONGEST), math.inf))
    return When(begin, begin + lasts)


def _once(rng: random.Random) -> When:
    begin = rng.choice((0.0, rng.uniform(0.0, 0.3), rng.uniform(0.0, 3.0)))
    return When(begin, begin)


def _traffic(rng: random.Random) -> tuple[When, bool, bool, bool, bool, frozenset[str]]:
    down, up = rng.choice(((True, True), (True, False), (True, False), (False, True)))
    kinds = frozenset(rng.sample(KINDS, rng.choice((1, 1, 2)))) if rng.random() < 0.6 else frozenset[str]()
    return (_when(rng), down, up, True, False, kinds)


def _vector(rng: random.Random, sigma: float) -> tuple[float, float, float]:
    return (rng.gauss(0.0, sigma), rng.gauss(0.0, sigma), rng.gauss(0.0, sigma))


def _operator(rng: random.Random) -> Event:
    return e.Operator(_once(rng), rng.choice(ORDERS))


def _stranger(rng: random.Random) -> Event:
    system, component, kind, autopilot = rng.choice(
        (
            (1, *QUADROTOR),
            (2, *QUADROTOR),
            (1, *COMPANION),
            (9, *COMPANION),
            (255, *GROUND_STATION),
            (3, *FIXED_WING),
        )
    )
    says = frozenset(rng.sample(tuple(e.Saying), rng.choice((1, 2, 3))))
    own_port = (system == 1 and component == 1) or rng.random() < 0.5
    mode = rng.choice((Order.HOLD, Order.LAND, Order.OFFBOARD))
    return e.Stranger(
        _when(rng), system, component, kind, autopilot, says, mode, rng.random() < 0.5, _vector(rng, 50.0), own_port
    )


EVENTS: tuple[Callable[[random.Random], Event], ...] = (
    _operator, _operator, _operator, _operator,
    lambda rng: e.LinkCut(*_traffic(rng)), lambda rng: e.LinkCut(*_traffic(rng)),
    lambda rng: e.LinkCut(*_traffic(rng)),
    lambda rng: e.LinkDuplicate(*_traffic(rng), delay=rng.choice((0.0, 0.003, 0.015, 0.3, 1.0))),
    lambda rng: e.LinkRepeat(*_traffic(rng)),
    lambda rng: e.LinkDelay(*_traffic(rng), delay=rng.choice((0.0, 0.05, 0.3, 1.0)), growth=rng.choice((0.0, 0.1, 0.5))),
    lambda rng: e.LinkThin(*_traffic(rng), rate=rng.choice((2.0, 10.0, 14.0, 40.0))),
    lambda rng: e.LinkRecut(*_traffic(rng)[:5], size=rng.randrange(1, 300), wait=rng.choice((0.0, 0.005, 0.05))),
    lambda rng: e.NotANumber(_when(rng), rng.choice(tuple(e.Part)), rng.choice((math.nan, math.inf, 3e38, -3e38))),
    lambda rng: e.Silence(_when(rng), rng.choice(tuple(e.Part))),
    lambda rng: e.FrozenState(_when(rng), rng.choice(tuple(e.Part)), rng.choice((0.0, 1e-6, 1e-3))),
    lambda rng: e.OffsetState(_when(rng), _vector(rng, 10.0), _vector(rng, 2.0), rng.uniform(-math.pi, math.pi)),
    lambda rng: e.WrongStamps(_when(rng), rng.choice(tuple(e.Stamps))),
    lambda rng: e.OdometryFrames(_when(rng), rng.choice((0, 1, 4, 18)), rng.choice((1, 8, 12, 255))),
    lambda rng: e.Impostor(_when(rng), rng.choice(TYPES), rng.choice(AUTOPILOTS)),
    lambda rng: e.EstimatorReset(_once(rng), _vector(rng, 8.0), yaw=rng.gauss(0.0, 0.5), counted=rng.random() < 0.5),
    lambda rng: e.ClockJump(_once(rng), rng.choice((0.1, 0.3, 3.0, 1000.0, -0.1, -3.0))),
    lambda rng: e.MotorFailure(_when(rng), rng.choice((1, 2, 3, 4, None)), rng.uniform(0.0, 1.0)),
    lambda rng: e.Push(_when(rng), _vector(rng, 8.0)),
    lambda rng: e.Hold(_when(rng)),
    lambda rng: e.Sticks(_when(rng), *(rng.choice((0.0, rng.uniform(-1.0, 1.0))) for _ in range(4))),
    _stranger,
    lambda rng: e.PortChange(_once(rng)),
)  # fmt: skip
"""How each kind of event is drawn; the likelier ones stand more than once."""
