"""A study as one HTML file that needs nothing else, in the style of the flight report."""

from __future__ import annotations

import html
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from companion.record.files import write_whole
from companion.study.explaining import error_name
from companion.study.reading import Study
from companion.study.telling import Verdict, flown_with, headlines, worst
from companion.vehicle import CompanionError

Row = dict[str, Any]
_PAGE = Template("""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light">
<title>$name: study</title>
<style>
$style</style>
</head>
<body>
<main>
<header>
<p class="kind">Study</p>
<h1>$name</h1>
<p class="facts">$facts</p>
<p class="outcome $mood">$verdict</p>
$tiles</header>
$figures$explained<section>
<h2>The worst flights</h2>
$worst</section>
<section>
<h2>As it was asked for</h2>
<pre>$text</pre>
</section>
</main>
<footer><p><code>companion study replay DIR NUMBER</code> flies one of them again, with its folder and its page; DIR is
<code>$folder</code>.</p></footer>
</body>
</html>
""")


def write_page(directory: Path, study: Study, rows: list[Row], said: Verdict) -> Path:
    """Write ``report.html`` into the folder of a study; its path. CompanionError: matplotlib is not installed."""
    text = _PAGE.substitute(
        name=html.escape(study.name),
        style=files("companion.record.report").joinpath("page.css").read_text(encoding="utf-8"),
        facts=" · ".join(f"<span>{html.escape(fact)}</span>" for fact in _facts(study, rows)),
        mood="completed" if said.holds else "aborted",
        verdict="<br>".join(map(html.escape, headlines(said))),
        tiles=_tiles(said),
        figures=_figures(said, rows),
        explained=_explained(said),
        worst=_worst(study, rows),
        text=html.escape(study.text),
        folder=html.escape(directory.resolve().name),
    )
    target = directory / "report.html"
    write_whole(target, text, durable=False)
    return target


def _facts(study: Study, rows: list[Row]) -> list[str]:
    model = study.model
    names = (study.mission.name, f"on {study.vehicle.name}", f"in {study.world.name}", f"output {model.output}")
    seeds = f"seeds {model.seed} to {model.seed + study.flights - 1}"
    return [*names, f"{len(rows)} of {study.flights} flights", seeds, model.sampling]


def _tiles(said: Verdict) -> str:
    """How many pass, and how large the errors are."""
    rate, errors = said.rate, said.errors
    bounds = f"between {100.0 * rate.low:.1f} and {100.0 * rate.high:.1f} %, {100.0 * said.model.confidence:g} % sure"
    tiles = [("Passed", f"{100.0 * rate.share:.1f}", "%", bounds)]
    if errors is not None:
        middle, most = f"{errors.middle:.2f}", f"{errors.high:.2f}"
        whose = "true" if errors.name.startswith("truth") else "estimated"
        tiles.append(("Path error, median", middle, "cm rms", f"settled, {whose}; 5 % are under {errors.low:.2f} cm"))
        tiles.append(("Path error, 95 %", most, "cm rms", f"are under it; the largest is {errors.largest:.2f} cm"))
    listed = "".join(
        f'<div><dt>{name}</dt><dd><b>{value}</b> <span class="unit">{unit}</span></dd><dd>{more}</dd></div>'
        for name, value, unit, more in tiles
    )
    return f'<dl class="tiles">{listed}</dl>\n'


def _figures(said: Verdict, rows: list[Row]) -> str:
    """The distribution of the error, and the error over what explains it best."""
    if said.errors is None:
        return ""
    try:
        from companion.study.figures import draw_figures
    except ImportError:
        raise CompanionError("the page draws with matplotlib: pip install 'px4-path-companion[report]'") from None
    pictures = "".join(
        f"<figure>\n{svg}\n<figcaption><b>Figure {number}.</b> {html.escape(caption)}</figcaption>\n</figure>\n"
        for number, (svg, caption) in enumerate(draw_figures(rows, said.errors.name, said.ranks), 1)
    )
    return f'<section>\n<h2>How far off the path</h2>\n<div class="figures">\n{pictures}</div>\n</section>\n'


def _explained(said: Verdict) -> str:
    """What of all that varies explains the errors."""
    if not said.ranks:
        return ""
    head, lines = ["", "rank correlation"], [[key, f"{value:+z.2f}"] for key, value in said.ranks]
    if said.indices is not None:
        shares = {index.name: index for index in said.indices}
        head += ["of the variance, alone", "with the others"]
        for line in lines:
            index = shares.get(line[0])
            line += ["", ""] if index is None else [f"{100.0 * index.first:.0f} %", f"{100.0 * index.total:.0f} %"]
    return f"<section>\n<h2>What explains the error</h2>\n{_table(head, lines)}</section>\n"


def _worst(study: Study, rows: list[Row]) -> str:
    """The worst flights, a line each."""
    name = error_name(study.model, rows) or ""
    lines = []
    for row in worst(study.model, rows):
        error, why = row.get(name), row.get("unmet") or row.get("reason")
        ended = "passed" if row["passed"] else str(row["outcome"])
        cells = [str(row["index"]), "" if error is None else f"{100.0 * error:.2f}", flown_with(study.model, row)]
        lines.append([*cells, ended if not why else f"{ended}: {why}"])
    return _table(["flight", "error, cm", "flown with", "ended"], lines, "worst")


def _table(head: list[str], lines: list[list[str]], kind: str = "") -> str:
    heads = "".join(f"<th>{html.escape(cell)}</th>" for cell in head)
    body = "".join(
        f'<tr><th scope="row">{html.escape(first)}</th>'
        f"{''.join(f'<td>{html.escape(cell)}</td>' for cell in cells)}</tr>\n"
        for first, *cells in lines
    )
    table = f'<table class="{kind}">\n<thead><tr>{heads}</tr></thead>\n<tbody>\n{body}</tbody></table>'
    return f'<div class="scroll">{table}</div>\n'
