"""Every table and the figure of docs/rivals.md: the law beside its rivals, with and without each of its remedies.

python -m bench.hold_the_path                     all of it, into docs/
python -m bench.hold_the_path sih held            only these tables, on the screen
python -m bench.hold_the_path --seeds 3           fewer seeds outdoors
"""

from __future__ import annotations

import argparse
import datetime
import math
import multiprocessing
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

from trials.rivals.ablation import REMEDIES
from trials.rivals.course import Course, circle, figure_eight
from trials.rivals.figures import Figures
from trials.rivals.sorties import ATTITUDE, ITS_OWN, PX4, RATES, TRACKER, Sortie, flown

DOCS = Path(__file__).resolve().parent.parent / "docs"
Cell = Callable[[Sequence[Figures], Course], str]


class Table:
    """Rows and columns of sorties; a cell may hold several, one a seed."""

    def __init__(self, title: str, note: str, columns: Sequence[str]) -> None:
        self.title, self.note, self.columns = title, note, columns
        self.rows: list[tuple[str, list[tuple[list[Sortie], Cell]]]] = []

    def row(self, name: str, cells: Sequence[tuple[list[Sortie], Cell]]) -> None:
        """Add one."""
        self.rows.append((name, list(cells)))

    @property
    def sorties(self) -> list[Sortie]:
        """All of them."""
        return [sortie for _, cells in self.rows for sorties, _ in cells for sortie in sorties]

    def text(self, results: dict[Sortie, Figures]) -> str:
        """As Markdown."""
        lines = [f"## {self.title}", "", self.note, "", "| | " + " | ".join(self.columns) + " |"]
        lines.append("|---" * (len(self.columns) + 1) + "|")
        for name, cells in self.rows:
            shown = [cell([results[s] for s in sorties], sorties[0].course) for sorties, cell in cells]
            lines.append(f"| {name} | " + " | ".join(shown) + " |")
        return "\n".join(lines) + "\n"


def settled(seen: Sequence[Figures], course: Course) -> str:
    """Path RMS cm; speed RMS in % of alpha; yaw RMS in degrees."""
    (f,) = seen
    if f.lost:
        return "lost"
    return f"**{100.0 * f.path_rms:.1f}** · {100.0 * f.speed_rms / course.speed:.1f} % · {f.yaw_rms:.1f}°"


def spread(seen: Sequence[Figures], course: Course) -> str:
    """Mean and worst path RMS over the seeds; the worst speed and yaw."""
    kept = [f for f in seen if not f.lost]
    if not kept:
        return "all lost"
    lost = f", {len(seen) - len(kept)} lost" if len(kept) < len(seen) else ""
    mean = sum(f.path_rms for f in kept) / len(kept)
    worst = max(f.path_rms for f in kept)
    speed = max(f.speed_rms for f in kept) / course.speed
    yaw = max(f.yaw_rms for f in kept)
    return f"{100.0 * mean:.1f}, **{100.0 * worst:.1f}**{lost} · {100.0 * speed:.1f} % · {yaw:.1f}°"


def recovery(seen: Sequence[Figures], course: Course) -> str:
    """The farthest from the path and the greatest speed."""
    (f,) = seen
    if not math.isfinite(f.path_max):
        return "ended by a guard"
    return f"**{100.0 * f.path_max:.0f} cm** · {f.speed_max / course.speed:.2f} alpha · {f.tilt_max:.0f}°"


def sih() -> Table:
    """The vehicle of PX4's own simulation."""
    courses = [circle(3.0), circle(5.0), circle(7.0), figure_eight(3.0)]
    note = (
        "PX4's simulated quadrotor (drag 1 1/s, slow rate loop), of which only a hover thrust of 0.5 is told (it is "
        "0.4905). Error of the position that the vehicle believes in, which wanders by 3 cm about the true one whoever "
        "flies: RMS in cm · speed error RMS in % of the speed · yaw error RMS. At 7 m/s against 5 m/s of wind it would "
        "have to lean by 58°, of the 50° it may: there the speed gives way."
    )
    table = Table("The vehicle of PX4's simulation", note, [c.name for c in courses])
    for place, who in (
        *(("SIH", w) for w in (PX4, TRACKER, ATTITUDE, RATES)),
        *(("SIH, wind 5 m/s, 20 ms each way, 10 % loss", w) for w in (PX4, TRACKER, ATTITUDE, RATES)),
    ):
        name = who if place == "SIH" else f"{who}; {place.removeprefix('SIH, ')}"
        table.row(name, [([Sortie(who, place, c)], settled) for c in courses])
    return table


def outdoor(seeds: int) -> Table:
    """An x500 outdoors."""
    courses = [circle(3.0), circle(6.0), figure_eight(3.0)]
    note = (
        f"An x500 in the world `outdoor` (wind 5 m/s with gusts, the noise of a GPS estimate), 100 Hz, 20 ms of link "
        f"delay, drag unknown; {seeds} seeds: mean and **worst** of the true path error RMS in cm · worst speed error "
        "RMS · worst yaw error RMS. The estimate itself wanders by 3 cm an axis: nobody can hold a path "
        "better than he knows where he is."
    )
    table = Table("Outdoors", note, [c.name for c in courses])
    for who in (PX4, TRACKER, ATTITUDE, RATES):
        table.row(who, [([Sortie(who, "outdoor", c, seed=seed) for seed in range(seeds)], spread) for c in courses])
    return table


def wrong() -> Table:
    """Told the wrong numbers."""
    courses = [circle(3.0), circle(6.0)]
    note = "The same, with one number wrong (one seed): true path error RMS in cm · speed error · yaw error."
    table = Table("Wrong numbers", note, [f"{c.name}, {who}" for c in courses for who in (TRACKER, RATES)])
    for place in ("mass +20 %", "mass -20 %", "inertia +30 %", "motor lag 60 ms, told 25", "delay 50 ms, told 20"):
        table.row(place, [([Sortie(who, place, c)], settled) for c in courses for who in (TRACKER, RATES)])
    return table


def held() -> Table:
    """Held back and pushed: what a timetable costs."""
    courses = [circle(3.0), circle(6.0)]
    note = (
        "An x500 in calm air. Held still for 4 s in the middle of the flight and let go; pushed with 5 N for 2 s. The "
        "farthest from the path afterwards · the greatest speed as a multiple of the mission's · the steepest tilt."
    )
    columns = [f"{what}, {c.name}" for what in ("held", "pushed") for c in courses]
    table = Table("Held back and pushed", note, columns)
    for who in (PX4, TRACKER, ATTITUDE, RATES):
        holds = [([Sortie(who, "calm", c, 24.0, 16.0, held=(12.0, 16.0))], recovery) for c in courses]
        pushes = [([Sortie(who, "calm", c, 20.0, 12.0, pushed=(12.0, 14.0))], recovery) for c in courses]
        table.row(who, [*holds, *pushes])
    return table


def ablation() -> Table:
    """What each remedy is worth."""
    courses = [circle(3.0), circle(7.0), figure_eight(3.0)]
    rough = "SIH, wind 5 m/s, 20 ms each way, 10 % loss"
    note = (
        "The law at rates on PX4's simulated quadrotor with one remedy taken away; the last column in wind, with delay "
        "and loss. Believed path error RMS in cm · speed error · yaw error."
    )
    table = Table("What each remedy brings", note, [*(c.name for c in courses), "circle r5 at 5, rough"])
    for remedy in REMEDIES:
        who = f"without: {remedy}"
        cells = [([Sortie(who, "SIH", c)], settled) for c in courses]
        table.row(remedy, [*cells, ([Sortie(who, rough, circle(5.0))], settled)])
    return table


def rotorpy() -> Table:
    """RotorPy's simulator."""
    calm = [circle(3.0), circle(6.0), figure_eight(4.0)]
    note = (
        "RotorPy's Hummingbird with RotorPy's aerodynamics, which neither side knows. RotorPy's own controller "
        "commands motor speeds without delay; the others send body rates at 100 Hz over 20 ms of delay to a rate loop "
        "of 25 ms."
    )
    columns = [*(c.name for c in calm), "circle r5 at 3, wind 5 m/s", "held 4 s at 3 m/s"]
    table = Table("In RotorPy's simulator", note, columns)
    for who in (ITS_OWN, TRACKER, RATES):
        cells: list[tuple[list[Sortie], Cell]] = [([Sortie(who, "RotorPy", c)], settled) for c in calm]
        cells.append(([Sortie(who, "RotorPy, wind", circle(3.0))], settled))
        cells.append(([Sortie(who, "RotorPy", circle(3.0), 24.0, 16.0, held=(12.0, 16.0))], recovery))
        table.row(who, cells)
    return table


def main() -> None:
    """Fly the tables that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="*", help="sih outdoor wrong held ablation rotorpy; all when none is named")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=multiprocessing.cpu_count())
    arguments = parser.parse_args()
    makers = {
        "sih": sih,
        "outdoor": lambda: outdoor(arguments.seeds),
        "wrong": wrong,
        "held": held,
        "ablation": ablation,
        "rotorpy": rotorpy,
    }
    unknown = set(arguments.tables) - set(makers)
    if unknown:
        parser.error(f"no such table: {', '.join(sorted(unknown))}; there are {', '.join(makers)}")
    tables = [makers[name]() for name in (arguments.tables or makers)]
    sorties = list(dict.fromkeys(sortie for table in tables for sortie in table.sorties))
    with multiprocessing.Pool(arguments.jobs) as pool:
        results = {}
        for done, (sortie, seen) in enumerate(zip(sorties, pool.imap(flown, sorties), strict=True), 1):
            results[sortie] = seen
            print(f"{done:4} of {len(sorties)}  {sortie.who}, {sortie.place}, {sortie.course.name}: {seen.cell} cm")
    text = "\n".join(table.text(results) for table in tables)
    print(text)
    if not arguments.tables:
        from trials.rivals.drawing import draw

        draw(results, DOCS / "rivals.svg")
        (DOCS / "rivals.md").write_text(_page(text), encoding="utf-8")


def _page(tables: str) -> str:
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    head = Path(__file__).with_name("rivals_head.md").read_text(encoding="utf-8")
    today = datetime.date.today().isoformat()
    return f"{head}\nFlown on {today} at commit {commit} by `python -m bench.hold_the_path`.\n\n{tables}"


if __name__ == "__main__":
    main()
