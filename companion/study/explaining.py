"""What of all that varies explains the errors: rank correlations, and Sobol indices where the design gives them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from companion.config.study.keys import StudyModel
from companion.study.sampling import drawn_names, grid_size, saltelli_block

Row = dict[str, Any]
ERRORS = ("truth.settled.path_error_m.rms", "settled.path_error_m.rms")
"""What flights may be ranked by."""
ENOUGH = 8
"""Flights from which on a rank correlation is told (engineering choice)."""


class Index(NamedTuple):
    """``first``: the share of the errors' variance that goes if this value were known; ``total``: that stays if all
    others were."""

    name: str
    first: float
    total: float


def error_name(model: StudyModel, rows: list[Row]) -> str | None:
    """The figure that flights are ranked by: what is required of them, else as it truly was, else as believed; None
    where no flight has one."""
    names = sorted(ERRORS, key=lambda name: name not in model.require)
    return next((name for name in names if any(row.get(name) is not None for row in rows)), None)


def explained(model: StudyModel, rows: list[Row]) -> list[tuple[str, float]]:
    """Spearman's rank correlation of each number that is drawn or chosen with the error, strongest first."""
    name = error_name(model, rows)
    known = [row for row in rows if name is not None and row.get(name) is not None]
    if name is None or len(known) < ENOUGH:
        return []
    from scipy.stats import spearmanr

    found = []
    for key in (key for key, each in model.vary.items() if not each.formulas):
        values = [row[f"vary.{key}"] for row in known]
        if all(isinstance(v, int | float) and not isinstance(v, bool) for v in values) and len(set(values)) > 1:
            correlation = float(spearmanr(values, [row[name] for row in known]).statistic)
            if np.isfinite(correlation):
                found.append((key, correlation))
    return sorted(found, key=lambda each: -abs(each[1]))


def sobol_indices(model: StudyModel, rows: list[Row], flights: int) -> list[Index] | None:
    """The Sobol indices of the error (its mean over the grid), largest first (Saltelli 2010, scipy.stats). None: the
    design is another, or a flight of it has no error."""
    name, drawn = error_name(model, rows), drawn_names(model.vary)
    if model.sampling != "saltelli" or name is None or not drawn or len(rows) < flights:
        return None
    values = [row.get(name) for row in sorted(rows, key=lambda row: int(row["index"]))]
    if any(value is None for value in values):
        return None
    from scipy.stats import sobol_indices as indices

    block = saltelli_block(len(drawn))
    errors = np.array(values, float).reshape(-1, grid_size(model.vary)).mean(axis=1).reshape(-1, block).T
    found = indices(func={"f_A": errors[:1], "f_B": errors[1:2], "f_AB": errors[2:, None, :]}, n=errors.shape[1])
    shares = zip(drawn, np.ravel(found.first_order), np.ravel(found.total_order), strict=True)
    return sorted((Index(key, float(first), float(total)) for key, first, total in shares), key=lambda i: -i.first)
