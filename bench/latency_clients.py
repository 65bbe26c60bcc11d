"""The clients bench/latency.py compares the daemon with: python bench/latency_clients.py echo|mavsdk PORT"""

from __future__ import annotations

import asyncio
import gc
import socket
import struct
import sys

from companion.daemon.realtime import PRIORITY, at_priority
from companion.mavlink.dialect import message

ODOMETRY, TARGET = message("ODOMETRY"), message("SET_ACTUATOR_CONTROL_TARGET")


def echo(port: int) -> None:
    """The least a client can do in Python: blocking receive, CRC, send. Nothing is understood but the stamp."""
    from fastcrc.crc16 import mcrf4xx

    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.bind(("127.0.0.1", port))
    extra, answer_extra = bytes([ODOMETRY.crc_extra]), bytes([TARGET.crc_extra])
    header, rest = bytes((43, 0, 0, 0, 1, 191, 139, 0, 0)), bytes(33) + b"\x01\x01"
    gc.freeze()
    at_priority(PRIORITY)
    while True:
        data, peer = link.recvfrom(512)
        if data[7:10] != b"\x4b\x01\x00":
            continue
        if mcrf4xx(data[1:-2] + extra) != data[-2] | data[-1] << 8:
            continue
        body = header + data[10:18] + rest
        link.sendto(b"\xfd" + body + struct.pack("<H", mcrf4xx(body + answer_extra)), peer)


async def mavsdk(port: int) -> None:
    """The same through MAVSDK's asyncio interface. A body rate carries the stamp back, the message has no other place:
    roll in deg/s is the stamp in steps of 4 ms, modulo 1000."""
    from mavsdk.asyncio import Configuration, Mavsdk
    from mavsdk.asyncio.plugins.offboard import OffboardAsync
    from mavsdk.asyncio.plugins.telemetry import TelemetryAsync
    from mavsdk.logging import log_subscribe
    from mavsdk.plugins.offboard import AttitudeRate

    log_subscribe(lambda *_: True)
    at_priority(PRIORITY)
    sdk = Mavsdk(Configuration.create_manual(1, 191, True))
    await sdk.add_any_connection(f"udpin://127.0.0.1:{port}")
    system = await sdk.first_autopilot(10.0)
    offboard, telemetry = OffboardAsync(system), TelemetryAsync(system)
    async for attitude in telemetry.subscribe_attitude_quaternion():
        await offboard.set_attitude_rate(AttitudeRate(attitude.timestamp_us // 4000 % 1000, 0.0, 0.0, 0.5))


if __name__ == "__main__":
    {"echo": echo, "mavsdk": lambda port: asyncio.run(mavsdk(port))}[sys.argv[1]](int(sys.argv[2]))
