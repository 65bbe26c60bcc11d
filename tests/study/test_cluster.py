"""A study on a real dask scheduler with workers as processes: killed, and no flight lost or flown twice."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.study.engine import flown
from companion.study.flying import Case, cases_of, row_of
from companion.study.reading import study_from
from companion.study.results import load_rows
from tests.study.test_study import ROOT, TINY

pytest.importorskip("distributed")
pytestmark = pytest.mark.xdist_group("real time")
SIX = TINY.replace("flights: 2", "flights: 6")
PATIENCE = 240.0
"""s that anything may take on a busy machine."""


@contextlib.contextmanager
def process(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    made = subprocess.Popen([sys.executable, "-m", *words], env=environment, stderr=subprocess.DEVNULL)
    try:
        yield made
    finally:
        made.kill()
        made.wait()


def wait_for_rows(log: Path, count: int, running: subprocess.Popen[bytes]) -> None:
    begun = time.monotonic()
    while not log.is_file() or log.read_bytes().count(b"\n") < count:
        assert running.poll() is None and time.monotonic() - begun < PATIENCE
        time.sleep(0.05)


def told_of_profile(case: Case) -> dict[str, Any]:
    import dask.config

    return {"index": case.index, "profile": dask.config.get("distributed.worker.profile.enabled")}


def test_workers_that_are_started_keep_no_profile() -> None:
    """Its memory grows with the time."""
    rows: list[dict[str, Any]] = []
    flown(cases_of(study_from(TINY, "tiny.yaml")), 1, None, rows.append, fly=told_of_profile)
    assert [row["profile"] for row in rows] == [False, False]


def test_kill_9_of_client_and_worker_loses_no_flight_and_flies_none_twice(tmp_path: Path) -> None:
    (tmp_path / "six.yaml").write_text(SIX, encoding="utf-8")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    folder = tmp_path / "r"
    run = ("companion", "study", "run", str(tmp_path / "six.yaml"), "--scheduler", address, "--record", str(folder))
    worker = ("distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
    scheduler = ("distributed.cli.dask_scheduler", "--port", address.rpartition(":")[2], "--no-dashboard")
    with process(*scheduler), process(*worker) as first:
        with process(*run) as client:
            wait_for_rows(folder / "rows.jsonl", 1, client)
            client.kill()
        with process(*run, "--resume") as client:
            wait_for_rows(folder / "rows.jsonl", 3, client)
            first.kill()
            with process(*worker):
                assert client.wait(PATIENCE) == 0
    assert (folder / "rows.jsonl").read_bytes().count(b"\n") == 6
    flown = [json.loads(json.dumps(row_of(case))) for case in cases_of(study_from(SIX, "six.yaml"))]
    for row, here in zip(load_rows(folder), flown, strict=True):
        assert {**row, "wall_s": 0.0} == {**here, "wall_s": 0.0}  # bit for bit, wherever it was flown
