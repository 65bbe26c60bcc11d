"""Where a flight was flown: the simulated world with its seed and events."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from companion.world import World
from companion.world.words import air_in_words, event_in_words, event_kind


@dataclass(frozen=True)
class SimulatedWorld:
    """The world of a simulated flight. ``file``: its name as given; ``text``: the file as it was; ``seed``: of wind,
    noise and link loss."""

    world: World
    file: str
    text: str
    seed: int


def simulation_document(simulated: SimulatedWorld) -> dict[str, Any]:
    """The world for resolved.json. Times in s, counted ``after`` the plant's start, the first arming or the first
    setpoint in OFFBOARD; ``to_s`` null where it lasts for good."""
    world = simulated.world
    return {
        "world": world.name,
        "file": simulated.file,
        "seed": simulated.seed,
        "wind_mps": list(world.wind_n),
        "air": air_in_words(world),
        "events": [
            {
                "kind": event_kind(event),
                "what": event_in_words(event),
                "from_s": event.when.begin,
                "to_s": event.when.end if math.isfinite(event.when.end) else None,
                "after": event.when.after.value,
            }
            for event in world.events
        ],
    }
