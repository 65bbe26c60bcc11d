"""Whether the vehicle makes the thrust that is commanded: both as acceleration along its thrust axis.

    made   = -e_b . (dv/dt - g e3 - air)    from the velocities of its states
    air    = LPF(d) - c v                   drag, and the wind as the estimator has had it for a while
    asked  = thrust / mass                  of the commands, in the vehicle's own scale as it was before

Both are smoothed over TIME; what was asked for comes later by what the command and the motors take. Without the air a
vehicle of much drag that leans by 45 degrees in a wind of 5 m/s seems to lack a third of its thrust. Only level, and
only what lasts: what pulls it down, or has just come, may be a motor that gives less. The scale is the estimator's with
SCALE_TIME: it learns within a second or two what a motor has lost, and would then ask for no more.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.steering.steering import Steered
from companion.vehicle import VehicleState

TIME = 0.08
"""s, time constant of both: a velocity that is 0.02 m/s rough makes 0.3 m/s^2 of it (engineering choice)."""
ACTUATION = 0.06
"""s until a command is thrust, without the link: rotors 0.05 (PX4's simulated quadrotor), and half a command's
period."""
AIR_TIME = 3.0
"""s, time constant of the disturbance that counts as air: a failing motor shows long before. Engineering choice."""
SCALE_TIME = 20.0
"""s, time constant in which the scale is taken over. Engineering choice: a battery that sags is none of this, a motor
that fails is."""
GAP_MAX = 0.1
"""s between two states beyond which both begin anew. Engineering choice."""


class Lift(NamedTuple):
    """m/s^2, smoothed: what was ``made`` and what was ``asked`` for; ``acting``: on its way to be. ``known``: s that
    it was followed without a gap. ``air``: m/s^2, north and east, the disturbance that lasts. ``scale``: of the thrust,
    as it was before."""

    made: float = 0.0
    asked: float = 0.0
    acting: float = 0.0
    known: float = 0.0
    air: tuple[float, float] = (0.0, 0.0)
    scale: float = 1.0


NO_LIFT = Lift()


def update_lift(
    lift: Lift, old: VehicleState, new: VehicleState, steered: Steered, mass: float, gravity: float, delay: float,
    judged: bool,
) -> Lift:  # fmt: skip
    """``lift`` after another state. ``steered``: the command before it. ``delay``: s, of the link there and back.
    ``judged``: False while the scale is still being found, which is then taken as it is."""
    dt = new.t_boot - old.t_boot
    if not 0.0 < dt < GAP_MAX or new.resets != old.resets:
        return NO_LIFT
    (u, v, w), (a, b, c), r = old.v_n, new.v_n, new.r_nb
    found, begins = steered.estimates, lift.known == 0.0
    drag, (north, east), scale = (
        (0.0, (0.0, 0.0), 1.0) if found is None else (found.drag, found.disturbance[:2], found.thrust_scale)
    )
    air = (north, east) if begins else _towards(lift.air, (north, east), dt / (AIR_TIME + dt))
    kept = scale if begins or not judged else lift.scale + dt / (SCALE_TIME + dt) * (scale - lift.scale)
    ax, ay = (a - u) / dt + drag * a - air[0], (b - v) / dt + drag * b - air[1]
    made = -(ax * r[2] + ay * r[5] + ((c - w) / dt - gravity) * r[8])
    asked = steered.thrust_n / mass * kept / scale
    if begins:
        return Lift(made, asked, asked, dt, air, kept)
    k, later = dt / (TIME + dt), dt / (ACTUATION + delay + dt)
    acting = lift.acting + later * (asked - lift.acting)
    smooth = _towards((lift.made, lift.asked), (made, acting), k)
    return Lift(*smooth, acting, lift.known + dt, air, kept)


def _towards(a: tuple[float, float], b: tuple[float, float], k: float) -> tuple[float, float]:
    return a[0] + k * (b[0] - a[0]), a[1] + k * (b[1] - a[1])
