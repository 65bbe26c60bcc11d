"""What becomes of datagrams on their way: when each arrives, if it does."""

from __future__ import annotations

import heapq
import random

from companion.world.link import Way
from sim_bridge.noise import Cause

OVERTAKEN_FOR_US = 20_000
"""us a datagram that is overtaken comes later than it should."""


class Passage:
    """One way of every endpoint's link: datagrams in now, out when they arrive. Times are us of the bridge's clock."""

    def __init__(self, way: Way, seed: int, cause: Cause) -> None:
        self._way = way
        self._delay_us = round(way.delay * 1e6)
        self._jitter_us = way.jitter * 1e6
        self._chance = random.Random(f"{seed} {cause.name}").random
        self._last_us: dict[int, int] = {}
        self._queue: list[tuple[int, int, int, bytes]] = []
        self._sent = 0

    def send(self, now_us: int, endpoint: int, datagram: bytes) -> None:
        """A datagram sets out."""
        way, chance = self._way, self._chance
        if way.loss and chance() < way.loss:
            return
        at_us = now_us + self._delay_us
        if way.jitter:
            at_us = max(at_us + round(self._jitter_us * chance()), self._last_us.get(endpoint, 0))
            self._last_us[endpoint] = at_us
        if way.reordered and chance() < way.reordered:
            at_us += OVERTAKEN_FOR_US
        for _ in range(2 if way.duplicated and chance() < way.duplicated else 1):
            self._sent += 1  # of those that arrive together, first in, first out
            heapq.heappush(self._queue, (at_us, self._sent, endpoint, datagram))

    def arrived(self, now_us: int) -> list[tuple[int, bytes]]:
        """What has arrived by now: (endpoint, datagram), in the order it did."""
        queue = self._queue
        ready = []
        while queue and queue[0][0] <= now_us:
            _, _, endpoint, datagram = heapq.heappop(queue)
            ready.append((endpoint, datagram))
        return ready
