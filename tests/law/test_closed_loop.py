"""The law evaluated continuously on the ideal, unconstrained model: what the paper proves, to round-off.

The model here is the paper's own (Eqs. 1, 2, 4) in its own coordinates, written out again for the test.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag, expm

from companion.calculus.vectors import Vector
from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.frames import Heading, rotation_from_euler, tilt
from companion.law.bare import bare_law
from companion.law.flight import Flying, implicit_law, model_of
from companion.law.gains import Gains, Level
from companion.law.reference import reference_motion
from companion.law.speed_scale import SpeedScale
from companion.mission import Mission


@dataclass(frozen=True)
class Loop:
    """A mission of the paper and its closed loop chi' = f + g u(chi)."""

    mission: Mission
    derivative: Callable[[float, np.ndarray], np.ndarray]
    xi: Callable[[np.ndarray], np.ndarray]
    start: np.ndarray

    def fly(self, chi: np.ndarray, t: np.ndarray) -> np.ndarray:
        solution = solve_ivp(self.derivative, (t[0], t[-1]), chi, method="DOP853", t_eval=t, rtol=1e-12, atol=1e-12)
        assert solution.success
        return np.asarray(solution.y.T)


def loop_of(name: str, heading: Heading = Heading.PROJECTED) -> Loop:
    mission = replace(load_mission(name, Level.MOTORS), heading=heading)
    vehicle = load_vehicle("paper")
    gains = mission.gains
    assert gains is not None
    spec = mission.specification(1.0)
    law = implicit_law(spec, Level.MOTORS, model_of(vehicle), gains, None)
    bare = bare_law(spec, Level.MOTORS, model_of(vehicle), gains)
    m, g = vehicle.mass, vehicle.gravity
    ix, iy, iz = vehicle.inertia

    def derivative(t: float, chi: np.ndarray) -> np.ndarray:
        x, y, z, psi, theta, phi, u, v, w, p, q, r, zeta, zeta_dot = (float(c) for c in chi)
        R = rotation_from_euler(psi, theta, phi)
        command = law(Flying((x, y, z), (u, v, w), R, zeta, (p, q, r), zeta_dot), SpeedScale())
        u2, u3, u4 = command.turn
        c_th, s_ph, c_ph, t_th = math.cos(theta), math.sin(phi), math.cos(phi), math.tan(theta)
        return np.array(
            [
                u, v, w,
                (s_ph * q + c_ph * r) / c_th, c_ph * q - s_ph * r, p + (s_ph * q + c_ph * r) * t_th,
                -zeta / m * R[2], -zeta / m * R[5], g - zeta / m * R[8],
                (u2 - (iz - iy) * q * r) / ix, (u3 - (ix - iz) * r * p) / iy, (u4 - (iy - ix) * p * q) / iz,
                zeta_dot, command.zeta_derivative,
            ]
        )  # fmt: skip

    start = mission.start
    assert start is not None
    chi = np.array(
        [
            *start.position, start.heading, start.pitch, start.roll, *start.velocity, *start.rates_b,
            vehicle.weight, 0.0,
        ]
    )  # fmt: skip
    return Loop(mission, derivative, lambda c: np.array(bare([float(v) for v in c]).xi), chi)


def companion_matrix(gains: Gains) -> np.ndarray:
    """A of Eq. (10): a chain of integrators an output, closed by its gains."""
    blocks = []
    for k in gains.each:
        block = np.eye(len(k), k=1)
        block[-1] = -np.array(k)
        blocks.append(block)
    return np.asarray(block_diag(*blocks))


@pytest.fixture(scope="module", params=["paper_case1", "paper_case2"])
def loop(request: Any) -> Loop:
    return loop_of(request.param)


def test_errors_are_linear_and_decoupled(loop: Loop) -> None:
    """xi(t) = exp(A t) xi(0) (Eq. 10), from the paper's own start, to 1e-6 of its start."""
    t = np.linspace(0.0, 6.0, 25)
    flown = loop.fly(loop.start, t)
    assert loop.mission.gains is not None
    A = companion_matrix(loop.mission.gains)
    first = loop.xi(flown[0])
    for time, chi in zip(t, flown, strict=True):
        assert np.max(np.abs(loop.xi(chi) - expm(A * time) @ first)) < 1e-6 * np.max(np.abs(first))


def test_steady_states_of_the_paper(loop: Loop) -> None:
    """Largest roll and pitch atan(alpha^2/(r g)) and the thrust m sqrt(g^2 + (alpha^2/r)^2)."""
    speed = loop.mission.alpha(0.0)
    angle = {3.0: 5.2418, 15.0: 66.4428}[speed]
    thrust = {3.0: 19.7024, 15.0: 49.0912}[speed]
    period = math.tau * 10.0 / speed
    # half-turns are split finely enough that the extremes are hit to 1e-5 deg
    t = np.concatenate([[0.0], 20.0 + np.linspace(0.0, period, 4001)])
    flown = loop.fly(loop.start, t)[1:]
    assert np.degrees(np.max(np.abs(flown[:, 4]))) == pytest.approx(angle, abs=1e-4)
    assert np.degrees(np.max(np.abs(flown[:, 5]))) == pytest.approx(angle, abs=1e-4)
    assert np.max(flown[:, 12]) == pytest.approx(thrust, abs=1e-4)
    assert np.min(flown[:, 12]) == pytest.approx(thrust, abs=1e-4)
    assert np.max(np.abs(np.hypot(flown[:, 0], flown[:, 1]) - 10.0)) < 1e-6
    assert np.degrees(np.max(np.abs(flown[:, 3]))) < 1e-4


def test_the_twist_heading_needs_no_yaw_torque_in_a_steady_turn() -> None:
    """Case 2 again, 66 degrees steep: the errors are as linear; and in the steady state, where the projected heading
    swings the yaw rate by 3.15 rad/s twice a turn, the twist turns at alpha/r (1 - cos(tilt)) all the time."""
    loop = loop_of("paper_case2", Heading.TWIST)
    t = np.concatenate([np.linspace(0.0, 6.0, 25), 20.0 + np.linspace(0.0, math.tau * 10.0 / 15.0, 101)])
    flown = loop.fly(loop.start, t)
    assert loop.mission.gains is not None
    A = companion_matrix(loop.mission.gains)
    first = loop.xi(flown[0])
    for time, chi in zip(t[:25], flown, strict=False):
        assert np.max(np.abs(loop.xi(chi) - expm(A * time) @ first)) < 1e-6 * np.max(np.abs(first))
    for s in (0.0, 7.0, 33.3, 60.0):
        assert np.max(np.abs(loop.xi(on_the_manifold(loop.mission, s)))) < 1e-8
    steady = flown[25:]
    R = [rotation_from_euler(*map(float, chi[3:6])) for chi in steady]
    lean = math.atan(22.5 / 9.81)
    assert np.degrees([tilt(r) for r in R]) == pytest.approx(math.degrees(lean), abs=1e-4)
    assert np.degrees([Heading.TWIST.of(r) for r in R]) == pytest.approx(0.0, abs=1e-4)
    assert np.max(np.abs(np.hypot(steady[:, 0], steady[:, 1]) - 10.0)) < 1e-6
    # alpha > 0 runs counter-clockwise seen from above: the thrust axis precesses that way, and the body the other
    assert steady[:, 11] == pytest.approx(1.5 * (1.0 - math.cos(lean)), abs=1e-4)
    assert np.hypot(steady[:, 9], steady[:, 10]) == pytest.approx(1.5 * math.sin(lean), abs=1e-4)


def on_the_manifold(mission: Mission, s: float) -> np.ndarray:
    """chi on the path following manifold at arc length s (Lemma 4.4, corrected)."""
    x, y, z = mission.path.table.at(s)[0]
    ref = reference_motion(mission.specification(1.0), model_of(load_vehicle("paper")), Vector(x, y, z))
    R = ref.R
    psi, theta, phi = math.atan2(R.e1.y, R.e1.x), math.asin(-R.e1.z), math.atan2(R.e2.z, R.e3.z)
    return np.array([x, y, z, psi, theta, phi, *ref.V.components(), *ref.w.components(), ref.zeta, ref.zeta_dot])


def test_the_reference_is_on_the_manifold(loop: Loop) -> None:
    for s in (0.0, 7.0, 33.3, 60.0):
        assert np.max(np.abs(loop.xi(on_the_manifold(loop.mission, s)))) < 1e-8


def test_angles_and_thrust_by_the_corrected_lemma(loop: Loop) -> None:
    """phi = asin((s_psi a1 - c_psi a2)/zeta), theta = asin((c_psi a1 + s_psi a2)/(zeta c_phi)), zeta = |a|."""
    m, g = 2.0, 9.81
    speed = loop.mission.alpha(0.0)
    for s in (1.0, 20.0, 44.0):
        chi = on_the_manifold(loop.mission, s)
        x, y, psi, theta, phi, zeta = chi[0], chi[1], chi[3], chi[4], chi[5], chi[12]
        a = -m * (np.array([-x, -y, 0.0]) * speed**2 / 100.0 - np.array([0.0, 0.0, g]))
        assert zeta == pytest.approx(np.linalg.norm(a), rel=1e-9)
        sine = (math.sin(psi) * a[0] - math.cos(psi) * a[1]) / zeta
        assert phi == pytest.approx(math.asin(sine), abs=1e-9)
        sine = (math.cos(psi) * a[0] + math.sin(psi) * a[1]) / (zeta * math.cos(phi))
        assert theta == pytest.approx(math.asin(sine), abs=1e-9)


def test_invariance(loop: Loop) -> None:
    """Started on the path following manifold the vehicle stays on the path for 60 s, and eta' = alpha."""
    t = np.linspace(0.0, 60.0, 241)
    flown = loop.fly(on_the_manifold(loop.mission, 12.0), t)
    table = loop.mission.path.table
    off = [math.hypot(math.hypot(chi[0], chi[1]) - 10.0, chi[2] + 20.0) for chi in flown]
    assert max(off) < 1e-6
    eta = [table.locate((float(c[0]), float(c[1]), float(c[2])))[0] for c in flown]
    speed = loop.mission.alpha(0.0)
    for time, here in zip(t, eta, strict=True):
        assert abs(table.difference(here, table.within(12.0 + speed * time))) < 1e-6


def test_lemma_4_4(loop: Loop) -> None:
    """det(d sigma) = -zeta^4 c_phi^2 / (m^6 c_theta) (n . mu)^3 (n . d lambda) at points of the manifold."""
    rng = random.Random(2)
    table = loop.mission.path.table
    for _ in range(4):
        s = rng.uniform(0.0, table.length)
        chi = on_the_manifold(loop.mission, s)

        def sigma(state: np.ndarray, s: float = s) -> np.ndarray:
            here = (float(state[0]), float(state[1]), float(state[2]))
            return np.append(loop.xi(state), table.difference(table.nearest(here, s)[0], s))

        columns = []
        for i in range(14):
            h = 1e-5 * max(1.0, abs(chi[i]))
            step = np.zeros(14)
            step[i] = h
            columns.append((sigma(chi + step) - sigma(chi - step)) / (2.0 * h))
        zeta, theta, phi = chi[12], chi[4], chi[5]
        area = 2.0 * 10.0  # |grad h1 x grad h2| = 2 r on the paper's circle, along mu and along d lambda
        expected = -(zeta**4) * math.cos(phi) ** 2 / (2.0**6 * math.cos(theta)) * area**3 * area
        assert np.linalg.det(np.stack(columns, axis=1)) == pytest.approx(expected, rel=2e-5)
