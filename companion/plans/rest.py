"""What of a plan comes after the item that its path ends with, in words: whoever flies it must know before."""

from __future__ import annotations

from collections.abc import Callable

from companion.mavlink_common import MAV_CMD_NAV_RETURN_TO_LAUNCH
from companion.plans.items import Item, Key, flies_somewhere
from companion.plans.payload import PAYLOAD


def rest_in_words(rest: list[Item], end: str, line_of: Callable[[Key], int] | None) -> list[str]:
    """A note, or none where nothing of it would fly or do something. ``rest``: the items after the ``end`` (in words)
    of the path; ``line_of``: of the file, where something of it stands."""
    flown = [item for item in rest if flies_somewhere(item.command) and item.command != MAV_CMD_NAV_RETURN_TO_LAUNCH]
    done = [item for item in rest if item.command in PAYLOAD]
    if flown:
        missed = [item for item in rest if item in flown or item in done]
        what, advice = "NOT FLOWN", ("it needs a plan of its own", "they need a plan of their own")
    elif done:
        missed, what, advice = done, "NOT CARRIED OUT", ("do it yourself", "do them yourself")
    else:
        return []
    first, last = missed[0], missed[-1]
    single = first is last
    which = f"item {first.number}" if single else f"items {first.number} to {last.number}"
    if not single and last.number <= first.number:  # numbers given twice, by who writes plans by hand
        which = f"{len(missed)} items from item {first.number} on"
    where = "" if line_of is None else f" (line {line_of(first.key)}{'' if single else ' on'})"
    return [f"{what}: {which}, after {end}{where}; {advice[0 if single else 1]}"]
