"""Truncated Taylor arithmetic: time derivatives along a motion, and gradients beside them, exact to rounding.

``Taylor`` is a polynomial in time t with the powers above its order dropped. ``Gradient`` is a number that carries its
derivatives with respect to three variables (x, y, z). ``Gradient`` of ``Taylor`` is what the implicit outputs need: the
value of h along X(t) = X + V t + A t^2/2 + J t^3/6 and, along it, the gradient of h (control notes, 3a').
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from companion.calculus.scalar import DERIVATIVES, Scalar, elementary


class Taylor:
    """sum_k c[k] t^k; ``c[k]`` is the k-th time derivative over k!. Two series give one of the lower order."""

    __slots__ = ("c",)

    def __init__(self, coefficients: tuple[Scalar, ...]) -> None:
        self.c = coefficients

    @property
    def order(self) -> int:
        """The highest power kept."""
        return len(self.c) - 1

    def derivative(self, k: int) -> Scalar:
        """The k-th time derivative at t = 0."""
        factorial = 1.0
        for i in range(2, k + 1):
            factorial *= i
        return self.c[k] * factorial

    def differentiated(self) -> Taylor:
        """The time derivative, one order lower."""
        return Taylor(tuple(k * self.c[k] for k in range(1, len(self.c))))

    def __neg__(self) -> Taylor:
        return Taylor(tuple(-a for a in self.c))

    def __add__(self, other: Scalar) -> Scalar:
        if isinstance(other, Gradient):
            return NotImplemented
        if isinstance(other, Taylor):
            return Taylor(tuple(a + b for a, b in zip(self.c, other.c, strict=False)))
        return Taylor((self.c[0] + other, *self.c[1:]))

    __radd__ = __add__

    def __sub__(self, other: Scalar) -> Scalar:
        return NotImplemented if isinstance(other, Gradient) else self + -other

    def __rsub__(self, other: Scalar) -> Scalar:
        return -self + other

    def __mul__(self, other: Scalar) -> Scalar:
        if isinstance(other, Gradient):
            return NotImplemented
        if not isinstance(other, Taylor):
            return Taylor(tuple(a * other for a in self.c))
        a, b = self.c, other.c
        size = min(len(a), len(b))
        return Taylor(tuple(_sum(a[i] * b[k - i] for i in range(k + 1)) for k in range(size)))

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Scalar:
        if isinstance(other, Gradient):
            return NotImplemented
        if not isinstance(other, Taylor):
            return self * (1.0 / other)
        a, b = self.c, other.c
        quotient: list[Scalar] = []
        for k in range(min(len(a), len(b))):
            quotient.append((a[k] - _sum(quotient[i] * b[k - i] for i in range(k))) / b[0])
        return Taylor(tuple(quotient))

    def __rtruediv__(self, other: Scalar) -> Taylor:
        constant = Taylor((other, *(0.0 for _ in self.c[1:])))
        result: Taylor = constant / self
        return result

    def elementary(self, function: str, arguments: tuple[Scalar, ...]) -> Scalar:
        """``function`` by its derivative: f' = sum_i (df/dx_i) x_i', one power at a time."""
        if any(isinstance(argument, Gradient) for argument in arguments):
            return _chain(function, arguments)
        size = min(len(x.c) for x in arguments if isinstance(x, Taylor))
        series = [x.c if isinstance(x, Taylor) else (x, *(0.0 for _ in range(size - 1))) for x in arguments]
        value = [elementary(function, *(x[0] for x in series))]
        for k in range(1, size):
            known = Taylor(tuple(value))
            partials = DERIVATIVES[function](known, *(_truncated(x, k) for x in arguments))
            total: Scalar = 0.0
            for x, partial in zip(series, partials, strict=True):
                g = partial.c if isinstance(partial, Taylor) else (partial, *(0.0 for _ in range(k - 1)))
                total = total + _sum((j * x[j]) * g[k - j] for j in range(1, k + 1))
            value.append(total / k)
        return Taylor(tuple(value))


class Gradient:
    """A number with its partial derivatives with respect to x, y and z: forward differentiation."""

    __slots__ = ("partials", "value")

    def __init__(self, value: Scalar, partials: tuple[Scalar, Scalar, Scalar]) -> None:
        self.value = value
        self.partials = partials

    def _mapped(self, value: Scalar, by: Callable[[Scalar], Scalar]) -> Gradient:
        a, b, c = self.partials
        return Gradient(value, (by(a), by(b), by(c)))

    def __neg__(self) -> Gradient:
        return self._mapped(-self.value, lambda d: -d)

    def __add__(self, other: Scalar) -> Gradient:
        if not isinstance(other, Gradient):
            return Gradient(self.value + other, self.partials)
        return _paired(self, other, self.value + other.value, lambda a, b: a + b)

    __radd__ = __add__

    def __sub__(self, other: Scalar) -> Scalar:
        return self + -other

    def __rsub__(self, other: Scalar) -> Scalar:
        return -self + other

    def __mul__(self, other: Scalar) -> Gradient:
        if not isinstance(other, Gradient):
            return self._mapped(self.value * other, lambda d: d * other)
        x, y = self.value, other.value
        return _paired(self, other, x * y, lambda a, b: a * y + x * b)

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Scalar:
        if not isinstance(other, Gradient):
            return self * (1.0 / other)
        y = other.value
        quotient = self.value / y
        return _paired(self, other, quotient, lambda a, b: (a - quotient * b) / y)

    def __rtruediv__(self, other: Scalar) -> Gradient:
        quotient = other / self.value
        return self._mapped(quotient, lambda d: -quotient * d / self.value)

    def elementary(self, function: str, arguments: tuple[Scalar, ...]) -> Gradient:
        """``function`` by the chain rule."""
        return _chain(function, arguments)


def _chain(function: str, arguments: tuple[Scalar, ...]) -> Gradient:
    values = [x.value if isinstance(x, Gradient) else x for x in arguments]
    value = elementary(function, *values)
    slopes = DERIVATIVES[function](value, *values)
    total: Gradient | None = None
    for argument, slope in zip(arguments, slopes, strict=True):
        if isinstance(argument, Gradient):
            a, b, c = argument.partials
            term = Gradient(value, (a * slope, b * slope, c * slope))
            total = term if total is None else _paired(total, term, value, lambda p, q: p + q)
    assert total is not None
    return total


def _paired(a: Gradient, b: Gradient, value: Scalar, by: Callable[[Scalar, Scalar], Scalar]) -> Gradient:
    x, y, z = (by(p, q) for p, q in zip(a.partials, b.partials, strict=True))
    return Gradient(value, (x, y, z))


def _truncated(x: Scalar, size: int) -> Scalar:
    return Taylor(x.c[:size]) if isinstance(x, Taylor) else x


def _sum(terms: Iterable[Scalar]) -> Scalar:
    total: Scalar = 0.0
    for term in terms:
        total = total + term
    return total
