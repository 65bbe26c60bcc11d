"""What varies -> the values of every flight, by its number: a grid over choices, a design over the rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from companion.config.study.keys import VaryModel

TAIL = 1e-6
"""How near to probability 0 and 1 a draw may come: what has no bounds ends at 4.8 deviations."""


def grid_values(model: VaryModel) -> list[Any] | None:
    """The values of a choice or a range; None where it is drawn."""
    if model.choice is not None:
        return model.choice
    if model.range is not None:
        low, high, count = model.range
        return [float(x) for x in np.linspace(low, high, int(count))]
    return None


def grid_size(vary: Mapping[str, VaryModel]) -> int:
    """How many combinations the grid has; 1 where there is none."""
    return math.prod(len(values) for values in map(grid_values, vary.values()) if values is not None)


def ends_of(model: VaryModel) -> list[Any]:
    """Values that stand for all: every choice, and the ends of what is drawn (1 % and 99 % where it has none)."""
    values = grid_values(model)
    if values is not None:
        return values
    inside = 0.0 if model.normal is None and model.weibull is None else 0.01
    return [quantile(model, inside), quantile(model, 1.0 - inside)]


def quantile(model: VaryModel, p: float) -> float:
    """The value below which a share ``p`` of the draws lies."""
    if model.uniform is not None:
        low, high = model.uniform
        return low + (high - low) * p
    if model.loguniform is not None:
        low, high = model.loguniform
        return float(low * (high / low) ** p)
    p = min(max(p, TAIL), 1.0 - TAIL)
    if model.normal is not None:
        from scipy.special import ndtri

        mean, deviation = model.normal
        return float(mean + deviation * ndtri(p))
    assert model.weibull is not None
    scale, shape = model.weibull
    return float(scale * (-math.log1p(-p)) ** (1.0 / shape))


def drawn_names(vary: Mapping[str, VaryModel]) -> list[str]:
    """What is drawn, not taken from the grid."""
    return [name for name, model in vary.items() if grid_values(model) is None]


def samples(vary: Mapping[str, VaryModel], flights: int, sampling: str, seed: int) -> list[dict[str, Any]]:
    """The varied values of each flight. The same for the same arguments, whoever flies them.

    Every combination of the grid is flown at the same draws: a sequence cut by its index would give each of them only
    a part of what is drawn.
    """
    drawn, size = drawn_names(vary), grid_size(vary)
    points = _points(len(drawn), -(-flights // size), sampling, seed)
    grid = {name: values for name, model in vary.items() if (values := grid_values(model)) is not None}
    made = []
    for index in range(flights):
        row, rest = {}, index
        for name, values in grid.items():
            rest, which = divmod(rest, len(values))
            row[name] = values[which]
        row |= {name: quantile(vary[name], float(p)) for name, p in zip(drawn, points[index // size], strict=True)}
        made.append({name: row[name] for name in vary})
    return made


def _points(dimensions: int, flights: int, sampling: str, seed: int) -> Any:
    if dimensions == 0:
        return np.zeros((flights, 0))
    if sampling == "random":
        return np.random.default_rng(seed).random((flights, dimensions))
    from scipy.stats import qmc

    if sampling == "latin":
        return qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed)).random(flights)
    whole = qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random_base2(max(0, (flights - 1).bit_length()))
    return whole[:flights]
