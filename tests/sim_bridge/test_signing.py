"""The stand-in signs and checks as PX4 does."""

from __future__ import annotations

import pytest

from companion.config.vehicle import load_vehicle
from companion.mavlink.codec import Decoder, Encoder, Frame
from companion.mavlink.dialect import Value, message
from companion.mavlink.signing import SIGNED, Signing
from companion.world import World
from sim_bridge.bridge import Bridge
from sim_bridge.world_events import COMPANION, GROUND_STATION
from tests.support.signing import KEY, OTHER

STAMP = 10**12


def vehicle(key: bytes | None = None, *, landed: bool = True) -> Bridge:
    return Bridge(load_vehicle("x500"), World(), landed=landed, key=key)


def said(bridge: Bridge, seconds: float = 1.2) -> list[tuple[int, Frame]]:
    """What it says in some time, and to whom; signed or not."""
    decoders = {endpoint: Decoder() for endpoint in (COMPANION, GROUND_STATION)}
    found = []
    for _ in range(round(seconds / bridge.step_s)):
        bridge.step()
        for endpoint, data in bridge.datagrams():
            found += [(endpoint, frame) for frame in decoders[endpoint].datagram(data)]
    return found


def signs(bridge: Bridge) -> set[bool]:
    """For each link whether it signs."""
    both = {endpoint: {bool(f.raw[2] & SIGNED) for at, f in said(bridge) if at == endpoint} for endpoint in (0, 1)}
    assert both[0] == both[1]
    return both[0]


def give(
    bridge: Bridge, key: bytes, stamp: int = STAMP, signing: Signing | None = None, target: tuple[int, int] = (1, 1)
) -> None:
    setup = Encoder(1, 191, signing=signing).message(
        message("SETUP_SIGNING"), target_system=target[0], target_component=target[1], secret_key=tuple(key),
        initial_timestamp=stamp,
    )  # fmt: skip
    bridge.receive(setup, COMPANION)


def ask(bridge: Bridge, signing: Signing | None, **fields: Value) -> int | None:
    """The answer to a request that changes nothing; None where there is none."""
    usual = {"command": 512, "param1": 148.0, "target_system": 1, "target_component": 1}
    encoder = Encoder(1, 191, signing=signing)
    bridge.receive(encoder.message(message("COMMAND_LONG"), **{**usual, **fields}), COMPANION)
    acks = [f.values[1] for at, f in said(bridge, 0.1) if f.format.name == "COMMAND_ACK" and at == COMPANION]
    return acks[0] if acks else None


def test_without_a_key_nothing_is_signed_and_everything_is_accepted() -> None:
    bridge = vehicle()
    assert signs(bridge) == {False}
    assert ask(bridge, None) == 0
    assert ask(bridge, Signing(OTHER, stamp=STAMP)) == 0


def test_a_key_is_given_while_disarmed_and_counts_on_all_links() -> None:
    bridge = vehicle()
    give(bridge, KEY)
    assert signs(bridge) == {True}
    assert ask(bridge, None) is None
    assert ask(bridge, Signing(OTHER, stamp=STAMP)) is None
    mine = Signing(KEY, stamp=STAMP)
    assert ask(bridge, mine) == 0
    assert all(mine.accepts(f.raw, f.format.id) for at, f in said(bridge, 0.5) if at == COMPANION)


def test_a_key_is_not_taken_while_armed_nor_by_another_target_nor_unsigned_where_there_is_one() -> None:
    flying = vehicle(landed=False)
    give(flying, KEY)
    assert signs(flying) == {False}
    bridge = vehicle()
    give(bridge, KEY, target=(7, 1))
    give(bridge, KEY, target=(1, 50))
    assert signs(bridge) == {False}
    give(bridge, KEY)
    give(bridge, OTHER)  # unsigned
    give(bridge, bytes(32), stamp=0)
    give(bridge, OTHER, signing=Signing(OTHER, stamp=STAMP))
    assert ask(bridge, Signing(KEY, stamp=STAMP)) == 0
    give(bridge, OTHER, signing=Signing(KEY, stamp=STAMP + 100))
    assert ask(bridge, Signing(OTHER, stamp=STAMP)) == 0
    give(bridge, bytes(32), stamp=0, signing=Signing(OTHER, stamp=STAMP + 100))
    assert signs(bridge) == {False}


def test_replays_are_refused_and_the_stamps_that_it_hears_are_followed() -> None:
    bridge = vehicle(KEY)
    first = Encoder(1, 191, signing=Signing(KEY, stamp=STAMP)).message(
        message("COMMAND_LONG"), command=512, param1=148.0, target_system=1, target_component=1
    )
    for answered in (True, False):
        bridge.receive(first, COMPANION)
        acks = [f for _, f in said(bridge, 0.1) if f.format.name == "COMMAND_ACK"]
        assert bool(acks) is answered
    last = max(int.from_bytes(f.raw[-12:-6], "little") for at, f in said(bridge, 0.2) if at == COMPANION)
    assert last > STAMP


@pytest.mark.parametrize("name", ["HEARTBEAT", "RADIO_STATUS", "COLLISION"])
def test_what_px4_accepts_unsigned(name: str) -> None:
    bridge = vehicle(KEY)
    before = bridge.counters[0].frames
    bridge.receive(Encoder(51, 68).message(message(name)), COMPANION)
    bridge.receive(Encoder(51, 68).message(message("ATTITUDE")), COMPANION)
    assert bridge.counters[0].frames == before + 1


def test_a_key_and_what_is_not_signed_are_not_forwarded() -> None:
    bridge = vehicle(KEY)
    station, companion = (Signing(KEY, link, stamp=STAMP) for link in (0, 5))
    bridge.receive(
        Encoder(255, 190, signing=station).message(message("HEARTBEAT"), type=6, autopilot=8), GROUND_STATION
    )
    bridge.receive(Encoder(1, 191, signing=companion).message(message("HEARTBEAT"), type=18, autopilot=8), COMPANION)
    said(bridge, 0.1)
    text = {"severity": 6, "text": "x"}
    bridge.receive(Encoder(1, 191).message(message("STATUSTEXT"), **text), COMPANION)
    give(bridge, OTHER, signing=companion, target=(0, 0))
    assert not [f for at, f in said(bridge, 0.1) if at == GROUND_STATION and f.format.name == "STATUSTEXT"]
    assert not [f for at, f in said(bridge, 0.1) if f.format.name == "SETUP_SIGNING"]
