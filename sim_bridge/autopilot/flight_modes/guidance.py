"""What the automatic modes fly: hold, take off, land, return.

Each step gives a target for the position loop, or says that the throttle is to be opened so far with the vehicle level,
which is how it stands, takes off and settles on the ground.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.frames import Vec3, euler_from_rotation, rotation_matrix
from companion.mavlink.modes import Mode
from companion.vehicle import GRAVITY
from sim_bridge.autopilot.flight_modes.heading import HeadingSmoothing
from sim_bridge.autopilot.flight_modes.orbit import Orbit
from sim_bridge.autopilot.missions.flight import Leg, MissionFlight
from sim_bridge.autopilot.parameters import Parameters
from sim_bridge.control.position import Axes, Target
from sim_bridge.control.reference import Reference, TrajectoryLimits, along, towards
from sim_bridge.sensors import Estimate

HEIGHT_REACHED = 0.8  # m, NAV_MC_ALT_RAD
PLACE_REACHED = 1.0
"""m from home, level, from where a return descends."""
CRAWL_BELOW = 0.75
"""m above ground below which a landing crawls."""
SLOWS_BETWEEN = (5.0, 10.0)  # m, MPC_LAND_ALT2, MPC_LAND_ALT1
RAMP_LATE = 1.45
"""How much later than its limit of climb allows a take-off hovers: the loop's sum has to come back first (measured)."""
CLOSED_OF_HOVER = 0.25
"""Throttle over hover throttle once the ground is felt in a landing, until it counts as landed."""
DOWN_AT_ONCE = frozenset({Mode.LAND, Mode.PRECISION_LAND, Mode.DESCEND})
"""Modes that land where they begin; there is no target to land precisely on."""
LIMITS = TrajectoryLimits()


@dataclass(frozen=True, slots=True)
class Throttle:
    """Level, at this part of the hover throttle."""

    of_hover: float


@dataclass(frozen=True, slots=True)
class TakeOff:
    """Where a take-off goes: over a place (m north, east), to a height (m down); None: this one, PX4's default."""

    level: tuple[float, float] | None = None
    down: float | None = None


def takeoff_throttle(seconds: float, climb: float, parameters: Parameters) -> Throttle:
    """The throttle ``seconds`` after it began to open for a take-off at ``climb`` m/s.

    PX4 lets its limit of climb grow in MPC_TKO_RAMP_T from where the velocity loop asks for no thrust at all.
    """
    least = GRAVITY / max(0.01, parameters["MPC_Z_VEL_P_ACC"])
    ramp = RAMP_LATE * parameters["MPC_TKO_RAMP_T"] * least / (least + max(0.0, climb))
    return Throttle(max(0.0, seconds / max(0.1, ramp)))


class Guidance:
    """The automatic modes of one vehicle. ``home_n``: where a return goes (m, NED).

    ``takeoff``: the next take-off. ``cruise_speed``: m/s, where somebody has asked for another than MPC_XY_CRUISE; it
    counts until the mode changes.
    """

    def __init__(self, parameters: Parameters, mission: MissionFlight, home_n: Vec3 = (0.0, 0.0, 0.0)) -> None:
        self._parameters = parameters
        self._mission = mission
        self.home_n = home_n
        self.takeoff = TakeOff()
        self._mode = Mode.HOLD
        self._reference = Reference(home_n, (0.0, 0.0, 0.0))
        self._heading_smoothing = HeadingSmoothing(parameters)
        self._heading: float | None = None  # what the nose is to point at; None: where it goes
        self._place: Vec3 | None = None  # where the reference is led; None: to a stop
        self._opened_at: float | None = None
        self._climbing = self._landing = False
        self.orbit: Orbit | None = None
        self.notes: list[str] = []  # for the operator, to be taken out by whoever shows them
        self.target: Target | None = None  # what was last asked of the position loop
        self.cruise_speed: float | None = None
        self._speed_there: float | None = None  # m/s, that of one way only

    @property
    def destination(self) -> Vec3 | None:
        """Where the reference is led (m, NED); None: to a stop."""
        return self._place

    def enter(self, mode: Mode, now: Estimate) -> None:
        """Begin a mode from where the vehicle is and as fast as it moves."""
        # on to the very height of the take-off, to the very end of the mission
        at_the_end = self._mode is Mode.MISSION and self._mission.finished and not self._landing
        goes_on = mode is Mode.HOLD and (self.has_taken_off(now) or at_the_end)
        takes_off_still = mode is self._mode is Mode.TAKEOFF
        self._mode = mode
        self.cruise_speed = self._speed_there = None
        if goes_on:
            return
        self._reference = Reference(now.p_n, now.v_n)
        self._heading_smoothing.point(euler_from_rotation(rotation_matrix(now.q_nb))[0])
        self._heading = None
        self._place = None
        if not takes_off_still:
            self._opened_at = None
        self._climbing, self._landing = mode is Mode.RETURN, mode in DOWN_AT_ONCE
        north, east, down = now.p_n
        if mode is Mode.TAKEOFF:
            wanted, self.takeoff = self.takeoff, TakeOff()
            top = down - self._parameters["MIS_TAKEOFF_ALT"] if wanted.down is None else wanted.down
            self._place = (*(wanted.level or (north, east)), min(top, down))
        elif mode is Mode.MISSION:
            self._mission.begin(now)
        elif mode is Mode.RETURN:
            self._place = (north, east, self.home_n[2] - self.return_height(now))

    def go_to(
        self, now: Estimate, level: tuple[float, float] | None, down: float | None, heading: float | None,
        speed: float | None,
    ) -> None:  # fmt: skip
        """Of HOLD: hold at another place (m, NED), heading (rad); None: as it is. ``speed``: m/s, for this way only."""
        before = self._place or self._reference.p_n
        if level is None and down is None and heading is None:
            self._place = None  # stop here
        else:
            self._place = (*(before[:2] if level is None else level), before[2] if down is None else down)
        self._heading = heading
        self._speed_there = speed

    def notice_reset(self, now: Estimate) -> None:
        """The estimate has jumped: as in PX4 the reference goes on from the new one, back to where it was to be."""
        heading = euler_from_rotation(rotation_matrix(now.q_nb))[0]
        if self._place is None:
            self._place, self._heading = self._reference.p_n, heading
        self._reference = Reference(now.p_n, now.v_n)
        self._heading_smoothing.point(heading)

    @property
    def is_landing(self) -> bool:
        """Whether the vehicle is on its way down to the ground."""
        return self._landing

    @property
    def is_taking_off(self) -> bool:
        """Whether the vehicle is on its way up from the ground."""
        return self._mode is Mode.TAKEOFF or (self._mode is Mode.MISSION and self._climbing)

    def has_taken_off(self, now: Estimate) -> bool:
        """Whether a take-off has reached its height."""
        return self._mode is Mode.TAKEOFF and self._place is not None and now.p_n[2] - self._place[2] < HEIGHT_REACHED

    def return_height(self, now: Estimate) -> float:
        """The height above home (m) a return from here flies at: PX4's cone of 45 degrees near home."""
        distance = self._from_home(now)
        near, height = self._parameters["NAV_ACC_RAD"], self._parameters["RTL_RETURN_ALT"]
        if distance <= near:
            height = 2.0 * distance
        else:
            if distance <= self._parameters["RTL_MIN_DIST"]:
                height = min(distance, height)
            height = max(height, 2.0 * near)
        return max(height, self.home_n[2] - now.p_n[2])

    def step(self, now: Estimate, t: float, on_ground: bool, touching: bool, step: float) -> Target | Throttle:
        """What to fly at ``t`` (s). ``on_ground``: not lifted off yet or landed; ``touching``: the ground is felt."""
        wanted = self._update_target(now, t, on_ground, touching, step)
        self.target = wanted if isinstance(wanted, Target) else None
        return wanted

    def _update_target(
        self, now: Estimate, t: float, on_ground: bool, touching: bool, step: float
    ) -> Target | Throttle:
        if self._mode is Mode.MISSION:
            self._follow(self._mission.leg(now, t, on_ground))
        if on_ground:
            self._reference = Reference(now.p_n, (0.0, 0.0, 0.0))
            return self._open_throttle(t) if self.is_taking_off else Throttle(0.0)
        self._turn(now, step)
        if self._landing:
            if touching:
                return Throttle(CLOSED_OF_HOVER)
            self._reference = self._sunk(now, step)
            north, east, _ = self._reference.p_n
            return self._target((north, east, None))
        if self._mode is Mode.RETURN:
            self._next_leg(now)
        if self._mode is Mode.ORBIT and self.orbit is not None:
            self._reference = self.orbit.moved(self._reference, self._trajectory_limits, step)
            return self._target(self._reference.p_n)
        limits = self._trajectory_limits
        if self.is_taking_off:
            limits = limits._replace(climb=self._parameters["MPC_TKO_SPEED"])
        self._reference = self._advanced(limits, step)
        return self._target(self._reference.p_n)

    def _target(self, position: Axes) -> Target:
        moves = self._reference
        return Target(position, moves.v_n, self._heading_smoothing.heading, moves.a_n, self._heading_smoothing.rate)

    def _follow(self, leg: Leg) -> None:
        """Of a mission: go on with what it says."""
        self._place, self._heading = leg.place, leg.heading
        self._climbing, self._landing = leg.takes_off, leg.lands

    def _turn(self, now: Estimate, step: float) -> None:
        """The nose a little nearer to where it is to point, or to where the vehicle goes if that is far enough."""
        wanted = self._heading
        if self._mode is Mode.ORBIT and self.orbit is not None:
            wanted = self.orbit.heading(now, self._heading_smoothing.heading)
        if wanted is None and self._place is not None:
            north, east = self._place[0] - now.p_n[0], self._place[1] - now.p_n[1]
            if math.hypot(north, east) > self._parameters["NAV_ACC_RAD"]:
                wanted = math.atan2(east, north)
        if wanted is not None or self._heading_smoothing.rate != 0.0:
            self._heading_smoothing.turn(self._heading_smoothing.heading if wanted is None else wanted, step)

    @property
    def _trajectory_limits(self) -> TrajectoryLimits:
        """The limits the parameters set, with the cruise speed somebody has asked for."""
        parameters = self._parameters
        cruise = self._speed_there or self.cruise_speed or parameters["MPC_XY_CRUISE"]
        return TrajectoryLimits(
            max(0.1, min(cruise, parameters["MPC_XY_VEL_MAX"])),
            max(0.1, parameters["MPC_Z_V_AUTO_UP"]),
            max(0.1, parameters["MPC_Z_V_AUTO_DN"]),
            max(0.1, parameters["MPC_ACC_HOR"]),
            max(0.1, parameters["MPC_JERK_AUTO"]),
            max(0.1, parameters["MPC_ACC_UP_MAX"]),
        )

    def _advanced(self, limits: TrajectoryLimits, step: float) -> Reference:
        """The reference one step nearer to its place, or to a stop."""
        if self._place is None:
            return along(self._reference, (0.0, 0.0, 0.0), limits, step)
        return towards(self._reference, self._place, limits, step)

    def _open_throttle(self, t: float) -> Throttle:
        """Idle for the spool-up time, then open the throttle until the vehicle leaves the ground."""
        if self._opened_at is None:
            self._opened_at = t + self._parameters["COM_SPOOLUP_TIME"]
        return takeoff_throttle(t - self._opened_at, self._parameters["MPC_TKO_SPEED"], self._parameters)

    def _sunk(self, now: Estimate, step: float) -> Reference:
        """The reference one step further down: fast while high, slower below 10 m, crawling at the end."""
        slow = self._parameters["MPC_LAND_SPEED"]
        height = self.home_n[2] - now.p_n[2]
        low, high = SLOWS_BETWEEN
        share = max(0.0, min(1.0, (height - low) / (high - low)))
        speed = self._parameters["MPC_LAND_CRWL"] if height < CRAWL_BELOW else slow + share * (LIMITS.sink - slow)
        (north, east, _), (vn, ve, _), (an, ae, _) = self._advanced(LIMITS, step)
        _, _, down = zip(*along(self._reference, (0.0, 0.0, speed), LIMITS, step), strict=True)
        return Reference((north, east, down[0]), (vn, ve, down[1]), (an, ae, down[2]))

    def _next_leg(self, now: Estimate) -> None:
        """Of a return: up first, then across to home, then down."""
        assert self._place is not None
        if self._climbing and now.p_n[2] - self._place[2] < HEIGHT_REACHED:
            self._climbing = False
            self._place = (self.home_n[0], self.home_n[1], self._place[2])
        if not self._landing and not self._climbing and self._from_home(now) < PLACE_REACHED:
            self._landing = True
            self.notes.append("RTL: land at destination\t")

    def _from_home(self, now: Estimate) -> float:
        """m, level."""
        return math.hypot(now.p_n[0] - self.home_n[0], now.p_n[1] - self.home_n[1])
