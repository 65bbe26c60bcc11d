"""The phases of the flight as a strip of HTML: it needs no figure, and it bends to any width."""

from __future__ import annotations

from typing import Any

from companion.record.report.evidence import Evidence
from companion.record.report.numbers import escaped, worded
from companion.record.report.palette import PHASES

UNKNOWN = "#aab6c1"


def timeline(evidence: Evidence) -> str:
    """The strip, a scale under it, and the phases by name; a sentence where there were none."""
    spans = list(_spans(evidence.figures.get("phases")))
    if not spans:
        return "<p>The record holds no tick, so there are no phases to show.</p>"
    total = spans[-1][2]
    # in per mille of the flight: growths that sum to less than 1 would leave the strip unfilled
    bars = "".join(
        f'<span style="flex-grow:{1e3 * (end - begin) / total:.1f};background:{PHASES.get(name, UNKNOWN)}"></span>'
        for name, begin, end in spans
        if end > begin and total > 0.0
    )
    items = "".join(
        f'<li><i style="background:{PHASES.get(name, UNKNOWN)}"></i>{escaped(name)} '
        f"<span>{_when(begin, end)}</span></li>"
        for name, begin, end in spans
    )
    return (
        f'<div class="strip" role="img" aria-label="phases of the flight over time">{bars}</div>'
        f'<div class="scale"><span>0 s</span><span>{worded(total)} s</span></div><ol class="phases">{items}</ol>'
    )


def _when(begin: float, end: float) -> str:
    return f"{worded(end - begin)} s" if end > begin else f"at {worded(begin)} s"


def _spans(phases: Any) -> list[tuple[str, float, float]]:
    spans = []
    for phase in phases if isinstance(phases, list) else []:
        try:
            spans.append((str(phase["phase"]), float(phase["from_s"]), float(phase["to_s"])))
        except (KeyError, TypeError, ValueError):
            continue
    return spans
