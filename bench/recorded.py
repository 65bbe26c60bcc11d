"""The estimator on a recorded session of a real PX4 that shakes: ``python -m bench.recorded FILE``.

FILE: ../shared/data/px4_noisy_circle.npz, which is not in the repository. Means over 5 s of following, as
``bench.consistency`` has them for the stand-in.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from trials.prediction import nis_line
from trials.recorded import session

ENGAGED, FOLLOWED, ENDED = 14.2, 19.3, 77.0
"""s on the vehicle's clock: the flight to the path began, the path was reached, the circle ended."""
EARLY = 20.0
"""s of following that are told apart."""


def main(file: Path) -> None:
    """Print a line every 5 s, and the whole."""
    found = session(file, ENGAGED, FOLLOWED, ENDED)
    for each in found.windows:
        print(
            f"{each.begin:4.0f} s: scale {100.0 * each.scale:+.1f} %, drag {100.0 * each.drag:+.1f} %,"
            f" disturbance {each.disturbance:.2f} m/s^2, NEES {each.nees:.1f}, inside {100.0 * each.inside:.0f} %"
        )
    early, late = ([w.inside for w in found.windows if (w.begin < EARLY) is first] for first in (True, False))
    print(
        f"NEES inside its bounds {100.0 * np.mean(early):.0f} % of the first {EARLY:g} s, {100.0 * np.mean(late):.0f} %"
        f" afterwards, {100.0 * np.mean(early + late):.0f} % of all"
    )
    print(nis_line("a state", found.nis))
    print(nis_line("a second", found.nis_second))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("python -m bench.recorded FILE: the recorded session, px4_noisy_circle.npz")
    main(Path(sys.argv[1]))
