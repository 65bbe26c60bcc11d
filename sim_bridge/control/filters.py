"""Low-pass filters of first and second order, one number at a time."""

from __future__ import annotations

import math


class LowPass:
    """First order: ``value`` follows the input with the time constant 1 / (2 pi cutoff). Hz and s."""

    __slots__ = ("_gain", "value")

    def __init__(self, cutoff: float, step: float, value: float = 0.0) -> None:
        self._gain = step / (step + 1.0 / (2.0 * math.pi * cutoff))
        self.value = value

    def update(self, sample: float) -> float:
        """The filtered value after one more sample."""
        self.value += self._gain * (sample - self.value)
        return self.value


class ButterworthLowPass:
    """Second order Butterworth by the bilinear transform, direct form II, as PX4's LowPassFilter2p. Hz and s.

    A cutoff at or above half the sample rate passes everything.
    """

    __slots__ = ("_a1", "_a2", "_b0", "_d1", "_d2", "_passes")

    def __init__(self, cutoff: float, step: float, value: float = 0.0) -> None:
        self._passes = cutoff * step >= 0.5
        warped = 0.0 if self._passes else math.tan(math.pi * cutoff * step)
        scale = 1.0 + math.sqrt(2.0) * warped + warped * warped
        self._b0 = warped * warped / scale
        self._a1 = 2.0 * (warped * warped - 1.0) / scale
        self._a2 = (1.0 - math.sqrt(2.0) * warped + warped * warped) / scale
        self._d1 = self._d2 = 0.0
        self.settle(value)

    def settle(self, value: float) -> None:
        """Forget the past: as if ``value`` had come in for ever."""
        self._d1 = self._d2 = 0.0 if self._passes else value / (1.0 + self._a1 + self._a2)

    def update(self, sample: float) -> float:
        """The filtered value after one more sample."""
        if self._passes:
            return sample
        d1, d2 = self._d1, self._d2
        d0 = sample - d1 * self._a1 - d2 * self._a2
        self._d2 = d1
        self._d1 = d0
        return self._b0 * (d0 + 2.0 * d1 + d2)
