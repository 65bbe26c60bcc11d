"""What varies -> the values of every flight, by its number: a grid over choices, a design over the rest."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from companion.calculus.expression import Expression, parse
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
    """What is drawn: neither taken from the grid nor made by a formula."""
    return [name for name, model in vary.items() if grid_values(model) is None and model.formula is None]


def completed(vary: Mapping[str, VaryModel], values: Mapping[str, Any]) -> dict[str, Any]:
    """``values`` with what formulas make of them, in the order of ``vary``. ValueError, ArithmeticError, TypeError: a
    formula makes nothing of them."""
    made: dict[str, Any] = {}
    for name, model in vary.items():
        numbers = [float(_expression(text)(values)) for text in model.formulas]
        made[name] = values[name] if not numbers else numbers[0] if isinstance(model.formula, str) else numbers
    return made


@functools.cache
def _expression(text: str) -> Expression:
    return parse(text, None)


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
        made.append(completed(vary, row))
    return made


def _points(dimensions: int, flights: int, sampling: str, seed: int) -> Any:
    if dimensions == 0:
        return np.zeros((flights, 0))
    if sampling == "random":
        return np.random.default_rng(seed).random((flights, dimensions))
    from scipy.stats import qmc

    if sampling == "latin":
        return qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed)).random(flights)
    blocks = saltelli_block(dimensions) if sampling == "saltelli" else 1
    count = -(-flights // blocks)
    sequence = qmc.Sobol(dimensions if blocks == 1 else 2 * dimensions, rng=np.random.default_rng(seed))
    whole = sequence.random_base2(max(0, (count - 1).bit_length()))
    return (whole if blocks == 1 else _saltelli(whole))[:flights]


def saltelli_block(dimensions: int) -> int:
    """Flights of each base point of Saltelli's design: A, B, and A with each value in its turn from B."""
    return dimensions + 2


def whole_power(count: float) -> int:
    """The least power of two that is no less than ``count``."""
    return 1 << max(0, math.ceil(count) - 1).bit_length()


def _saltelli(points: Any) -> Any:
    """Base points (each of twice the dimensions) -> the design, block by block."""
    a, b = np.split(points, 2, axis=1)
    dimensions = a.shape[1]
    turned = np.repeat(a[:, None, :], dimensions, axis=1)
    every = np.arange(dimensions)
    turned[:, every, every] = b
    return np.concatenate([a[:, None, :], b[:, None, :], turned], axis=1).reshape(-1, dimensions)
