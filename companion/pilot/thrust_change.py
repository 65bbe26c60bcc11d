"""A thrust scale that was found to have changed all at once, told to people while the flight goes on."""

from __future__ import annotations

from companion.steering.steering import Steered

CHANGE_TOLD = 0.08
"""Ratio of a change of the thrust scale from one state to the next from which on it is told. Simulated: what sags or is
found better moves by less than a hundredth in a second."""


def thrust_change_line(before: Steered | None, now: Steered | None) -> str | None:
    """A line for people, where the scale changed between two states, and was known before."""
    if before is None or now is None or before.estimates is None or now.estimates is None:
        return None
    ratio = now.estimates.thrust_scale / before.estimates.thrust_scale - 1.0
    if abs(ratio) < CHANGE_TOLD or not before.converged:
        return None
    percent = f"{100.0 * abs(ratio):.0f} %"
    if ratio > 0.0:
        return (
            f"the vehicle makes {percent} more thrust for its weight than a moment ago (a load that fell off?): it is "
            "reckoned with, and the flight goes on; look at what it carries before the next one"
        )
    return (
        f"the vehicle makes {percent} less thrust for its weight than a moment ago (a load, a motor, a propeller, the "
        "battery?): it is reckoned with, and the flight goes on; land it and look at it"
    )
