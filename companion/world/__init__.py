"""A simulated world: air, machine, estimate, link, and what happens in it.

    air         gusts                                machine   where the true machine differs from its vehicle file
    estimate    how wrong the vehicle's state is     link      what becomes of datagrams
    events      pushes, failures, resets: what happens at a time (when); link_events: to datagrams
    actors      the operator, the pilot's hands, strangers on the link
    words       all of it for people

SI units and radians; world frame NED (``_n``). The figures of a vehicle file are what the companion believes; a World
says what is true where that differs. ``Start`` says how a vehicle comes up in the air.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.frames import Quaternion, Vec3, quaternion_from_euler
from companion.world.air import DrydenGusts, Gusts
from companion.world.estimate import Errors
from companion.world.events import Event
from companion.world.link import Link, Way
from companion.world.machine import Battery, Deviations

__all__ = ["Battery", "Deviations", "Errors", "Event", "Home", "Link", "Start", "Way", "World"]


@dataclass(frozen=True, slots=True)
class Home:
    """Where the local frame's origin lies: degrees, and m above mean sea level. The default is PX4's SIH."""

    latitude: float = 47.397742
    longitude: float = 8.545594
    altitude: float = 489.4


@dataclass(frozen=True, slots=True)
class World:
    """A world. ``wind_n``: the mean velocity of the air over the ground, m/s; ``gusts`` come on top of it.

    ``battery`` None: it never sags. ``events`` in any order.
    """

    name: str = "ideal"
    wind_n: Vec3 = (0.0, 0.0, 0.0)
    gusts: Gusts | DrydenGusts | None = None
    home: Home = field(default_factory=Home)
    link: Link = field(default_factory=Link)
    truth: Deviations = field(default_factory=Deviations)
    battery: Battery | None = None
    estimate: Errors = field(default_factory=Errors)
    events: tuple[Event, ...] = ()


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
