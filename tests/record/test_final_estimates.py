"""What was found in flight, in figures and in words."""

from __future__ import annotations

import math

import numpy as np

from companion.config.vehicle import load_vehicle
from companion.record.final_estimates import curve_sentences, estimate_sentences, final_estimates


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


def test_a_thrust_curve_that_px4_was_not_told_of_is_said_with_the_factor_to_set() -> None:
    flown = columns([1.0]) | {"thrust_curve": np.array([0.176]), "thrust_curve_std": np.array([0.03])}
    figures = final_estimates(flown)
    assert figures is not None
    assert "thrust curve +0.18 +- 0.03 beyond proportion" in estimate_sentences(figures, load_vehicle("sih"))[0]
    (sentence,) = curve_sentences(figures, 0.0, 0.5)
    assert "THR_MDL_FAC 0.30 in the place of 0.00" in sentence


def test_a_thrust_curve_that_is_poorly_known_or_hardly_there_says_nothing_of_px4() -> None:
    def said(curve: float, std: float, told: float | None = 0.0) -> list[str]:
        flown = columns([1.0]) | {"thrust_curve": np.array([curve]), "thrust_curve_std": np.array([std])}
        return curve_sentences(final_estimates(flown), told, 0.5)

    assert said(0.2, 0.03)
    assert not said(0.2, 0.06) and not said(0.08, 0.03) and not said(0.2, 0.03, None)
    assert not said(-0.1, 0.02)  # the battery: there is no less than none
    assert said(-0.12, 0.03, 0.3)  # told of a curve that is not there
    assert not curve_sentences(final_estimates(columns([1.0])), 0.0, 0.5) and not curve_sentences(None, 0.0, 0.5)
