"""Lissajous curves: each coordinate a sine of its own frequency. A figure-eight is one of them."""

from __future__ import annotations

import math

from companion.calculus.scalar import Scalar, sin
from companion.frames import Vec3
from companion.paths.curve import Curve, analytic


def lissajous(center: Vec3, amplitude: Vec3, frequency: tuple[int, int, int], phase: Vec3) -> Curve:
    """center + amplitude sin(frequency u + phase), coordinate by coordinate; amplitudes m, phases rad.

    It closes after one round of u, in which a common factor of the frequencies is left out. ValueError: it is a point.
    """
    moving = [f for a, f in zip(amplitude, frequency, strict=True) if a != 0.0]
    common = math.gcd(*moving)
    if common == 0:
        raise ValueError("every amplitude or frequency is zero: it is a point")

    def gamma(u: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        x, y, z = (
            c + (a * sin((f // common) * u + p) if a != 0.0 else 0.0)
            for c, a, f, p in zip(center, amplitude, frequency, phase, strict=True)
        )
        return x, y, z

    return analytic(gamma, 0.0, math.tau, True)
