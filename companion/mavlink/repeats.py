"""Frames that come a second time: a network with two routes, a relay that sends again. The second one is no news.

A status has no stamp, so that an old one that comes late would be taken for what is so now. The second is told from the
first by its bytes, which are the same, and by the sender's own number on the frame, which lies behind the newest: for
as long as the numbers last, 256 frames, 0.4 s of a busy link. Of the oldest quarter of them the number may as well be a
new one, since not every frame comes here: then it is a second one only if the sender has said something else in this
message since. Words that are still the newest do no harm, and a status that never changes is always news.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.mavlink.codec import MAGIC_V2, Frame

NUMBERS = 256
"""Of frames in MAVLink: then a sender begins again."""
AHEAD_MAX = 64
"""How far ahead of the newest number a frame may be and be the next one, others lost between: a tenth of a second of a
busy link. What is further ahead is behind: it comes late."""
SENDERS_MAX = 8
"""Senders that are told apart: the vehicle, and whom it forwards. Those of any others are not looked at."""


@dataclass(slots=True)
class _Sender:
    newest: int
    seen: list[bytes | None] = field(default_factory=lambda: [None] * NUMBERS)
    said: dict[int, bytes] = field(default_factory=dict)  # by message, its newest payload


@dataclass(slots=True)
class Repeats:
    """What each sender said last, by the numbers of its frames. ``count``: how many came again."""

    count: int = 0
    _senders: dict[int, _Sender] = field(default_factory=dict)

    def is_repeat(self, frame: Frame) -> bool:
        """Whether this very frame has come before. It counts as come from now on."""
        fmt, system, component, _, raw = frame
        head, number = (10, raw[4]) if raw[0] == MAGIC_V2 else (6, raw[2])
        words = raw[head:-2]
        who = system << 8 | component
        sender = self._senders.get(who)
        if sender is None:
            if len(self._senders) >= SENDERS_MAX:
                return False
            sender = self._senders[who] = _Sender(number)
        else:
            ahead = (number - sender.newest) % NUMBERS
            may_be_next = 1 <= ahead <= AHEAD_MAX
            if ahead != 1 and sender.seen[number] == raw:
                if may_be_next and words == sender.said.get(fmt.id):
                    return False  # either way it says what is so; which of the two it is, the next frame tells
                self.count += 1
                return True
            if may_be_next:
                for lost in range(1, ahead):
                    sender.seen[(sender.newest + lost) % NUMBERS] = None
                sender.newest = number
            elif fmt.id in sender.said:  # overtaken by others: what was said since stays the newest
                words = sender.said[fmt.id]
        sender.seen[number] = raw
        sender.said[fmt.id] = words
        return False
