"""``demo``: the flight that shows what the law is for."""

from __future__ import annotations

from pathlib import Path

from companion.cli.finish import Ending
from companion.cli.output import Output
from companion.cli.simulate import Simulation, in_lockstep, over_udp
from companion.cli.story import DEMO, PLAIN
from companion.cli.terminal import say
from companion.library.orders import check_record, read_sortie, read_world
from companion.record.place import new_directory

DURATION = 30.0
"""s of following: long enough for the start, the hold and the way back, and a minute with everything around it."""
SETTLE, PLAIN_SETTLE = 20.0, 10.0
"""s of following after which the flight counts as settled: the disturbed one is back on the path by then."""


def demo(*, fast: bool, plain: bool, output: Output, record: Path | None, as_json: bool) -> int:
    """Fly it; the exit code. ``plain``: undisturbed, from a hover on the path."""
    check_record(record)
    for line in PLAIN if plain else DEMO:
        say(line)
    simulation = Simulation(
        sortie=read_sortie("circle_r10" if plain else "demo", "x500", output, direct=True),
        simulated=read_world("ideal" if plain else "demo", 0),
        from_ground=False,
        duration=DURATION,
        directory=record or new_directory("demo"),
        ending=Ending(as_json, PLAIN_SETTLE if plain else SETTLE, report=True),
    )
    return (in_lockstep if fast else over_udp)(simulation)
