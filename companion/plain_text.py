"""Words from outside are data: what a terminal or a log may be given of them.

A control character in a STATUSTEXT, a mission's name or a file's name could move the cursor, clear the screen, turn the
reading direction or forge a line of ours. It is shown as its escape sequence instead.
"""

from __future__ import annotations


def printable(text: str) -> str:
    """One line: every character that does not print is its escape, ``\\x1b`` for ESC."""
    return text if text.isprintable() else "".join(map(_printable, text))


def printable_lines(text: str) -> str:
    """Several lines of ours: ``printable``, but for the ends of lines. Outside words in it were made ``printable``
    before, where they could hold a line's end."""
    return "\n".join(map(printable, text.split("\n")))


def _printable(character: str) -> str:
    return character if character.isprintable() else character.encode("unicode_escape").decode("ascii")
