"""``report.html``: the page one shows to others, from a flight folder.

    evidence    everything the page is made from, whatever is missing from the folder
    palette     the colours
    style       type, lines, axes: one hand for every figure
    curves      the path, the track and quantities over time as points to draw, coloured by another quantity
    marks       what happened, drawn into the figures
    maps        figures 1 and 2: from above, and in space
    errors      figures 3 and 4: G1, G2, G3 over time and along the path
    motion      figures 5 and 6: attitude, thrust and what was sent, as in the paper's Figs. 3 and 4; and the loop
    vehicle     what was estimated of the vehicle, and PX4's own curves beside ours
    figures     the figures in their order, with their captions, as pieces of the page
    zoom        the same figures for plotly.js, to zoom into
    text        the sentences, the phases, and the table of the numbers that matter
    page        all of it as one HTML file; page.css is its dress, page.js the zooming

Only ``figures`` and what it draws with need matplotlib, and only here is it imported.
"""

from __future__ import annotations

from pathlib import Path

from companion.record.files import write_whole
from companion.record.report.evidence import read_evidence
from companion.record.report.page import page_text
from companion.vehicle import CompanionError


def write_report(directory: Path) -> Path:
    """Write ``report.html`` into a flight folder; its path.

    CompanionError: matplotlib is not installed, or the folder is not a readable flight folder (ConfigError).
    """
    try:
        from companion.record.report import figures, zoom
    except ImportError as error:
        if (error.name or "").split(".")[0] not in ("matplotlib", "mpl_toolkits"):
            raise
        raise CompanionError("the report draws with matplotlib: pip install 'px4-path-companion[report]'") from None
    evidence = read_evidence(directory)
    text = page_text(evidence, figures.figure_sections(evidence), zoom.library())
    target = directory / "report.html"
    write_whole(target, text, durable=False)
    return target


__all__ = ["write_report"]
