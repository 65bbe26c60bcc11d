"""The line that a person watching a flight reads."""

from __future__ import annotations

from companion.daemon.progress import Watch
from companion.world import World
from companion.world.events import LinkCut, When
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


def test_a_state_that_is_old_is_not_shown_as_if_it_were_now() -> None:
    lines: list[str] = []
    watch = Watch(0.25)

    def look(flown: Flown, now: float) -> None:
        said = watch.look(flown.conductor, now)
        if said is not None and now > 4.0:
            lines.append(said)

    world = World(events=(LinkCut(When(2.5), up=False),))
    flight(duration=20.0, meddle=look, world=world, time_out=9.0)
    assert len(lines) > 10
    assert all(" no state for " in f" {line}" and "tilt" not in line and "path error" not in line for line in lines), (
        lines
    )
