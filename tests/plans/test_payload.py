"""Cameras, grippers and servos of a plan: kept, and worked where the path comes to their place, once."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from companion.config.mission.mission import load_mission
from companion.config.syntax.faults import ConfigError
from companion.mission import Mission
from companion.pilot import completed
from companion.plans.payload import PayloadCommand, placed_along
from companion.vehicle import OutputLevel
from tests.support.flights import flight
from tests.support.plan_text import item, survey, waypoint, written

PHOTO, TRIGGER, GRIPPER, START_CAPTURE = 203, 206, 211, 2000


def read(tmp_path: Path, *items: dict[str, Any], **more: Any) -> Mission:
    return load_mission(str(written(tmp_path / "field.plan", *items, **more)), None)


def orders(mission: Mission) -> list[tuple[int, float]]:
    return [(action.command, round(action.s, 2)) for action in mission.actions]


def test_a_survey_takes_its_photos_along_its_lines(tmp_path: Path) -> None:
    """Two lines of 20 m with a picture every 5 m; none on the way from one to the other."""
    mission = read(
        tmp_path,
        waypoint(-5, 0, 10),
        survey(
            waypoint(0, 0, 10), item(TRIGGER, 5, 0, 1), waypoint(20, 0, 10), item(TRIGGER, 0, 0, 1),
            waypoint(20, 8, 10), item(TRIGGER, 5, 0, 0), waypoint(0, 8, 10), item(TRIGGER, 0, 0, 1),
        ),
    )  # fmt: skip
    first, second = [s for _, s in orders(mission)][:5], [s for _, s in orders(mission)][5:]
    assert {command for command, _ in orders(mission)} == {PHOTO}
    assert mission.actions[0].params == (0, 0, 0, 0, 1, 0, 0)
    assert first == pytest.approx([5.0, 10.0, 15.0, 20.0, 25.0], abs=0.9)  # a corner is cut there
    assert second == pytest.approx([36.8, 41.8, 46.8, 51.4], abs=0.3)
    assert mission.notes == ()


def test_others_hang_on_the_waypoint_before_them(tmp_path: Path) -> None:
    mission = read(
        tmp_path, item(530, 0, 2), waypoint(0, 0, 10), waypoint(10, 0, 10), item(183, 9, 1500),
        waypoint(10, 0.02, 10), item(GRIPPER, 1, 0, None), waypoint(30, 0, 10), item(START_CAPTURE, 0, 0, 1),
    )  # fmt: skip
    assert orders(mission) == [(530, 0.0), (183, 10.0), (GRIPPER, 10.0), (START_CAPTURE, 30.0)]
    assert [action.number for action in mission.actions] == [1, 4, 6, 8]
    assert mission.actions[2].params == (1, 0, 0, 0, 0, 0, 0)


def test_what_is_not_carried_out_is_said_by_item_and_line(tmp_path: Path) -> None:
    mission = read(tmp_path, waypoint(0, 0, 10), item(222, 1), waypoint(9, 0, 10), item(17001), waypoint(20, 0, 10))
    lines = (tmp_path / "field.plan").read_text().splitlines()
    first = 1 + next(i for i, line in enumerate(lines) if '"command": 222' in line)
    (one, two) = mission.notes
    assert one.startswith("command 222 is not known here and not carried out (item 2, line ")
    assert abs(int(one.rpartition(" ")[2].rstrip(")")) - first) <= 3
    assert "command 17001" in two


def test_a_trigger_without_end_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="takes 30000 pictures from item 2 on"):
        read(tmp_path, waypoint(0, 0, 10), item(TRIGGER, 0.001, 0, 0), waypoint(30, 0, 10))
    trigger = PayloadCommand(TRIGGER, (4.0, 0, 1.0, 0, 0, 0, 0), 7)
    assert [placed.s for placed in placed_along([(2.0, (trigger,))], 15.0)] == [2.0, 6.0, 10.0, 14.0]


def test_they_are_sent_once_at_their_place(tmp_path: Path) -> None:
    """A photo every 3 m of 12 and a gripper at the end. No camera answers here, as with PX4's stand-in: that is said
    once, and counted. The stand-in has no gripper either and says so."""
    items = (waypoint(0, 0, 8), item(TRIGGER, 3, 0, 1), waypoint(12, 0, 8), item(TRIGGER, 0), item(GRIPPER, 1, 0))
    file = written(tmp_path / "field.plan", *items)
    sent: list[tuple[float, float]] = []
    grips = []

    def meddle(flown: Any, now: float) -> None:
        for at, frame in flown.between.sent:
            if frame.format.name == "COMMAND_LONG":
                values = frame.format.named(frame.values)
                if values["command"] == PHOTO:
                    north = flown.between.truth.p_n[0]
                    sent.append((at, north))
                    assert (values["param5"], values["confirmation"]) == (1.0, 0)
                elif values["command"] == GRIPPER:
                    grips.append(math.dist(flown.between.truth.p_n, (12.0, 0.0, -8.0)))
        flown.between.sent.clear()

    flown = flight(str(file), level=OutputLevel.RATES, duration=None, time_out=60.0, meddle=meddle)
    assert flown.conductor.memory is not None
    assert completed(flown.conductor.memory), flown.notes
    assert [north for _, north in sent] == pytest.approx([0.0, 3.0, 6.0, 9.0, 12.0], abs=0.15)
    assert len(grips) == 1
    assert grips[0] < 0.15
    said = [note for note in flown.notes if note.startswith("payload")]
    assert f"item 2 (command {PHOTO}) at 0.0 m: no answer" in said[0]
    assert any("6 commands sent, 0 accepted" in note and "5 times no answer" in note for note in said), said
