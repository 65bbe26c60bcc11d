"""The line that a person watching a flight reads."""

from __future__ import annotations

from companion.daemon.progress import Watch
from tests.support.flights import Flown, flight


def test_every_line_says_what_its_phase_is_about() -> None:
    """Ticks that bring a message and no state come between the states: also then the line has the speed."""
    lines: list[str] = []
    watch = Watch(0.02)

    def look(flown: Flown, now: float) -> None:
        said = watch.look(flown.conductor, now)
        if said is not None:
            lines.append(said)

    flight(duration=2.0, meddle=look, from_ground=True)
    following = [line for line in lines if line.startswith("follow ")]
    assert len(following) > 50
    assert all("path error" in line and " m/s" in line and "yaw error" in line for line in following), following
    for phase in ("take off ", "land "):
        told = [line for line in lines if line.startswith(phase)]
        assert told
        assert all(" m " in line and "height" in line and "path error" not in line for line in told), told
