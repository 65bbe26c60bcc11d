"""One flight, without sockets or clocks: datagrams and the time in, datagrams out.

Here, and only here, MAVLink and the pilot meet. ``loop`` runs a conductor on a real link; the simulator runs the same
conductor against the plant under a simulated clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from companion import pilot
from companion.daemon.asked_of_vehicle import COMMANDS, WANTED, answer_to, streams
from companion.daemon.ground import WANTED as GROUND_WANTED
from companion.daemon.ground import GroundSide
from companion.daemon.orders import Orders, commands_of
from companion.daemon.payload import Payload
from companion.daemon.preparing import Preparation
from companion.daemon.state_count import StateCount
from companion.daemon.tick import Tick, UnfinishedTick
from companion.estimation.learned import Learned
from companion.flight.phases import EXITS, NOT_FLYING, Event, Phase
from companion.flight.situation import Answer
from companion.geodesy import LocalFrame
from companion.mavlink import link as wire
from companion.mavlink import setpoints, telemetry
from companion.mavlink.codec import Decoder
from companion.mavlink.parameters import Parameters
from companion.mavlink.peer import Received
from companion.mavlink.repeats import Repeats
from companion.mavlink_common import MAV_COMP_ID_AUTOPILOT1
from companion.pilot import Memory, Observation
from companion.plan import Plan
from companion.record.ticks import TickRecorder
from companion.vehicle import CompanionError, Setpoint, TorqueSetpoint, VehicleState, is_finite

__all__ = ["Conductor", "Orders", "Tick"]

ENDING = frozenset(phase for phase, exits in EXITS.items() if exits and Event.STOP not in dict(exits))
"""The phases that a stop does not end: they end the flight as it is."""


class Conductor:
    """One companion flying one vehicle.

    Doors: ``receive`` and ``on_timer`` take the time (s, monotonic); ``datagrams`` gives what is to be sent;
    ``finish_tick`` is called when that is done, and may leave more of it; ``next_timer`` says when to call again.
    ``notes``: lines for people, taken by the caller. ``xrce``: where setpoints go to PX4's XRCE client, the same doors
    for that link. ``now``: s, the stamp of what is recorded.
    """

    def __init__(self, orders: Orders, recorder: TickRecorder | None, now: float, *, stream: bool = False) -> None:
        self.orders = orders
        self.xrce = commands_of(orders, recorder) if orders.over_xrce else None
        self.link = wire.Link(streams=streams(orders.vehicle.state_rate))
        self.parameters = Parameters(self.link.send)
        self.telemetry = telemetry.Telemetry()
        self._frames: list[bytes] = []  # what came and went since the last ``finish_tick``, for the record
        self.repeats = Repeats()
        self.decoder = Decoder(wanted=WANTED)
        if recorder is not None:
            self.decoder.tap = self._frames.append
        self.plan: Plan | None = None
        self.memory: Memory | None = None
        self.notes: list[str] = []
        self.ground = GroundSide(self.link.send, self.notes.append, orders.conduct.speed_scale_max)
        self.payload = Payload(self.notes.append)
        self.last: Tick | None = None
        self._states = StateCount(now)
        self._late = 0.0
        self.link.clock.may_stand = orders.conduct.at_once
        self._stream = stream
        self._stop = False
        self.preparation = Preparation(self.link, self.telemetry, self.parameters, self.notes, xrce=self.xrce)
        self._wake_at = now
        self._unfinished: UnfinishedTick | None = None
        self._unrecorded: Tick | None = None
        self._recorder = recorder
        self.now = now
        self._relay: Callable[[list[bytes]], None] | None = None

    def relay(self, take: Callable[[list[bytes]], None]) -> None:
        """Have ``take`` called with the frames that came from the vehicle or went to it, after the setpoint."""
        self._relay = take
        self.decoder.tap = self._frames.append

    @property
    def done(self) -> bool:
        """Whether there is nothing left to do."""
        return self._over and not self.preparation.changed

    @property
    def refusal(self) -> str | None:
        """Why the flight was not even begun, in one sentence."""
        return self.preparation.refusal

    @property
    def _over(self) -> bool:
        return self.preparation.refusal is not None or (self.memory is not None and self.memory.phase is Phase.DONE)

    @property
    def learned(self) -> Learned | None:
        """What the flight found out of its vehicle; None if that is nothing."""
        if self.plan is None or self.memory is None or self.memory.steering.memory is None:
            return None
        return self.plan.steering.learned_values(self.memory.steering.memory)

    @property
    def states(self) -> int:
        """States that arrived so far."""
        return self._states.total

    def stop(self) -> None:
        """Hand the vehicle back at the next tick. Where it already goes by itself to its end, that is told."""
        if not self._stop and self.memory is not None and self.memory.phase in ENDING:
            self.notes.append(f"told to stop: {self.memory.phase.value} goes on to its end; a second time ends at once")
        self._stop = True
        self._wake_at = -math.inf

    def receive(self, batch: Sequence[Received], now: float) -> None:
        """Take in what arrived at ``now``. Several datagrams are taken in before the newest state is acted on."""
        self._conclude()
        status = self.telemetry.status
        state, answer, count = self.take_in(batch, now)
        if state is not None or answer is not None or self.telemetry.status is not status:
            self._tick(state, answer, now, max(count - 1, 0))

    def take_in(self, batch: Sequence[Received], now: float) -> tuple[VehicleState | None, Answer | None, int]:
        """Read what arrived at ``now`` and act on nothing: the newest state, the last answer to a request, and how many
        states came. ``receive`` flies on it; whoever ends a flight whose pilot has failed only looks. What comes from
        elsewhere than the vehicle is counted and has no effect."""
        self.now = now
        if self.xrce is not None and self.xrce.flight_mode is not None:
            self.telemetry.own_mode = self.xrce.flight_mode.mode
        state: VehicleState | None = None
        answer: Answer | None = None
        count, late = 0, 0.0
        decoder, stream, peers = self.decoder, self._stream, self.link.peers
        for data, source in batch:
            if source == peers.heard:
                peers.heard_at = now
            elif peers.knock(data, source, now):
                decoder.restart()
                self.link.on_new_source(now)
            else:
                continue
            for frame in decoder.stream(data) if stream else decoder.piece(data, now):
                if self.link.of_vehicle(frame) and self.repeats.is_repeat(frame):
                    continue
                acknowledged = self.link.receive(frame, now)
                if acknowledged is not None:
                    answer = None if self.payload.take_answer(*acknowledged, now) else answer_to(*acknowledged)
                of_vehicle = self.link.of_vehicle(frame)
                if frame.format.id in GROUND_WANTED and self.link.identity is not None:
                    self.ground.receive(frame, self.link.identity.system, now, of_vehicle=of_vehicle)
                elif of_vehicle:
                    self.preparation.on_heartbeat(self.orders.vehicle, frame.system, now)
                    self.parameters.receive(frame)
                    arrived = self.telemetry.receive(frame, now)
                    if arrived is not None:
                        self._late = self.link.clock.late(arrived.t_boot, now)
                        if state is None or arrived.t_boot >= state.t_boot:
                            state, late = arrived, self._late
                        count += self._states.is_new(arrived.t_boot, self.link.clock.restarts)
        for _, text in self.link.texts:
            self.notes.append(f"vehicle: {text}")
        self.link.texts.clear()
        self._late = late
        self.preparation.report_restored()
        self._states.add(count, now)
        return state, answer, count

    def on_timer(self, now: float) -> None:
        """Do what is due."""
        self._conclude()
        self.now = now
        self.link.on_timer(now)
        self.parameters.on_timer(now)
        self.payload.on_timer(now)
        self.preparation.report_restored()
        self.ground.on_timer(now)
        if now >= self._wake_at:
            self._tick(None, None, now)

    def next_timer(self) -> float:
        """When ``on_timer`` wants to be called."""
        link, parameters, ground, payload = self.link, self.parameters, self.ground, self.payload
        return min(self._wake_at, link.next_timer(), parameters.next_timer(), ground.next_timer(), payload.next_timer())

    def datagrams(self) -> list[bytes]:
        """What is to be sent now, as it was queued. What ``supervise`` queues comes after ``finish_tick``."""
        outgoing, self.link.outgoing = self.link.outgoing, []
        self._frames += outgoing
        return outgoing

    def finish_tick(self, latency: float = math.nan) -> None:
        """The datagrams are on their way, ``latency`` s after what caused them arrived. The rest of the tick."""
        if self._recorder is not None:
            for frame in self._frames:
                self._recorder.add_frame(self.now, frame)
        if self._relay is not None:
            self._relay(self._frames)
        self._frames.clear()
        self._conclude()
        if self._unrecorded is not None:
            tick, self._unrecorded = self._unrecorded, None
            if self._recorder is not None:
                self._recorder.add_tick(tick.observation, tick.memory, tick.outcome, tick.now, latency)

    def drop_tick(self) -> None:
        """Forget the tick in hand: its pilot has failed."""
        self._unfinished = self._unrecorded = None

    def queue(self, setpoint: Setpoint, t_boot: float, now: float) -> None:
        """Have a setpoint sent with the time (s, the vehicle's) of its state. CompanionError: it is not finite."""
        if not is_finite(setpoint):
            raise CompanionError(f"a setpoint that is not finite is not sent: {setpoint}")
        if self.xrce is not None:
            self.xrce.send(setpoint, t_boot, now, pilot.takes_commands(self.telemetry.status, now))
        elif self.link.identity is not None and not isinstance(setpoint, TorqueSetpoint):
            target = (self.link.identity.system, MAV_COMP_ID_AUTOPILOT1)
            self.link.send(*setpoints.encoded(setpoint, t_boot, *target))

    def _tick(self, state: VehicleState | None, answer: Answer | None, now: float, behind: int = 0) -> None:
        if self._over:
            self._wake_at = math.inf
            return
        self._wake_at = now + pilot.WAKE_AFTER
        if self.memory is None or self.plan is None:
            self._prepare(state, now)
            return  # making the plan took its time, and this state is no longer fresh
        self.link.peers.flying = self.memory.phase is not Phase.PREFLIGHT
        if not self.link.peers.flying and (ambiguity := self.preparation.ambiguity()) is not None:
            self._decline(ambiguity, now)
            return
        clock = self.link.clock
        clock.may_restart = self.memory.phase in NOT_FLYING
        self.plan = self.ground.apply_settings(self.plan, now, self._recorder)
        observation = Observation(
            state, self.telemetry.status, answer, self._stop, self.link.round_trip, self._states.rate, behind,
            self.link.companions(now), self.ground.speed_scale, self._late if state is not None else 0.0, clock.rate,
        )  # fmt: skip
        before = self.memory
        self.memory, early = pilot.compute_setpoint(self.plan, before, observation, now)
        self._unfinished = UnfinishedTick(observation, early, now, before)
        if early is None:
            self._conclude()
        else:
            self._queue(self.memory, early.steered.setpoint, now)

    def _conclude(self) -> None:
        """The rest of a tick, where one is left: after the send if its setpoint was early, else at once."""
        if self._unfinished is None or self.plan is None or self.memory is None:
            return
        (observation, early, now, before), self._unfinished = self._unfinished, None
        self.memory, outcome = pilot.supervise(self.plan, self.memory, observation, now, early)
        if early is None and outcome.setpoint is not None:
            self._queue(self.memory, outcome.setpoint, now)
        if outcome.sent and outcome.request is not None and self.memory.request.asking is not None:
            self.link.requests.ask(COMMANDS[outcome.request], self.memory.request.asking.tries - 1, now)
        if outcome.actions:
            self.payload.send(outcome.actions, self.link.requests, now)
        self._wake_at = pilot.wake_at(self.memory, now)
        self.notes += outcome.notes
        self.last = self._unrecorded = Tick(observation, self.memory, outcome, now, before)
        self.ground.report(self.plan, self.memory, outcome, self.memory.first_fault is not None, now)
        if self.xrce is not None:
            self.xrce.tell(pilot.may_be_selected(self.memory, now), self._over, pilot.completed(self.memory))
        if self._over:
            self.payload.finish()
            self.preparation.restore(now)

    def _queue(self, memory: Memory, setpoint: Setpoint, now: float) -> None:
        self.queue(setpoint, memory.state.t_boot if memory.state is not None else 0.0, now)

    def _prepare(self, state: VehicleState | None, now: float) -> None:
        """Make the plan once the vehicle is known and has said where it is."""
        self.plan = None if self._stop else self.preparation.plan(self.orders, state, now)
        reason = "stopped by the user before the flight began" if self._stop else self.refusal
        if reason is not None:
            self._decline(reason, now)
        if self.plan is None:
            return
        self.memory = pilot.begin(now)
        self.ground.offer(self.plan)
        if self._recorder is not None:
            self._recorder.begin(self.plan, now)
        origin, identity = self.telemetry.origin, self.link.identity
        if self.orders.draw and origin is not None and identity is not None:
            self.ground.draw(self.plan, LocalFrame(*origin), identity.system)

    def _decline(self, reason: str, now: float) -> None:
        """There will be no flight: what was set goes back, our mode goes, and a PX4's ground station hears why."""
        self.preparation.refusal = reason
        self.preparation.restore(now)
        if self.preparation.is_ours and not self._stop:
            self.ground.decline(reason, now)
        if self.xrce is not None:
            self.xrce.tell(can_run=False, over=True, completed=False)
