"""A seeded slice of bench/fuzz_link.py in lockstep: 1400 damaged datagrams a second beside the vehicle's own."""

from __future__ import annotations

import random

import pytest

from companion.vehicle import OutputLevel
from sim_bridge.world_events import COMPANION
from tests.support.flights import Flown, flight
from trials.damaged_datagrams import mutated

STRANGER = 9
FLOODS = (b"\xfe" * 1400, b"\xfd\xff\x00\x01\x00" * 280)
EACH_STEP = 5.6
"""Damaged datagrams in 4 ms: 1400 a second."""


@pytest.mark.parametrize("level", [OutputLevel.MOTORS, OutputLevel.RATES])
def test_damaged_datagrams_change_not_one_setpoint(level: OutputLevel) -> None:
    rng = random.Random(11)
    sent = [0]

    def damage(flown: Flown) -> None:
        def down(data: bytes, now: float) -> list[bytes]:
            if rng.random() < EACH_STEP / 8.0:  # some eight messages a step
                sent[0] += 1
                return [mutated(data, rng), data]
            return [data]

        flown.between.down = down

    def strangers(flown: Flown, now: float) -> None:
        if flown.conductor.memory is not None:
            flood = rng.choice(FLOODS) if rng.random() < 0.05 else rng.randbytes(60)
            flown.conductor.receive([(flood, STRANGER)], now)
            sent[0] += 1

    disturbed = flight(level=level, duration=4.0, prepare=damage, meddle=strangers)
    calm = flight(level=level, duration=4.0)
    assert sent[0] > 1400
    counters = disturbed.conductor.decoder.counters
    assert counters.bad_crc + counters.garbage_bytes > 1000
    assert disturbed.setpoints == calm.setpoints
    assert disturbed.conductor.link.peers.foreign > 500
    assert disturbed.conductor.link.peers.heard == COMPANION
