"""What an output level needs of the link, before the flight and in it: one table."""

from __future__ import annotations

from typing import NamedTuple

from companion.vehicle import OutputLevel


class LinkNeeds(NamedTuple):
    """What an output level needs of the link. ``delay``: s there and back at most, before the flight and in it;
    ``rate``: Hz of states at least, in flight."""

    delay: float
    rate: float


RATE_WANTED = 20.0
"""Hz of states, of which fewer are not begun with (engineering choice), and are why an attitude is not held. Simulated:
14 Hz swing up within 1 s at rates."""
BY_RATE_LOOP = LinkNeeds(delay=0.2, rate=12.0)
"""s there and back, and Hz of states, where the vehicle's own rate loop stands between. Issue 11: 100 ms each way;
beyond it the law tilts too far. Simulated: 12.5 states a second fly the circle of the deck to its end."""
WITHOUT_RATE_LOOP = LinkNeeds(delay=0.1, rate=14.0)
"""s there and back, and Hz of states, where none does. Simulated: later it tumbles; by 14 states a second it flies the
circle of the deck to its end, by 12.5 it sinks."""
NEEDS = {
    OutputLevel.RATES: BY_RATE_LOOP,
    OutputLevel.ATTITUDE: BY_RATE_LOOP,
    OutputLevel.MOTORS: WITHOUT_RATE_LOOP,
    OutputLevel.TORQUES: WITHOUT_RATE_LOOP,
}
"""Of each output level."""
