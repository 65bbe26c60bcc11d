"""The daemon's own code and the plant's own code in one process, exchanging the datagrams UDP would carry.

The clock is the plant's count of steps, so a flight is the same for the same seed, bit for bit, and runs as fast as the
machine computes.
"""

from __future__ import annotations

from collections.abc import Callable

from companion.daemon.conductor import Conductor
from companion.mavlink.peer import Received
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Truth
from sim_bridge.strangers import source

COMPANION_ENDPOINT, GROUND_STATION_ENDPOINT = 0, 1


def fly(conductor: Conductor, bridge: Bridge, watch: Callable[[Conductor, Truth], None], time_out: float) -> None:
    """Fly until the conductor is done, ``time_out`` s of simulated time at most. ``watch`` is called at every step."""
    conductor.link.peers.call(COMPANION_ENDPOINT)
    begun = bridge.now
    while not conductor.done and bridge.now - begun < time_out:
        bridge.step()
        now = bridge.now
        arrived = _arrived(bridge)
        while arrived or now >= conductor.next_timer():
            if arrived:
                conductor.receive(arrived, now)
            if now >= conductor.next_timer():
                conductor.on_timer(now)
            _send(conductor, bridge)
            conductor.sent()
            _send(conductor, bridge)
            arrived = _arrived(bridge)
            if conductor.done:
                break
        watch(conductor, bridge.truth)


def _arrived(bridge: Bridge) -> list[Received]:
    """What came for the companion: from the vehicle's endpoint, or from strangers beside it."""
    return [
        (data, source(endpoint, bridge.ports_dialled))
        for endpoint, data in bridge.datagrams()
        if endpoint != GROUND_STATION_ENDPOINT
    ]


def _send(conductor: Conductor, bridge: Bridge) -> None:
    """What goes to the vehicle, where it was last met."""
    to = conductor.link.peers.to
    for datagram in conductor.datagrams():
        if to == source(COMPANION_ENDPOINT, bridge.ports_dialled):
            bridge.receive(datagram, COMPANION_ENDPOINT)
