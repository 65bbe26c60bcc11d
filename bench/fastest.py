"""`speed: auto` against the optimum on a fine grid, and against flight.

    python bench/fastest.py

The optimum is sought on a grid four times as fine: by the same barrier, and the rest of the way to the limits by linear
programmes in a shrinking trust region. `auto` should come within 5 % of its time. Flown on the ideal plant at
motors, no limit may be passed by more than 1 % of the share that `auto` is told to use (margin 0.9).
"""

from __future__ import annotations

import math
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.sparse import csr_matrix, diags_array, vstack

import companion
from companion.feasibility.demand import Demand
from companion.feasibility.fastest import KNOT_TIME, Fastest, speeds
from companion.feasibility.limits import quantities
from companion.mission import Mission
from companion.profiles import AutoSpeed
from companion.vehicle import Vehicle
from trials.agreement import Flown, flown

Array = NDArray[np.float64]

POLISHINGS = 12
PATHS = {
    "circle": "{kind: circle, center: [0, 0, 12], radius: 6}",
    "figure-eight": "{kind: lissajous, center: [0, 0, 12], amplitude: [7, 4, 1], frequency: [1, 2, 1],"
    " phase_deg: [90, 0, 0]}",
    "random spline": "{kind: spline, closed: true, points: [[9.1, 0.4, 12], [3.2, 7.9, 13.1], [-4.1, 6.2, 12.4],"
    " [-9.0, 0.9, 11.2], [-2.8, -7.1, 12.9], [5.5, -6.4, 13.3]]}",
}


def main() -> None:
    """Print the table."""
    vehicle = companion.load_vehicle("x500").value
    print("path            auto s   found in   optimum s   slower by   largest share of the margin used in flight")
    for name, path in PATHS.items():
        mission = companion.new_mission(name, yaml.safe_load(path), "auto", 20, frame="enu", origin="local")
        begun = time.perf_counter()
        report = companion.check(mission, "x500", output="motors").report
        took = time.perf_counter() - begun
        best = optimum(mission.value, vehicle)
        did = flown(mission, "x500", "motors", report.duration, settle=14.0)
        used = share_used(did, vehicle) / 0.9
        slower = 100.0 * (report.duration / best - 1.0)
        print(
            f"{name:14} {report.duration:7.3f} {took:8.2f} s {best:11.3f} {slower:9.2f} %   {100.0 * used:7.2f} %",
            flush=True,
        )


def optimum(mission: Mission, vehicle: Vehicle) -> float:
    """s of the fastest lap."""
    assert isinstance(mission.speed, AutoSpeed)
    search = Fastest(mission, mission.speed, vehicle, knot_time=0.25 * KNOT_TIME)
    headroom, at, matrices, ds = search.headroom, search.at, search.matrices, search.ds
    c = search.improve(search.first())
    # a barrier stays off the limits: the rest of the way is for linear programmes, each feasible to a thousandth
    trust, best = 0.02, search.time(c)
    for _ in range(POLISHINGS):
        y = np.stack([m @ c for m in matrices])
        used = headroom.used(at, speeds(y))
        slopes = search.slopes(y, used)
        rows, rhs = [], []
        for j in range(len(used)):
            near = np.flatnonzero(used[j] > 0.7)
            if len(near):
                row = csr_matrix((len(near), len(c)))
                for k in range(4):
                    row = row + diags_array(slopes[k, j, near]) @ matrices[k][near]
                rows.append(csr_matrix(row))
                rhs.append(1.0 - used[j, near])
        cost = matrices[0].T @ (-0.5 * ds * y[0] ** -1.5)
        within = np.stack([-trust * c, trust * c], axis=1)
        done = linprog(cost, vstack(rows), np.concatenate(rhs), bounds=within, method="highs-ipm")
        step = done.x if done.status == 0 else np.zeros_like(c)
        while float(headroom.used(at, speeds([m @ (c + step) for m in matrices])).max()) > 1.001:
            step = 0.5 * step
        if search.time(c + step) < best * (1.0 - 1e-5):
            c, best = c + step, search.time(c + step)
        else:
            trust *= 0.4
    return best


def share_used(did: Flown, vehicle: Vehicle) -> float:
    """The largest share of a limit used in flight, as `check` counts it."""
    e = did.extremes
    pairs = [
        Demand(
            thrust=np.array([thrust]),
            tilt=np.array([e.tilt_max]),
            rates=np.array([did.rates]).T,
            torques=np.zeros((3, 1)),
            motors=np.full((4, 1), motor),
            yaw_rate=np.zeros(1),
            yaw_acceleration=np.zeros(1),
            acceleration=np.zeros(1),
            along=np.zeros(1),
            speed=np.array([did.speed]),
        )
        for thrust, motor in ((e.thrust_min, e.motor_min), (e.thrust_max, e.motor_max))
    ]
    return max(float(np.max(q.used)) for asked in pairs for q in quantities(asked, vehicle) if math.isfinite(q.high))


if __name__ == "__main__":
    main()
