"""Who is believed, for how long, and who decides: dirty links, dying links and operators, each as a flight in lockstep.

Nothing that changes mode, arming or place is sent later than the rules allow (docs/flight.md), whatever happens.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.config.world.world import load_world
from companion.flight.conduct import Conduct
from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import Value, message
from companion.mission import Origin
from companion.pilot import completed, epilogue
from companion.vehicle import Mode, OutputLevel
from companion.world import Link, Way, World
from companion.world.events import LinkDelay, LinkThin, MotorFailure, Push, When
from tests.support.flights import Flown, Operator, flight, name_of, once, silent

LEVELS = [OutputLevel.RATES, OutputLevel.ATTITUDE, OutputLevel.MOTORS]
MOVES_OR_ARMS = {20, 21, 22, 176, 192, 300, 400}
"""MAV_CMD of return, land, take-off, mode, reposition, mission start, arming."""
HOLD, LAND, OFFBOARD = (1.0, 4.0, 3.0), (1.0, 4.0, 6.0), (1.0, 6.0, 0.0)
AT = 4.0
"""s: when it happens to a flight that began in a hover."""
Filter = Callable[[bytes, float], list[bytes]]
Fields = dict[str, Value]


def commands(flown: Flown, since: float) -> list[tuple[float, int, float]]:
    """What was sent after ``since`` that changes mode, arming or place: time, command, second parameter."""
    found = []
    for now, frame in flown.between.sent:
        values = frame.format.named(frame.values)
        if frame.format.name in ("COMMAND_LONG", "COMMAND_INT") and values["command"] in MOVES_OR_ARMS and now > since:
            found.append((now, values["command"], values["param2"]))
        assert frame.format.name not in ("SET_MODE", "MISSION_START")
    return found


def said(flown: Flown) -> str:
    memory = flown.conductor.memory
    assert memory is not None
    sentence = epilogue(memory, flown.conductor.telemetry.status.last.mode)
    assert sentence is not None, flown.notes
    return sentence


def through(flown: Flown) -> bool:
    return flown.conductor.memory is not None and completed(flown.conductor.memory)


class Worst:
    """The lowest height (m) and the steepest tilt (degrees) from AT on, as they truly were."""

    def __init__(self) -> None:
        self.lowest, self.tilt = math.inf, 0.0

    def __call__(self, flown: Flown, now: float) -> None:
        if now >= AT:
            truth = flown.between.truth
            _, x, y, _ = truth.q_nb
            self.lowest = min(self.lowest, -truth.p_n[2])
            self.tilt = max(self.tilt, math.degrees(2.0 * math.asin(min(1.0, math.hypot(x, y)))))


def altered(name: str, change: Callable[[Fields, float], Fields | None], since: float = 0.0) -> Callable[[Flown], None]:
    """Somebody in the middle who changes, or drops, every message of a name from the vehicle."""
    encoder = Encoder(1, 1)

    def down(data: bytes, now: float) -> list[bytes]:
        (frame,) = Decoder().datagram(data)
        if frame.format.name != name or now < since:
            return [data]
        fields = change(frame.format.named(frame.values), now)
        return [] if fields is None else [encoder.message(frame.format, **fields)]

    def prepare(flown: Flown) -> None:
        flown.between.down = down

    return prepare


def cut(flown: Flown) -> None:
    """The vehicle is heard no more; it hears us."""
    flown.between.down = lambda data, now: []


class Later:
    """Hands on what comes, after ``delay(now)`` s, with the flight's own steps as its clock."""

    def __init__(self, delay: Callable[[float], float], *, copies: bool = False, names: set[str] | None = None) -> None:
        self._delay, self._copies, self._names = delay, copies, names
        self._waiting: list[tuple[float, int, bytes]] = []
        self._count = 0

    def __call__(self, data: bytes, now: float) -> list[bytes]:
        if self._names is not None and name_of(data) not in self._names:
            return [data]
        self._count += 1
        self._waiting.append((now + self._delay(now), self._count, data))
        self._waiting.sort()
        passed = [data] if self._copies else []
        while self._waiting and self._waiting[0][0] <= now:
            passed.append(self._waiting.pop(0)[2])
        return passed


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("after", [0.0, 0.015])
def test_every_state_twice_is_flown_as_if_it_came_once(after: float, level: OutputLevel) -> None:
    def prepare(flown: Flown) -> None:
        flown.between.down = Later(lambda now: after, copies=True, names={"ODOMETRY"})

    flown = flight(level=level, duration=3.0, prepare=prepare)
    assert through(flown), flown.notes
    assert flown.path_errors[-1][1] < 0.05


@pytest.mark.parametrize(("factor", "says"), [(0.0, "do not advance"), (1e-3, "advance by 0.001 s a second")])
def test_stamps_that_are_none_are_named_and_not_flown(factor: float, says: str) -> None:
    change = altered("ODOMETRY", lambda fields, now: {**fields, "time_usec": int(factor * fields["time_usec"])})
    flown = flight(level=OutputLevel.RATES, from_ground=True, prepare=change, time_out=70.0)
    assert flown.conductor.done
    assert says in said(flown)
    assert not commands(flown, 0.0)


@pytest.mark.parametrize("level", LEVELS)
def test_the_last_state_repeated_for_ever_is_given_up(level: OutputLevel) -> None:
    kept: list[Fields] = []

    def repeat(fields: Fields, now: float) -> Fields:
        kept.append(fields)
        return kept[0]

    worst = Worst()
    flown = flight(level=level, prepare=altered("ODOMETRY", repeat, AT), meddle=worst)
    assert "the same one comes again and again" in said(flown)
    assert flown.setpoints[-1][0] < AT + 0.55
    assert worst.lowest > 8.0


@pytest.mark.parametrize("level", LEVELS)
def test_a_delay_that_grows_ends_in_hold_while_it_still_flies(level: OutputLevel) -> None:
    worst = Worst()

    def prepare(flown: Flown) -> None:
        flown.between.down = Later(lambda now: max(0.0, 0.1 * (now - AT)))

    flown = flight(level=level, duration=20.0, prepare=prepare, meddle=worst)
    assert "late" in said(flown) or "there and back, more than 0.1 s" in said(flown)  # at motors that comes first
    assert worst.tilt < 45.0
    assert worst.lowest > 8.0
    assert flown.between.bridge.autopilot.commander.mode is Mode.HOLD


@pytest.mark.parametrize(("each_way", "flies"), [(0.08, True), (0.12, False), (0.15, False)])
def test_a_link_that_is_too_slow_is_not_flown_with(each_way: float, flies: bool) -> None:
    world = World(link=Link(Way(delay=each_way), Way(delay=each_way)))
    flown = flight(level=OutputLevel.RATES, duration=2.0, world=world, time_out=75.0)
    assert any(note.startswith("waiting: a message takes") for note in flown.notes) is not flies
    if flies:
        assert through(flown), flown.notes
    else:
        assert f"a message takes {100 * each_way:.0f}" in said(flown)
        assert not commands(flown, 0.0)


def test_a_simulators_clock_that_runs_slow_is_no_delay() -> None:
    """At 0.95 of ours all along, as PX4's simulator does on a busy computer, and back to 1."""
    slow = {"now": 0.0, "own": 0.0}

    def stamp(now: float) -> float:
        pace = 0.95 if now < 12.0 else 1.0
        slow["own"] += pace * (now - slow["now"])
        slow["now"] = now
        return slow["own"]

    encoder = Encoder(1, 1)

    def down(data: bytes, now: float) -> list[bytes]:
        (frame,) = Decoder().datagram(data)
        fields = frame.format.named(frame.values)
        if frame.format.name == "ODOMETRY":
            return [encoder.message(frame.format, **{**fields, "time_usec": round(1e6 * stamp(now))})]
        if frame.format.name == "TIMESYNC" and fields["tc1"]:
            return [encoder.message(frame.format, **{**fields, "tc1": round(1e9 * stamp(now))})]
        return [data]

    flown = flight(level=OutputLevel.RATES, duration=15.0, prepare=lambda f: setattr(f.between, "down", down))
    assert through(flown), flown.notes


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("part", ["position", "attitude"])
def test_a_part_that_stands_still_but_for_a_little_noise(part: str, level: OutputLevel) -> None:
    rng, kept, worst = random.Random(1), {}, Worst()

    def freeze(fields: Fields, now: float) -> Fields:
        keys = ("x", "y", "z") if part == "position" else ("q",)
        for key in keys:
            kept.setdefault(key, fields[key])

        def noisy(value: Value) -> Value:
            return (
                [v + rng.gauss(0.0, 1e-6) for v in value]
                if isinstance(value, list | tuple)
                else value + rng.gauss(0.0, 1e-6)
            )

        return {**fields, **{key: noisy(kept[key]) for key in keys}}

    flown = flight(level=level, prepare=altered("ODOMETRY", freeze, AT), meddle=worst)
    assert f"always the same {part}" in said(flown)
    first = commands(flown, AT - 1e-3)[0]
    assert first[0] < AT + (0.3 if part == "position" else 0.6)
    assert worst.tilt < 45.0


@pytest.mark.parametrize("level", LEVELS)
def test_a_jump_without_the_reset_counter(level: OutputLevel) -> None:
    worst = Worst()
    jump = altered("ODOMETRY", lambda fields, now: {**fields, "x": fields["x"] + 20.0}, AT)
    flown = flight(level=level, prepare=jump, meddle=worst)
    assert "the position jumped by 20.0 m" in said(flown)
    assert commands(flown, AT - 1e-3)[0][0] < AT + 0.3
    assert worst.tilt < 45.0


def in_phase(phase: str, action: Callable[[Flown, float], None], wait: float = 0.0) -> Callable[[Flown, float], None]:
    """Something that happens once, ``wait`` s after a phase began."""
    begun: list[float] = []
    done: list[bool] = []

    def meddle(flown: Flown, now: float) -> None:
        if not begun and any(f"-> {phase}:" in note for note in flown.notes):
            begun.append(now)
        if begun and not done and now >= begun[0] + wait:
            done.append(True)
            action(flown, now)

    return meddle


PHASES = [("arm", 0.0), ("take off", 0.0), ("take off", 2.0), ("take over", 0.0), ("hand back", 0.0), ("land", 0.02)]


@pytest.mark.parametrize(("phase", "wait"), PHASES)
@pytest.mark.parametrize("operator", [LAND, HOLD])
def test_the_downlink_is_lost_and_the_operator_decides(
    phase: str, wait: float, operator: tuple[float, float, float]
) -> None:
    """He is not heard, and yet nothing is asked for any more from a second after the last word on."""
    lost: list[float] = []

    def lose(flown: Flown, now: float) -> None:
        cut(flown)
        lost.append(now)
        Operator(flown.between.bridge).commands(176, *operator)

    flown = flight(
        level=OutputLevel.RATES, duration=1.0, from_ground=True, meddle=in_phase(phase, lose, wait), time_out=60.0
    )
    assert lost, flown.notes
    assert not commands(flown, lost[0] + 1.0), flown.notes
    assert all(now < lost[0] + 0.6 for now, _ in flown.setpoints)


def test_the_operator_disarms_just_after_arming() -> None:
    def disarm(flown: Flown, now: float) -> None:
        Operator(flown.between.bridge).commands(400, 0.0)

    flown = flight(level=OutputLevel.RATES, from_ground=True, meddle=in_phase("arm", disarm, 0.06), time_out=60.0)
    assert "disarmed after ARM was accepted" in said(flown)
    assert [command for _, command, _ in commands(flown, 0.0)] == [400]
    assert flown.between.truth.on_ground


def test_what_was_armed_unanswered_is_not_called_unflown() -> None:
    unanswered = silent("COMMAND_ACK", since=0.0)
    lost = in_phase("take over", lambda flown, now: silent("COMMAND_ACK", "ODOMETRY", since=now)(flown))
    flown = flight(level=OutputLevel.RATES, from_ground=True, prepare=unanswered, meddle=lost)
    assert "nothing was flown" not in said(flown)
    assert "the vehicle is in Hold" in said(flown)


def test_offboard_requests_are_lost_and_the_operator_lands() -> None:
    def lossy(flown: Flown) -> None:
        def up(data: bytes, now: float) -> list[bytes]:
            (frame,) = Decoder().datagram(data)
            fields = frame.format.named(frame.values)
            return [] if fields.get("command") == 176 else [data]

        flown.between.up = up

    def land(flown: Flown, now: float) -> None:
        Operator(flown.between.bridge).commands(176, *LAND)

    flown = flight(level=OutputLevel.RATES, prepare=lossy, meddle=in_phase("take over", land, 0.7), time_out=30.0)
    assert said(flown).startswith("the operator took over: the mode is Land now")
    assert flown.between.bridge.autopilot.commander.mode is Mode.LAND


@pytest.mark.parametrize("level", LEVELS)
def test_the_status_falls_silent_while_the_states_come(level: OutputLevel) -> None:
    land = once(AT + 0.3, lambda flown: Operator(flown.between.bridge).commands(176, *LAND))
    quiet = silent("HEARTBEAT", "CURRENT_MODE", since=AT)
    flown = flight(level=level, duration=None, prepare=quiet, meddle=land, time_out=30.0)
    assert "has not said its mode" in said(flown)
    assert not commands(flown, AT)
    assert flown.setpoints[-1][0] < AT + 3.0
    assert flown.between.bridge.autopilot.commander.mode is Mode.LAND


def test_the_link_is_back_and_offboard_still_meant() -> None:
    """HOLD at most three times more, on fresh knowledge, until it is meant no longer."""

    def meddle(flown: Flown, now: float) -> None:
        away = AT <= now < AT + 4.0
        flown.between.down = flown.between.up = (lambda data, now: []) if away else (lambda data, now: [data])

    flown = flight(level=OutputLevel.RATES, meddle=meddle, time_out=60.0)
    assert flown.between.bridge.autopilot.commander.user_intended_mode is not Mode.OFFBOARD
    assert 1 <= len(commands(flown, AT + 4.0)) <= 3


@pytest.mark.parametrize("mode", [LAND, (1.0, 4.0, 5.0)])
def test_a_vehicle_in_somebody_elses_hands_is_not_taken(mode: tuple[float, float, float]) -> None:
    take = once(0.0, lambda flown: Operator(flown.between.bridge).commands(176, *mode))
    flown = flight(level=OutputLevel.RATES, prepare=lambda flown: take(flown, 1.0), time_out=100.0)
    assert "the companion takes over only from Hold or Position" in said(flown)
    assert not commands(flown, 0.0)


def test_after_somebody_elses_landing_it_is_not_armed() -> None:
    """The flight waits for the battery while the operator lands and disarms."""
    low = message("BATTERY_STATUS")

    def prepare(flown: Flown) -> None:
        encoder = Encoder(1, 1)
        flown.between.down = lambda data, now: (
            [encoder.message(low, battery_remaining=5 if now < 30.0 else 90)]
            if name_of(data) == "BATTERY_STATUS" else [data]
        )  # fmt: skip

    land = once(2.0, lambda flown: Operator(flown.between.bridge).commands(176, *LAND))
    flown = flight(level=OutputLevel.RATES, prepare=prepare, meddle=land, conduct=Conduct(), time_out=100.0)
    assert flown.conductor.done
    assert not commands(flown, 0.0)


def thrust_lost(left: float, level: OutputLevel) -> tuple[Flown, Worst, float]:
    """A flight whose first motor has only so much left from AT on; and how long after that it was given up, s."""
    worst = Worst()
    ended: list[float] = []

    def meddle(flown: Flown, now: float) -> None:
        if not any("follow -> abort" in note for note in flown.notes):
            worst(flown, now)
        elif not ended:
            ended.append(now - AT)

    world = World(events=(MotorFailure(When(AT), 1, left),))
    flown = flight(level=level, duration=8.0, world=world, meddle=meddle)
    assert ended, flown.notes
    return flown, worst, ended[0]


@pytest.mark.parametrize(("left", "within"), [(0.5, 0.85), (0.0, 0.45)])
@pytest.mark.parametrize("level", LEVELS)
def test_thrust_that_does_not_answer_is_the_cause_that_is_named(left: float, within: float, level: OutputLevel) -> None:
    flown, worst, ended = thrust_lost(left, level)
    assert "thrust does not answer" in said(flown)
    assert "motors and propellers" in said(flown)
    assert ended < within
    assert worst.lowest > 9.5


@pytest.mark.parametrize("level", [OutputLevel.RATES, OutputLevel.ATTITUDE])
def test_a_push_from_above_is_no_lost_thrust(level: OutputLevel) -> None:
    """A fifth of its weight more for half a second, as a payload that is hooked on."""
    world = World(events=(Push(When(AT, AT + 0.5), (0.0, 0.0, 4.0)),))
    assert through(flight(level=level, duration=4.0, world=world))


@pytest.mark.parametrize(
    ("prepare", "says"),
    [
        (silent("ODOMETRY", since=0.0), "ODOMETRY"),
        (altered("ODOMETRY", lambda fields, now: {**fields, "frame_id": 20}), "ODOMETRY in frame 20"),
        (silent("EXTENDED_SYS_STATE", since=0.0), "EXTENDED_SYS_STATE"),
    ],
)
def test_what_is_missing_is_named_and_the_flight_given_up(prepare: Callable[[Flown], None], says: str) -> None:
    named: list[float] = []

    def listen(flown: Flown, now: float) -> None:
        if not named and any(says in note for note in flown.notes):
            named.append(now)

    flown = flight(level=OutputLevel.RATES, prepare=prepare, meddle=listen, time_out=70.0)
    assert named and named[0] < 10.0
    assert flown.conductor.refusal is not None and says in flown.conductor.refusal


def test_a_home_that_is_missing_is_named() -> None:
    """A mission that counts from home, and a vehicle without one: said within 10 s, and given up."""
    named: list[float] = []

    def listen(flown: Flown, now: float) -> None:
        if not named and any(note.startswith("waiting") and "HOME_POSITION" in note for note in flown.notes):
            named.append(now)

    quiet = silent("HOME_POSITION", since=0.0)
    flown = flight(level=OutputLevel.RATES, prepare=quiet, meddle=listen, time_out=70.0, origin=Origin.HOME)
    assert named and named[0] < 10.0
    assert flown.conductor.refusal is not None and "HOME_POSITION" in flown.conductor.refusal
    assert not commands(flown, 0.0)


def test_fourteen_states_a_second_are_refused_with_the_limit() -> None:
    world = World(events=(LinkThin(When(0.0), up=False, messages=frozenset({"ODOMETRY"}), rate=14.0),))
    flown = flight(level=OutputLevel.RATES, world=world, time_out=75.0)
    assert any(note.startswith("waiting: only 14 states a second arrive, 20 are needed") for note in flown.notes)
    assert "20 are needed" in said(flown)
    assert not commands(flown, 0.0)


@pytest.mark.parametrize("level", LEVELS)
def test_setpoints_that_come_later_and_later_end_in_hold_while_it_still_flies(level: OutputLevel) -> None:
    worst = Worst()
    world = World(events=(LinkDelay(When(AT), down=False, growth=0.1),))
    flown = flight(level=level, duration=20.0, world=world, meddle=worst)
    assert worst.tilt < 45.0
    assert worst.lowest > 8.0
    assert flown.between.bridge.autopilot.commander.mode is Mode.HOLD
    assert "there and back" in said(flown)


def test_states_that_come_later_and_later_are_named_before_the_attitude_is_lost() -> None:
    """ODOMETRY alone, by 0.05 s a second: the round trip shows nothing of it. Real PX4 tilted by 73 degrees over it."""
    delay = LinkDelay(When(AT), up=False, growth=0.05, messages=frozenset({"ODOMETRY"}))
    world, worst = replace(load_world("sih"), events=(delay,)), Worst()
    flown = flight("circle_r5", "sih", OutputLevel.RATES, 20.0, world=world, meddle=worst)
    assert worst.tilt < 35.0
    assert "states come 0." in said(flown)
    assert "mend the link" in said(flown)
