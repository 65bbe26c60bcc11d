"""A vehicle is given its signing key over an open port, in real time."""

from __future__ import annotations

from companion.daemon.loop import NoVehicleError, clock
from companion.daemon.port import Port
from companion.mavlink.counters import Counters
from companion.mavlink.key_setup import KeySetup

HEARTBEAT_WITHIN = 10.0
"""s in which a vehicle must be heard; it speaks every second. Engineering choice."""
WITHIN = 20.0
"""s in which it must have answered. Engineering choice."""
TURN = 0.1
"""s of waiting at most. Engineering choice."""


def give_key(setup: KeySetup, port: Port) -> None:
    """Until the vehicle signs or will not: see ``setup.done`` and ``setup.refusal``. NoVehicleError: none is heard."""
    peers = setup.link.peers
    if port.called is not None:
        peers.call(port.called)
    begun = clock()
    while not setup.over:
        batch = port.receive(TURN)
        now = clock()
        setup.receive(batch, now)
        setup.on_timer(now)
        outgoing, setup.link.outgoing = setup.link.outgoing, []
        for datagram in outgoing:
            if peers.to is not None:
                port.send(datagram, peers.to)
        if setup.link.identity is None and now - begun > HEARTBEAT_WITHIN:
            heard = peers.heard_words(Counters())
            raise NoVehicleError(
                f"no vehicle: listened to {port.describe()} for {HEARTBEAT_WITHIN:g} s and heard {heard}"
            )
        if not setup.over and now - begun > WITHIN:
            setup.refusal = "the vehicle has fallen silent; see whether it signs now, and give the key again if not"
