"""The companion as the ground station knows it: words, errors, its parameters, the curve on the map."""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.flight.phases import FLOWN, NOT_FLYING
from companion.geodesy import LocalFrame
from companion.mavlink.announcing import Announcer
from companion.mavlink.codec import Frame
from companion.mavlink.dialect import Format, Value
from companion.mavlink.own_parameters import WANTED as OWN_WANTED
from companion.mavlink.own_parameters import Own, OwnParameters
from companion.mavlink.upload import CURVE_POINTS, Place, Upload
from companion.mavlink.upload import WANTED as UPLOAD_WANTED
from companion.mavlink_common import MAV_COMP_ID_ONBOARD_COMPUTER, MavSeverity
from companion.pilot import Memory, Outcome, yaw_error
from companion.plan import Plan
from companion.record.ticks import TickRecorder
from companion.settings import settings_of, with_settings
from companion.vehicle import CompanionError

SPEED_SCALE = "PF_SPEED_SCALE"
SAFE_WHEN = "it can be set only while the vehicle does not fly on our setpoints"
WANTED = OWN_WANTED | UPLOAD_WANTED


class GroundSide:
    """``send`` queues a message, ``note`` takes a line for people."""

    def __init__(
        self, send: Callable[[Format, tuple[Value, ...]], None], note: Callable[[str], None], speed_scale_max: float
    ) -> None:
        self._send = send
        self._note = note
        self._announcer = Announcer(send)
        self._own = OwnParameters(send, MAV_COMP_ID_ONBOARD_COMPUTER, {SPEED_SCALE: Own(1.0, 0.0, speed_scale_max)})
        self._upload: Upload | None = None
        self._applied: dict[str, float] = {}  # what the plan has, under the names of its settings
        self._is_set = False  # whether one was set since
        self._may_be_set = True

    @property
    def speed_scale(self) -> float:
        """The factor on the mission's speed that is asked for."""
        return self._own.named[SPEED_SCALE].value

    def receive(self, frame: Frame, system: int, now: float, *, of_vehicle: bool) -> None:
        """Take in what is meant for us: from a ground station through the vehicle, or from the vehicle itself."""
        if not of_vehicle:
            note = self._own.receive(frame, system)
            if note is not None:
                self._is_set = True
                self._note(note)
                self._announcer.say(note, now)
        elif self._upload is not None:
            before = self._upload.outcome
            self._upload.receive(frame, now)
            if self._upload.outcome is not None and before is None:
                self._note(self._upload.outcome)

    def offer(self, plan: Plan) -> None:
        """Show the plan's gains and limits among the parameters."""
        for name, setting in settings_of(plan).items():
            self._own.named[name] = Own(*setting)
            self._applied[name] = setting.value

    def apply_settings(self, plan: Plan, now: float, recorder: TickRecorder | None) -> Plan:
        """The plan with the gains and limits that were set since the tick before."""
        if not self._is_set:
            return plan
        self._is_set = False
        changed = {name: self._own.named[name].value for name, value in self._applied.items()
                   if self._own.named[name].value != value}  # fmt: skip
        if not changed:
            return plan
        try:
            plan = with_settings(plan, changed)
        except CompanionError as error:
            for name in changed:
                self._own.named[name].value = self._applied[name]
                self._own.tell(name)
            self._note(f"{', '.join(changed)} not taken: {error}")
            return plan
        self._applied |= changed
        if recorder is not None:
            recorder.add_settings(changed, now)
        return plan

    def draw(self, plan: Plan, frame: LocalFrame, system: int) -> None:
        """Put the curve on the ground station's map."""
        _, points = plan.table.samples(CURVE_POINTS)
        places = [Place(*frame.to_global((float(x), float(y), float(z)))) for x, y, z in points]
        self._upload = Upload(self._send, places, system)

    def report(self, plan: Plan, memory: Memory, outcome: Outcome, fault: bool, now: float) -> None:
        """What a tick brought. Gains and limits may be set until the next one, if the vehicle does not fly on our
        setpoints after this one."""
        may_be_set = memory.phase in NOT_FLYING
        if may_be_set is not self._may_be_set:
            self._may_be_set = may_be_set
            self._own.locked = (frozenset() if may_be_set else frozenset(self._applied), SAFE_WHEN)
        for note in outcome.notes:
            self._announcer.say(
                f"path: {note.split(' -> ')[-1]}", now, MavSeverity.WARNING if fault else MavSeverity.INFO
            )
        if not self._announcer.are_numbers_due(now):
            return
        steered, progress = outcome.steered, memory.path.progress
        if steered is not None and progress is not None and memory.state is not None and memory.phase in FLOWN:
            command = steered.command
            wanted = command.alpha * outcome.ramp.value
            self._announcer.numbers(now, memory.state.t_boot, {
                "pf_path": progress.path_error,
                "pf_speed": command.speed - wanted,
                "pf_yaw": math.degrees(yaw_error(steered)),
            })  # fmt: skip

    def decline(self, reason: str, now: float) -> None:
        """Say why there will be no flight."""
        self._announcer.say(f"mission cannot be flown here: {reason}", now, MavSeverity.WARNING)
        self._announcer.on_timer(now)  # it may be the last that is said

    def on_timer(self, now: float) -> None:
        """Send what is due."""
        self._announcer.on_timer(now)
        if self._upload is not None:
            self._upload.on_timer(now)

    def next_timer(self) -> float:
        """When ``on_timer`` has something to do."""
        announcement = self._announcer.next_timer()
        return announcement if self._upload is None else min(announcement, self._upload.next_timer())
