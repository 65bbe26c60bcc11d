"""The vehicle's own log by MAVLink FTP: only whole, and only of a vehicle that is known to be disarmed."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from companion.services import log_files
from companion.services.log_files import is_armed, wait_for_closed_log
from companion.services.vehicle import ServiceError


class Card:
    """A card with one log, whose size at each look is the next of ``sizes``."""

    def __init__(self, sizes: Iterator[int]) -> None:
        self._sizes = sizes

    def list_directory(self, path: str) -> Any:
        if path == log_files.FOLDERS[0]:
            return SimpleNamespace(entries=[SimpleNamespace(name="sess001", size_bytes=0)])
        return SimpleNamespace(entries=[SimpleNamespace(name="log001.ulg", size_bytes=next(self._sizes))])


def test_a_log_is_taken_once_it_stands_still_and_never_half(monkeypatch: pytest.MonkeyPatch) -> None:
    slept: list[float] = []
    monkeypatch.setattr(log_files, "time", SimpleNamespace(monotonic=lambda: sum(slept), sleep=slept.append))
    assert wait_for_closed_log(Card(iter([10, 20, 30, 30]))) == "/fs/microsd/log/sess001/log001.ulg"
    with pytest.raises(ServiceError, match=r"still writes .*log001\.ulg"):
        wait_for_closed_log(Card(iter(range(1_000_000))))


class Telemetry:
    """MAVSDK's: ``armed`` is False until a HEARTBEAT has come, which says ``truth``."""

    def __init__(self, truth: bool | None) -> None:
        self._truth = truth
        self.subscribed = 0

    def armed(self) -> bool:
        return False

    def subscribe_armed(self, callback: Callable[[bool, Any], None]) -> int:
        self.subscribed += 1
        if self._truth is not None:
            threading.Timer(0.01, callback, (self._truth, None)).start()
        return 1

    def unsubscribe_armed(self, handle: int) -> None:
        self.subscribed -= handle


@pytest.mark.parametrize("truth", [True, False])
def test_whether_it_is_armed_is_what_its_heartbeat_says(truth: bool) -> None:
    telemetry = Telemetry(truth)
    assert is_armed(telemetry) is truth
    assert telemetry.subscribed == 0


def test_a_vehicle_that_is_not_heard_is_not_taken_for_disarmed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_files, "HEARTBEAT_WITHIN", 0.01)
    with pytest.raises(ServiceError, match="not been heard"):
        is_armed(Telemetry(None))
