"""What an output level needs of the link, before the flight and in it: one table."""

from __future__ import annotations

from typing import NamedTuple

from companion.vehicle import OutputLevel


class LinkNeeds(NamedTuple):
    """What an output level needs of the link. ``delay``: s there and back at most, before the flight and in it;
    ``rate``: Hz of states at least, in flight."""

    delay: float
    rate: float


SLOW_RATE = 12.0
"""Hz of states, of which fewer are not flown by; preflight asks for 20 (engineering choice)."""
BY_RATE_LOOP = LinkNeeds(delay=0.2, rate=SLOW_RATE)
"""s there and back, and Hz of states, where the vehicle's own rate loop stands between. Issue 11: 100 ms each way;
beyond it the law tilts too far."""
WITHOUT_RATE_LOOP = LinkNeeds(delay=0.1, rate=SLOW_RATE)
"""s there and back, and Hz of states, where none does. Simulated: later it tumbles."""
NEEDS = {
    OutputLevel.RATES: BY_RATE_LOOP,
    OutputLevel.ATTITUDE: BY_RATE_LOOP,
    OutputLevel.MOTORS: WITHOUT_RATE_LOOP,
    OutputLevel.TORQUES: WITHOUT_RATE_LOOP,
}
"""Of each output level."""
