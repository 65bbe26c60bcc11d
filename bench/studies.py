"""What a study costs, how well it shares its work, and what it survives.

python -m bench.studies cost [FLIGHTS]     dispersed circle, 60 s: core-seconds a flight, one worker beside two, memory
python -m bench.studies waiting            eight workers whose flights only wait: how busy the engine keeps them
python -m bench.studies tape               what numpy gains on the recorded step of the filter, flights at once or one
python -m bench.studies kills [FLIGHTS]    a scheduler and workers as processes: kill -9 of each, then of the client
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import json
import os
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest.mock
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from companion.calculus.straight import Function, Outputs, Tape, flat
from companion.estimation import kalman_step
from companion.study.engine import flown
from companion.study.flying import Case, cases_of, row_of
from companion.study.reading import Study, load_study, study_from
from companion.study.results import load_rows

ROOT = Path(__file__).resolve().parent.parent
CIRCLE = ROOT / "configs/studies/dispersed_circle.yaml"
WAIT = 0.5
"""s that a flight of ``waiting`` takes."""
SHORT = """\
study: kills
flights: {flights}
mission: circle_r5
world: outdoor
output: rates
duration: 2
settle: 1
seed: 3
vary:
  world.truth.mass_kg: {{uniform: [1.8, 2.2]}}
"""


def measured(case: Case) -> dict[str, Any]:
    """A flight and what it took of a core, and the process's largest memory so far."""
    begun = time.process_time()
    row = row_of(case)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {**row, "core_s": time.process_time() - begun, "rss_mb": peak / 1024.0, "worker": os.getpid()}


def study_of(flights: int, duration: float) -> Study:
    """The dispersed circle, shorter."""
    study = load_study(CIRCLE)
    return dataclasses.replace(study, model=study.model.model_copy(update={"flights": flights, "duration": duration}))


def cost(flights: int) -> None:
    """Print what a flight takes on one worker and on two."""
    walls = {}
    for workers in (1, 2):
        cases, rows = cases_of(study_of(flights, 60.0)), list[dict[str, Any]]()
        begun = time.monotonic()
        flown(cases, workers, None, rows.append, measured)
        walls[workers] = time.monotonic() - begun
        core = sum(row["core_s"] for row in rows) / len(rows)
        whole = resource.getrusage(resource.RUSAGE_CHILDREN)
        minutes = walls[workers] / len(rows) * 1000.0 / 60.0
        print(
            f"{workers} worker(s): {len(rows)} flights of 60 s in {walls[workers]:.1f} s, {minutes:.1f} min for 1000; "
            f"{core:.2f} core-s a flight; children so far {whole.ru_utime + whole.ru_stime:.0f} core-s; "
            f"{sum(row['passed'] for row in rows)} passed",
            flush=True,
        )
        for worker in {row["worker"] for row in rows}:
            memory = [row["rss_mb"] for row in rows if row["worker"] == worker]
            print(f"  worker {worker}: peak {memory[0]:.0f} MB after its first flight, {memory[-1]:.0f} MB at the end")
    print(f"efficiency of two over one: {100.0 * walls[1] / (2.0 * walls[2]):.0f} %")


def wait(case: Case) -> dict[str, Any]:
    """What stands in the place of a flight."""
    time.sleep(WAIT)
    return {"index": case.index, "passed": True, "worker": os.getpid()}


def waiting(flights: int = 400, workers: int = 8) -> None:
    """Print how busy so many workers are."""
    landed: list[tuple[float, int]] = []
    flown(
        cases_of(study_of(flights, 1.0)), workers, None,
        lambda row: landed.append((time.monotonic(), row["worker"])), wait,
    )  # fmt: skip
    # from when every worker has landed one, so that it does not count how long they take to start and to import
    begun = next(i for i in range(flights) if len({worker for _, worker in landed[: i + 1]}) == workers)
    ideal = (flights - begun - 1) * WAIT / workers
    spent = landed[-1][0] - landed[begun][0]
    share = 100.0 * ideal / spent
    print(
        f"{flights} waits of {WAIT} s on {workers} workers, the last {flights - begun - 1} counted: {spent:.2f} s, "
        f"ideal {ideal:.2f}: {share:.1f} %"
    )


@contextlib.contextmanager
def process(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    """A process that is gone afterwards."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    made = subprocess.Popen(
        [sys.executable, "-m", *words], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True,
    )  # fmt: skip
    try:
        yield made
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(made.pid, signal.SIGKILL)
        made.wait()


def kills(flights: int) -> None:
    """A run whose worker, scheduler and client are killed, beside one that nobody disturbs."""
    with tempfile.TemporaryDirectory() as place:
        study = Path(place) / "kills.yaml"
        text = SHORT.format(flights=flights)
        study.write_text(text, encoding="utf-8")
        reference = [row_of(case) for case in cases_of(study_from(text, "kills.yaml"))]
        for who in ("worker", "scheduler", "client"):
            folder = Path(place) / who
            codes = _disturbed(study, folder, who, flights)
            rows = load_rows(folder)
            lines = (folder / "rows.jsonl").read_text(encoding="utf-8").splitlines()
            other = _differing(rows, reference)
            print(
                f"kill -9 of the {who}: exit codes {codes}, {len(lines)} rows of {len(reference)} flights, "
                f"{f'OTHER FIGURES: {other}' if other else 'the same figures bit for bit'}",
                flush=True,
            )


def _disturbed(study: Path, folder: Path, who: str, flights: int) -> list[int]:
    """Fly with a real scheduler and two workers, kill one of them after a fifth of the flights, and go on until all is
    flown."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    scheduler = functools.partial(process, "distributed.cli.dask_scheduler", "--port", str(port), "--no-dashboard")
    worker = functools.partial(
        process, "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard", "--no-nanny"
    )
    client = functools.partial(
        process, "companion", "study", "run", str(study), "--scheduler", address, "--record", str(folder)
    )
    codes = []
    with contextlib.ExitStack() as stack:
        first, one, _ = stack.enter_context(scheduler()), stack.enter_context(worker()), stack.enter_context(worker())
        with client() as running:
            while _landed(folder) < flights // 5:
                time.sleep(0.1)
                if running.poll() is not None:
                    raise SystemExit(f"the study ended with {running.returncode} before anything was killed")
            {"worker": one, "scheduler": first, "client": running}[who].kill()
            codes.append(running.wait(300.0))
        if who == "scheduler":
            stack.enter_context(scheduler())
            stack.enter_context(worker())
        while codes[-1] not in (0, 1) or len(load_rows(folder)) < flights:
            with client("--resume") as running:
                codes.append(running.wait(300.0))
            if len(codes) > 4:
                break
    return codes


def _landed(folder: Path) -> int:
    log = folder / "rows.jsonl"
    return log.read_text(encoding="utf-8").count("\n") if log.is_file() else 0


def tape() -> None:
    """Print what numpy gains on the recorded step of the filter."""
    made: list[tuple[Tape, str, Outputs]] = []

    class Kept(Tape):
        def function(self, name: str, outputs: Outputs) -> Function:
            made.append((self, name, outputs))
            return super().function(name, outputs)

    with unittest.mock.patch.object(kalman_step, "Tape", Kept):
        one = kalman_step._record_step("kalman", learning=True)
    recorded, name, outputs = made[0]
    many = recorded.array_function(name, outputs)
    covariance = [1.0 if i == j else 0.01 for i, j in kalman_step.UPPER] * kalman_step.AXES
    axis, belief = (0.1,) * kalman_step.AXES, (0.1,) * kalman_step.SIZE
    given = (
        *(0.008, (0.1, 0.2, -9.8), 9.8, axis, axis, 1e-6, 1e-3),
        *((0.01,) * kalman_step.AXES,) * 4,
        *(0.01, 1e-4, 1e-5, 1e-5, axis),
        *(
            belief,
            tuple(covariance),
            (0.1,) * (2 * kalman_step.AXES * kalman_step.PER_AXIS),
            (0.04, 0.01, 0.25),
            belief,
        ),
    )
    alone = _least(lambda: one(*given), 800)
    for count in (100, 1000, 10000):
        arrays = [np.full(count, value) for value in flat(given)]
        together = _least(lambda arrays=arrays: many(*arrays), 10) / count  # type: ignore[misc]
        print(
            f"N = {count}: {1e6 * together:.2f} us a flight, alone {1e6 * alone:.0f} us: {alone / together:.0f} times"
        )


def _least(run: Callable[[], object], times: int) -> float:
    """s, of so many."""
    spent = []
    for _ in range(times):
        begun = time.perf_counter()
        run()
        spent.append(time.perf_counter() - begun)
    return min(spent)


def _differing(rows: list[dict[str, Any]], reference: list[dict[str, Any]]) -> list[str]:
    """Which columns are not the same, wall times apart."""
    here = [json.loads(json.dumps(row)) for row in reference]
    if len(rows) != len(here):
        return ["the number of rows"]
    pairs = list(zip(rows, here, strict=True))
    keys = {key for row in (*rows, *here) for key in row} - {"wall_s"}
    return [key for key in sorted(keys) if any(row.get(key) != there.get(key) for row, there in pairs)]


def main() -> None:
    """Run what is asked for."""
    match sys.argv[1:]:
        case ["cost", *rest]:
            cost(int(rest[0]) if rest else 40)
        case ["waiting"]:
            waiting()
        case ["kills", *rest]:
            kills(int(rest[0]) if rest else 40)
        case ["tape"]:
            tape()
        case []:
            tape()
            cost(40)
            waiting()
            kills(40)
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
