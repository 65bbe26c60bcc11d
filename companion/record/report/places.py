"""Where things were, as rows of east, north, up (m): the path, the track, the rest of the flight, the true track."""

from __future__ import annotations

import numpy as np

from companion.record.report.evidence import Array, Evidence
from companion.record.report.thinning import along

SEEN_APART = 0.003
"""Share of the picture by which the true track must differ from the seen one to be drawn beside it."""
STILL = 0.1
"""m; what moved less before and after following is not drawn."""


def road(evidence: Evidence) -> Array:
    """The path."""
    table = evidence.plan.table
    return _enu(table.samples(min(2000, max(361, 6 * len(table.pieces))))[1])


def tracks(evidence: Evidence) -> tuple[Array | None, Array | None]:
    """The track of every followed tick, and the rest of the flight (thinned; NaN where it was following)."""
    told = evidence.told
    flown = np.stack([told["east"], told["north"], -told["down"]], axis=1) if evidence.followed else None
    table = evidence.table
    seen = table[table["fresh"] == 1]
    points = np.stack([seen["east"], seen["north"], -seen["down"]], axis=1)
    if flown is None:
        return None, points[along(points)] if len(points) else None
    following = (
        np.isfinite(seen["alpha"]) & (seen["t_boot"] >= told["t_boot"][0]) & (seen["t_boot"] <= told["t_boot"][-1])
    )
    parts = [points[: int(np.argmax(following))], points[len(following) - int(np.argmax(following[::-1])) :]]
    gap = np.full((1, 3), np.nan)
    rest = np.concatenate([gap, *(row for part in parts if len(part) for row in (part[along(part, 400)], gap))])
    known = rest[np.isfinite(rest[:, 0])]
    moved = len(known) > 0 and float(np.max(np.ptp(known, axis=0))) > STILL
    return flown, rest if moved else None


def true_track(evidence: Evidence, flown: Array | None) -> Array | None:
    """The true track, where it can be told from the seen one with the eye."""
    if evidence.truth is None or flown is None or len(evidence.truth) < 2:
        return None
    stamps, truth = evidence.told["t_boot"], evidence.truth
    rows = truth[(truth["t_boot"] >= stamps[0]) & (truth["t_boot"] <= stamps[-1])]
    if len(rows) < 2:
        return None
    true = _enu(np.asarray(rows["p_n"], dtype=float))
    there = np.stack([np.interp(stamps, rows["t_boot"], true[:, i]) for i in range(3)], axis=1)
    apart = float(np.max(np.linalg.norm((there - flown)[:, :2], axis=1)))
    return true[along(true)] if apart > SEEN_APART * float(np.max(np.ptp(flown, axis=0))) else None


def _enu(points_n: Array) -> Array:
    return np.stack([points_n[:, 1], points_n[:, 0], -points_n[:, 2]], axis=1)
