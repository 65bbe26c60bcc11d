"""Many flights on many workers, by dask: on this machine, or on a scheduler that is there.

A worker that dies loses no flight (dask flies it elsewhere); what has landed is in the results, and nothing is flown
twice that is there.
"""

from __future__ import annotations

import contextlib
import logging
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

from companion.study.flying import Case, row_of
from companion.vehicle import CompanionError

AHEAD = 3
"""Flights that wait at the workers, for each of them: enough that none is ever idle (engineering choice)."""
RETRIES = 3
"""Workers that may die of one flight until it counts as failed (engineering choice)."""

Fly = Callable[[Case], dict[str, Any]]


def flown(
    cases: list[Case], workers: int, scheduler: str | None, take: Callable[[dict[str, Any]], None], fly: Fly = row_of
) -> None:
    """Fly every case; ``take`` is given each row as it lands. CompanionError: dask is not there, or the scheduler is
    gone."""
    try:
        import distributed
    except ImportError:
        message = "a study needs dask: pip install 'px4-path-companion[study]'"
        raise CompanionError(message) from None
    with contextlib.ExitStack() as stack:
        client = stack.enter_context(_client(distributed, workers, scheduler))
        waiting: Iterator[Case] = iter(cases)
        landing = distributed.as_completed(with_results=False)  # type: ignore[no-untyped-call]
        flying: dict[Any, Case] = {}
        lost: Counter[int] = Counter()

        def send(case: Case | None) -> None:
            if case is not None:
                future = client.submit(fly, case, pure=False, retries=RETRIES)
                flying[future] = case
                landing.add(future)  # type: ignore[no-untyped-call]

        for _ in range(AHEAD * max(1, len(client.nthreads()))):
            send(next(waiting, None))
        while flying:
            future = next(landing)
            case = flying.pop(future)
            row = _row(future, case)
            if row is None and client.status != "running":
                raise CompanionError("the scheduler is gone; what has landed is kept, and --resume flies the rest")
            lost[case.index] += row is None
            if row is None and lost[case.index] <= RETRIES:
                send(case)  # its worker died with the result
                continue
            take(row or _failed(case, "its workers died of it"))
            future.release()
            send(next(waiting, None))


def _row(future: Any, case: Case) -> dict[str, Any] | None:
    """What came of it; None where it was lost on the way."""
    from distributed.client import FutureCancelledError

    if future.status in ("cancelled", "lost"):
        return None
    try:
        row: dict[str, Any] = future.result()
        return row
    except (FutureCancelledError, TimeoutError):
        return None
    except Exception as error:  # the flight's own, or that its workers died of it
        return _failed(case, f"{type(error).__name__}: {error}")


def _failed(case: Case, reason: str) -> dict[str, Any]:
    return {"index": case.index, "seed": case.seed, "outcome": "failed", "reason": reason, "passed": False, "unmet": ""}


@contextlib.contextmanager
def _client(distributed: Any, workers: int, scheduler: str | None) -> Iterator[Any]:
    import dask.config

    logging.getLogger("distributed").setLevel(logging.ERROR)
    if scheduler is not None:
        try:
            client = distributed.Client(scheduler, timeout="10s")
        except OSError:
            raise CompanionError(f"no scheduler answers at {scheduler}; start one with: dask scheduler") from None
        with client:
            yield client
        return
    with (
        # dask's profile of its workers grows for an hour (50 MB in two dozen flights), and takes 5 % of their time
        dask.config.set({"distributed.worker.profile.enabled": False}),
        distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            silence_logs=logging.CRITICAL,
            # no dashboard; a free port for dask's own page of health, which warns where its usual one is taken
            dashboard_address="127.0.0.1:0",
            scheduler_kwargs={"dashboard": False},
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client
