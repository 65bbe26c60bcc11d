"""The state a vehicle is in, and what it says of itself."""

from __future__ import annotations

import enum
import math
from typing import Generic, NamedTuple, TypeVar

from companion.frames import Matrix3, Quaternion, Vec3, body_z_axis, clamped, rotation_matrix


class VehicleState(NamedTuple):
    """The vehicle's own estimate at one stamp.

    ``t_boot``: s, the vehicle's clock. ``p_n``, ``v_n``: m, m/s in its local NED frame. ``q_nb``: body to world.
    ``w_b``: rad/s. ``resets``: the estimator's reset counter (compare changes, not values).
    """

    t_boot: float
    p_n: Vec3
    v_n: Vec3
    q_nb: Quaternion
    w_b: Vec3
    resets: int = 0

    @property
    def r_nb(self) -> Matrix3:
        """The rotation matrix of ``q_nb``."""
        return rotation_matrix(self.q_nb)

    @property
    def z_axis_n(self) -> Vec3:
        """The body's down axis in the world: the third column of ``r_nb``."""
        return body_z_axis(self.q_nb)

    @property
    def tilt(self) -> float:
        """rad, the angle between the body's down axis and the world's."""
        return math.acos(clamped(body_z_axis(self.q_nb)[2], -1.0, 1.0))


class Mode(enum.Enum):
    """A flight mode of PX4, by its own numbers (main, sub)."""

    MANUAL = (1, 0)
    ALTITUDE = (2, 0)
    POSITION = (3, 0)
    ORBIT = (3, 1)
    POSITION_SLOW = (3, 2)
    READY = (4, 1)
    TAKEOFF = (4, 2)
    HOLD = (4, 3)
    MISSION = (4, 4)
    RETURN = (4, 5)
    LAND = (4, 6)
    FOLLOW = (4, 8)
    PRECISION_LAND = (4, 9)
    EXTERNAL1 = (4, 11)
    EXTERNAL2 = (4, 12)
    EXTERNAL3 = (4, 13)
    EXTERNAL4 = (4, 14)
    EXTERNAL5 = (4, 15)
    EXTERNAL6 = (4, 16)
    EXTERNAL7 = (4, 17)
    EXTERNAL8 = (4, 18)
    GUIDED_COURSE = (4, 19)
    DESCEND = (4, 20)
    ACRO = (5, 0)
    OFFBOARD = (6, 0)
    STABILIZED = (7, 0)
    TERMINATION = (10, 0)
    ALTITUDE_CRUISE = (11, 0)
    UNKNOWN = (0, 0)

    __hash__ = object.__hash__  # members are the only ones of their kind; Enum's own goes by the name, in Python

    @property
    def words(self) -> str:
        """Its name as a pilot reads it."""
        return self.name.replace("_", " ").capitalize()

    @property
    def main(self) -> int:
        """The main mode of DO_SET_MODE's second parameter."""
        return self.value[0]

    @property
    def sub(self) -> int:
        """The sub mode of DO_SET_MODE's third parameter."""
        return self.value[1]

    @property
    def custom_mode(self) -> int:
        """The number in HEARTBEAT and CURRENT_MODE."""
        return self.value[0] << 16 | self.value[1] << 24


class Landed(enum.Enum):
    """Where the vehicle says it is (MAV_LANDED_STATE)."""

    UNDEFINED = 0
    ON_GROUND = 1
    IN_AIR = 2
    TAKING_OFF = 3
    LANDING = 4

    __hash__ = object.__hash__


T = TypeVar("T")


class Fact(NamedTuple, Generic[T]):
    """Something the vehicle said. ``at``: s, our clock, when it was received; its message carries no stamp of the
    vehicle's. ``lasts``: s for which it counts, by the rhythm of the message that said it. Older is unknown."""

    value: T
    at: float
    lasts: float

    def value_at(self, now: float) -> T | None:
        """The value; None where it is older than it lasts."""
        value, at, lasts = self
        return value if now - at <= lasts else None


class KnownStatus(NamedTuple):
    """What is known of the vehicle at one moment; None where it has not said, or not of late.

    ``mode`` is the mode it is in, ``intended`` the one its user asked for (they differ in a failsafe). ``ready``: it
    would accept arming. ``battery``: what remains, 0..1. ``estimator``: the flags of ESTIMATOR_STATUS. ``mode_age``: s
    since it last said its mode, inf where it never did. ``was_armed``: it was seen armed since it was first heard.
    """

    armed: bool | None = None
    mode: Mode | None = None
    intended: Mode | None = None
    landed: Landed | None = None
    ready: bool | None = None
    failsafe: bool | None = None
    battery: float | None = None
    estimator: int | None = None
    mode_age: float = math.inf
    was_armed: bool = False


class VehicleStatus(NamedTuple):
    """What the vehicle last said of itself, each with its age; None where it has not said. The fields are those of
    KnownStatus, which is what may be decided on."""

    armed: Fact[bool] | None = None
    mode: Fact[Mode] | None = None
    intended: Fact[Mode] | None = None
    landed: Fact[Landed] | None = None
    ready: Fact[bool] | None = None
    failsafe: Fact[bool] | None = None
    battery: Fact[float] | None = None
    estimator: Fact[int] | None = None
    was_armed: bool = False

    def known_at(self, now: float) -> KnownStatus:
        """What is known at ``now``, s by our clock."""
        armed, mode, intended, landed, ready, failsafe, battery, estimator, was_armed = self
        return KnownStatus(
            None if armed is None else armed.value_at(now),
            None if mode is None else mode.value_at(now),
            None if intended is None else intended.value_at(now),
            None if landed is None else landed.value_at(now),
            None if ready is None else ready.value_at(now),
            None if failsafe is None else failsafe.value_at(now),
            None if battery is None else battery.value_at(now),
            None if estimator is None else estimator.value_at(now),
            math.inf if mode is None else now - mode.at,
            was_armed,
        )

    @property
    def last(self) -> KnownStatus:
        """What it last said, however long ago: for people to read, never to decide on."""
        return self.known_at(-math.inf)._replace(mode_age=0.0)


class Tuning(NamedTuple):
    """What the autopilot's own parameters say that matters to the law and to the guards; None where it did not say."""

    roll_p: float | None = None  # 1/s, attitude error to body rate (MC_ROLL_P)
    pitch_p: float | None = None  # 1/s (MC_PITCH_P)
    yaw_p: float | None = None  # 1/s (MC_YAW_P)
    smoothing: float | None = None  # rad/s, of the model that smooths the attitude it is sent (MC_REF_W_N, since 1.18)
    hover_thrust: float | None = None  # normalised (MPC_THR_HOVER)
    thrust_curve: float | None = None  # 0 linear, 1 quadratic in the motor command (THR_MDL_FAC)
    offboard_loss_time: float | None = None  # s until the loss of setpoints is acted on (COM_OF_LOSS_T)
    offboard_loss_action: int | None = None  # how (COM_OBL_RC_ACT)
    fail_roll: float | None = None  # rad at which its failure detector ends the flight (FD_FAIL_R)
    fail_pitch: float | None = None  # rad (FD_FAIL_P)
    battery_low: float | None = None  # 0..1 (BAT_LOW_THR)
    battery_critical: float | None = None  # 0..1 (BAT_CRIT_THR)
    fence_radius: float | None = None  # m from home, 0 for none (GF_MAX_HOR_DIST)
    fence_height: float | None = None  # m above home, 0 for none (GF_MAX_VER_DIST)
    roll_rate_p: float | None = None  # s/rad, rate error to the part of the motors' range (MC_ROLLRATE_P)
    roll_rate_k: float | None = None  # factor on it (MC_ROLLRATE_K)
    yaw_rate_p: float | None = None  # s/rad (MC_YAWRATE_P)
    yaw_rate_i: float | None = None  # 1/rad, of its integral (MC_YAWRATE_I)
    yaw_rate_k: float | None = None  # factor on both (MC_YAWRATE_K)


class Home(NamedTuple):
    """Where the vehicle would return to: degrees, m above mean sea level, and the same place in its local frame (m)."""

    latitude: float
    longitude: float
    altitude: float
    p_n: Vec3


class FrameOrigin(NamedTuple):
    """Where the vehicle's local frame has its origin: degrees, and m above mean sea level."""

    latitude: float
    longitude: float
    altitude: float
