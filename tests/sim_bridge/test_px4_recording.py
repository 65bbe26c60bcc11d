"""A session of PX4's own simulation, recorded: its client's side again, and what the vehicle answers and does.

``tests/data/px4_session.*`` holds what the client sent, by the vehicle's clock, and what PX4 answered and where it was.
PX4 main of August 2026 with its simulated quadrotor, all parameters at their defaults.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from companion.config.world.world import load_world
from tests.support.plant_client import Client

pytestmark = pytest.mark.xdist_group("bridge/test_px4_recording")

DATA = Path(__file__).parents[1] / "data"
TOLERANCE = 0.1
"""The share by which the time between two events may differ; and, for short ones, the time PX4 itself scatters by."""
SCATTER = 0.2
BOOTING_GRIPPER = 211
"""What PX4's own modules tell each other when it comes up."""


class Replay:
    """The recorded session and the same client's side flown again."""

    def __init__(self) -> None:
        recorded = json.loads((DATA / "px4_session.json").read_text(encoding="ascii"))
        arrays = np.load(DATA / "px4_session.npz")
        self.recorded: dict[str, list[list[Any]]] = recorded
        self.places = np.column_stack([arrays["places_ms"] * 1e-3, arrays["places"]])
        self.client = Client("sih", load_world("sih"), landed=True)
        self.client.ground_station()
        self.heights: list[tuple[float, float]] = []
        setpoints = zip(arrays["setpoints_us"] * 1e-6, arrays["setpoints"].tolist(), strict=True)
        sent = [(float(t), values) for t, values in setpoints]
        orders = [(t, endpoint, bytes.fromhex(raw)) for t, endpoint, _, raw in recorded["orders"]]
        self._fly(sent, orders)

    def _fly(self, sent: list[tuple[float, list[float]]], orders: list[tuple[float, int, bytes]]) -> None:
        client = self.client
        next_setpoint = next_order = 0
        while client.bridge.now < 73.5:
            now = client.bridge.now
            while next_setpoint < len(sent) and sent[next_setpoint][0] <= now:
                client.rates(*sent[next_setpoint][1])
                next_setpoint += 1
            while next_order < len(orders) and orders[next_order][0] <= now:
                client.bridge.receive(orders[next_order][2], orders[next_order][1])
                next_order += 1
            client.step()
            if round(now * 250) % 25 == 0:
                self.heights.append((now, client.bridge.truth.p_n[2]))

    def changes(self, name: str, *fields: str) -> list[list[Any]]:
        """When the fields of a message changed, and to what."""
        found: list[list[Any]] = []
        for heard in self.client.heard:
            if heard.name == name and heard.endpoint == 0:
                values = [heard.fields[field] for field in fields]
                if not found or found[-1][1:] != values:
                    found.append([heard.at, *values])
        return found


@pytest.fixture(scope="module")
def replay() -> Replay:
    return Replay()


def assert_alike(found: list[list[Any]], recorded: list[list[Any]]) -> None:
    """The same sequence, at the same times counted from one event to the next."""
    assert [row[1:] for row in found] == [row[1:] for row in recorded]
    for i in range(2, len(found)):  # the first only says when it began to speak
        took, expected = found[i][0] - found[i - 1][0], recorded[i][0] - recorded[i - 1][0]
        assert took == pytest.approx(expected, rel=TOLERANCE, abs=SCATTER), (found[i], recorded[i])


def test_every_command_is_answered_as_px4_did(replay: Replay) -> None:
    found = [
        [heard.at, heard.fields["command"], heard.fields["result"]]
        for heard in replay.client.heard
        if heard.name == "COMMAND_ACK"
    ]
    recorded = [row[:3] for row in replay.recorded["answers"] if row[1] != BOOTING_GRIPPER]
    assert [row[1:] for row in found] == [row[1:] for row in recorded]
    for (at, *_), (expected, *_) in zip(found, recorded, strict=True):
        assert at == pytest.approx(expected, abs=SCATTER)


def test_modes_and_intents_come_and_go_as_px4s(replay: Replay) -> None:
    assert_alike(replay.changes("CURRENT_MODE", "custom_mode", "intended_custom_mode"), replay.recorded["modes"])


def test_landed_states(replay: Replay) -> None:
    assert_alike(replay.changes("EXTENDED_SYS_STATE", "landed_state"), replay.recorded["landed"])


def test_arming_and_status_in_the_heartbeat(replay: Replay) -> None:
    found = replay.changes("HEARTBEAT", "base_mode", "custom_mode", "system_status")
    assert [row[1:] for row in found] == [row[1:] for row in replay.recorded["heartbeats"]]


def test_the_operator_reads_the_same(replay: Replay) -> None:
    recorded = [text for _, _, text in replay.recorded["texts"] if "[logger]" not in text and "Preflight" not in text]
    assert replay.client.texts() == recorded


def test_the_height_follows_the_recording_through_the_offboard_part(replay: Replay) -> None:
    times, heights = np.array(replay.heights).T
    expected = np.interp(times, replay.places[:, 0], replay.places[:, 3])
    flown = (times > 18.2) & (times < 46.7)
    assert np.abs(heights - expected)[flown].max() < 0.3
