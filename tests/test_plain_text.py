"""What a terminal or a log is given of words from outside."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from companion.config.syntax.faults import Fault
from companion.plain_text import printable, printable_lines


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("Höhe 3 m, 90° – \u98de", "Höhe 3 m, 90° – \u98de"),
        ("\x1b]0;title\x07", "\\x1b]0;title\\x07"),
        ("a\r\nb", "a\\r\\nb"),
        ("\x9b2J", "\\x9b2J"),  # CSI in one byte
        ("\x7f\x08", "\\x7f\\x08"),
        ("\u202e\u2066\u200b\ufeff", "\\u202e\\u2066\\u200b\\ufeff"),  # reading direction, widths of nothing
        ("\u2028\u0085", "\\u2028\\x85"),
        ("\udc80", "\\udc80"),  # a byte of a file's name that is no UTF-8
    ],
)
def test_every_character_that_does_not_print_is_its_escape(text: str, shown: str) -> None:
    assert printable(text) == shown
    assert printable(text).isprintable()
    printable(text).encode()


def test_our_own_lines_end_where_they_end() -> None:
    assert printable_lines("one\ntwo\x1b\n") == "one\ntwo\\x1b\n"
    assert str(Fault("a\nb.yaml", 3, "path", "\x1b[2J")) == "a\\nb.yaml:3: path: \\x1b[2J"


def test_names_in_files_reach_no_terminal_raw(tmp_path: Path) -> None:
    mission = tmp_path / "m\x1b[2J.yaml"
    mission.write_text('mission: "\\e]0;gotcha\\a"\nframe: ned\npath: {kind: circle, center: [0, 0, -5], radius: 5}\n')
    for command in (["check", str(mission)], ["check", str(tmp_path / "none\x1b[2J\nok")]):
        done = subprocess.run(
            [sys.executable, "-m", "companion", *command], capture_output=True, text=True, check=False
        )
        assert done.stdout + done.stderr
        assert "\x1b" not in done.stdout + done.stderr, done.stdout + done.stderr
        assert "\x07" not in done.stdout + done.stderr
