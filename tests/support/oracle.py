"""An independent computation of the law: exact Lie derivatives of the outputs by symbolic differentiation (CasADi).

It shares nothing with companion.law but the text of the expressions, which CasADi's functions evaluate here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

FUNCTIONS = {
    name: getattr(ca, name)
    for name in ("sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "fabs")
}


@dataclass(frozen=True)
class Exact:
    xi: np.ndarray
    b: np.ndarray
    D: np.ndarray
    lower: float
    """the largest input term below the relative degree, which must vanish"""


def _value(text: str, names: Mapping[str, Any]) -> Any:
    scope = {**FUNCTIONS, "abs": ca.fabs, "hypot": lambda a, b: ca.sqrt(a * a + b * b), "pi": np.pi, **names}
    return eval(text, {"__builtins__": {}}, scope)


def oracle(
    h1: str,
    h2: str,
    alpha: str,
    beta: str,
    constants: Mapping[str, float],
    model: Mapping[str, float],
    rates: bool,
    twist: bool = False,
) -> Any:
    """A function of chi that gives Exact. ``rates``: the level of rates, chi without p, q, r and zeta_dot. ``twist``:
    beta is for the heading of the axis-angle twist about down, from the half angles of its quaternion."""
    X = ca.SX.sym("X", 3)
    psi, theta, phi = (ca.SX.sym(n) for n in ("psi", "theta", "phi"))
    V = ca.SX.sym("V", 3)
    w = ca.SX.sym("w", 3)
    zeta, zeta_dot = ca.SX.sym("zeta"), ca.SX.sym("zeta_dot")
    cps, sps, cth, sth, cph, sph = (
        ca.cos(psi), ca.sin(psi), ca.cos(theta), ca.sin(theta), ca.cos(phi), ca.sin(phi)
    )  # fmt: skip
    R = ca.vertcat(
        ca.horzcat(cth * cps, cps * sth * sph - cph * sps, cph * cps * sth + sph * sps),
        ca.horzcat(cth * sps, sth * sph * sps + cph * cps, cph * sth * sps - cps * sph),
        ca.horzcat(-sth, cth * sph, cth * cph),
    )
    Y = ca.vertcat(
        ca.horzcat(0, sph / cth, cph / cth), ca.horzcat(0, cph, -sph), ca.horzcat(1, sph * sth / cth, cph * sth / cth)
    )
    m, g = model["m"], model["g"]
    V_dot = ca.vertcat(0, 0, g) - zeta / m * R[:, 2]
    if rates:
        chi = ca.vertcat(X, psi, theta, phi, V, zeta)
        f = ca.vertcat(V, ca.SX.zeros(3), V_dot, 0)
        inputs = ca.vertcat(
            ca.SX.zeros(3, 4), ca.horzcat(ca.SX.zeros(3, 1), Y), ca.SX.zeros(3, 4), ca.SX([[1, 0, 0, 0]])
        )
        degrees = (3, 3, 2, 1)
    else:
        J = ca.diag(ca.DM([model["Ix"], model["Iy"], model["Iz"]]))
        chi = ca.vertcat(X, psi, theta, phi, V, w, zeta, zeta_dot)
        f = ca.vertcat(V, Y @ w, V_dot, ca.solve(J, -ca.cross(w, J @ w)), zeta_dot, 0)
        turning = ca.horzcat(ca.SX.zeros(3, 1), ca.inv(J))
        inputs = ca.vertcat(ca.SX.zeros(9, 4), turning, ca.SX.zeros(1, 4), ca.SX([[1, 0, 0, 0]]))
        degrees = (4, 4, 3, 2)
    names = {"x": X[0], "y": X[1], "z": X[2], **constants}
    f1, f2 = _value(h1, names) + 0 * X[0], _value(h2, names) + 0 * X[0]
    normal = ca.cross(ca.gradient(f1, X), ca.gradient(f2, X))
    h3 = ca.dot(normal / ca.norm_2(normal), V) - _value(alpha, names)
    heading = psi
    if twist:
        (c1, c2, c3), (s1, s2, s3) = ([f(0.5 * a) for a in (psi, theta, phi)] for f in (ca.cos, ca.sin))
        heading = 2.0 * ca.atan((s1 * c2 * c3 - c1 * s2 * s3) / (c1 * c2 * c3 + s1 * s2 * s3))
    h4 = heading - _value(beta, names)
    xi, b, rows, lower = [], [], [], []
    for h, degree in zip((f1, f2, h3, h4), degrees, strict=True):
        derivative = ca.SX(h)
        for k in range(degree):
            xi.append(derivative)
            row = ca.jtimes(derivative, chi, inputs)
            if k < degree - 1:
                lower.append(row)
            else:
                rows.append(row)
            derivative = ca.jtimes(derivative, chi, f)
        b.append(derivative)
    function = ca.Function("oracle", [chi], [ca.vertcat(*xi), ca.vertcat(*b), ca.vertcat(*rows), ca.vertcat(*lower)])

    def exact(state: Sequence[float]) -> Exact:
        values = [np.array(v) for v in function(ca.DM(list(state)))]
        return Exact(values[0].ravel(), values[1].ravel(), values[2], float(np.max(np.abs(values[3]), initial=0.0)))

    return exact
