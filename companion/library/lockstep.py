"""The daemon's own code and the plant's own code in one process, exchanging the datagrams UDP would carry.

The clock is the plant's count of steps, so a flight is the same for the same seed, bit for bit, and runs as fast as the
machine computes.
"""

from __future__ import annotations

from collections.abc import Callable

from companion.daemon.conductor import Conductor
from companion.daemon.last_resort import LastResort
from companion.mavlink.peer import Received
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Truth
from sim_bridge.strangers import source
from sim_bridge.world_events import COMPANION, GROUND_STATION, XRCE


def fly(
    conductor: Conductor,
    bridge: Bridge,
    watch: Callable[[Conductor, Truth], None],
    time_out: float,
    *,
    survive: bool = False,
) -> LastResort | None:
    """Fly until the conductor is done, ``time_out`` s of simulated time at most. ``watch`` is called at every step.

    ``survive``: what escapes a tick is caught as the real-time loop catches it, and what ended the flight then is
    returned; else it is raised.
    """
    conductor.link.peers.call(COMPANION)
    begun = bridge.now
    flown: Conductor | LastResort = conductor
    while not flown.done and bridge.now - begun < time_out:
        bridge.step()
        try:
            _exchange(conductor, flown, bridge)
        except Exception as error:
            if not survive:
                raise
            if isinstance(flown, LastResort):
                flown.stumble(bridge.now)
            else:
                flown = LastResort(conductor, error, bridge.now)
        watch(conductor, bridge.truth)
    return flown if isinstance(flown, LastResort) else None


def _exchange(conductor: Conductor, flown: Conductor | LastResort, bridge: Bridge) -> None:
    """Everything that the two have to say to each other at this moment."""
    now = bridge.now
    arrived = _arrived(conductor, bridge, now)
    while arrived or now >= flown.next_timer():
        if arrived:
            flown.receive(arrived, now)
        if now >= flown.next_timer():
            flown.on_timer(now)
        _send(conductor, flown, bridge)
        flown.finish_tick()
        _send(conductor, flown, bridge)
        arrived = _arrived(conductor, bridge, now)
        if flown.done:
            break


def _arrived(conductor: Conductor, bridge: Bridge, now: float) -> list[Received]:
    """What came for the companion: from the vehicle's endpoint, or from strangers beside it. What the vehicle's XRCE
    client has to say is heard and answered until neither side has more."""
    found: list[Received] = []
    xrce = conductor.xrce
    while True:
        said = bridge.datagrams()
        if not said and xrce is None:
            return found
        for endpoint, data in said:
            if endpoint == XRCE:
                if xrce is not None:
                    xrce.receive(data, now)
            elif endpoint != GROUND_STATION:
                found.append((data, source(endpoint, bridge.ports_dialled)))
        answers = [] if xrce is None else xrce.datagrams(now)
        if not answers:
            return found
        for answer in answers:
            bridge.receive(answer, XRCE)


def _send(conductor: Conductor, flown: Conductor | LastResort, bridge: Bridge) -> None:
    """What goes to the vehicle, where it was last met."""
    to = conductor.link.peers.to
    for datagram in flown.datagrams():
        if to == source(COMPANION, bridge.ports_dialled):
            bridge.receive(datagram, COMPANION)
