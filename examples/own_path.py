"""A path of one's own, as the paper writes one: where h1 = h2 = 0. Here a circle on a tilted plane."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import companion


def main(folder: Path = Path("."), seconds: float = 20.0) -> companion.Flight:
    """Look at it, ask the law, fly it for ``seconds``; the flight."""
    path = companion.implicit_path(
        h1=lambda x, y, z: np.hypot(x, y) - 6.0, h2=lambda x, y, z: z - 12.0 - 0.4 * x, near=[6, 0, 14.4]
    )
    mission = companion.new_mission("tilted-circle", path, speed=lambda x, y, z: 2.5 - 0.1 * (z - 12.0), frame="enu")
    print(companion.check(mission, "x500"))

    law = companion.control_law(mission, "x500", level="rates")
    hovering = [6.0, 0.0, -14.4, 0, 0, 0, 0, 0, 0, 2.0 * 9.80665]  # x y z, psi theta phi, u v w, zeta
    answer = law(hovering)
    print("at rest on the path: xi =", np.round(answer.xi, 3), " u =", np.round(answer.u, 3))

    flight = companion.simulate(mission, "x500", world="outdoor", duration=seconds, settle=seconds / 2)
    print(repr(flight))
    print("largest |h1|, |h2|, m:", *(f"{np.nanmax(np.abs(flight.xi[h])):.3f}" for h in ("h1", "h2")))
    mission.save(folder / "tilted_circle.yaml")  # companion sim tilted_circle.yaml
    return flight


if __name__ == "__main__":
    main()
