"""The colours of the figures: Okabe and Ito's, which colour-blind readers tell apart."""

from __future__ import annotations

INK = "#1c2733"
FAINT = "#5d6b78"
RULE = "#dde3e8"
TRUE = "#a9bccb"
"""The true state of a simulated vehicle: wide and pale, under what the companion saw."""
ROAD = "#d5dde4"
"""The path: broad and pale, under the track."""

BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = "#0072b2", "#d55e00", "#009e73", "#b0578d", "#e69f00", "#56b4e9"
LINES = (BLUE, VERMILION, GREEN, PURPLE)

DONE_TO, AT_LIMIT, SLOWED = "#fdeecb", "#f7d5c8", "#e6eaee"
"""Shades of the time plots: what was done to the vehicle, time at a limit, time slowed down."""

PHASES = {
    "preflight": "#cfd7de",
    "arm": "#aab6c1",
    "take off": SKY,
    "stand by": "#e4d8b4",
    "take over": ORANGE,
    "settle": "#f0c75e",
    "join": SKY,
    "follow": BLUE,
    "rest": "#7fb8d8",
    "rehearse": BLUE,
    "hand back": "#cc79a7",
    "land": GREEN,
    "return": "#66c2a5",
    "release": "#aab6c1",
    "disarm": "#aab6c1",
    "abort": VERMILION,
    "done": "#cfd7de",
}
