"""The messages of one client: submessages made into datagrams with their numbers, and what came taken apart."""

from __future__ import annotations

from collections.abc import Iterable

from companion.xrce.messages import BEST_EFFORT, RELIABLE, SESSION, Acknack, CreateClient, Heartbeat, Submessage
from companion.xrce.objects import WriteData
from companion.xrce.wire import NO_SESSION, NO_STREAM, Message, WireError, decode, encode
from sim_bridge.autopilot.xrce.reliable import NUMBERS, ReliableIn, ReliableOut, ahead

FIRST_REQUEST = 10
"""The requests below it have meanings of their own."""


class Session:
    """``outbox``: datagrams to send, oldest first."""

    def __init__(self) -> None:
        self.outbox: list[bytes] = []
        self._request = FIRST_REQUEST
        self._reset()

    def _reset(self) -> None:
        self.reliable_out, self._reliable_in = ReliableOut(), ReliableIn()
        self._published = 0
        self._heard = NUMBERS - 1

    def request(self) -> int:
        """The id of the next request."""
        request = self._request
        self._request = request + 1 if request < NUMBERS - 1 else FIRST_REQUEST
        return request

    def begin(self, key: int) -> None:
        """Ask the agent for a session."""
        self._reset()
        self._request = FIRST_REQUEST
        self._send(NO_SESSION, NO_STREAM, 0, [CreateClient(key.to_bytes(4, "big"))])

    def ping(self, submessage: Submessage) -> None:
        """Say something outside of any session."""
        self._send(NO_SESSION, NO_STREAM, 0, [submessage])

    def say(self, submessage: Submessage) -> None:
        """Say something on no stream."""
        self._send(SESSION, NO_STREAM, 0, [submessage])

    def publish(self, writer: int, sample: bytes) -> None:
        """A sample, on the stream where nothing is repeated."""
        self._send(SESSION, BEST_EFFORT, self._published, [WriteData(self.request(), writer, sample)])
        self._published = (self._published + 1) % NUMBERS

    def demand(self, submessages: Iterable[Submessage]) -> bool:
        """Say something that has to arrive. False: too much of the like has not been acknowledged."""
        out = self.reliable_out
        if out.is_full:
            return False
        self._send(SESSION, RELIABLE, out.next_number, submessages)
        out.keep(self.outbox[-1])
        return True

    def remind(self, now_us: int) -> None:
        """Say what has not been acknowledged, if that is due."""
        heartbeat = self.reliable_out.heartbeat(now_us)
        if heartbeat is not None:
            self.say(heartbeat)

    def take(self, datagram: bytes) -> list[Submessage]:
        """What came, less what the streams need among themselves; in order, and each once where that was promised."""
        try:
            message = decode(datagram)
        except WireError:
            return []
        if message.session not in (SESSION, NO_SESSION):
            return []
        if message.stream == RELIABLE:
            ready = self._reliable_in.take(message.sequence, message.submessages)
            self.say(self._reliable_in.acknack)
        elif message.stream == BEST_EFFORT:
            if ahead(self._heard, message.sequence) <= 0:
                return []
            self._heard = message.sequence
            ready = list(message.submessages)
        else:
            ready = list(message.submessages)
        return [each for each in ready if not self._handle(each)]

    def _handle(self, said: Submessage) -> bool:
        if isinstance(said, Acknack):
            if said.stream == RELIABLE:
                self.outbox += self.reliable_out.take(said)
            return True
        if isinstance(said, Heartbeat):
            if said.stream == RELIABLE:
                self._reliable_in.hear(said)
                self.say(self._reliable_in.acknack)
            return True
        return False

    def _send(self, session: int, stream: int, number: int, submessages: Iterable[Submessage]) -> None:
        self.outbox.append(encode(Message(session, stream, number, tuple(submessages))))
