"""The deck of fault flights: every fault that was ever seen, and its neighbours.

links       what becomes of datagrams
states      what the vehicle says wrongly of its state
speakers    who speaks, and who does not
operators   what a human does meanwhile
machines    what the machine itself loses
seen        which of them were seen on a real link, or in daemons of old
"""

from __future__ import annotations

from trials.faults.case import Case
from trials.faults.deck import links, machines, operators, speakers, states

GROUPS: dict[str, tuple[Case, ...]] = {
    "What becomes of datagrams": links.CASES,
    "What the vehicle says of its state": states.CASES,
    "Who speaks": speakers.CASES,
    "What a human does": operators.CASES,
    "What the machine loses": machines.CASES,
}
DECK: tuple[Case, ...] = tuple(case for cases in GROUPS.values() for case in cases)
