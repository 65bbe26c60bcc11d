"""What the events mean: the description ground stations read an EVENT by, in the format of PX4's own."""

from __future__ import annotations

import re
from typing import Any

from sim_bridge.autopilot.commander.events import BY_REASON, FAILSAFE, FAILSAFE_AFTER_HOLD, PLAIN, REASONS, WITH_NUMBERS
from sim_bridge.autopilot.commander.health_report import (
    ARMING_SUMMARY,
    COMMUNICATION,
    GLOBAL_POSITION,
    GPS,
    HEALTH_SUMMARY,
    LOCAL_POSITION,
    NO_GLOBE,
    NO_MISSION,
    NO_OPERATOR,
    NO_PLACE,
    NO_STICKS,
    NO_STREAM,
    NOT_THIS_MODE,
    NUMBERS,
    REMOTE_CONTROL,
    SYSTEM,
)

PARTS = {
    GPS: "GPS", REMOTE_CONTROL: "Remote control", COMMUNICATION: "Communication links",
    LOCAL_POSITION: "Local position estimate", SYSTEM: "System", GLOBAL_POSITION: "Global position estimate",
}  # fmt: skip
CHECKS = {
    NO_STREAM: "No offboard signal", NOT_THIS_MODE: "Mode not suitable for arming",
    NO_PLACE: "Navigation error: No valid position estimate",
    NO_GLOBE: "Navigation error: No valid global position estimate", NO_MISSION: "No valid mission available",
    NO_STICKS: "No manual control input", NO_OPERATOR: "No connection to the ground control station",
}  # fmt: skip
PART, MODES, REASON = "health_component_t", "navigation_mode_group_t", "arm_disarm_reason_t"
KINDS = {"f": "float", "i": "int32_t", "h": "int16_t", "B": "uint8_t"}
"""The kinds of arguments by their letter in a struct."""
_GROUP = re.compile(r"(?<!\\)\(.*?(?<!\\)\)")


def event_table() -> dict[str, Any]:
    """All of it."""
    of_a_check = _arguments(("modes", MODES), ("health_component_index", "uint8_t"))
    checks = {str(identity): _event(f"check_{identity}", text, of_a_check) for identity, text in CHECKS.items()}
    checks[str(ARMING_SUMMARY)] = _summary("arming_check", _arguments(
        ("chunk_idx", "uint8_t"), ("error", PART), ("warning", PART), ("can_arm", MODES), ("can_run", MODES),
    ))  # fmt: skip
    health = {str(HEALTH_SUMMARY): _summary("health", _arguments(
        ("chunk_idx", "uint8_t"), ("is_present", PART), ("error", PART), ("warning", PART),
    ))}  # fmt: skip
    texts = {str(identity): _event(f"text_{identity}", text, arguments) for identity, text, arguments in _texts()}
    component = {
        "namespace": "px4",
        "enums": {
            PART: _bits(PARTS),
            REASON: {"type": "uint8_t", "entries": {
                str(number): {"name": why.replace(" ", "_"), "description": why} for why, number in REASONS.items()
            }},
            MODES: _bits({bit: mode.name.replace("_", " ").title() for mode, bit in NUMBERS.items()}),
        },
        "event_groups": {
            "default": {"events": texts}, "arming_check": {"events": checks}, "health": {"events": health},
        },
        "navigation_mode_groups": {"groups": {str(bit): [mode.custom_mode] for mode, bit in NUMBERS.items()}},
        "supported_protocols": ["health_and_arming_check"],
    }  # fmt: skip
    return {"version": 2, "components": {"1": component}}


def _texts() -> list[tuple[int, str, list[dict[str, str]]]]:
    """(id, what is shown, arguments) of the events beside the texts."""
    intent = (("mode", "uint32_t"), ("action", "uint8_t"))
    found = [(identity, text, _arguments()) for text, identity in PLAIN.items()]
    found += [(identity, f"{text}{{1}}", _arguments(("reason", REASON))) for text, identity in BY_REASON.items()]
    found.append((FAILSAFE, "Failsafe activated", _arguments(*intent)))
    for_seconds = "Failsafe activated: entering Hold for {3} seconds"
    found.append((FAILSAFE_AFTER_HOLD, for_seconds, _arguments(*intent, ("seconds", "uint16_t"))))
    for pattern, identity, layout in WITH_NUMBERS:
        kinds = [(f"number_{i}", KINDS[letter]) for i, letter in enumerate(layout.removeprefix("<"), 1)]
        text = pattern.pattern
        for i in range(1, len(kinds) + 1):
            text = _GROUP.sub(f"{{{i}}}", text, count=1)
        found.append((identity, text.replace("\\", ""), _arguments(*kinds)))
    return found


def _event(name: str, text: str, arguments: list[dict[str, str]]) -> dict[str, object]:
    return {"name": name, "message": text, "arguments": arguments}


def _summary(group: str, arguments: list[dict[str, str]]) -> dict[str, object]:
    return _event(f"{group}_summary", f"{group} summary", arguments) | {"type": "summary"}


def _arguments(*named: tuple[str, str]) -> list[dict[str, str]]:
    return [{"name": name, "type": kind} for name, kind in named]


def _bits(names: dict[int, str]) -> dict[str, object]:
    entries = {
        str(1 << bit): {"name": name.lower().replace(" ", "_"), "description": name} for bit, name in names.items()
    }
    return {"type": "uint32_t", "is_bitfield": True, "separator": "|", "entries": entries}
