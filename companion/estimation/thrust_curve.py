"""The thrust curve, found by how the velocity follows what the commanded thrust varies by.

Thrust goes with the command F (specific thrust as encoded, m/s^2) and not quite in proportion,

    lift = k F_lin,    F_lin = F (1 + b (F - g) / g)

so that the thrust scale k is that at the hover as told, F = g, and b what the thrust's slope there is beyond
proportion. A rotor that makes f u^2 + (1 - f) u of a command u that PX4's THR_MDL_FAC has not bent is exactly this,
with b = f h / (1 - f + f h), h the normalised hover thrust as told. Everything but the encoding counts in F_lin, which
is linear in the lift; b is found like the motors' lag (``motor_lag``), with the slope dF_lin/db = F (F - g) / g.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.kalman import Innovation
from companion.estimation.motor_lag import correct_by_innovation
from companion.frames import clamped

CURVE_STD = 0.15
"""Ratio, standard deviation of b before a flight. Engineering choice: a THR_MDL_FAC that should be 0.3 is 0.18 at a
hover of one half, one of 0.5 is 0.33."""
CURVE_RANGE = (0.0, 0.5)
"""Ratio, of b. Engineering choice: f to 0.65 at a hover of one half. Not less than none, which would make the vertical
loop quicker: commands whose times are not known (a link that jitters by 100 ms) look like a thrust that answers
weakly."""
CORRELATION = 2.0
"""Number of innovations that tell as much as one that is independent. Simulated: with 1 errors after 40 s are 1.6
deviations on sih_noisy with a curve of 0.3."""
CURVE_Q = 3e-5
"""1/s, process noise of b: 0.04 in a minute. It keeps the deviation from shrinking below what the model is worth: with
1e-6 errors after a minute are 1.9 deviations, with this 1.2 (`sih_noisy`, 64 flights). Engineering choice."""


class ThrustCurve(NamedTuple):
    """``slope``: b. ``variance``: of it; zero where thrust is taken for proportional to the command."""

    slope: float
    variance: float

    def made_of(self, command: float, gravity: float) -> float:
        """F_lin of F, m/s^2."""
        return command * (1.0 + self.slope * (command / gravity - 1.0))

    def command_for(self, specific_thrust: float, gravity: float) -> float:
        """F of F_lin, m/s^2."""
        straight = 1.0 - self.slope
        bent = straight * straight + 4.0 * self.slope * specific_thrust / gravity
        return 2.0 * specific_thrust / (straight + math.sqrt(max(bent, 0.0)))

    def by_slope(self, specific_thrust: float, gravity: float) -> float:
        """dF_lin/db where it is ``specific_thrust``, m/s^2."""
        command = self.command_for(specific_thrust, gravity)
        return command * (command / gravity - 1.0)


PROPORTIONAL = ThrustCurve(0.0, 0.0)
"""Ratio: where thrust is taken for proportional to the command. By definition."""
UNKNOWN = ThrustCurve(0.0, CURVE_STD**2)
"""Ratio: before a flight. As CURVE_STD."""


def model_factor(slope: float, hover_thrust: float, told: float) -> float:
    """The THR_MDL_FAC with which thrust would be proportional to its command, 0..1, where it is ``told`` and leaves
    ``slope`` (b) at ``hover_thrust`` (normalised): that of the same slope there. PX4 makes the motor command s of the
    thrust m s^2 + (1 - m) s."""
    straight = 1.0 - told
    s = 2.0 * hover_thrust / (straight + math.sqrt(straight * straight + 4.0 * told * hover_thrust))
    taken = told * s / (straight + told * s)
    beyond = (1.0 + slope) * (1.0 + taken) - 1.0
    return clamped(beyond / (s + beyond * (1.0 - s)), 0.0, 1.0)


def update_thrust_curve(known: ThrustCurve, innovation: Innovation, dt: float) -> ThrustCurve:
    """``known`` after an ``innovation``, ``dt`` s later."""
    if known.variance == 0.0:
        return known
    slope, variance = correct_by_innovation(
        known.slope, known.variance + CURVE_Q * dt, innovation, innovation.by_curve, CORRELATION
    )
    return ThrustCurve(clamped(slope, *CURVE_RANGE), variance)
