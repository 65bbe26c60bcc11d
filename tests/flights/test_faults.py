"""What can go wrong, each as a flight in lockstep, and where it ends: never on the ground unless told to land.

Every one that is not flown through ends with one sentence: what happened, what was done, what to do next.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable
from dataclasses import dataclass

import pytest

from companion.fence import Circle, Fence
from companion.flight.conduct import Conduct, Limits
from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import Value, message
from companion.pilot import LEVEL_FOR, completed, epilogue
from companion.vehicle import Mode, OutputLevel, RateSetpoint
from companion.world import Link, Way, World
from companion.world.events import (
    ClockJump,
    EstimatorReset,
    Event,
    LinkCut,
    MotorFailure,
    NotANumber,
    Part,
    Push,
    Silence,
    When,
)
from sim_bridge.world_events import COMPANION, GROUND_STATION
from tests.support.flights import Flown, Operator, flight, once

FLOOR = 5.0
"""m above the ground that no fault here may cost: the paths lie at 10 m and more."""
SPEED = 3.0
"""m/s, of every path here."""
Meddling = Callable[[Flown], None]
AT = 5.0
"""s: when it happens; the path has been flown for more than four seconds then."""


@dataclass
class Watched:
    """A flight, how low the vehicle came (m), how fast it was when it happened, and at most (m/s)."""

    flown: Flown
    lowest: float
    speed: float
    fastest: float

    @property
    def said(self) -> str:
        memory = self.flown.conductor.memory
        assert memory is not None
        said = epilogue(memory, self.flown.conductor.telemetry.status.last.mode)
        assert said is not None, self.flown.notes
        assert said.count("; ") >= 1
        return said

    @property
    def mode(self) -> Mode:
        return self.flown.between.bridge.autopilot.commander.mode

    def through(self) -> bool:
        memory = self.flown.conductor.memory
        return memory is not None and completed(memory)


def fly(
    *events: Event,
    mission: str = "circle_r5",
    level: OutputLevel = OutputLevel.RATES,
    link: Link | None = None,
    meddle: Callable[[Flown, float], None] | None = None,
    prepare: Callable[[Flown], None] | None = None,
    conduct: Conduct | None = None,
    killed_at: float | None = None,
    duration: float = 8.0,
    after: float = 2.0,
) -> Watched:
    """Fly into it, and let the vehicle fly on for ``after`` s once the companion has ended."""
    heights: list[float] = []
    speed = fastest = 0.0

    def watch(flown: Flown, now: float) -> None:
        nonlocal speed, fastest
        fastest = max(fastest, math.hypot(*flown.between.truth.v_n))
        if now <= AT:
            speed = math.hypot(*flown.between.truth.v_n)
        heights.append(-flown.between.truth.p_n[2])
        if meddle is not None:
            meddle(flown, now)

    world = World(link=link or Link(), events=events)
    flown = flight(
        mission, level=level, duration=duration, speed=SPEED, world=world, meddle=watch, prepare=prepare, conduct=conduct,
        time_out=killed_at or 60.0,
    )  # fmt: skip
    bridge = flown.between.bridge
    ends = bridge.now + after
    while bridge.now < ends:
        bridge.step()
        bridge.datagrams()
        heights.append(-bridge.truth.p_n[2])
    return Watched(flown, min(heights), speed, fastest)


def cut(seconds: float) -> Event:
    return LinkCut(When(AT, AT + seconds))


def holding(flown: Flown) -> None:
    """What happens on a lost stream is HOLD, not the return that is PX4's default without sticks."""
    flown.between.bridge.autopilot.parameters["COM_OBL_RC_ACT"] = 5


@pytest.mark.parametrize("mission", ["circle_r5", "figure8"])
@pytest.mark.parametrize("level", [OutputLevel.RATES, OutputLevel.ATTITUDE])
def test_the_companion_is_killed(mission: str, level: OutputLevel) -> None:
    """Nobody asks for anything any more: PX4 notices by itself, in time."""
    watched = fly(mission=mission, level=level, prepare=holding, killed_at=AT, after=4.0)
    assert watched.speed > 0.95 * SPEED
    assert not watched.flown.conductor.done
    assert watched.mode is Mode.HOLD
    assert watched.lowest > FLOOR
    assert math.hypot(*watched.flown.between.truth.v_n) < 0.5


FLOWN = [("circle_r5", OutputLevel.RATES), ("figure8", OutputLevel.RATES), ("figure8", OutputLevel.ATTITUDE)]


@pytest.mark.parametrize(("mission", "level"), FLOWN)
@pytest.mark.parametrize("seconds", [0.3, 1.0, 5.0])
def test_the_link_is_cut(mission: str, level: OutputLevel, seconds: float) -> None:
    watched = fly(cut(seconds), mission=mission, level=level, prepare=holding)
    assert watched.speed > 0.95 * SPEED
    assert watched.mode is Mode.HOLD
    # asked for until it was so: PX4 will not go back into OFFBOARD by itself
    assert watched.flown.between.bridge.autopilot.commander.user_intended_mode is Mode.HOLD
    assert watched.said.startswith("no state from the vehicle for 0.2")
    assert "HOLD was asked for, and the vehicle is in Hold; check the link" in watched.said
    assert watched.lowest > FLOOR
    sent = [now for now, _ in watched.flown.setpoints if now > AT + 0.1]
    assert max(sent) - min(sent) <= LEVEL_FOR + 0.01


def test_what_a_dead_link_does_not_set_back_is_said() -> None:
    watched = fly(cut(60.0))
    assert watched.flown.conductor.done
    notes = [note for note in watched.flown.notes if note.startswith("COM_OF_LOSS_T") and "set" in note]
    assert notes == ["COM_OF_LOSS_T may still be 0.3: the vehicle did not answer; set it back to 1"]


@pytest.mark.parametrize(("mission", "level"), FLOWN)
def test_a_third_of_everything_is_lost(mission: str, level: OutputLevel) -> None:
    watched = fly(mission=mission, level=level, link=Link(Way(loss=0.3), Way(loss=0.3)))
    assert watched.through(), watched.flown.notes
    assert 0.95 * SPEED < watched.fastest < 1.2 * SPEED
    assert watched.mode is Mode.HOLD
    assert watched.lowest > FLOOR
    memory = watched.flown.conductor.memory
    assert memory is not None
    assert not memory.watch.gaps  # at 250 states a second a third is lost without a gap
    ended = watched.flown.path_errors[-1][0]
    assert max(error for now, error in watched.flown.path_errors if now > ended - 4.0) < 0.15


def test_everything_comes_up_to_100_ms_late() -> None:
    watched = fly(link=Link(Way(jitter=0.1), Way(jitter=0.1)))
    assert watched.through(), watched.flown.notes
    assert max(error for now, error in watched.flown.path_errors if now > AT) < 1.0


def test_everything_comes_in_another_order() -> None:
    watched = fly(link=Link(Way(reordered=0.3, duplicated=0.1), Way(reordered=0.3, duplicated=0.1)))
    assert watched.through(), watched.flown.notes
    assert max(error for now, error in watched.flown.path_errors if now > AT) < 0.3


@pytest.mark.parametrize("part", [Part.POSITION, Part.STATE])
def test_the_state_falls_silent_while_the_link_lives(part: Part) -> None:
    watched = fly(Silence(When(AT), part))
    assert watched.said.startswith("no state from the vehicle for 0.2")
    assert watched.mode is Mode.HOLD
    assert watched.lowest > FLOOR


Fields = dict[str, Value]


def altered(name: str, change: Callable[[Fields], Fields], at: float = AT, until: float = math.inf) -> Meddling:
    """Somebody in the middle who changes every message of this name from ``at`` on, on its way down or up."""
    encoders = {kind: Encoder(1, kind) for kind in (1, 191)}

    def between(data: bytes, now: float) -> list[bytes]:
        (frame,) = Decoder().datagram(data)
        if frame.format.name != name or not at < now < until:
            return [data]
        values = change(frame.format.named(frame.values))
        return [encoders[frame.component].message(frame.format, **values)]

    def prepare(flown: Flown) -> None:
        flown.between.down = flown.between.up = between

    return prepare


def frozen(*keys: str) -> Callable[[Fields], Fields]:
    """These fields stay as they first were."""
    kept: Fields = {}

    def change(fields: Fields) -> Fields:
        for key in keys:
            kept.setdefault(key, fields[key])
        return {**fields, **kept}

    return change


STALE_PARTS = {
    "position": (("x", "y", "z"), "the vehicle says that it moves, and always the same position"),
    "attitude": (("q",), "the vehicle says that it turns, and always the same attitude"),
}


@pytest.mark.parametrize(("mission", "level"), [("circle_r5", OutputLevel.ATTITUDE), ("figure8", OutputLevel.RATES)])
@pytest.mark.parametrize("part", STALE_PARTS)
def test_a_part_of_the_state_stands_still_while_the_rest_goes_on(part: str, mission: str, level: OutputLevel) -> None:
    """Stale attitude only, stale position only: nothing falls silent, and yet it is noticed within 0.2 s."""
    keys, says = STALE_PARTS[part]
    watched = fly(mission=mission, level=level, prepare=altered("ODOMETRY", frozen(*keys)))
    assert watched.said == f"{says}: HOLD was asked for, and the vehicle is in Hold; see the estimator's log"
    assert watched.mode is Mode.HOLD
    assert watched.lowest > FLOOR
    assert watched.flown.setpoints[-1][0] < AT + 0.2 + LEVEL_FOR + 0.02
    # turning cannot be told from an attitude that is not known
    last = watched.flown.setpoints[-1][1]
    assert part == "position" or not isinstance(last, RateSetpoint) or last.rates_b == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("part", STALE_PARTS)
def test_a_part_that_stands_still_for_a_moment_is_flown_through(part: str) -> None:
    keys, _ = STALE_PARTS[part]
    watched = fly(prepare=altered("ODOMETRY", frozen(*keys), until=AT + 0.15))
    assert watched.through(), watched.flown.notes
    assert max(error for now, error in watched.flown.path_errors if now > AT) < 0.5


def cuts(count: int) -> list[Event]:
    """Gaps of 0.12 s, two a second."""
    return [LinkCut(When(AT + 0.5 * i, AT + 0.5 * i + 0.12)) for i in range(count)]


def test_link_gaps() -> None:
    """None of them is long enough to be silence; five are too many."""
    watched = fly(*cuts(8))
    assert watched.said == (
        "the link has gaps: 5 of over 0.1 s within 10 s: HOLD was asked for, and the vehicle is in Hold; mend the link: "
        "antennas, range, another radio; or ask for fewer states"
    )
    assert watched.mode is Mode.HOLD
    assert watched.lowest > FLOOR
    assert max(error for _, error in watched.flown.path_errors) < 1.0


def test_a_few_link_gaps_are_flown_through() -> None:
    watched = fly(*cuts(4))
    assert watched.through(), watched.flown.notes
    assert max(error for now, error in watched.flown.path_errors if now > AT) < 0.2


def test_the_attitude_falls_silent() -> None:
    watched = fly(Silence(When(AT), Part.ATTITUDE))
    assert watched.through() or watched.said.startswith("no state from the vehicle")
    assert watched.mode is Mode.HOLD
    assert watched.lowest > FLOOR


@pytest.mark.parametrize("part", [Part.POSITION, Part.ATTITUDE])
def test_the_state_is_no_number(part: Part) -> None:
    watched = fly(NotANumber(When(AT), part))
    assert watched.said.startswith("no state from the vehicle for 0.2")
    assert watched.flown.conductor.telemetry.refused
    assert watched.mode is Mode.HOLD


def test_an_estimate_that_jumps_within_the_tube_is_flown_on() -> None:
    """The path stays where it is in the vehicle's frame; the vehicle comes back to it."""
    watched = fly(EstimatorReset(When(AT), position_n=(3.0, 2.0, 0.0)), duration=12.0)
    assert watched.through(), watched.flown.notes
    assert watched.flown.path_errors[-1][1] < 0.1
    assert watched.lowest > FLOOR


def test_an_estimate_that_jumps_out_of_the_tube_means_hold() -> None:
    watched = fly(EstimatorReset(When(AT), position_n=(5.0, 1.0, 0.0)))
    assert watched.said.startswith("the estimator moved the vehicle by 5.1 m at once")
    assert watched.mode is Mode.HOLD
    assert watched.lowest > FLOOR


def test_a_heading_that_is_reset_by_30_degrees_is_flown_on() -> None:
    watched = fly(EstimatorReset(When(AT), yaw=math.radians(30.0)), duration=10.0)
    assert watched.through(), watched.flown.notes
    assert watched.flown.path_errors[-1][1] < 0.2
    assert watched.lowest > FLOOR


@pytest.mark.parametrize("by", [3.0, -3.0])
def test_the_vehicles_clock_jumps(by: float) -> None:
    watched = fly(ClockJump(When(AT), by))
    assert "the vehicle's clock jumped" in watched.said
    assert watched.mode is Mode.HOLD
    assert watched.lowest > FLOOR


def test_a_failsafe_of_the_vehicle_is_left_alone_and_offboard_ended_after_it() -> None:
    """Its fence sends it home; it lands and disarms; and then PX4 would be in OFFBOARD again."""

    def fence(flown: Flown) -> None:
        flown.between.bridge.autopilot.parameters.update(
            GF_MAX_HOR_DIST=4.9, GF_ACTION=3, RTL_RETURN_ALT=11.0, RTL_DESCEND_ALT=4.0
        )

    watched = fly(meddle=once(AT, fence), after=0.5)
    flown = watched.flown
    assert watched.said.startswith(
        "the vehicle left OFFBOARD by itself, for Hold (a failsafe): HOLD was asked for to end"
    )
    assert flown.between.truth.on_ground
    commander = flown.between.bridge.autopilot.commander
    assert not commander.armed
    assert (commander.mode, commander.user_intended_mode) == (Mode.HOLD, Mode.HOLD)
    assert flown.setpoints[-1][0] < AT + 1.1
    asked = [now for now, f in flown.between.sent if f.format.name == "COMMAND_LONG" and now > AT]
    assert min(asked) > AT + 10.0  # nothing was asked for while the failsafe flew


@pytest.mark.parametrize(("command", "says"), [((176, 1.0, 4.0, 3.0), "Hold"), ((176, 1.0, 4.0, 6.0), "Land")])
def test_the_operator_changes_the_mode(command: tuple[float, ...], says: str) -> None:
    watched = fly(meddle=once(AT, lambda f: Operator(f.between.bridge).commands(int(command[0]), *command[1:])))
    assert watched.said == (
        f"the operator took over: the mode is {says} now: nothing more was sent; start again when it is to fly the path"
    )
    assert watched.flown.setpoints[-1][0] < AT + 0.1


def test_the_operator_disarms_in_the_air() -> None:
    """It falls, as he wanted; but when it is armed again it will not be in OFFBOARD."""
    watched = fly(meddle=once(AT, lambda f: Operator(f.between.bridge).commands(400, 0.0, 21196.0)))
    assert watched.said.startswith(
        "the vehicle was disarmed: HOLD was asked for to end OFFBOARD, and the vehicle is in Ho"
    )
    assert watched.flown.between.bridge.autopilot.commander.user_intended_mode is Mode.HOLD
    assert watched.flown.setpoints[-1][0] < AT + 1.1  # the heartbeat tells it, once a second


def test_the_pilot_moves_the_sticks() -> None:
    """Through a joystick that was there from the start."""

    def hands(flown: Flown, now: float) -> None:
        if round(now * 1000.0) % 20 == 0:
            push = min(max(0.0, 2.0 * (now - AT)), 0.9)
            encoder = Encoder(255, 190)
            flown.between.bridge.receive(
                encoder.message(message("MANUAL_CONTROL"), target=1, x=round(1000 * push), z=500), GROUND_STATION
            )

    watched = fly(meddle=hands, after=0.0)
    assert watched.said.startswith("the operator took over: the mode is Position now")
    assert watched.mode is Mode.POSITION
    assert watched.flown.setpoints[-1][0] < AT + 1.0


def test_the_missions_fence() -> None:
    def fenced(flown: Flown) -> None:
        orders = flown.conductor.orders
        fence = Fence((Circle((0.0, 0.0), 4.6, inside=False),))
        flown.conductor.orders = orders.__class__(
            **{**orders.__dict__, "mission": orders.mission.__class__(**{**orders.mission.__dict__, "fence": fence})}
        )

    push = Push(When(AT, AT + 0.6), (0.0, 0.0, 0.0))
    watched = fly(push, EstimatorReset(When(AT), position_n=(-2.0, -2.0, 0.0)), prepare=fenced, duration=12.0)
    if watched.through():
        pytest.fail(str(watched.flown.notes))
    assert "outside the mission's fence" in watched.said
    assert watched.mode is Mode.HOLD


def test_the_vehicles_fence() -> None:
    """We hand back before the autopilot's own fence acts."""

    def fenced(flown: Flown) -> None:
        flown.between.bridge.autopilot.parameters["GF_MAX_HOR_DIST"] = 5.5

    watched = fly(prepare=fenced)
    assert "at the vehicle's own fence of 5.5 m (GF_MAX_HOR_DIST)" in watched.said
    assert watched.mode is Mode.HOLD
    assert watched.lowest > FLOOR


def test_floor_and_ceiling() -> None:
    for limits, says in ((Limits(floor=11.0), "below the floor of 11 m"), (Limits(ceiling=9.0), "ceiling of 9 m")):
        watched = fly(conduct=Conduct(limits=limits), after=0.5)
        assert says in watched.said
        assert watched.mode is Mode.HOLD


def test_the_battery_is_low() -> None:
    fmt = message("BATTERY_STATUS")

    def drain(flown: Flown) -> None:
        flown.between.down = lambda data, now: (
            [Encoder(1, 1).message(fmt, battery_remaining=12)] if data[7] == fmt.id and now > AT else [data]
        )

    watched = fly(prepare=drain, duration=12.0)
    assert watched.said == (
        "the battery is at 12 %, below 15 %: HOLD was asked for, and the vehicle is in Hold; land it and charge"
    )
    assert watched.lowest > FLOOR


def test_a_motor_fails() -> None:
    """Nothing flies on three: but it is noticed at once, said, and the autopilot is asked to hold."""
    watched = fly(MotorFailure(When(AT), 1), after=0.0)
    memory = watched.flown.conductor.memory
    assert memory is not None
    assert memory.first_fault is not None
    assert memory.first_fault.startswith("thrust does not answer (a motor, propeller or battery)"), memory.first_fault
    assert "motors and propellers" in watched.said


def unmoved(fields: Fields) -> Fields:
    """No body rate is asked for, and the attitude that was asked for first."""
    return {**fields, "body_roll_rate": 0.0, "body_pitch_rate": 0.0, "body_yaw_rate": 0.0}


@pytest.mark.parametrize("level", [OutputLevel.RATES, OutputLevel.ATTITUDE])
def test_the_rate_loop_does_not_answer(level: OutputLevel) -> None:
    """The vehicle keeps its attitude, whatever is commanded: no rate is wrong, and no tilt is steep."""
    change = unmoved if level is OutputLevel.RATES else frozen("q")
    watched = fly(level=level, prepare=altered("SET_ATTITUDE_TARGET", change))
    assert re.match("the tilt is [456]. degrees off the commanded one: HOLD was asked for", watched.said)
    assert "motors and propellers" in watched.said
    assert watched.mode is Mode.HOLD
    assert watched.lowest > FLOOR
    # which tilt is held is chance; held for good, it takes the vehicle off by the square of the time until it is told
    assert max(error for _, error in watched.flown.path_errors) < 1.3


def test_at_motors_a_weak_motor_is_made_up_for_or_named() -> None:
    """There is no rate loop that would: what the body turns beside its torques is taken out of them, and tells which
    share of its thrust a motor still gives."""
    watched = fly(MotorFailure(When(AT), 1, left=0.75), level=OutputLevel.MOTORS, duration=8.0)
    assert watched.through(), watched.flown.notes
    assert max(error for _, error in watched.flown.path_errors) < 0.3
    watched = fly(MotorFailure(When(AT), 1, left=0.5), level=OutputLevel.MOTORS, after=0.0)
    assert re.match(
        r"thrust does not answer \(a motor or propeller\): one gives [56]. % of what it is told", watched.said
    )
    assert watched.flown.path_errors[-1][1] < 0.5


def test_a_weak_motor_is_flown_with() -> None:
    watched = fly(MotorFailure(When(AT), 1, left=0.8), duration=10.0)
    assert watched.through(), watched.flown.notes
    assert watched.lowest > FLOOR


def test_another_vehicle_answers_in_flight() -> None:
    """Its states, its modes and its refusals are not ours."""
    other = Encoder(2, 1)
    frames = [
        other.message(message("HEARTBEAT"), autopilot=12, type=2, system_status=4, custom_mode=0x03040000),
        other.message(message("ODOMETRY"), frame_id=1, child_frame_id=1, q=(1, 0, 0, 0), x=50.0, time_usec=9_000_000),
        other.message(message("CURRENT_MODE"), custom_mode=0x03040000),
    ]

    def speak(flown: Flown, now: float) -> None:
        if now > AT and round(now * 1000.0) % 100 == 0:
            flown.conductor.receive([(frame, COMPANION) for frame in frames], now)

    watched = fly(meddle=speak)
    assert watched.through(), watched.flown.notes


def test_a_second_companion_speaks_on_the_link() -> None:
    other = Encoder(1, 191)
    beat = other.message(message("HEARTBEAT"), autopilot=8, type=18, system_status=4)

    def speak(flown: Flown, now: float) -> None:
        if now > AT and round(now * 1000.0) % 1000 == 0:
            flown.conductor.receive([(beat, COMPANION)], now)

    watched = fly(meddle=speak, duration=10.0)
    assert watched.said.startswith("another companion speaks on the link")
    assert watched.mode is Mode.HOLD


def test_two_autopilots_or_a_second_companion_before_the_flight() -> None:
    for component, autopilot, kind, says in ((1, 12, 2, "two autopilots"), (191, 8, 18, "another companion")):
        beat = Encoder(1 if component == 191 else 7, component).message(
            message("HEARTBEAT"), autopilot=autopilot, type=kind, system_status=4
        )

        def speak(flown: Flown, beat: bytes = beat) -> None:
            flown.between.down = lambda data, now: [beat, data]

        watched = flight(prepare=speak, time_out=70.0)
        conductor = watched.conductor
        assert not watched.setpoints
        reason = conductor.refusal or (conductor.memory and conductor.memory.first_fault) or ""
        assert says in reason


def test_setpoints_never_repeat_and_never_jump_in_time() -> None:
    watched = fly(link=Link(Way(loss=0.2, reordered=0.2)))
    times = [now for now, _ in watched.flown.setpoints]
    assert all(b > a for a, b in itertools.pairwise(times))
