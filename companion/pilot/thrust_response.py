"""Whether the vehicle makes the thrust that is commanded: both as acceleration along its thrust axis.

    made      = -e_b . (dv/dt - g e3 - air)    from the velocities of its states
    air       = LPF(d) - c v                   drag, and the wind as the estimator has had it for a while
    commanded = thrust / mass                  of the commands, in the vehicle's own scale as it was before

Both are low-passed with TIME; what was commanded comes later by what the command and the motors take. Without the air a
vehicle of much drag at a tilt of 45 degrees in a wind of 5 m/s seems to lack a third of its thrust. Only the horizontal
disturbance counts, low-passed with AIR_TIME: what pulls down, or has just come, may be a motor that gives less. The
scale is low-passed with SCALE_TIME, because the estimator takes a motor's loss into it within a second or two.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.steering.steering import Steered
from companion.vehicle import VehicleState

TIME = 0.08
"""s, time constant of both: a velocity that is 0.02 m/s rough makes 0.3 m/s^2 of it (engineering choice)."""
HELD = 0.01
"""s that a command is old on average when it acts, without the link and the motors: half a command's period and of the
vehicle's. Engineering choice."""
MOTOR_LAG = 0.05
"""s, of the motors where it is not looked for: PX4's simulated quadrotor."""
AIR_TIME = 3.0
"""s, time constant of the disturbance that counts as air: a failing motor shows long before. Engineering choice."""
SCALE_TIME = 20.0
"""s, time constant in which the scale is taken over. Engineering choice: a battery that sags is none of this, a motor
that fails is."""
GAP_MAX = 0.1
"""s between two states beyond which both begin anew. Engineering choice."""


class ThrustResponse(NamedTuple):
    """m/s^2, smoothed: the specific thrust ``made`` and ``commanded``; ``acting``: what acts of it. ``known``: s
    without a gap. ``air``: m/s^2, north and east, the disturbance that lasts. ``scale``: of the thrust, as it was
    before."""

    made: float = 0.0
    commanded: float = 0.0
    acting: float = 0.0
    known: float = 0.0
    air: tuple[float, float] = (0.0, 0.0)
    scale: float = 1.0


NO_RESPONSE = ThrustResponse()


def update_thrust_response(
    response: ThrustResponse, old: VehicleState, new: VehicleState, steered: Steered, mass: float, gravity: float,
    delay: float, judged: bool,
) -> ThrustResponse:  # fmt: skip
    """``response`` after another state. ``steered``: the command before it. ``delay``: s, of the link there and back.
    ``judged``: False while the scale is still being found, which is then taken as it is."""
    dt = new.t_boot - old.t_boot
    if not 0.0 < dt < GAP_MAX or new.resets != old.resets:
        return NO_RESPONSE
    (u, v, w), (a, b, c), (x, y, z) = old.v_n, new.v_n, new.z_axis_n
    found, begins = steered.estimates, response.known == 0.0
    drag, (north, east), scale, motor_lag = 0.0, (0.0, 0.0), 1.0, MOTOR_LAG
    if found is not None:
        drag, (north, east), scale = found.drag, found.disturbance[:2], found.thrust_scale
        motor_lag = MOTOR_LAG if math.isnan(found.motor_lag) else found.motor_lag
    air = (north, east) if begins else _towards(response.air, (north, east), dt / (AIR_TIME + dt))
    kept = scale if begins or not judged else response.scale + dt / (SCALE_TIME + dt) * (scale - response.scale)
    ax, ay = (a - u) / dt + drag * a - air[0], (b - v) / dt + drag * b - air[1]
    made = -(ax * x + ay * y + ((c - w) / dt + drag * c - gravity) * z)
    commanded = steered.thrust / mass * kept / scale
    if begins:
        return ThrustResponse(made, commanded, commanded, dt, air, kept)
    k, later = dt / (TIME + dt), dt / (HELD + motor_lag + delay + dt)
    acting = response.acting + later * (commanded - response.acting)
    smooth = _towards((response.made, response.commanded), (made, acting), k)
    return ThrustResponse(*smooth, acting, response.known + dt, air, kept)


def _towards(a: tuple[float, float], b: tuple[float, float], k: float) -> tuple[float, float]:
    return a[0] + k * (b[0] - a[0]), a[1] + k * (b[1] - a[1])
