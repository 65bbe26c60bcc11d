"""Setpoints -> samples for PX4, and the gate before them: section 6 of what kills a vehicle at this level, as code.

PX4 holds the last motor commands for as long as offboard_control_mode comes, and takes commands of anybody in any mode.
Therefore mode and command go out in one message or not at all; a command only where PX4 itself says, over both of its
links, that it flies on it; and before that the mode alone, which is what PX4 wants to see before OFFBOARD.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from companion.vehicle import (
    AttitudeSetpoint,
    MotorSetpoint,
    OutputLevel,
    RateSetpoint,
    Setpoint,
    TorqueSetpoint,
)
from companion.xrce.agent import Agent, Sample
from companion.xrce.flight_mode import FlightMode
from companion.xrce.topics import Layout, Topic, TopicError

CONTROL_MODE_LASTS = 0.7
"""s that a vehicle_control_mode counts: PX4 publishes it at 2 Hz, and within 22 ms of a change (xrce.md, section 6)."""
KEPT_BACK_USUALLY = 10
"""Commands kept back where one link says it before the other, at the beginning and the end (engineering choice)."""
MODE, CONTROL_MODE = "offboard_control_mode", "vehicle_control_mode"
TOPICS = {
    OutputLevel.MOTORS: ("actuator_motors", "vehicle_thrust_setpoint"),
    OutputLevel.TORQUES: ("vehicle_torque_setpoint", "vehicle_thrust_setpoint"),
    OutputLevel.RATES: ("vehicle_rates_setpoint",),
    OutputLevel.ATTITUDE: ("vehicle_attitude_setpoint",),
}
"""What PX4 must read for a level, beside the mode. PX4's land detector believes the last vehicle_thrust_setpoint, so
that one is written along with motors: without it two take-offs ended in "landed" at 6 m and a disarming."""
FLAG = {
    OutputLevel.MOTORS: "direct_actuator",
    OutputLevel.TORQUES: "thrust_and_torque",
    OutputLevel.RATES: "body_rate",
    OutputLevel.ATTITUDE: "attitude",
}
"""The flag of offboard_control_mode."""
UNUSED = (math.nan,) * 8
"""The motors of actuator_motors' twelve that a quadrotor has not: NaN leaves them stopped."""


@dataclass(slots=True)
class Commands:
    """What goes to PX4 at one ``level`` over ``agent``.

    ``tap``: called with the time, whether it goes to PX4, and the bytes of each datagram. ``refusal``: why this PX4
    cannot be commanded over it. ``flight_mode``: ours, flown in the place of OFFBOARD; None: OFFBOARD. ``sent``:
    commands so far; ``kept_back``: those that the gate kept back while PX4 said that it flies in that mode. ``raises``:
    whether what fails in here is raised; False once the last resort has begun, whose setpoints go out all the same.
    """

    level: OutputLevel
    agent: Agent = field(default_factory=Agent)
    tap: Callable[[float, bool, bytes], None] | None = None
    refusal: str | None = None
    flight_mode: FlightMode | None = None
    sent: int = 0
    kept_back: int = 0
    raises: bool = True
    _in_offboard: bool = False
    _follows: bool = False
    _said_at: float = -math.inf

    def receive(self, data: bytes, now: float) -> None:
        """Take in a datagram. Nothing is acted on: what PX4 says opens and closes the gate."""
        try:
            if self.tap is not None:
                self.tap(now, False, data)
            for sample in self.agent.receive(data, now):
                self._take(sample, now)
        except Exception:
            if self.raises:
                raise

    def datagrams(self, now: float) -> list[bytes]:
        """What is to be sent at ``now``."""
        datagrams: list[bytes] = []
        try:
            if self.flight_mode is not None and self.refusal is None:
                self._try(lambda mode: mode.write(self.agent, now))
            datagrams = self.agent.datagrams(now)
            if self.tap is not None:
                for data in datagrams:
                    self.tap(now, True, data)
        except Exception:
            if self.raises:
                raise
        return datagrams

    def next_timer(self) -> float:
        """s, when ``datagrams`` has something without anything coming in."""
        return self.agent.next_timer()

    def tell(self, can_run: bool, over: bool, completed: bool) -> None:
        """Where the flight stands, for a flight mode of ours: it may be selected; it is over, and how."""
        if self.flight_mode is not None:
            self.flight_mode.can_run = can_run
            if over:
                self.flight_mode.finish(completed=completed)

    def _take(self, sample: Sample, now: float) -> None:
        """Take in what PX4 says of its controllers at ``now`` (s)."""
        if sample.topic.name == CONTROL_MODE and (layout := self._layout(sample.topic)) is not None:
            said = layout.decode(sample.cdr)
            if said is not None:
                self._said_at = now
                self._in_offboard = said["flag_control_offboard_enabled"]
                self._follows = follows(said, self.level)
        elif self.flight_mode is not None:
            self._try(lambda mode: mode.take(self.agent, sample, now))

    def _try(self, step: Callable[[FlightMode], None]) -> None:
        """A step of our flight mode; a version of its topics that is not known here is a refusal."""
        try:
            if self.flight_mode is not None:
                step(self.flight_mode)
        except TopicError as error:
            self.refusal = str(error)

    @property
    def missing(self) -> str | None:
        """What is waited for from PX4's client, in words that follow "for the vehicle to say"; None: nothing."""
        if self.agent.is_adopted:
            return (
                "that its XRCE client has begun a new session: it still is in that of an agent that is gone, such as a "
                "companion before a restart, and begins anew within 15 s; until then it is only listened to"
            )
        lacking = self._lacking
        if lacking is None:
            return None
        return f"that its XRCE client has {lacking} (UXRCE_DDS_CFG set, this address its agent's, PX4 1.15 or later?)"

    @property
    def _lacking(self) -> str | None:
        """The first topic that PX4's client does not read, or publish, yet; None: everything is there."""
        lacking = None if self.flight_mode is None else self.flight_mode.missing(self.agent)
        if lacking is not None:
            return lacking
        for name in (MODE, *TOPICS[self.level]):
            reader = self.agent.reading.get(name)
            if reader is None or self._layout(reader.topic) is None:
                return name
        return None if self._said_at > -math.inf else CONTROL_MODE

    def send(self, setpoint: Setpoint, t_boot: float, now: float, says_so: bool) -> bool:
        """Queue a setpoint with the time (s, the vehicle's) of its state; whether the command is in what goes out.
        ``says_so``: the vehicle has just said over MAVLink that it is in OFFBOARD, or in our own mode."""
        mode, fresh = self.flight_mode, now - self._said_at <= CONTROL_MODE_LASTS
        flies = self._in_offboard if mode is None else mode.is_selected(now)
        is_open = fresh and flies and self._follows and says_so
        samples = self._command(setpoint, round(t_boot * 1e6)) if is_open else []
        if mode is None and fresh and (is_open or not flies):
            samples.insert(0, self._sample(MODE, **{FLAG[self.level]: True}))
        written = all(cdr for _, cdr in samples) and self.agent.write(samples)
        done = is_open and written
        if done and mode is not None:
            mode.notice_command(now)
        self.agent.keeps_time = not done  # see there
        self.sent += done
        self.kept_back += flies and not done
        return done

    def rehearse(self, setpoint: Setpoint, t_boot: float) -> None:
        """Encode a command, and forget it: the next finds code and data in the caches."""
        mode = self._sample(MODE, **{FLAG[self.level]: True})
        self.agent.encoded([mode, *self._command(setpoint, round(t_boot * 1e6))])

    def words(self) -> list[str]:
        """What was lost or refused so far, for people."""
        found, counters = [], self.agent.counters
        if counters.lost or counters.late or counters.garbage or counters.strange:
            found.append(
                f"XRCE: beside {counters.messages} messages of PX4's client, {counters.lost} were lost and "
                f"{counters.late} late, {counters.garbage} datagrams made no sense and {counters.strange} came from "
                "another session or client; they were skipped"
            )
        if counters.orphaned:
            found.append(
                f"XRCE: {counters.orphaned} messages of PX4's client came in a session whose agent was gone; they were "
                "only counted"
            )
        if self.agent.sessions > 1:
            found.append(f"XRCE: PX4's client began {self.agent.sessions} sessions; look at the line between the two")
        if self.kept_back > KEPT_BACK_USUALLY:
            found.append(
                f"XRCE: {self.kept_back} commands were kept back, {self.sent} sent: PX4 did not say over both of its "
                "links, and of late, that it flies on them"
            )
        return found

    def _command(self, setpoint: Setpoint, sample: int) -> list[tuple[str, bytes]]:
        """The samples of a setpoint. ``sample``: us, PX4's stamp of the state, by which it measures its latency."""
        match setpoint:
            case MotorSetpoint(commands):
                share = sum(commands) / len(commands)
                return [
                    self._sample("actuator_motors", timestamp_sample=sample, control=(*commands, *UNUSED)),
                    self._sample("vehicle_thrust_setpoint", timestamp_sample=sample, xyz=(0.0, 0.0, -share)),
                ]
            case TorqueSetpoint(torque_b, thrust):
                return [
                    self._sample("vehicle_torque_setpoint", timestamp_sample=sample, xyz=torque_b),
                    self._sample("vehicle_thrust_setpoint", timestamp_sample=sample, xyz=(0.0, 0.0, -thrust)),
                ]
            case RateSetpoint((p, q, r), thrust):
                lift = (0.0, 0.0, -thrust)
                return [self._sample("vehicle_rates_setpoint", roll=p, pitch=q, yaw=r, thrust_body=lift)]
            case AttitudeSetpoint(q_nb, thrust):
                return [self._sample("vehicle_attitude_setpoint", q_d=q_nb, thrust_body=(0.0, 0.0, -thrust))]

    def _sample(self, name: str, **values: Any) -> tuple[str, bytes]:
        """A topic's sample; its stamp 0, so that PX4 puts its own time in."""
        reader = self.agent.reading.get(name)
        layout = None if reader is None else self._layout(reader.topic)
        return name, b"" if layout is None else layout.encode(**values)

    def _layout(self, topic: Topic) -> Layout | None:
        """A topic's layout. None: this PX4's is not known here, which is remembered as a refusal."""
        try:
            return self.agent.layout(topic)
        except TopicError as error:
            self.refusal = str(error)
            return None


def follows(control_mode: dict[str, Any], level: OutputLevel) -> bool:
    """Whether PX4's controllers take setpoints of a level: what stands above it is off, what stands below it is on."""
    said = {name.removeprefix("flag_control_").removesuffix("_enabled"): value for name, value in control_mode.items()}
    match level:
        case OutputLevel.MOTORS:
            return not said["allocation"]
        case OutputLevel.TORQUES:
            return bool(said["allocation"]) and not said["rates"]
        case OutputLevel.RATES:
            return bool(said["rates"]) and not said["attitude"]
        case OutputLevel.ATTITUDE:
            return bool(said["attitude"]) and not any(said[name] for name in ("position", "velocity", "altitude"))
