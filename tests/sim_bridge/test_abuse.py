"""What nobody should do to a vehicle: floods, nonsense, clients that vanish. It flies on, answers, and says one line."""

from __future__ import annotations

import math
import random
import signal
import socket
import subprocess
import sys
import time
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink

from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.mavlink.modes import Mode
from tests.sim_bridge.test_missions import SQUARE, item, upload
from tests.support.plant_client import ACCEPTED, NAN, Client

FLOOD_HZ = 10_000
FLOOD_S = 1.5


def nonsense(encoder: Encoder, rng: random.Random) -> bytes:
    """A datagram of a bad day: garbage, damaged frames, messages full of odd numbers."""
    kind = rng.randrange(6)
    if kind == 0:
        return rng.randbytes(rng.randrange(300))
    name = rng.choice(["COMMAND_LONG", "SET_ATTITUDE_TARGET", "SET_POSITION_TARGET_LOCAL_NED", "MISSION_ITEM_INT",
                       "MISSION_COUNT", "PARAM_SET", "MANUAL_CONTROL", "TIMESYNC", "PING", "COMMAND_INT", "HEARTBEAT",
                       "FILE_TRANSFER_PROTOCOL", "MISSION_REQUEST_INT", "SET_POSITION_TARGET_GLOBAL_INT"])  # fmt: skip
    fmt = message(name)
    raw = encoder.encode(fmt, fmt.unpack(rng.randbytes(fmt.size)))
    if kind == 1:
        at = rng.randrange(len(raw))
        return raw[:at] + bytes([raw[at] ^ 0x55]) + raw[at + 1 :]
    return raw


def test_thousands_of_odd_things_do_not_hurt() -> None:
    client = Client("sih")
    client.ground_station()
    rng, encoder = random.Random(7), Encoder(1, 191)
    for _ in range(20_000):
        client.bridge.receive(nonsense(encoder, rng), rng.randrange(2))
        if rng.random() < 0.05:
            client.bridge.step()
            client.bridge.datagrams()
    client.run(0.5)
    assert all(map(math.isfinite, (*client.bridge.truth.p_n, *client.bridge.truth.q_nb)))
    assert client.command(512, 148) == ACCEPTED


def test_the_texts_of_a_flood_are_few() -> None:
    client = Client("sih")
    client.ground_station()
    for _ in range(1000):
        client.send("SET_POSITION_TARGET_LOCAL_NED", coordinate_frame=7)
    client.run(0.1)
    assert 1 <= len(client.texts()) < 50
    assert len(client.bridge.log) < 5


def test_one_who_uploads_and_vanishes_is_forgotten() -> None:
    client = Client("sih")
    client.send("MISSION_COUNT", 1, count=5)
    client.send("MISSION_ITEM_INT", 1, seq=0, **SQUARE[0])
    client.run(5.5)
    assert upload(client, [item(16, 5.0, 0.0, 10.0, param4=NAN)])["type"] == 0


def test_one_who_flies_and_vanishes_leaves_a_vehicle_that_comes_home() -> None:
    client = Client("sih")
    client.ground_station()
    client.rates(thrust=0.4905)
    assert client.mode(Mode.OFFBOARD) == ACCEPTED
    client._heartbeat_at = None
    client.run(1.3)
    assert client.flown is Mode.RETURN
    client.run_until(lambda: not client.bridge.autopilot.commander.armed, 60.0)
    assert client.height == pytest.approx(0.0, abs=0.05)


@pytest.mark.xdist_group("real time")
def test_a_flood_over_udp_does_not_stop_it() -> None:
    """Ten thousand datagrams a second; it goes on answering and ends when told to."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.bind(("127.0.0.1", 0))
        peer.settimeout(30.0)
        url = f"udpout://127.0.0.1:{peer.getsockname()[1]}"
        command = [sys.executable, "-m", "sim_bridge", "--ground-station", "none", "--hover", "--connect", url]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        try:
            _, vehicle = peer.recvfrom(4096)
            _flood(peer, vehicle)
            assert _answers(peer, vehicle)
        finally:
            process.send_signal(signal.SIGTERM)
            _, said = process.communicate(timeout=30.0)
    assert process.returncode == 0, said[-2000:]
    assert len(said.splitlines()) < 40


def _flood(peer: socket.socket, vehicle: Any) -> None:
    rng, encoder = random.Random(3), Encoder(1, 191)
    batch = [nonsense(encoder, rng) for _ in range(500)]
    began = time.monotonic()
    sent = 0
    while (passed := time.monotonic() - began) < FLOOD_S:
        while sent < passed * FLOOD_HZ:
            peer.sendto(batch[sent % len(batch)], vehicle)
            sent += 1
        time.sleep(0.001)


def _answers(peer: socket.socket, vehicle: Any) -> bool:
    """Whether a request is answered after all that."""
    mav = mavlink.MAVLink(None, srcSystem=1, srcComponent=191)
    mav.robust_parsing = True
    end = time.monotonic() + 30.0
    while time.monotonic() < end:
        peer.sendto(mavlink.MAVLink_command_long_message(1, 1, 512, 0, 148, 0, 0, 0, 0, 0, 0).pack(mav), vehicle)
        for _ in range(200):
            data, _ = peer.recvfrom(4096)
            if any(m.get_type() == "AUTOPILOT_VERSION" for m in mav.parse_buffer(bytearray(data)) or []):
                return True
    return False
