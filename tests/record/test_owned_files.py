"""Files of ours where others can write too."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from companion.record.owned_files import PRIVATE, READABLE, SIZE_MAX, owner_of, read_owned, write_owned


def test_written_whole_and_read_again(tmp_path: Path) -> None:
    file = tmp_path / "companion" / "quad.json"
    assert read_owned(file) is None
    assert write_owned(file, "ä")
    assert write_owned(file, "ö")
    assert read_owned(file) == "ö"
    assert [path.name for path in file.parent.iterdir()] == ["quad.json"]
    assert file.stat().st_mode & 0o777 == PRIVATE
    assert file.parent.stat().st_mode & 0o777 == 0o700
    assert write_owned(file, "x", READABLE)
    assert file.stat().st_mode & 0o777 & ~0o022 == READABLE


def test_a_link_in_the_files_place_is_replaced_and_never_followed(tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_text("mine")
    file = tmp_path / "d" / "7.json"
    file.parent.mkdir()
    file.symlink_to(victim)
    (file.parent / f".7.json.{os.getpid()}.part").symlink_to(victim)
    assert read_owned(file) is None
    assert write_owned(file, "ours")
    assert victim.read_text() == "mine"
    assert read_owned(file) == "ours"


def test_a_directory_that_is_a_link_or_everybodys_or_somebody_elses_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = tmp_path / "real"
    real.mkdir()
    (tmp_path / "link").symlink_to(real)
    assert not write_owned(tmp_path / "link" / "a", "x")
    assert owner_of(tmp_path / "link") is None
    real.chmod(0o777)
    assert not write_owned(real / "a", "x")
    assert owner_of(real) is None
    real.chmod(0o755)
    assert owner_of(real) == os.geteuid()
    monkeypatch.setattr("os.geteuid", lambda: 4242)
    assert not write_owned(real / "a", "x")
    assert not list(real.iterdir())


def test_what_is_no_plain_file_of_the_right_owner_is_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert read_owned(tmp_path / "pipe") is None  # and it does not wait for a writer
    assert read_owned(tmp_path) is None
    file = tmp_path / "file"
    file.write_bytes(b"\xff")
    assert read_owned(file) is None
    file.write_text("x" * (SIZE_MAX + 1))
    assert read_owned(file) is None
    file.write_text("x")
    assert read_owned(file) == "x"
    assert read_owned(file, owner=os.geteuid() + 1) is None
    assert read_owned(tmp_path / "a\0b") is None
