"""The first seconds of flights whose machine is not as its file says: the scale is not yet known, the thrust is looked for.

Three of the dispersed circle's thousand. What was held by zeta_dot's bound alone was learned from in them, and the thrust
lagged behind a scale that still changed: two climbed by 30 and 50 m on full thrust before they were handed back.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from companion.study.flying import cases_of, row_of
from companion.study.reading import load_study

STUDY = Path(__file__).resolve().parents[2] / "configs/studies/dispersed_circle.yaml"


@pytest.mark.parametrize("index", [122, 395, 472])
def test_the_thrust_is_found(index: int) -> None:
    study = load_study(STUDY)
    study = dataclasses.replace(study, model=study.model.model_copy(update={"duration": 11.0}))
    row = row_of(cases_of(study)[index])
    assert row["outcome"] == "completed", row["reason"]
    assert row["passed"]
