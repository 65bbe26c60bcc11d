"""PX4's XRCE client served beside the vehicle's MAVLink link, by the same thread: whichever speaks is heard at once.

What the client says is answered where it is heard. What is commanded goes out with the tick, see ``loop``. Where both
have come, the link's goes first: a state waits for its setpoint, and PX4 says each thing over XRCE several times.
"""

from __future__ import annotations

import math
import select
from collections.abc import Callable

from companion.daemon.address import EXPECTED, parse_address
from companion.daemon.port import AddressError, Port
from companion.mavlink.peer import Received, Source
from companion.xrce.commands import Commands
from companion.xrce.framing import AGENT, CLIENT, Deframer, framed

GONE_AFTER = 3.0
"""s of silence after which another client may take the place of the one that was heard: PX4 pings every second.
Engineering choice: three pings."""
REOPENED_WITHIN = 0.05
"""s between two looks at a line that is unplugged. Engineering choice."""
REST = 0.004
"""s for which PX4's client is left alone after it was heard, while it is commanded and nothing is missing: it publishes
370 samples a second, and what they say may be as old as that. Engineering choice: less than the 5.4 ms of its turn."""


class XrceLink:
    """The port of the agent that ``commands`` speak through."""

    def __init__(self, port: Port, commands: Commands) -> None:
        self.port = port
        self.commands = commands
        self._peer: Source | None = None
        self._deframer = Deframer(AGENT, commands.agent.counters)

    def serve(self, now: float) -> None:
        """Take in what has come, and answer it."""
        agent = self.commands.agent
        for data, source in self.port.receive(0.0):
            if source != self._peer and now - agent.heard_at < GONE_AFTER:
                agent.counters.strange += 1
                continue  # one client at a time
            for message in self._deframer.receive(data) if self.port.stream else (data,):
                self.commands.receive(message, now)
            if agent.heard_at == now:
                self._peer = source
        self.flush(now)

    def flush(self, now: float) -> None:
        """Send what is to be sent. It is on its way when this returns."""
        for data in self.commands.datagrams(now):
            if self._peer is not None:
                self.port.send(framed(data, AGENT, CLIENT) if self.port.stream else data, self._peer)


class Beside:
    """A link and, beside it, XRCE: a Port that gives what comes over the first and serves the second."""

    def __init__(self, port: Port, xrce: XrceLink, clock: Callable[[], float]) -> None:
        self._port, self._xrce, self._clock = port, xrce, clock
        self.stream, self.called, self.exposed = port.stream, port.called, port.exposed
        self.send, self.describe = port.send, port.describe
        self._owes = False
        self._rests_until = -math.inf

    def fileno(self) -> int:
        """See Port: of the link."""
        return self._port.fileno()

    def receive(self, timeout: float) -> list[Received]:
        """See Port."""
        port, xrce = self._port, self._xrce
        now = self._clock()
        if self._owes:  # the link went first, once
            self._serve(now)
        until = now + max(timeout, 0.0)
        while True:
            link, other = port.fileno(), xrce.port.fileno()
            wait = max(min(until, xrce.commands.next_timer()) - now, 0.0)
            if link < 0 or other < 0:
                wait = min(wait, REOPENED_WITHIN)
            waited_for = [link] if link >= 0 else []
            if now < self._rests_until:
                wait = min(wait, self._rests_until - now)
            elif other >= 0:
                waited_for.append(other)
            ready, _, _ = select.select(waited_for, [], [], wait)
            now = self._clock()
            self._owes = other in ready or other < 0 or now >= xrce.commands.next_timer()
            if self._owes and link not in ready:
                self._serve(now)
            if link in ready or link < 0 or now >= until:
                return port.receive(0.0)

    def _serve(self, now: float) -> None:
        self._owes = False
        self._xrce.serve(now)
        self._rests_until = now + REST if self._xrce.commands.is_calm else -math.inf

    def close(self) -> None:
        """See Port: both."""
        self._port.close()
        self._xrce.port.close()


def parse_xrce_address(url: str) -> Callable[[], Port]:
    """How to open the address of ``--xrce``. AddressError: it is none, or it cannot be opened."""
    expected = "expected udp://HOST:PORT or serial:///dev/NAME:BAUD"
    if not url.startswith(("udp://", "serial://")):
        raise AddressError(f"{url!r} is no address for --xrce; {expected}")
    listening = url.replace("udp://", "udpin://", 1)
    try:
        opening = parse_address(listening)
    except AddressError as error:
        raise AddressError(str(error).replace(listening, url).replace(EXPECTED, expected)) from None

    def opened() -> Port:
        try:
            return opening()
        except AddressError as error:
            what, *_ = str(error).split(";")
            raise AddressError(f"--xrce: {what}; {_AGENT_HINT}" if "in use" in what else f"--xrce: {error}") from None

    return opened


_AGENT_HINT = (
    "where MicroXRCEAgent has it, end that: PX4's client talks to one agent, and with --xrce the companion is it"
)
