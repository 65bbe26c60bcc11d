"""A flight mode of our own: registered with PX4, ready or not as we are, selected and left by the pilot, completed.

PX4 asks every 0.3 s whether it can be flown; after four questions without an answer it takes the vehicle back to Hold
(1.0 to 1.3 s, externalChecks.cpp of main 3/2026). For so long it flies on the last setpoint, which is why attitudes
alone may be flown (MODE_LEVELS). It registers nobody while the vehicle is armed.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

from companion.vehicle import CompanionError, Mode, OutputLevel
from companion.xrce.agent import Agent, Sample

NAMED = "Path"
"""What it is called where nobody says otherwise."""
NAME_MAX = 24
"""letters of a name that PX4 keeps."""
MODE_LEVELS = frozenset({OutputLevel.ATTITUDE})
"""What is flown in a mode of ours: what PX4 may fly on for 1.3 s after we died. Killed on the circle on PX4: 24 degrees
at most at attitude; the others only on the stand-in (bench.deaths), where motors and torques turn it over."""
NEEDS = (
    "register_ext_component_request",
    "unregister_ext_component",
    "arming_check_reply",
    "config_control_setpoints",
    "mode_completed",
)
"""The topics that PX4 must read."""
ASK_AGAIN = 1.0
"""s after which what was not answered is asked again (engineering choice)."""
FIRST_EXTERNAL = 23
"""nav_state of PX4's first mode from outside."""
MODES = 8
"""Modes from outside that PX4 takes (NAVIGATION_STATE_EXTERNAL1 to 8)."""
STATUS_LASTS = 0.7
"""s that a vehicle_status counts: PX4 publishes it at 2 Hz, and within 0.2 s of a change."""
STALLED = 0.5
"""s in the mode without a command after which it cannot be flown: else PX4 would hold the last one for as long as its
questions are answered."""
CONTROLLERS = {
    OutputLevel.ATTITUDE: ("attitude", "rates", "allocation"),
    OutputLevel.RATES: ("rates", "allocation"),
    OutputLevel.TORQUES: ("allocation",),
    OutputLevel.MOTORS: (),
}
"""PX4's controllers that fly what is sent."""
SUCCESS, FAILURE = 0, 100
"""Results of mode_completed."""
API_VERSION = 1
"""px4_ros2_api_version of every PX4 from 1.15 to main 3/2026."""


@dataclass(slots=True)
class FlightMode:
    """``level``: of the setpoints that are flown in it. ``can_run``: whether it may be selected now. ``number``: its
    nav_state; None: not registered (yet)."""

    name: str = NAMED
    level: OutputLevel = OutputLevel.ATTITUDE
    can_run: bool = False
    number: int | None = None
    _check: int = -1
    _request: int = 0
    _asked_at: float = -math.inf
    _session: int = 0
    _nav_state: int | None = None
    _said_at: float = -math.inf
    _commanded_at: float = -math.inf
    _finished: bool = False
    _samples: list[tuple[str, dict[str, object]]] = field(default_factory=list)

    @property
    def mode(self) -> Mode | None:
        """What MAVLink calls it."""
        return None if self.number is None else Mode[f"EXTERNAL{self.number - FIRST_EXTERNAL + 1}"]

    def missing(self, agent: Agent) -> str | None:
        """What PX4 has not got of it yet."""
        lacking = next((name for name in NEEDS if name not in agent.reading), None)
        if lacking is None and self.number is None:
            return f"the mode {self.name} registered, which it does while disarmed"
        return lacking

    def is_selected(self, now: float) -> bool:
        """Whether PX4 has just said that it flies in it."""
        return self.number is not None and self._nav_state == self.number and now - self._said_at <= STATUS_LASTS

    def notice_command(self, now: float) -> None:
        """A command went out."""
        self._commanded_at = now

    def take(self, agent: Agent, sample: Sample, now: float) -> None:
        """Take in what PX4 says of modes. TopicError: in a version that is not known here."""
        if sample.topic.name not in ("vehicle_status", "register_ext_component_reply", "arming_check_request"):
            return
        said = agent.layout(sample.topic).decode(sample.cdr)
        if said is None:
            return
        if sample.topic.name == "vehicle_status":
            if said["nav_state"] != self._nav_state:
                self._commanded_at = now  # from here on commands are waited for
            self._nav_state, self._said_at = said["nav_state"], now
        elif sample.topic.name == "arming_check_request":
            self._answer(said["request_id"], now)
        elif said["request_id"] == self._request and said["success"]:
            number, check = said["mode_id"], said["arming_check_id"]
            if 0 <= number - FIRST_EXTERNAL < MODES and check >= 0:  # else it is nonsense, and asked again
                self.number, self._check = number, check
                self._configure()

    def write(self, agent: Agent, now: float) -> None:
        """Have what is due sent: a registration until it is answered, answers."""
        if self._session != agent.sessions:  # PX4's client began anew, and perhaps PX4
            self._session, self.number, self._asked_at = agent.sessions, None, -math.inf
        if self.number is None and not self._finished and now - self._asked_at > ASK_AGAIN:
            self._asked_at = now
            self._request = round(now * 1e6)
            self._samples.append((NEEDS[0], {
                "request_id": self._request, "name": self.name.encode(), "px4_ros2_api_version": API_VERSION,
                "register_arming_check": True, "register_mode": True,
            }))  # fmt: skip
        samples, self._samples = self._samples, []  # what cannot be said now is not said later either
        if any(name not in agent.reading for name in NEEDS):
            return
        for name, values in samples:
            agent.write([(name, agent.layout(agent.reading[name].topic).encode(**values))])

    def finish(self, *, completed: bool) -> None:
        """The flight is over: say how it ended, and unregister."""
        if self.number is None or self._finished:
            return
        self._finished, self.can_run = True, False
        result = SUCCESS if completed else FAILURE
        self._samples.append(("mode_completed", {"result": result, "nav_state": self.number}))
        self._samples.append(("unregister_ext_component", {
            "name": self.name.encode(), "arming_check_id": self._check, "mode_id": self.number, "mode_executor_id": -1,
        }))  # fmt: skip

    def _answer(self, request: int, now: float) -> None:
        """Whether it can be flown. It begins in the air, so that nobody arms in it."""
        if self.number is None or self._finished:
            return
        stalls = self._nav_state == self.number and now - self._commanded_at > STALLED
        self._samples.append(("arming_check_reply", {
            "request_id": request, "registration_id": self._check, "can_arm_and_run": self.can_run and not stalls,
            "mode_req_angular_velocity": True, "mode_req_attitude": True, "mode_req_local_alt": True,
            "mode_req_local_position": True, "mode_req_prevent_arming": True,
        }))  # fmt: skip
        self._configure()

    def _configure(self) -> None:
        """Which of PX4's controllers are on while it is selected."""
        flags = {f"flag_control_{name}_enabled": True for name in CONTROLLERS[self.level]}
        self._samples.append(("config_control_setpoints", {**flags, "source_id": self.number}))


def level_refused(level: OutputLevel) -> str | None:
    """Why setpoints of a level are not sent in a mode of our own; None: they are."""
    if level in MODE_LEVELS:
        return None
    return (
        f"--start mode flies attitude alone, not {level.value}: where the companion dies PX4 goes on for 1.0 to 1.3 s "
        "on its last setpoint, and at rates, torques and motors that is a crash; in OFFBOARD it is 0.3 or 0.1 s"
    )


def mode_name(name: str) -> str:
    """A name for it. CompanionError: PX4 would cut it, a ground station could not show it, or it is PX4's own."""
    if re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9 _.-]*", name) is None or len(name) > NAME_MAX or name != name.strip():
        raise CompanionError(
            f"{name!r} is no name for a flight mode; expected 1 to {NAME_MAX} letters, digits, spaces and _ . -, "
            "beginning with a letter or a digit"
        )
    if re.sub(r"[ _.-]", "", name).upper() in {each.name.replace("_", "") for each in Mode}:
        raise CompanionError(f"{name!r} is a flight mode of PX4 itself; expected a name that nobody mistakes for it")
    return name
