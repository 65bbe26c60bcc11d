"""A study as one HTML file that needs nothing else."""

from __future__ import annotations

import html
import io
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from companion.record.files import write_whole
from companion.study.reading import Study
from companion.study.telling import error_name, explained, holds, in_words, line_of, worst
from companion.vehicle import CompanionError

Row = dict[str, Any]
BINS = 30
_PAGE = Template("""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$name: study</title>
<style>
$style</style>
</head>
<body>
<main>
<header>
<p class="kind">Study</p>
<h1>$name</h1>
<p class="outcome $mood">$verdict</p>
</header>
$figures<section>
<h2>The worst flights</h2>
<pre>$worst</pre>
</section>
<section>
<h2>As it was asked for</h2>
<pre>$text</pre>
</section>
</main>
<footer><p><code>companion study replay $folder INDEX</code> flies one of them again.</p></footer>
</body>
</html>
""")


def write_page(directory: Path, study: Study, rows: list[Row]) -> Path:
    """Write ``report.html`` into the folder of a study; its path. CompanionError: matplotlib is not installed."""
    lines = in_words(study.model, rows, study.flights)
    text = _PAGE.substitute(
        name=html.escape(study.name),
        style=files("companion.record.report").joinpath("page.css").read_text(encoding="utf-8"),
        mood="completed" if holds(study.model, rows, study.flights) else "aborted",
        verdict="<br>".join(map(html.escape, lines)),
        figures=_figures(rows),
        worst=html.escape("\n".join(map(line_of, worst(rows)))),
        text=html.escape(study.text),
        folder=html.escape(str(directory)),
    )
    target = directory / "report.html"
    write_whole(target, text, durable=False)
    return target


def _figures(rows: list[Row]) -> str:
    """The distribution of the error, and the error over what explains it best."""
    name = error_name(rows)
    if name is None:
        return ""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise CompanionError("the page draws with matplotlib: pip install 'px4-path-companion[report]'") from None
    known = [row for row in rows if row.get(name) is not None]
    errors = [100.0 * row[name] for row in known]
    keys = [key for key, _ in explained(rows)][:3]
    figure = Figure(figsize=(4.0 * (1 + len(keys)), 3.4), layout="constrained")
    axes = figure.subplots(1, 1 + len(keys), squeeze=False)[0]
    axes[0].hist(errors, bins=min(BINS, max(5, len(errors) // 4)))
    axes[0].set(xlabel="path error, cm RMS settled", ylabel="flights")
    for key, place in zip(keys, axes[1:], strict=True):
        place.plot([row[f"vary.{key}"] for row in known], errors, ".", markersize=4)
        place.set(xlabel=key, ylabel="path error, cm")
    out = io.StringIO()
    figure.savefig(out, format="svg")
    svg = out.getvalue()
    return f"<section>\n<h2>How far off the path</h2>\n<figure>{svg[svg.index('<svg') :]}</figure>\n</section>\n"
