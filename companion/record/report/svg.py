"""A figure as a piece of the page: inline SVG whose words are words, in the page's own font."""

from __future__ import annotations

import io
import re

from matplotlib.figure import Figure

from companion.record.report.numbers import escaped

_FONT = re.compile(r"font: (?P<weight>(?:bold |[0-9]+ )?)(?P<style>(?:italic |oblique )?)(?P<size>[\d.]+px) [^;\"]*")
_LONG = re.compile(r"-?\d+\.\d{3,}")
_TAG = re.compile(r"<[^>]+>")
_ID = re.compile(r'(?P<before>\bid="|href="#|url\(#)(?P<name>[^")]+)')
_NAMED_GROUP = re.compile(r'<g id="[a-zA-Z]\w*_\d+">')


def inline(figure: Figure, name: str, description: str) -> str:
    """``figure`` as an <svg> element. ``name``: unique in the page; ``description``: for those who cannot see it."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = buffer.getvalue()
    body = text[text.index(">", text.index("<svg")) + 1 : text.rindex("</svg>")]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    body = re.sub(r"<!--.*?-->", "", body, flags=re.DOTALL)
    body = body.replace("xlink:href", "href")
    body = _NAMED_GROUP.sub("<g>", body)
    # ids are the page's, not the figure's: two figures may not share one
    body = _ID.sub(lambda found: f"{found['before']}{name}-{found['name']}", body)
    body = _FONT.sub(_font, body)
    # a hundredth of a point is finer than any eye and any printer
    body = _TAG.sub(lambda tag: _LONG.sub(lambda found: f"{float(found[0]):.2f}", tag[0]), body)
    body = re.sub(r"\s*\n\s*", "\n", body).strip()
    width, height = (72.0 * inches for inches in figure.get_size_inches())
    return (
        f'<svg viewBox="0 0 {width:.0f} {height:.0f}" role="img" aria-label="{escaped(description)}">\n{body}\n</svg>'
    )


def _font(found: re.Match[str]) -> str:
    weight = found["weight"].strip()
    return (f"font-weight: {weight}; " if weight else "") + f"font-size: {found['size']}"
