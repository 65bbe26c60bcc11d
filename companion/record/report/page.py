"""The page: one HTML file that needs nothing else."""

from __future__ import annotations

from importlib.resources import files
from string import Template
from typing import NamedTuple

from companion.record.report.evidence import Evidence
from companion.record.report.text import NBSP, data_element, escaped, facts, notes, outcome, table, timeline
from companion.record.xrce_log import latency_words, read_latency

_PAGE = Template("""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light">
<title>$mission: flight report</title>
<style>
$style</style>
</head>
<body>
<main>
<header>
<p class="kind">Flight report</p>
<h1>$mission</h1>
<p class="facts">$facts</p>
<p class="outcome $mood">$outcome</p>
$notes</header>
$tiles$first<section>
<h2>Phases</h2>
$timeline
</section>
$sections$table<section>
<h2>How it was flown</h2>
$provenance
</section>
</main>
<footer><p>Made from the flight folder <code>$folder</code>. <code>companion report DIR</code> makes this page again,
<code>companion replay DIR</code> feeds the recorded inputs through the pilot and compares every setpoint bit for bit.
</p></footer>
$scripts</body>
</html>
""")

_TILES = (
    ("Path error", "cm", "path_error_m", 100.0),
    ("Speed error", "m/s", "speed_error_mps", 1.0),
    ("Yaw error", "deg", "yaw_error_deg", 1.0),
)


def page_text(evidence: Evidence, sections: list[Section], library: str | None = None) -> str:
    """The whole page. ``library``: plotly.js, gzipped and in base64, to zoom with; None: the figures are still."""
    completed, sentence = outcome(evidence)
    return _PAGE.substitute(
        mission=escaped(evidence.figures["mission"]),
        style=files(__package__).joinpath("page.css").read_text(encoding="utf-8"),
        facts=" · ".join(f"<span>{escaped(fact)}</span>" for fact in facts(evidence)),
        mood="completed" if completed else "aborted",
        outcome=escaped(sentence),
        notes=_notes(evidence),
        tiles=_tiles(evidence),
        timeline=timeline(evidence),
        table=_table(evidence),
        first=_sections(sections[:1], 0),
        sections=_sections(sections[1:], sum(len(section.pictures) for section in sections[:1])),
        provenance=_provenance(evidence),
        scripts="" if library is None else _scripts(library),
        folder=escaped(evidence.directory.resolve().name),
    )


def _scripts(library: str) -> str:
    script = files(__package__).joinpath("page.js").read_text(encoding="utf-8")
    return f'<script type="text/plain" id="plotly-packed">{library}</script>\n<script>\n{script}</script>\n'


def _notes(evidence: Evidence) -> str:
    items = "".join(f"<li>{escaped(note)}</li>" for note in notes(evidence))
    return f'<div class="notes"><h2>Take note</h2><ul>{items}</ul></div>\n' if items else ""


def _tiles(evidence: Evidence) -> str:
    """The three goals in three numbers: settled where the flight settled, else of all following."""
    if not evidence.has_following:
        return ""
    part = "follow" if evidence.settled_from is None else "settled"
    when = "while following" if evidence.settled_from is None else f"settled, from {evidence.settled_from:g}{NBSP}s"
    known = "truth" in evidence.figures
    whose = ", estimated" if known else ""
    tiles = []
    for name, unit, key, factor in _TILES:
        rms, most = (data_element(evidence.number(part, key, kind), factor) for kind in ("rms", "max"))
        true, true_most = (data_element(evidence.number("truth", part, key, kind), factor) for kind in ("rms", "max"))
        truth = f'<dd class="true"><b>{true}</b> <span class="unit">{unit} rms, true</span></dd>' if known else ""
        largest = f"largest {most} {unit}" + (f", true {true_most} {unit}" if known else "")
        tiles.append(
            f'<div><dt>{name}</dt><dd><b>{rms}</b> <span class="unit">{unit} rms{whose}</span></dd>'
            f"{truth}<dd>{largest}; {when}</dd></div>"
        )
    return f'<dl class="tiles">{"".join(tiles)}</dl>\n'


def _table(evidence: Evidence) -> str:
    if not evidence.has_following:
        return ""
    return f'<section>\n<h2>Figures of the flight</h2>\n<div class="scroll">{table(evidence)}</div>\n</section>\n'


def _sections(sections: list[Section], number: int) -> str:
    """Sections, their figures counted on from ``number``."""
    parts = []
    for section in sections:
        pictures = []
        for picture in section.pictures:
            number += 1
            pictures.append(
                f'<figure id="figure-{picture.name}">\n{picture.svg}\n{_chart(picture)}'
                f"<figcaption><b>Figure {number}.</b> {escaped(picture.caption)}</figcaption>\n</figure>\n"
            )
        words = "".join(f"<p>{escaped(text)}</p>\n" for text in section.words)
        shown_pictures = f'<div class="figures">\n{"".join(pictures)}</div>\n' if pictures else ""
        parts.append(f"<section>\n<h2>{escaped(section.title)}</h2>\n{words}{shown_pictures}</section>\n")
    return "".join(parts)


def _chart(picture: Picture) -> str:
    if picture.chart is None:
        return ""
    # "</script>" in a name must not end the element
    text = picture.chart.replace("<", "\\u003c")
    return f'<script type="application/json" class="chart">{text}</script>\n'


def _provenance(evidence: Evidence) -> str:
    plan, resolved = evidence.plan, evidence.resolved
    north, east, down = plan.mission.placement.origin_n
    origin = f"{north:zg} m north, {east:zg} m east, {down:zg} m down in the vehicle's local frame"
    length = f"{plan.table.length:.2f} m, " + ("closed" if plan.table.closed else "open")
    rows = [
        ("Mission file", _file(resolved, "mission")),
        ("Vehicle file", _file(resolved, "vehicle")),
        *([("World file", _file(resolved, "simulation"))] if resolved.get("simulation") else []),
        ("Path length", length),
        ("Origin of the mission", origin),
        ("Ticks recorded", f"{len(evidence.table)}"),
        *([("Commands", latency_words(sent))] if (sent := read_latency(evidence.directory, evidence.table)) else []),
    ]
    listed = "".join(f"<div><dt>{name}</dt><dd>{escaped(value)}</dd></div>" for name, value in rows)
    sources = "".join(
        f"<details><summary>{escaped(name)}</summary><pre>{escaped(text)}</pre></details>\n"
        for name, text in evidence.sources.items()
    )
    return f'<dl class="provenance">{listed}</dl>\n{sources}'


def _file(resolved: dict[str, object], what: str) -> str:
    part = resolved.get(what)
    name = part.get("file") if isinstance(part, dict) else None
    # where the file lay is this machine's business, its name is the reader's
    return str(name).replace("\\", "/").rsplit("/", 1)[-1] if name else "not recorded"


class Picture(NamedTuple):
    """A figure: its id in the page, its SVG, the sentence under it; the same for plotly.js, where it can be zoomed."""

    name: str
    svg: str
    caption: str
    chart: str | None = None


class Section(NamedTuple):
    """A part of the page: its title, its paragraphs (plain text), its figures."""

    title: str
    words: list[str]
    pictures: list[Picture]
