"""A frame that comes again is no news; one that says the same again is."""

from __future__ import annotations

import random

from companion.mavlink.codec import Decoder, Encoder, Frame
from companion.mavlink.dialect import message
from companion.mavlink.repeats import SENDERS_MAX, Repeats

HEARTBEAT, TIMESYNC = message("HEARTBEAT"), message("TIMESYNC")


def frames(count: int, encoder: Encoder, every: int = 4, *, modes: int = 1) -> list[Frame]:
    """So many frames of one sender: a heartbeat ``every`` so often, the same one or of so many ``modes`` in turn, and in
    between what is always new."""
    decoder, made = Decoder(), []
    for i in range(count):
        beat = encoder.message(HEARTBEAT, custom_mode=i // every % modes) if i % every == 0 else None
        data = beat or encoder.message(TIMESYNC, tc1=i, ts1=7)
        made += decoder.datagram(data)
    return made


def test_the_same_words_in_new_frames_are_news() -> None:
    for every in (1, 4, 256):  # also where a sender says nothing else, and where its numbers come round
        repeats = Repeats()
        assert not any(repeats.is_repeat(frame) for frame in frames(2000, Encoder(1, 1), every))


def test_a_frame_that_comes_twice_at_once_or_late_counts_once() -> None:
    for behind in (0, 1, 17, 180, 195, 230, 254):  # the last: 0.4 s late at 640 frames a second
        for modes in (1, 2, 3):
            repeats, sent = Repeats(), frames(1000, Encoder(1, 1), modes=modes)
            for i, frame in enumerate(sent):
                assert not repeats.is_repeat(frame)
                if i >= behind:
                    late, newest = sent[i - behind], sent[i - i % 4]  # the last heartbeat
                    # words that are still the newest may count as said once more, where the number may be a new one
                    still = behind > 191 and late.format is HEARTBEAT and late.values == newest.values
                    assert repeats.is_repeat(late) or still


def test_the_same_words_are_news_where_most_frames_are_not_looked_at() -> None:
    """A vehicle's mode must not grow old because every so often it is said in a frame of the same number."""
    for step in (2, 3, 8, 16):
        repeats = Repeats()
        seen = [frame for i, frame in enumerate(frames(8000, Encoder(1, 1), 64)) if i % 64 == 0 or i % step == 1]
        assert not any(repeats.is_repeat(frame) for frame in seen), step


def test_lost_and_overtaken_frames_are_news() -> None:
    chance = random.Random(3)
    kept = [frame for frame in frames(3000, Encoder(1, 1), 7) if chance.random() < 0.6]
    for i in range(0, len(kept) - 4, 3):
        if chance.random() < 0.3:
            kept[i], kept[i + 3] = kept[i + 3], kept[i]
    repeats = Repeats()
    assert sum(repeats.is_repeat(frame) for frame in kept) == 0


def test_senders_are_told_apart_and_bounded() -> None:
    repeats = Repeats()
    alike = [frames(1, Encoder(system, 1))[0] for system in range(1, SENDERS_MAX + 3)]
    assert not any(repeats.is_repeat(frame) for frame in alike)
    assert [repeats.is_repeat(frame) for frame in alike] == [True] * SENDERS_MAX + [False] * 2
