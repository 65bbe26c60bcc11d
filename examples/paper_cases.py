"""The paper's two simulations (section V): a circle of radius 10 m at 3 and at 15 m/s, from its own start off the path.

Draws the track from above, the tilt, and the motors as the paper's figures do, and writes a report of each flight.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import companion


def main(folder: Path = Path("."), seconds: float = 30.0, reports: bool = True) -> list[companion.Flight]:
    """Fly both cases for ``seconds`` of following; the flights."""
    flights = []
    figure, axes = plt.subplots(2, 3, figsize=(13, 7), layout="constrained")
    for case, (above, tilt, motors) in zip((1, 2), axes, strict=True):
        flight = companion.simulate(f"paper_case{case}", duration=seconds, record=folder / f"paper-case{case}")
        print(repr(flight))
        if reports:
            print("report:", flight.report())
        told = flight.followed
        above.plot(told["east"], told["north"])
        above.set(title=f"case {case}", xlabel="east, m", ylabel="north, m", aspect="equal")
        tilt.plot(told["t"], np.degrees(told["roll"]), label="roll")
        tilt.plot(told["t"], np.degrees(told["pitch"]), label="pitch")
        tilt.set(xlabel="t, s", ylabel="deg")
        tilt.legend()
        for i in range(4):
            motors.plot(told["t"], told[f"sent_{i}"] * 250.0, label=f"motor {i + 1}")  # 250 N at command 1
        motors.set(xlabel="t, s", ylabel="thrust, N")
        motors.legend()
        flights.append(flight)
    figure.savefig(folder / "paper_cases.svg")
    plt.close(figure)
    return flights


if __name__ == "__main__":
    main()
