"""The pass rate with its exact bounds, what explains the errors, the worst flights."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from companion.config.study.keys import StudyModel
from companion.study.explaining import Index, error_name, explained, sobol_indices

Row = dict[str, Any]
WORST = 10


class Rate(NamedTuple):
    """``passed`` of ``flights``, and between which shares the true rate lies, as sure as the study asks."""

    passed: int
    flights: int
    low: float
    high: float

    @property
    def share(self) -> float:
        """Of the flights that passed; 0 of none."""
        return self.passed / self.flights if self.flights else 0.0


def rate_of(passed: int, flights: int, confidence: float) -> Rate:
    """The exact (Clopper-Pearson) two-sided bounds of a binomial rate."""
    from scipy.stats import beta

    tail = 0.5 * (1.0 - confidence)
    low = 0.0 if passed == 0 else float(beta.ppf(tail, passed, flights - passed + 1))
    high = 1.0 if passed == flights else float(beta.ppf(1.0 - tail, passed + 1, flights - passed))
    return Rate(passed, flights, low, high)


def worst(model: StudyModel, rows: list[Row], count: int = WORST) -> list[Row]:
    """Those that did not pass first, then by their error, largest first; one that did not get so far as to have one is
    worse than any."""
    name = error_name(model, rows) or ""

    def rank(row: Row) -> tuple[bool, float, int]:
        error = row.get(name)
        return bool(row["passed"]), -math.inf if error is None else -error, row["index"]

    return sorted(rows, key=rank)[:count]


class Errors(NamedTuple):
    """The figure that flights are ranked by, in cm: under which 5, 50 and 95 % of the flights lie, and the largest."""

    name: str
    low: float
    middle: float
    high: float
    largest: float


def errors_of(model: StudyModel, rows: list[Row]) -> Errors | None:
    """How large the errors are; None where no flight has one."""
    name = error_name(model, rows)
    if name is None:
        return None
    errors = np.array([row[name] for row in rows if row.get(name) is not None]) * 100.0
    low, middle, high = np.percentile(errors, [5, 50, 95])
    return Errors(name, float(low), float(middle), float(high), float(errors.max()))


class Verdict(NamedTuple):
    """What the flights of a study say. ``ranks``: rank correlation of each value with the error, strongest first.
    ``indices``: None where the design gives none. ``flown`` of ``flights`` have landed."""

    model: StudyModel
    flown: int
    flights: int
    rate: Rate
    holds: bool
    errors: Errors | None
    ranks: list[tuple[str, float]]
    indices: list[Index] | None


def judged(model: StudyModel, rows: list[Row], flights: int) -> Verdict:
    """``rows``: of the flights so far, ``flights``: of the whole study. It holds if it is complete and enough of it was
    completed and met what is required."""
    rate = rate_of(sum(bool(row["passed"]) for row in rows), len(rows), model.confidence)
    held = len(rows) == flights and rate.share >= model.pass_rate
    found = explained(model, rows), sobol_indices(model, rows, flights)
    return Verdict(model, len(rows), flights, rate, held, errors_of(model, rows), *found)


def headlines(said: Verdict) -> list[str]:
    """Whether it holds, in a line; and what is missing, in another."""
    model, rate, missing = said.model, said.rate, said.flights - said.flown
    so = "holds" if said.holds else "is not complete" if missing else "does not hold"
    lines = [
        f"{model.study} {so}: {rate.passed} of {rate.flights} flights passed ({100.0 * rate.share:.1f} %); the "
        f"true rate lies between {100.0 * rate.low:.1f} and {100.0 * rate.high:.1f} %, {100.0 * model.confidence:g} % "
        f"sure; required {100.0 * model.pass_rate:g} %"
    ]
    if missing:
        lines.append(f"{missing} of {said.flights} flights are still to be flown: --resume")
    return lines


def in_words(said: Verdict) -> list[str]:
    """The verdict and what stands behind it, in lines."""
    lines, errors = headlines(said), said.errors
    if errors is not None:
        lines.append(
            f"{errors.name}: median {errors.middle:.2f} cm, 5 % to 95 % {errors.low:.2f} to {errors.high:.2f}, largest "
            f"{errors.largest:.2f}"
        )
    lines += [f"rank correlation with the error: {key} {value:+z.2f}" for key, value in said.ranks]
    if said.indices is not None:
        lines += [
            f"Sobol index of the error: {key} alone explains {100.0 * first:.0f} % of its variance, with the others "
            f"{100.0 * total:.0f} %"
            for key, first, total in said.indices
        ]
    elif said.model.sampling == "saltelli" and said.flown == said.flights:
        lines.append("no Sobol indices: a flight of the design has no error; see the worst flights")
    return lines


def line_of(model: StudyModel, row: Row) -> str:
    """A flight in a line."""
    name = error_name(model, [row])
    error = "" if name is None else f", path error {100.0 * row[name]:.2f} cm"
    why = row.get("unmet") or row.get("reason")
    ended = "passed" if row["passed"] else row["outcome"]
    return f"{row['index']:>6}  {ended}{error}; {flown_with(model, row)}" + (f"; {why}" if why else "")


def flown_with(model: StudyModel, row: Row) -> str:
    """What was drawn or chosen for a flight; without what formulas made of it."""
    keys = [key for key, each in model.vary.items() if not each.formulas]
    return ", ".join(f"{key} {shown(row.get(f'vary.{key}'))}" for key in keys)


def shown(value: Any) -> str:
    """A value that varies, short, as a study's file has it."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {shown(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(shown, value)) + "]"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
