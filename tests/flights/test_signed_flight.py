"""A flight over a signed link: nothing that is not signed has any effect, either way, and the key is in no record."""

from __future__ import annotations

from pathlib import Path

from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import message
from companion.mavlink.signing import SIGNED, Signing
from sim_bridge.world_events import COMPANION
from tests.support.flights import Flown, flight
from tests.support.signing import KEY, OTHER

EPOCH = 1.79e9
HOLD = 0x03040000


def orders(signing: Signing | None) -> list[bytes]:
    """What would end the flight, said to the companion as if by the vehicle."""
    encoder = Encoder(1, 1, signing=signing)
    return [
        encoder.message(message("CURRENT_MODE"), custom_mode=HOLD, intended_custom_mode=HOLD),
        encoder.message(message("HEARTBEAT"), autopilot=12, type=2, custom_mode=HOLD, base_mode=29, system_status=4),
        encoder.message(message("ODOMETRY"), frame_id=1, child_frame_id=1, q=(1, 0, 0, 0), x=60.0, time_usec=10**9),
    ]


def commands(signing: Signing | None) -> list[bytes]:
    """What would end it, said to the vehicle as if by the companion or a ground station."""
    mode = {"command": 176, "param1": 1.0, "param2": 4.0, "param3": 3.0, "target_system": 1, "target_component": 1}
    kill = {"command": 400, "param1": 0.0, "param2": 21196.0, "target_system": 1, "target_component": 1}
    return [
        Encoder(system, component, signing=signing).message(message("COMMAND_LONG"), **fields)
        for system, component in ((1, 191), (255, 190))
        for fields in (mode, kill)
    ]


def signed(flown: Flown) -> None:
    flown.between.bridge.keys.use_key(KEY, 0)
    signing = Signing(KEY, epoch=EPOCH)
    flown.conductor.link.sign(signing)
    flown.conductor.decoder.signing = signing


def test_unsigned_forged_and_replayed_orders_change_nothing(tmp_path: Path) -> None:
    replayed: dict[str, list[bytes]] = {"up": [], "down": []}

    def attacked(flown: Flown) -> None:
        signed(flown)
        between = flown.between
        between.up = lambda data, now: (replayed["up"].append(data), [data])[1]
        between.down = lambda data, now: (replayed["down"].append(data), [data])[1]

    def attack(flown: Flown, now: float) -> None:
        if now < 1.0 or flown.conductor.memory is None or round(now * 1000.0) % 40:
            return
        forged = Signing(OTHER, stamp=2**47)
        down = orders(None) + orders(forged) + replayed["down"][-400:-380]
        flown.conductor.receive([(data, COMPANION) for data in down], now)
        for data in commands(None) + commands(forged) + replayed["up"][-400:-380]:
            flown.between.bridge.receive(data)

    record = tmp_path / "flight"
    flown = flight(duration=3.0, prepare=attacked, meddle=attack, record=record)
    calm = flight(duration=3.0, prepare=signed)
    assert flown.setpoints == calm.setpoints
    assert flown.notes == calm.notes
    assert all(data[2] & SIGNED for data in replayed["up"] if data[0] == 0xFD)
    signing = flown.conductor.decoder.signing
    assert signing is not None
    assert min(signing.refused.unsigned, signing.refused.forged, signing.refused.replayed) > 50
    assert "without effect" in flown.conductor.link.peers.words()[-1]
    for file in record.iterdir():
        data = file.read_bytes()
        assert KEY not in data
        assert KEY.hex().encode() not in data.lower()


def test_a_vehicle_that_does_not_sign_is_not_met_and_that_is_said() -> None:
    def ours_alone(flown: Flown) -> None:
        signing = Signing(KEY, epoch=EPOCH)
        flown.conductor.link.sign(signing)
        flown.conductor.decoder.signing = signing

    flown = flight(duration=3.0, prepare=ours_alone, time_out=3.0)
    assert flown.conductor.link.identity is None
    heard = flown.conductor.link.peers.heard_words(flown.conductor.decoder.counters)
    assert "unsigned" in heard and "companion vehicle sign" in heard


def test_a_vehicle_whose_clock_is_behind_is_met_because_it_follows_ours() -> None:
    """PX4 begins with the stamp of the day its key was given."""
    flown = flight(duration=3.0, prepare=signed)
    assert flown.setpoints
    stamps = [
        int.from_bytes(frame.raw[-12:-6], "little")
        for data in [flown.conductor.link.encoder.message(message("HEARTBEAT"))]
        for frame in Decoder().datagram(data)
    ]
    assert stamps[0] > 10**12
