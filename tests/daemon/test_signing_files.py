"""Time stamps that outlive the process."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from companion.daemon import signing_files
from companion.daemon.signing_files import StampsError, signing_with
from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import message
from companion.mavlink.signing import Signing
from tests.support.signing import KEY, OTHER

EPOCH = 1.79e9
HEARTBEAT = message("HEARTBEAT")


@pytest.fixture(autouse=True)
def own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return tmp_path / "companion"


def heard(stamp: int) -> bytes:
    return Encoder(1, 1, signing=Signing(KEY, stamp=stamp)).message(HEARTBEAT)


def test_what_was_heard_once_is_refused_after_a_restart(own: Path) -> None:
    with signing_with(KEY, EPOCH) as signing:
        signing.advance(0.0)
        old = heard(signing.stamp + 5)
        assert Decoder(signing=signing).datagram(old)
        ours = signing.stamp
    with signing_with(KEY, EPOCH - 1e6) as signing:  # the computer has lost its time
        signing.advance(0.0)
        assert signing.stamp >= ours
        assert Decoder(signing=signing).datagram(old) == []
        assert Decoder(signing=signing).datagram(heard(ours + 6))
    with signing_with(OTHER, EPOCH - 1e6) as signing:
        assert signing.streams == {}
    (mine, other) = sorted(own.iterdir())
    assert mine.stat().st_mode & 0o777 == other.stat().st_mode & 0o777 == 0o600
    for file in own.iterdir():
        assert KEY.hex() not in file.name + file.read_text()


def test_a_power_cut_takes_no_stamp_back(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(signing_files, "PERIOD", 0.01)
    with signing_with(KEY, EPOCH) as signing:
        (file,) = own.iterdir()
        signing.advance(1.0)
        Decoder(signing=signing).datagram(heard(signing.stamp + 5))
        used = signing.stamp
        for _ in range(500):
            document = json.loads(file.read_text())
            if document["streams"]:
                break
            signing_files.threading.Event().wait(0.01)
        assert document["stamp"] > used
        assert document["streams"]["1/1/0"] > used - 5
    assert json.loads(file.read_text())["stamp"] == used


@pytest.mark.parametrize("text", ["", "{", "[]", '{"stamp": "x", "streams": {}}', '{"stamp": 7, "streams": {"a": 1}}'])
def test_a_spoiled_file_begins_from_the_clock(own: Path, text: str) -> None:
    with signing_with(KEY, EPOCH):
        (file,) = own.iterdir()
    file.write_text(text)
    with signing_with(KEY, EPOCH) as signing:
        signing.advance(0.0)
        assert signing.stamp == Signing(KEY, stamp=signing.stamp).stamp > 10**12


def test_stamps_that_cannot_be_kept_stop_before_anything_is_sent(own: Path) -> None:
    own.parent.mkdir(exist_ok=True)
    own.write_text("a file in the directory's place")
    with pytest.raises(StampsError, match="cannot be kept"), signing_with(KEY, EPOCH):
        pass
