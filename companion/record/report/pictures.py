"""What a page is put together from."""

from __future__ import annotations

from typing import NamedTuple


class Picture(NamedTuple):
    """A figure: its id in the page, its SVG, the sentence under it."""

    name: str
    svg: str
    caption: str


class Section(NamedTuple):
    """A part of the page: its title, its paragraphs (plain text), its figures."""

    title: str
    words: list[str]
    pictures: list[Picture]
