"""The key file: what is one, and that the key is never said."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from companion.config.signing_key import read_key
from companion.config.syntax.faults import ConfigError
from tests.support.signing import KEY, key_file


def test_a_key_is_64_hexadecimal_digits_in_a_file_of_mode_0600(tmp_path: Path) -> None:
    assert read_key(key_file(tmp_path)) == KEY
    file = tmp_path / "upper"
    file.write_text(KEY.hex().upper())
    file.chmod(0o600)
    assert read_key(file) == KEY


@pytest.mark.parametrize("mode", [0o644, 0o640, 0o666, 0o604, 0o700])
def test_a_file_that_others_can_read_is_refused(tmp_path: Path, mode: int) -> None:
    with pytest.raises(ConfigError) as caught:
        read_key(key_file(tmp_path, mode=mode))
    assert f"has mode {mode:04o}, expected 0600" in str(caught.value)
    assert KEY.hex() not in str(caught.value)


@pytest.mark.parametrize("text", ["", KEY.hex()[:-1], KEY.hex() + "00", "g" * 64, KEY.hex()[:32], " " + KEY.hex()])
def test_what_is_no_key_is_refused_without_being_said(tmp_path: Path, text: str) -> None:
    file = tmp_path / "key"
    file.write_text(text)
    file.chmod(0o600)
    with pytest.raises(ConfigError) as caught:
        read_key(file)
    assert "expected 64 hexadecimal digits" in str(caught.value)
    assert not text.strip() or text.strip() not in str(caught.value)


def test_no_file_a_directory_a_pipe_and_all_zeros(tmp_path: Path) -> None:
    zeros = key_file(tmp_path, bytes(32))
    os.mkfifo(tmp_path / "pipe")
    for path, said in (
        (tmp_path / "none", "No such file"),
        (tmp_path, "is no file"),
        (tmp_path / "pipe", "is no file"),
        (zeros, "all zeros"),
    ):
        with pytest.raises(ConfigError) as caught:
            read_key(path)
        assert said in str(caught.value)
        assert str(caught.value).startswith("--signing-key: ")
