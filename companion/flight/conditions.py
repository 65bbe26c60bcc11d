"""What the safety rows look at, and their conditions.

A condition is a pure function of what is seen and the limits: it says in words why it holds, or nothing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.flight.conduct import Limits
from companion.flight.link_needs import BY_RATE_LOOP, LinkNeeds
from companion.vehicle import KnownStatus

ESTIMATOR_PARTS = (
    (1, "attitude"), (2, "horizontal velocity"), (4, "vertical velocity"), (8 | 16, "horizontal position"),
    (32, "height"),
)  # fmt: skip
"""Bits of ESTIMATOR_STATUS that must be there (one of each group), in words. MAVLink's ESTIMATOR_STATUS_FLAGS."""
CLOCK_JUMP = 0.5
"""s that the vehicle's clock may run ahead of ours between two states (engineering choice)."""
VELOCITY_OFF = 3.0
"""m/s that position and velocity may disagree by. Engineering choice: PX4's own differ by 0.04 m/s."""
RATES_OFF = 1.5
"""rad/s that attitude and body rates may disagree by. Engineering choice."""
TILT_ERROR = math.radians(40.0)
"""rad between the thrust axis asked for and the one flown (engineering choice)."""
RATE_ERROR = 3.0
"""rad/s between the rates asked for and flown (engineering choice)."""
TURNS_TOO_FAST = 1.2
"""Ratio to the vehicle's greatest body rate, where PX4's rate loop does not bound it. Engineering choice."""
TURNING = 1.0
"""rad/s: a vehicle that turns slower than that is not out of hand (engineering choice)."""
THRUST_RATIO_GONE = 0.6
"""Ratio of thrust made to thrust asked for, below which it does not answer, at once. Simulated: one motor of an x500
at 50 % comes to 0.58, a storm to 0.66 for a moment."""
THRUST_RATIO_SHORT = 0.7
"""Ratio, the same where it lasts. Simulated likewise."""
THRUST_RATIO_ASTRAY = 0.78
"""Ratio, the same while it turns otherwise than commanded: one motor is weak. Simulated: a storm comes to 0.83."""
RATE_ASTRAY = 1.5
"""rad/s between the rates commanded and flown. Simulated: a storm comes to 1.9, one motor at 50 % to 2.9."""
LATE_ASTRAY = 0.06
"""s that states come late, at which rates that are astray are the link's doing. On PX4's simulation, ODOMETRY alone
later by 0.05 s a second: the circle swung up from 0.08 s on, 46 degrees of tilt at 0.12, 73 at 0.16."""
THRUST_RATIO_LEANS = 0.9
"""Ratio below which thrust is named with a tilt that is not as commanded. Engineering choice."""
BEHIND = 5
"""Number of states that arrive together with the newest, from which on the computer is behind. Engineering choice."""
GAP = 0.1
"""s without a state that count as a gap. Engineering choice: 12 states of 125 Hz."""
GAPS = 5
"""Number of gaps within GAPS_WITHIN that are too many. Engineering choice."""
GAPS_WITHIN = 10.0
"""s within which gaps are counted. Engineering choice."""
FENCE_AHEAD = 1.0
"""m before the vehicle's own fence, which PX4 would act on (engineering choice)."""
FAR_OFF = 1.0
"""m from the path that a vehicle may be for a while and not for good (engineering choice)."""
ROTOR_WEAK = 0.65
"""Share of its thrust that a rotor gives, below which it does not answer, where the turning of the body tells it.
Engineering choice: yaw has no authority left from there on."""
THRUST_RATIO_SPENT = 0.9
"""Ratio below which thrust is named where it is at its limit and the vehicle sinks. Engineering choice: a sound vehicle
at the bottom of a steep curve sinks at full thrust too, but makes it."""
THRUST_SPENT = 0.94
"""Share of the largest thrust that is its limit. Engineering choice."""
SINKING = 0.8
"""m/s of sinking. Engineering choice: one motor at half its thrust comes to this within 0.5 s."""


class SafetyInputs(NamedTuple):
    """What the rows look at."""

    status: KnownStatus
    following: bool = False  # the path is flown now, and it was reached
    path_error: float = 0.0  # m
    height: float | None = None  # m above the ground; None where that is not known
    fence_margin: float = math.inf  # m to the mission's fence, inside positive
    from_home: float | None = None  # m, level
    above_home: float | None = None  # m
    tilt: float = 0.0  # rad
    tilt_error: float = 0.0  # rad between the thrust axis and the one the law asks for
    rate_error: float | None = None  # rad/s between the rates asked for and flown; None where none are
    body_rate: float = 0.0  # rad/s, how fast it turns
    still: bool = False  # it neither moves nor turns
    saturated: bool = False  # a limit of the vehicle was met
    thrust_share: float = 0.0  # asked for, of the largest thrust
    sinking: float = 0.0  # m/s downwards
    round_trip: float | None = None  # s, of a message; None where it is not known
    late: float = 0.0  # s by which the last state was older than the youngest that this link has brought
    needs: LinkNeeds = BY_RATE_LOOP  # of the link
    jump: float = 0.0  # m that the position jumped
    flagged: bool = True  # by the estimator's reset counter
    velocity_off: float = 0.0  # m/s by which position and velocity disagree
    rates_off: float = 0.0  # rad/s by which attitude and body rates disagree
    same_place: bool = False  # the last state repeated the position of the one before, although it moves
    same_attitude: bool = False  # the same of the attitude, although it turns
    clock_jump: float = 0.0  # s that the vehicle's clock ran ahead of ours since the last state
    behind: int = 0  # states that arrived together with the newest and were passed over
    rate: float | None = None  # Hz of states; None until measured
    gaps: int = 0  # in the states, of the last while
    companions: int = 0  # others that speak on the link
    body_rate_max: float | None = None  # rad/s, where PX4's rate loop does not bound it
    specific_thrust_commanded: float = 0.0  # m/s^2; 0 where it is not followed
    specific_thrust_made: float = 0.0  # m/s^2
    rotor_left: float = 1.0  # share of its thrust that the weakest rotor gives


def missing_estimate(flags: int | None) -> str | None:
    """What the estimator does not know; None where it knows enough, or has not said."""
    if flags is None:
        return None
    missing = [words for bits, words in ESTIMATOR_PARTS if not flags & bits]
    return " and ".join(missing) if missing else None


def estimator(s: SafetyInputs, limits: Limits) -> str | None:
    missing = missing_estimate(s.status.estimator)
    return None if missing is None else f"the estimator has lost its {missing}"


def jump(s: SafetyInputs, limits: Limits) -> str | None:
    if not s.flagged and s.jump > 0.0:
        return f"the position jumped by {s.jump:.1f} m, and the estimator's reset counter says nothing of it"
    if limits.tube is None or s.jump <= limits.tube:
        return None
    return f"the estimator moved the vehicle by {s.jump:.1f} m at once, out of the tube of {limits.tube:g} m"


def same_place(s: SafetyInputs, limits: Limits) -> str | None:
    return "the vehicle says that it moves, and always the same position" if s.same_place else None


def same_attitude(s: SafetyInputs, limits: Limits) -> str | None:
    return "the vehicle says that it turns, and always the same attitude" if s.same_attitude else None


def velocity_off(s: SafetyInputs, limits: Limits) -> str | None:
    if s.velocity_off <= VELOCITY_OFF:
        return None
    return f"position and velocity disagree by {s.velocity_off:.1f} m/s"


def rates_off(s: SafetyInputs, limits: Limits) -> str | None:
    if s.rates_off <= RATES_OFF:
        return None
    return f"attitude and body rates disagree by {s.rates_off:.1f} rad/s"


def clock(s: SafetyInputs, limits: Limits) -> str | None:
    if abs(s.clock_jump) <= CLOCK_JUMP:
        return None
    way = "ahead" if s.clock_jump > 0.0 else "back"
    return f"the vehicle's clock jumped {way} by {abs(s.clock_jump):.1f} s"


def tilt(s: SafetyInputs, limits: Limits) -> str | None:
    if limits.tilt is None or s.tilt <= limits.tilt:
        return None
    return f"the vehicle tilts by {math.degrees(s.tilt):.0f} degrees, more than {math.degrees(limits.tilt):.0f}"


def tilt_error(s: SafetyInputs, limits: Limits) -> str | None:
    # a vehicle that is held does not tilt as commanded either; it is to carry on when it is let go
    if limits.tilt is None or s.tilt_error <= min(TILT_ERROR, limits.tilt) or s.still:
        return None
    cause = _thrust(s, THRUST_RATIO_LEANS)
    off = f"the tilt is {math.degrees(s.tilt_error):.0f} degrees off the commanded one"
    return off if cause is None else f"{off}, and {cause}"


def rates(s: SafetyInputs, limits: Limits) -> str | None:
    if s.rate_error is None or s.rate_error <= RATE_ERROR or s.body_rate <= TURNING:
        return None
    return f"the body rates are {s.rate_error:.1f} rad/s off the commanded ones"


def late(s: SafetyInputs, limits: Limits) -> str | None:
    """The attitude is not held, because it is told too late. Lateness alone may be a slow clock of the vehicle."""
    if s.rate_error is None or s.rate_error <= RATE_ASTRAY or s.late <= LATE_ASTRAY:
        return None
    return f"states come {s.late:.2f} s late, and the body rates are {s.rate_error:.1f} rad/s off the commanded ones"


def turns(s: SafetyInputs, limits: Limits) -> str | None:
    """It turns faster than PX4 would let it, where PX4 does not look."""
    if s.body_rate_max is None or s.body_rate <= s.body_rate_max:
        return None
    cause = _weak_rotor(s) or _thrust(s, THRUST_RATIO_LEANS)
    return cause or f"the vehicle turns at {math.degrees(s.body_rate):.0f} deg/s"


def thrust_gone(s: SafetyInputs, limits: Limits) -> str | None:
    """Much less thrust comes than is commanded."""
    astray = s.rate_error is not None and s.rate_error > RATE_ASTRAY
    return _thrust(s, THRUST_RATIO_ASTRAY if astray else THRUST_RATIO_GONE)


def thrust_short(s: SafetyInputs, limits: Limits) -> str | None:
    """Less thrust comes than is commanded, of all rotors or of one."""
    return _weak_rotor(s) or _thrust(s, THRUST_RATIO_SHORT)


def thrust_spent(s: SafetyInputs, limits: Limits) -> str | None:
    """Less thrust comes than is commanded, and there is no more: the vehicle sinks at its largest."""
    if limits.tilt is None or s.thrust_share < THRUST_SPENT or s.sinking < SINKING:
        return None
    return _thrust(s, THRUST_RATIO_SPENT)


def delay(s: SafetyInputs, limits: Limits) -> str | None:
    """The link has become slow."""
    if s.round_trip is None or s.round_trip <= s.needs.delay:
        return None
    return f"a message takes {s.round_trip:.2f} s there and back, more than {s.needs.delay:g} s"


def _weak_rotor(s: SafetyInputs) -> str | None:
    if s.rotor_left >= ROTOR_WEAK or s.specific_thrust_commanded <= 0.0 or s.still:
        return None
    return f"thrust does not answer (a motor or propeller): one gives {100.0 * s.rotor_left:.0f} % of what it is told"


def _thrust(s: SafetyInputs, ratio: float) -> str | None:
    if s.still or s.specific_thrust_made >= ratio * s.specific_thrust_commanded:
        return None
    made, commanded = s.specific_thrust_made, s.specific_thrust_commanded
    return f"thrust does not answer (a motor, propeller or battery): {made:.1f} m/s^2 of {commanded:.1f} come"


def floor(s: SafetyInputs, limits: Limits) -> str | None:
    if limits.floor is None or s.height is None or s.height >= limits.floor:
        return None
    return f"{s.height:z.1f} m above the ground, below the floor of {limits.floor:g} m"


def ceiling(s: SafetyInputs, limits: Limits) -> str | None:
    if limits.ceiling is None or s.height is None or s.height <= limits.ceiling:
        return None
    return f"{s.height:z.1f} m above the ground, above the ceiling of {limits.ceiling:g} m"


def fence(s: SafetyInputs, limits: Limits) -> str | None:
    return None if s.fence_margin >= 0.0 else f"the vehicle is {-s.fence_margin:.1f} m outside the mission's fence"


def own_fence(s: SafetyInputs, limits: Limits) -> str | None:
    if limits.radius and s.from_home is not None and s.from_home > limits.radius - FENCE_AHEAD:
        return f"{s.from_home:.0f} m from home, at the vehicle's own fence of {limits.radius:g} m (GF_MAX_HOR_DIST)"
    if limits.height and s.above_home is not None and s.above_home > limits.height - FENCE_AHEAD:
        return f"{s.above_home:z.0f} m above home, at the vehicle's own fence of {limits.height:g} m (GF_MAX_VER_DIST)"
    return None


def tube(s: SafetyInputs, limits: Limits) -> str | None:
    if not s.following or limits.tube is None or s.path_error <= limits.tube:
        return None
    return f"{s.path_error:.1f} m from the path, outside the tube of {limits.tube:g} m"


def saturated(s: SafetyInputs, limits: Limits) -> str | None:
    # whoever holds a vehicle still brings the law to its limits, not the path
    if not s.saturated or s.still or limits.tilt is None:
        return None
    return "the vehicle is at its limits and cannot fly this"


def battery(s: SafetyInputs, limits: Limits) -> str | None:
    battery = s.status.battery
    if battery is None or limits.battery is None or battery >= limits.battery:
        return None
    return f"the battery is at {100.0 * battery:.0f} %, below {100.0 * limits.battery:.0f} %"


def off_the_path(s: SafetyInputs, limits: Limits) -> str | None:
    if not s.following or s.path_error <= FAR_OFF:
        return None
    return f"{s.path_error:.1f} m from the path and not coming nearer"


def behind(s: SafetyInputs, limits: Limits) -> str | None:
    return None if s.behind < BEHIND else f"the computer is {s.behind} states behind"


def slow(s: SafetyInputs, limits: Limits) -> str | None:
    return None if s.rate is None or s.rate >= s.needs.rate else f"only {s.rate:.0f} states a second arrive"


def gaps(s: SafetyInputs, limits: Limits) -> str | None:
    return None if s.gaps < GAPS else f"the link has gaps: {s.gaps} of over {GAP:g} s within {GAPS_WITHIN:g} s"


def others(s: SafetyInputs, limits: Limits) -> str | None:
    return "another companion speaks on the link (a heartbeat of component 191)" if s.companions else None
