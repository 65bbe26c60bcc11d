"""The nouns of a simulated world: air, link, home, and where the true machine differs from its vehicle file.

SI units and radians; world frame NED (``_n``). The figures of a vehicle file are what the companion believes; a World
says what is true where that differs. ``Start`` says how a vehicle comes up in the air.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.frames import Quaternion, Vec3, quaternion_from_euler


@dataclass(frozen=True, slots=True)
class Home:
    """Where the local frame's origin lies: degrees, and m above mean sea level. The default is PX4's SIH."""

    latitude: float = 47.397742
    longitude: float = 8.545594
    altitude: float = 489.4


@dataclass(frozen=True, slots=True)
class Link:
    """The radio or cable between vehicle and companion: the delay each way, s."""

    delay_down: float = 0.0
    """vehicle to companion"""
    delay_up: float = 0.0
    """companion to vehicle"""


@dataclass(frozen=True, slots=True)
class Deviations:
    """The machine as it really is, where it differs from its vehicle file. None: as the file says.

    ``mass`` kg, ``inertia`` kg m^2, ``motor_lag`` s, ``drag`` 1/s, ``thrust_scale`` true over stated thrust,
    ``angular_drag`` N m s (torque against the body rates, which vehicle files do not know).
    """

    mass: float | None = None
    inertia: Vec3 | None = None
    motor_lag: float | None = None
    drag: float | None = None
    thrust_scale: float = 1.0
    angular_drag: float = 0.0


@dataclass(frozen=True, slots=True)
class World:
    """A world. ``wind_n``: the velocity of the air over the ground, m/s."""

    name: str = "ideal"
    wind_n: Vec3 = (0.0, 0.0, 0.0)
    home: Home = field(default_factory=Home)
    link: Link = field(default_factory=Link)
    truth: Deviations = field(default_factory=Deviations)


@dataclass(frozen=True, slots=True)
class Start:
    """A vehicle that comes up in the air, armed, in HOLD.

    ``position_n`` m, ``velocity_n`` m/s, ``q_nb`` body to world, ``rates_b`` rad/s. ``held``: nothing moves and the
    vehicle's clock stands at 0 until the first setpoint in OFFBOARD.
    """

    position_n: Vec3
    velocity_n: Vec3 = (0.0, 0.0, 0.0)
    q_nb: Quaternion = (1.0, 0.0, 0.0, 0.0)
    rates_b: Vec3 = (0.0, 0.0, 0.0)
    held: bool = False

    @classmethod
    def hover(cls, position_n: Vec3, heading: float = 0.0) -> Start:
        """At rest at ``position_n`` (m), the nose at ``heading`` (rad, clockwise from north)."""
        return cls(position_n, q_nb=quaternion_from_euler(heading, 0.0, 0.0))
