"""A load that falls off, and one that is taken up, are told; what is found bit by bit is not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from companion.daemon.conductor import Conductor
from companion.pilot.thrust_change import thrust_change_line
from companion.world.events import After, Event, MotorFailure, PayloadDrop, When
from sim_bridge.bridge import Bridge
from trials.measured import course, machine, measure_flight, world


def steered(thrust_scale: float, converged: bool = True) -> Any:
    return SimpleNamespace(estimates=SimpleNamespace(thrust_scale=thrust_scale), converged=converged)


def test_more_and_less_are_told_with_what_to_look_at() -> None:
    more, less = thrust_change_line(steered(1.0), steered(1.25)), thrust_change_line(steered(1.0), steered(0.8))
    assert more is not None and "25 % more thrust" in more and "fell off" in more
    assert less is not None and "20 % less thrust" in less and "land it" in less


def test_what_is_found_bit_by_bit_or_not_known_yet_is_not_told() -> None:
    assert thrust_change_line(steered(1.0), steered(1.02)) is None
    assert thrust_change_line(steered(1.0, converged=False), steered(1.25)) is None
    assert thrust_change_line(None, steered(1.25)) is None
    assert thrust_change_line(steered(1.0), SimpleNamespace(estimates=None, converged=True)) is None


@pytest.mark.parametrize(
    ("event", "words"),
    [
        (PayloadDrop(When(9.0, 9.0, After.OFFBOARD), 0.2), "more thrust for its weight"),
        (MotorFailure(When(9.0, after=After.OFFBOARD), None, 0.8), "less thrust for its weight"),
        (None, ""),
    ],
)
def test_it_is_told_once_in_a_flight(event: Event | None, words: str) -> None:
    conductors: list[Conductor] = []

    def prepare(conductor: Conductor, _: Bridge) -> None:
        conductors.append(conductor)

    where = world("sih_noisy", events=() if event is None else (event,))
    done = measure_flight(
        course("circle_r5", 3.0), machine("sih"), where, seed=3, duration=14.0, settle=8.0, prepare=prepare
    )
    assert done.reason is None
    told = [line for line in conductors[0].notes if "thrust for its weight" in line]
    assert len(told) == (event is not None) and all(words in line for line in told)
