"""Three-vectors of scalars, so that the law reads as the paper writes it. Not for floats in a loop: for recording."""

from __future__ import annotations

from companion.calculus.scalar import Scalar, sqrt


class Vector:
    """A 3-vector of any number type. ``a @ b`` is the inner product, ``a.cross(b)`` the vector product."""

    __slots__ = ("x", "y", "z")

    def __init__(self, x: Scalar, y: Scalar, z: Scalar) -> None:
        self.x, self.y, self.z = x, y, z

    def __add__(self, other: Vector) -> Vector:
        return Vector(self.x + other.x, self.y + other.y, self.z + other.z)

    def __sub__(self, other: Vector) -> Vector:
        return Vector(self.x - other.x, self.y - other.y, self.z - other.z)

    def __neg__(self) -> Vector:
        return Vector(-self.x, -self.y, -self.z)

    def __mul__(self, factor: Scalar) -> Vector:
        return Vector(self.x * factor, self.y * factor, self.z * factor)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Scalar) -> Vector:
        return Vector(self.x / divisor, self.y / divisor, self.z / divisor)

    def __matmul__(self, other: Vector) -> Scalar:
        return self.x * other.x + self.y * other.y + self.z * other.z

    def cross(self, other: Vector) -> Vector:
        """The vector product."""
        return Vector(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )

    def norm(self) -> Scalar:
        """The Euclidean length."""
        return sqrt(self @ self)

    def components(self) -> tuple[Scalar, Scalar, Scalar]:
        """(x, y, z)."""
        return (self.x, self.y, self.z)


ZERO = Vector(0.0, 0.0, 0.0)
"""No length."""
E3 = Vector(0.0, 0.0, 1.0)
"""The paper's e3: down in NED, the thrust's axis in the body frame."""


class Rotation:
    """R_nb by its columns: the body axes forward, right and down in the world frame."""

    __slots__ = ("e1", "e2", "e3")

    def __init__(self, e1: Vector, e2: Vector, e3: Vector) -> None:
        self.e1, self.e2, self.e3 = e1, e2, e3

    def to_world(self, v: Vector) -> Vector:
        """R v."""
        result: Vector = self.e1 * v.x + self.e2 * v.y + self.e3 * v.z
        return result

    def to_body(self, v: Vector) -> Vector:
        """R^T v."""
        return Vector(self.e1 @ v, self.e2 @ v, self.e3 @ v)

    def dot(self, w: Vector) -> Rotation:
        """R' = R [w]x for body rates w: the columns' time derivatives."""
        return Rotation(
            self.e2 * w.z - self.e3 * w.y,
            self.e3 * w.x - self.e1 * w.z,
            self.e1 * w.y - self.e2 * w.x,
        )
