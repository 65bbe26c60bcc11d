"""What becomes of datagrams on their way: whether they arrive, when, how often, and in what pieces."""

from __future__ import annotations

import heapq
import random
from collections.abc import Iterable, Sequence

from companion.mavlink.dialect import message
from companion.world.events import LinkCut, LinkDelay, LinkDuplicate, LinkEvent, LinkRecut, LinkRepeat, LinkThin
from companion.world.link import Way
from sim_bridge.noise import RandomStream

OVERTAKEN_FOR_US = 20_000
"""us a datagram that is overtaken comes later than it should."""
MAGIC_V1 = 0xFE
"""The first byte of a MAVLink 1 frame."""
MAGIC_V2 = 0xFD
"""The first byte of a MAVLink 2 frame."""
InTransit = tuple[int, bytes]
"""A datagram and the us it is on its way."""


def message_id(datagram: bytes) -> int | None:
    """The id of the message a datagram begins with, as far as its header says; None where it begins with none."""
    if len(datagram) >= 10 and datagram[0] == MAGIC_V2:
        return datagram[7] | datagram[8] << 8 | datagram[9] << 16
    return datagram[5] if len(datagram) >= 6 and datagram[0] == MAGIC_V1 else None


class LinkWay:
    """One way of every endpoint's link: datagrams in now, out when they arrive. Times are us of the bridge's clock."""

    def __init__(self, way: Way, seed: int, cause: RandomStream) -> None:
        self._way = way
        self._is_ideal = not way
        self._delay_us = round(way.delay * 1e6)
        self._jitter_us = way.jitter * 1e6
        self._duplicate_us = round(way.duplicate_delay * 1e6)
        self._random = random.Random(f"{seed} {cause.name}").random
        self._keeps_order = bool(way.jitter)
        self._last_us: dict[int, int] = {}
        self._queue: list[tuple[int, int, int, bytes]] = []
        self._sent = 0
        self._effects: tuple[Effect, ...] = ()
        self._cutters: dict[int, Recutter] = {}

    @property
    def is_clear(self) -> bool:
        """Whether everything passes at once and whole, and nothing is on its way."""
        return self._is_ideal and not (self._effects or self._queue or self._cutters)

    def is_clear_for(self, endpoint: int) -> bool:
        """Whether everything of an endpoint passes at once and whole."""
        if not self._is_ideal:
            return False
        concerned = endpoint in self._cutters or any(endpoint in effect.endpoints for effect in self._effects)
        return not (concerned or self._queue)

    def cuts(self, endpoint: int) -> bool:
        """Whether what arrives at an endpoint are pieces of a stream."""
        return endpoint in self._cutters

    def set_events(self, events: Sequence[tuple[LinkEvent, Iterable[int]]], now_us: int) -> None:
        """These are at work from now on, each with its endpoints. One that was already keeps what it remembers."""
        known = {id(effect.event): effect for effect in self._effects}
        lasting = [(event, frozenset(endpoints)) for event, endpoints in events if not isinstance(event, LinkRecut)]
        self._effects = tuple(known.get(id(event)) or Effect(event, where, now_us) for event, where in lasting)
        self._keeps_order = self._keeps_order or any(effect.delays_all for effect in self._effects)
        cut = {e: event for event, endpoints in events if isinstance(event, LinkRecut) for e in endpoints}
        for endpoint, event in cut.items():
            self._cutters.setdefault(endpoint, Recutter(round(event.wait * 1e6))).size = event.size
        for endpoint, cutter in self._cutters.items():
            if endpoint not in cut:
                cutter.size = 0  # what is left goes whole, and then it is gone

    def send(self, now_us: int, endpoint: int, datagram: bytes) -> None:
        """A datagram sets out."""
        if not self._effects:
            self._pass_on(now_us, endpoint, datagram)
            return
        passing: list[InTransit] = [(0, datagram)]
        for effect in self._effects:
            if endpoint in effect.endpoints:
                passing = [after for sent in passing for after in effect.pass_on(sent, now_us)]
        for later_us, data in passing:
            self._pass_on(now_us + later_us, endpoint, data)

    def _pass_on(self, now_us: int, endpoint: int, datagram: bytes) -> None:
        """What the way itself does to a datagram."""
        way, draw = self._way, self._random
        if way.loss and draw() < way.loss:
            return
        at_us = now_us + self._delay_us
        if way.jitter:
            at_us += round(self._jitter_us * draw())
        if self._keeps_order:
            at_us = max(at_us, self._last_us.get(endpoint, 0))
            self._last_us[endpoint] = at_us
        if way.reordered and draw() < way.reordered:
            at_us += OVERTAKEN_FOR_US
        self._queue_at(at_us, endpoint, datagram)
        if way.duplicated and draw() < way.duplicated:
            self._queue_at(at_us + self._duplicate_us, endpoint, datagram)

    def take_arrived(self, now_us: int) -> list[tuple[int, bytes]]:
        """What has arrived by now: (endpoint, datagram), in the order it did."""
        queue = self._queue
        ready = []
        while queue and queue[0][0] <= now_us:
            _, _, endpoint, datagram = heapq.heappop(queue)
            ready.append((endpoint, datagram))
        if self._cutters:
            ready = self._recut(ready, now_us)
        return ready

    def _queue_at(self, at_us: int, endpoint: int, datagram: bytes) -> None:
        self._sent += 1  # of those that arrive together, first in, first out
        heapq.heappush(self._queue, (at_us, self._sent, endpoint, datagram))

    def _recut(self, arrived: list[tuple[int, bytes]], now_us: int) -> list[tuple[int, bytes]]:
        pieces = []
        for endpoint, datagram in arrived:
            cutter = self._cutters.get(endpoint)
            pieces += [(endpoint, datagram)] if cutter is None else [
                (endpoint, piece) for piece in cutter.cut(datagram, now_us)
            ]  # fmt: skip
        for endpoint, cutter in list(self._cutters.items()):
            pieces += [(endpoint, piece) for piece in cutter.flush(now_us)]
            if not cutter.size and not cutter.left:
                del self._cutters[endpoint]
        return pieces


class Effect:
    """A link event at work. ``endpoints``: whose datagrams it concerns; ``begun_us``: since when."""

    def __init__(self, event: LinkEvent, endpoints: frozenset[int], begun_us: int) -> None:
        self.event = event
        self.endpoints = endpoints
        self._begun_us = begun_us
        self._messages = frozenset(message(name).id for name in event.messages)
        self._first: dict[int | None, bytes] = {}
        self._next_us: dict[int | None, int] = {}

    @property
    def delays_all(self) -> bool:
        """Whether it holds everything up, so that nothing may overtake what was sent while it lasted."""
        return isinstance(self.event, LinkDelay) and not self._messages

    def pass_on(self, sent: InTransit, now_us: int) -> Sequence[InTransit]:
        """What becomes of a datagram."""
        event, (later_us, datagram) = self.event, sent
        kind = message_id(datagram)
        if self._messages and kind not in self._messages:
            return (sent,)
        if isinstance(event, LinkCut):
            return ()
        if isinstance(event, LinkRepeat):
            return ((later_us, self._first.setdefault(kind, datagram)),)
        if isinstance(event, LinkDuplicate):
            return (sent, (later_us + round(event.delay * 1e6), datagram))
        if isinstance(event, LinkDelay):
            return ((later_us + round(event.delay * 1e6 + event.growth * (now_us - self._begun_us)), datagram),)
        if isinstance(event, LinkThin):
            due_us = self._next_us.get(kind, now_us)
            if now_us < due_us:
                return ()
            period_us = round(1e6 / event.rate)
            self._next_us[kind] = due_us + period_us if due_us + period_us > now_us else now_us + period_us
        return (sent,)


class Recutter:
    """A stream of bytes cut into pieces of ``size`` (0: as it comes); what is left goes after ``wait_us``."""

    def __init__(self, wait_us: int) -> None:
        self.size = 0
        self.left = b""
        self._wait_us = wait_us
        self._since_us = 0

    def cut(self, data: bytes, now_us: int) -> list[bytes]:
        """The pieces that are full now that ``data`` has come."""
        if not self.left:
            self._since_us = now_us
        stream, size = self.left + data, self.size or len(self.left) + len(data)
        full = len(stream) - len(stream) % size
        self.left = stream[full:]
        if full:
            self._since_us = now_us
        return [stream[at : at + size] for at in range(0, full, size)]

    def flush(self, now_us: int) -> list[bytes]:
        """What has waited long enough."""
        if not self.left or (self.size and now_us - self._since_us < self._wait_us):
            return []
        piece, self.left = self.left, b""
        return [piece]
