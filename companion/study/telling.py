"""The pass rate with its exact bounds, what explains the errors, the worst flights."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from companion.config.study.keys import StudyModel

Row = dict[str, Any]
ERRORS = ("truth.settled.path_error_m.rms", "settled.path_error_m.rms")
"""What flights are ranked by: the first that is known."""
WORST = 10
ENOUGH = 8
"""Flights from which on a rank correlation is told (engineering choice)."""


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


def pass_rate(model: StudyModel, rows: list[Row]) -> Rate:
    """Of flights that were completed and met what is required."""
    return rate_of(sum(bool(row["passed"]) for row in rows), len(rows), model.confidence)


def holds(model: StudyModel, rows: list[Row], flights: int) -> bool:
    """Whether the study is complete and enough of it passed."""
    return len(rows) == flights and pass_rate(model, rows).share >= model.pass_rate


def error_name(rows: list[Row]) -> str | None:
    """The figure that flights are ranked by; None where no flight has one."""
    return next((name for name in ERRORS if any(row.get(name) is not None for row in rows)), None)


def worst(rows: list[Row], count: int = WORST) -> list[Row]:
    """Those that did not pass first, then by their error, largest first."""
    name = error_name(rows) or ""
    return sorted(rows, key=lambda row: (bool(row["passed"]), -(row.get(name) or 0.0), row["index"]))[:count]


def explained(rows: list[Row]) -> list[tuple[str, float]]:
    """Spearman's rank correlation of each numeric value that varies with the error, strongest first."""
    from scipy.stats import spearmanr

    name = error_name(rows)
    known = [row for row in rows if name is not None and row.get(name) is not None]
    if name is None or len(known) < ENOUGH:
        return []
    found = []
    for key in [key for key in known[0] if key.startswith("vary.")]:
        values = [row[key] for row in known]
        if all(isinstance(v, int | float) and not isinstance(v, bool) for v in values) and len(set(values)) > 1:
            correlation = float(spearmanr(values, [row[name] for row in known]).statistic)
            if np.isfinite(correlation):
                found.append((key.removeprefix("vary."), correlation))
    return sorted(found, key=lambda each: -abs(each[1]))


def in_words(model: StudyModel, rows: list[Row], flights: int) -> list[str]:
    """The verdict and what stands behind it, in lines."""
    rate, name = pass_rate(model, rows), error_name(rows)
    verdict = "holds" if holds(model, rows, flights) else "does not hold" if len(rows) == flights else "is not complete"
    lines = [
        f"{model.study} {verdict}: {rate.passed} of {rate.flights} flights passed ({100.0 * rate.share:.1f} %); the "
        f"true rate lies between {100.0 * rate.low:.1f} and {100.0 * rate.high:.1f} %, {100.0 * model.confidence:g} % "
        f"sure; required {100.0 * model.pass_rate:g} %"
    ]
    if len(rows) < flights:
        lines.append(f"{flights - len(rows)} of {flights} flights are still to be flown: --resume")
    if name is not None:
        errors = np.array([row[name] for row in rows if row.get(name) is not None]) * 100.0
        low, middle, high = np.percentile(errors, [5, 50, 95])
        lines.append(f"{name}: median {middle:.2f} cm, 5 % to 95 % {low:.2f} to {high:.2f}, largest {errors.max():.2f}")
    lines += [f"rank correlation with the error: {key} {value:+.2f}" for key, value in explained(rows)]
    return lines


def line_of(row: Row) -> str:
    """A flight in a line."""
    name = error_name([row])
    error = "" if name is None else f", path error {100.0 * row[name]:.2f} cm"
    varied = ", ".join(f"{key.removeprefix('vary.')} {_shown(v)}" for key, v in row.items() if key.startswith("vary."))
    why = row.get("unmet") or row.get("reason")
    return f"{row['index']:>6}  {'passed' if row['passed'] else row['outcome']}{error}; {varied}" + (
        f"; {why}" if why else ""
    )


def _shown(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
