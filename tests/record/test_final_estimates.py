"""What was found in flight, in figures and in words."""

from __future__ import annotations

import math

import numpy as np

from companion.config.vehicle import load_vehicle
from companion.record.final_estimates import estimate_sentences, final_estimates


def columns(pace: list[float], scale: float = 1.02) -> dict[str, np.ndarray]:
    names = {"thrust_scale": scale, "drag": 0.98, "push_north": 3.0, "push_east": 4.0, "push_down": 0.0, "delay": 0.012,
             "rate_lag": 0.064, "motor_lag": 0.047}  # fmt: skip
    columns = {name: np.full(len(pace), value) for name, value in names.items()}
    return {**columns, "pace": np.array(pace), "t": np.arange(len(pace), dtype=float)}


def test_figures_and_words() -> None:
    figures = final_estimates(columns([1.0, 1.0, 1.0]))
    assert figures is not None
    (sentence,) = estimate_sentences(figures, load_vehicle("sih"))
    assert "thrust scale 1.020" in sentence
    assert "drag 0.98 1/s (file 1.00)" in sentence
    assert "disturbance 5.00" in sentence
    assert "rate loop lag 64 ms (file 71), motor lag 47 ms (file 50)" in sentence


def test_a_speed_that_gave_way_is_said() -> None:
    figures = final_estimates(columns([1.0, 0.9, 0.8, 1.0]))
    assert figures is not None
    assert figures["pace"] == {"min": 0.8, "slowed_fraction": 0.5}
    assert "80 %" in estimate_sentences(figures, load_vehicle("sih"))[1]


def test_an_output_that_estimates_nothing_has_found_nothing() -> None:
    assert final_estimates(columns([1.0], math.nan)) is None
    assert final_estimates(columns([])) is None
    assert estimate_sentences(None, load_vehicle("sih")) == []
