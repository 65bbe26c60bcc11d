"""A vehicle is given its key: taken, there already, refused for each reason."""

from __future__ import annotations

from companion.config.vehicle import load_vehicle
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.mavlink.key_setup import KeySetup
from companion.mavlink.signing import SETUP_SIGNING, Signing
from companion.world import World
from sim_bridge.bridge import Bridge
from sim_bridge.world_events import COMPANION
from tests.support.signing import KEY, OTHER

EPOCH = 1.79e9


def given(bridge: Bridge, key: bytes = KEY, seconds: float = 12.0) -> tuple[KeySetup, list[bytes]]:
    """One attempt in lockstep, and what was sent."""
    setup = KeySetup(Signing(key, epoch=EPOCH))
    setup.link.peers.call(COMPANION)
    sent: list[bytes] = []
    begun = bridge.now
    while not setup.over and bridge.now - begun < seconds:
        bridge.step()
        setup.receive([(data, at) for at, data in bridge.datagrams() if at == COMPANION], bridge.now)
        setup.on_timer(bridge.now)
        for datagram in setup.link.outgoing:
            sent.append(datagram)
            bridge.receive(datagram)
        setup.link.outgoing.clear()
    return setup, sent


def keys(sent: list[bytes]) -> int:
    return sum(data[7:10] == SETUP_SIGNING.id.to_bytes(3, "little") for data in sent)


def test_a_vehicle_takes_the_key_and_signs() -> None:
    bridge = Bridge(load_vehicle("x500"), World(), landed=True)
    setup, sent = given(bridge)
    assert (setup.done, setup.already, setup.refusal) == (True, False, None)
    assert keys(sent) == 1
    assert bridge.keys.key == KEY
    again, sent = given(bridge)
    assert (again.done, again.already) == (True, True)
    assert keys(sent) == 0


def test_another_key_and_an_armed_vehicle_are_refused_and_no_key_is_sent() -> None:
    for bridge, said in (
        (Bridge(load_vehicle("x500"), World(), landed=True, key=OTHER), "signs with another key"),
        (Bridge(load_vehicle("x500"), World(), landed=False), "is armed"),
    ):
        before = bridge.keys.key
        setup, sent = given(bridge)
        assert not setup.done
        assert setup.refusal is not None and said in setup.refusal
        assert keys(sent) == 0
        assert bridge.keys.key == before


def test_a_vehicle_that_cannot_sign_is_refused_with_its_version() -> None:
    bridge = Bridge(load_vehicle("x500"), World(), landed=True)
    bridge.keys.set_up = lambda *_, **__: None  # type: ignore[method-assign]
    setup, sent = given(bridge)
    assert setup.refusal is not None
    version = setup.link.identity.version if setup.link.identity else None
    assert version is not None
    assert f"PX4 {version[0]}.{version[1]}.{version[2]}) goes on without signing" in setup.refusal
    assert keys(sent) > 3


def test_not_px4_and_two_vehicles_are_refused() -> None:
    for system, autopilot, said in ((1, 3, "is not PX4"), (2, 12, "two vehicles are heard")):
        setup = KeySetup(Signing(KEY, epoch=EPOCH))
        setup.link.peers.call(COMPANION)
        for i in range(4):
            now = float(i)
            for encoder, kind in ((Encoder(1, 1), 12 if system == 2 else autopilot), (Encoder(system, 1), autopilot)):
                beat = encoder.message(message("HEARTBEAT"), autopilot=kind, type=2)
                setup.receive([(beat, COMPANION)], now)
            setup.on_timer(now)
        assert setup.refusal is not None and said in setup.refusal
        assert keys(setup.link.outgoing) == 0
