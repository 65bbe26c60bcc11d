"""Rotations: signs first, then properties."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.frames import (
    Heading,
    conjugate,
    euler_from_rotation,
    from_rotation_vector,
    multiply,
    normalised,
    quaternion_from_euler,
    rotation_from_euler,
    rotation_matrix,
    tilt,
    to_body,
    to_world,
    upright_error,
    wrap,
)

angle = st.floats(-3.1, 3.1)
tilts = st.floats(-1.5, 1.5)


def test_signs() -> None:
    north, east, down = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    yawed = rotation_from_euler(math.pi / 2, 0.0, 0.0)
    assert to_world(yawed, north) == pytest.approx(east)  # nose to the east
    pitched = rotation_from_euler(0.0, math.pi / 2, 0.0)
    assert to_world(pitched, north) == pytest.approx((0.0, 0.0, -1.0))  # nose up
    rolled = rotation_from_euler(0.0, 0.0, math.pi / 2)
    assert to_world(rolled, east) == pytest.approx(down)  # right side down


@given(angle, tilts, angle)
def test_quaternion_matrix_and_euler_agree(psi: float, theta: float, phi: float) -> None:
    r = rotation_matrix(quaternion_from_euler(psi, theta, phi))
    assert r == pytest.approx(rotation_from_euler(psi, theta, phi), abs=1e-12)
    assert rotation_from_euler(*euler_from_rotation(r)) == pytest.approx(r, abs=1e-9)
    matrix = np.array(r).reshape(3, 3)
    assert np.allclose(matrix @ matrix.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(matrix) == pytest.approx(1.0)


@given(angle, tilts, tilts)
def test_headings(psi: float, theta: float, phi: float) -> None:
    q = quaternion_from_euler(psi, theta, phi)
    r = rotation_matrix(q)
    assert wrap(Heading.PROJECTED.of(r) - psi) == pytest.approx(0.0, abs=1e-9)
    assert wrap(Heading.TWIST.of(r) - 2.0 * math.atan2(q[3], q[0])) == pytest.approx(0.0, abs=1e-9)
    assert wrap(Heading.TWIST.of(rotation_from_euler(psi, theta, 0.0)) - psi) == pytest.approx(0.0, abs=1e-9)


@given(angle, tilts, angle, st.tuples(*[st.floats(-5, 5)] * 3))
def test_body_and_world_are_inverse(psi: float, theta: float, phi: float, v: tuple[float, float, float]) -> None:
    r = rotation_from_euler(psi, theta, phi)
    assert to_body(r, to_world(r, v)) == pytest.approx(v, abs=1e-9)


@given(st.tuples(*[st.floats(-3, 3)] * 3))
def test_rotation_vectors(v: tuple[float, float, float]) -> None:
    q = from_rotation_vector(v)
    assert sum(c * c for c in q) == pytest.approx(1.0)
    assert multiply(q, conjugate(q)) == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-12)
    assert to_world(rotation_matrix(q), v) == pytest.approx(v, abs=1e-9)  # the axis stays


@given(angle, tilts, angle, angle, tilts, angle)
def test_products_compose(a: float, b: float, c: float, d: float, e: float, f: float) -> None:
    p, q = quaternion_from_euler(a, b, c), quaternion_from_euler(d, e, f)
    product = np.array(rotation_matrix(p)).reshape(3, 3) @ np.array(rotation_matrix(q)).reshape(3, 3)
    assert np.allclose(np.array(rotation_matrix(multiply(p, q))).reshape(3, 3), product, atol=1e-12)


@given(angle, st.floats(-1.4, 1.4), st.floats(-1.4, 1.4))
def test_turning_by_the_upright_error_comes_nearer_to_level(psi: float, theta: float, phi: float) -> None:
    q = quaternion_from_euler(psi, theta, phi)
    before = tilt(rotation_matrix(q))
    x, y = upright_error(rotation_matrix(q))
    assert math.hypot(x, y) == pytest.approx(math.sin(min(before, math.pi / 2)), abs=1e-6)
    after = tilt(rotation_matrix(multiply(q, from_rotation_vector((0.1 * x, 0.1 * y, 0.0)))))
    assert after <= before + 1e-9
    if before > 0.01:
        assert after < before


def test_upright_error_knows_a_way_even_upside_down() -> None:
    assert math.hypot(*upright_error(rotation_from_euler(0.0, 0.0, math.pi))) == pytest.approx(1.0)


def test_wrap_and_normalise() -> None:
    assert wrap(math.radians(190.0)) == pytest.approx(math.radians(-170.0))
    assert wrap(-7.0 * math.pi) == pytest.approx(math.pi, abs=1e-9) or wrap(-7.0 * math.pi) == pytest.approx(-math.pi)
    assert normalised((2.0, 0.0, 0.0, 0.0)) == (1.0, 0.0, 0.0, 0.0)
