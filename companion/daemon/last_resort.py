"""What is done when the companion itself fails: an exception that nobody expected escaped a tick.

It stands in the conductor's place with the same doors, and asks the pilot nothing any more. Where the vehicle flies on
our setpoints, HOLD is asked for as the link's own rules bound it, and the vehicle is levelled for as long as an abort
would, never longer; then there is silence, so that PX4's own failsafe can act. A vehicle that is in a mode of its own
is left in it. Every step here may fail too, and the others are taken all the same.
"""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from companion import pilot
from companion.daemon.asked_of_vehicle import COMMANDS
from companion.daemon.conductor import Conductor
from companion.flight.asking import FRESH_LOST, Asking, update_asking
from companion.flight.conduct import ControlAuthority
from companion.flight.interruptions import STATE_AGE_MAX
from companion.flight.phases import Phase, Request
from companion.flight.situation import Answer
from companion.mavlink.peer import Received
from companion.vehicle import Mode, Setpoint, VehicleState

ASKING = 1.4
"""s for which HOLD is asked for, three times at most (``flight.asking``). Issue 11, rule 2: within 1.5 s."""
RESTORING = 2.0
"""s for the parameters that were set for the flight to be set back. Engineering choice."""
STEP = 0.02
"""s between two looks where nothing arrives: a level setpoint is computed anew each time. Engineering choice."""
T = TypeVar("T")


class LastResort:
    """``error`` escaped at ``now`` from what flew ``conductor``. Doors as those of a conductor."""

    def __init__(self, conductor: Conductor, error: Exception, now: float) -> None:
        self.error = error
        self.trace = "".join(traceback.format_exception(error))
        self._conductor = conductor
        self._begun = self._now = now
        self._restoring_since: float | None = None
        self._state: VehicleState | None = None
        self._state_at = -math.inf
        if conductor.memory is not None and conductor.memory.state_at is not None:
            self._state, self._state_at = conductor.memory.state, conductor.memory.state_at
        self._authority = conductor.orders.conduct.authority
        self.was_flying = self._ours()
        self.asked = False
        conductor.drop_tick()
        if conductor.xrce is not None:
            conductor.xrce.raises = False
        self._asking = Asking(Request.HOLD, Mode.OFFBOARD)
        self._answer: Answer | None = None
        self._act(now)

    @property
    def done(self) -> bool:
        """Whether there is nothing left to do."""
        if self._restoring_since is None:
            return False
        return not self._conductor.preparation.changed or self._now - self._restoring_since > RESTORING

    @property
    def sentence(self) -> str:
        """What happened, what was done, what to do next."""
        mode = self._conductor.telemetry.status.last.mode
        where = "an unknown mode" if mode is None else mode.words
        if not self.was_flying:
            did = "nothing more was sent" if self._conductor.memory is not None else "nothing was flown"
        elif self.asked:
            did = f"HOLD was asked for, and the vehicle is in {where}"
        else:
            did = f"the vehicle was levelled for {pilot.LEVEL_FOR:g} s, then setpoints stopped; it is in {where}"
        do = "take the vehicle by remote control, land it" if self.was_flying else "look at the vehicle"
        return f"the companion itself failed ({error_words(self.error)}): {did}; {do}, and send in the flight folder"

    def receive(self, batch: Sequence[Received], now: float) -> None:
        """Listen, and act on the rules above."""
        taken = self._try(lambda: self._conductor.take_in(batch, now))
        if taken is not None and taken[0] is not None:
            self._state, self._state_at = taken[0], now
        if taken is not None and taken[1] is not None and taken[1].request is Request.HOLD:
            self._answer = taken[1]
        self._act(now)

    def on_timer(self, now: float) -> None:
        """Do what is due."""
        self._try(lambda: self._conductor.link.on_timer(now))
        self._try(lambda: self._conductor.parameters.on_timer(now))
        self._act(now)

    def next_timer(self) -> float:
        """When ``on_timer`` wants to be called."""
        return self._now + STEP

    def datagrams(self) -> list[bytes]:
        """What is to be sent now."""
        return self._try(self._conductor.datagrams) or []

    def finish_tick(self, latency: float = math.nan) -> None:
        """It is on its way."""
        self._try(lambda: self._conductor.finish_tick(latency))

    def stumble(self, now: float) -> None:
        """Something failed again, outside of these doors: time goes on."""
        self._now = now

    def _ours(self) -> bool:
        return (
            self._authority in (ControlAuthority.COMPANION, ControlAuthority.PILOT)
            and self._conductor.memory is not None
            and self._conductor.telemetry.status.known_at(self._now).mode is Mode.OFFBOARD
        )

    def _act(self, now: float) -> None:
        self._now = self._conductor.now = now
        since = now - self._begun
        ours = self._ours()
        status = self._conductor.telemetry.status.known_at(now)
        if self._restoring_since is not None:
            self._try(self._conductor.preparation.report_restored)
        elif since > ASKING or (not ours and status.mode_age < FRESH_LOST < since):
            self._restoring_since = now
            self._try(lambda: self._conductor.preparation.restore(now))
        elif ours:
            self.was_flying = True
            if since <= pilot.LEVEL_FOR:
                self._level(now)
            if self._authority is ControlAuthority.COMPANION:
                lost = now - self._state_at > STATE_AGE_MAX
                self._asking, sent = update_asking(self._asking, self._answer, status, Phase.ABORT, now, lost=lost)
                if sent:
                    self.asked = True
                    hold, tries = COMMANDS[Request.HOLD], self._asking.tries
                    self._try(lambda: self._conductor.link.requests.ask(hold, tries - 1, now))

    def _level(self, now: float) -> None:
        plan, memory = self._conductor.plan, self._conductor.memory
        if plan is None or memory is None:
            return
        state = self._state if now - self._state_at <= STATE_AGE_MAX else None
        t_boot = now if state is None else state.t_boot
        steering, known = plan.steering, memory.steering.memory
        if not self._queue(lambda: steering.level_setpoint(state, known), t_boot, now):
            self._queue(lambda: steering.level_setpoint(None), t_boot, now)

    def _queue(self, setpoint: Callable[[], Setpoint], t_boot: float, now: float) -> bool:
        """Have a setpoint sent that may fail to be computed; whether it is."""

        def step() -> bool:
            self._conductor.queue(setpoint(), t_boot, now)
            return True

        return self._try(step) or False

    def _try(self, step: Callable[[], T]) -> T | None:
        try:
            return step()
        except Exception:  # the next step is taken all the same
            return None


def error_words(error: Exception) -> str:
    """An exception in few words: its kind, its message, the line of ours that raised it."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if "companion" in Path(frame.filename).parts] or list(frames)
    where = f", {Path(ours[-1].filename).name} line {ours[-1].lineno}" if ours else ""
    return f"{type(error).__name__}: {error}{where}" if str(error) else f"{type(error).__name__}{where}"
