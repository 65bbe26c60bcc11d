"""The daemon's own code and the plant's own code in one process, exchanging the datagrams UDP would carry.

The clock is the plant's count of steps, so a flight is the same for the same seed, bit for bit, and runs as fast as the
machine computes.
"""

from __future__ import annotations

from collections.abc import Callable

from companion.daemon.conductor import Conductor
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Truth

COMPANION_ENDPOINT = 0


def fly(conductor: Conductor, bridge: Bridge, watch: Callable[[Conductor, Truth], None], time_out: float) -> None:
    """Fly until the conductor is done, ``time_out`` s of simulated time at most. ``watch`` is called at every step."""
    begun = bridge.now
    while not conductor.done and bridge.now - begun < time_out:
        bridge.step()
        now = bridge.now
        arrived = [datagram for endpoint, datagram in bridge.datagrams() if endpoint == COMPANION_ENDPOINT]
        while arrived or now >= conductor.next_timer():
            if arrived:
                conductor.receive(arrived, now)
            if now >= conductor.next_timer():
                conductor.on_timer(now)
            for datagram in conductor.datagrams():
                bridge.receive(datagram, COMPANION_ENDPOINT)
            conductor.sent()
            for datagram in conductor.datagrams():
                bridge.receive(datagram, COMPANION_ENDPOINT)
            arrived = [datagram for endpoint, datagram in bridge.datagrams() if endpoint == COMPANION_ENDPOINT]
            if conductor.done:
                break
        watch(conductor, bridge.truth)
