"""Mission Planner's polygons and fences (.poly, .fen): latitude and longitude a line. They are no path; what to write
in their stead is said."""

from __future__ import annotations

from pathlib import Path

from companion.config.syntax.faults import ConfigError, Fault

SUFFIXES = (".poly", ".fen")
SAID_MAX = 12
"""Corners that are written out in the message."""


def is_polygon(file: str) -> bool:
    """Whether a file is of this format, by its name."""
    return Path(file).suffix.lower() in SUFFIXES


def refuse(text: str, file: str) -> None:
    """ConfigError: says what the file is, and the fence to write into a mission. A .fen begins with the point to return
    to, and its polygon ends where it began."""
    corners: list[tuple[float, float]] = []
    for number, line in enumerate(text.removeprefix("\ufeff").splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            latitude, longitude = map(float, line.split())
        except ValueError:
            raise ConfigError(
                [Fault(file, number, "", "expected latitude and longitude, as Mission Planner writes")]
            ) from None
        corners.append((latitude, longitude))
    if Path(file).suffix.lower() == ".fen":
        corners = corners[1:]
    if len(corners) > 1 and corners[0] == corners[-1]:
        corners = corners[:-1]
    said = ", ".join(f"{{lat: {latitude:.7f}, lon: {longitude:.7f}}}" for latitude, longitude in corners[:SAID_MAX])
    more = ", ..." if len(corners) > SAID_MAX else ""
    message = (
        f"a polygon of {len(corners)} corners and no path; a mission has it as fence: [{{inside: [{said}{more}]}}]"
    )
    raise ConfigError([Fault(file, 1, "", message)])
