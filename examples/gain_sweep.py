"""Twenty gains, one plot: how far off the path an x500 flies outdoors, over where the poles of h1 and h2 lie."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import companion


def main(folder: Path = Path("."), seconds: float = 8.0, count: int = 20) -> list[float]:
    """Fly ``count`` gains for ``seconds`` each; the RMS path errors, cm."""
    poles = np.linspace(-1.5, -9.0, count)
    errors = []
    for pole in poles:
        gains = {"poles": {"path": [pole] * 3}}
        flight = companion.simulate("circle_r5", world="outdoor", gains=gains, duration=seconds, settle=seconds / 2)
        errors.append(100.0 * flight.summary["truth"]["settled"]["path_error_m"]["rms"])
    figure, axes = plt.subplots(layout="constrained")
    axes.plot(-poles, errors, "o-")
    axes.set(xlabel="poles of h1 and h2 at -x, 1/s", ylabel="true path error, cm RMS")
    figure.savefig(folder / "gain_sweep.svg")
    plt.close(figure)
    return errors


if __name__ == "__main__":
    print(main())
