"""What makes the control thread punctual on a machine with other work, as far as the system permits."""

from __future__ import annotations

import contextlib
import ctypes
import os
import resource
from collections.abc import Iterator
from pathlib import Path

PRIORITY = 50
"""SCHED_FIFO of the control thread: before all normal work, behind the kernel's own threads. Engineering choice."""
HELPER_PRIORITY = 40
"""Of a thread that shares the interpreter's lock with it: if other work held that thread up, it would hold the lock.
Engineering choice."""
_MCL_CURRENT = 1
"""mlockall(2): pages that are mapped."""
_MCL_FUTURE = 2
"""mlockall(2): pages that will be."""
_CAP_IPC_LOCK = 1 << 14
"""capabilities(7): the bit that permits locking memory."""


@contextlib.contextmanager
def punctual() -> Iterator[str]:
    """While it lasts, this thread goes before normal work and no page is swapped out, where permitted.

    Gives one line for a person: what was permitted, and what would permit the rest.
    """
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    fifo, locked = at_priority(PRIORITY), _locked()
    try:
        yield _realtime_words(fifo, locked)
    finally:
        if fifo:
            os.sched_setscheduler(0, *before)
        if locked:
            _libc().munlockall()


def at_priority(priority: int) -> bool:
    """Put the calling thread under SCHED_FIFO. Whether that was permitted."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError:
        return False
    return True


def _locked() -> bool:
    """Keep every page in memory. Under a limit it is not tried: the first allocation beyond it would fail in flight."""
    if not (_is_capable(_CAP_IPC_LOCK) or resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] == resource.RLIM_INFINITY):
        return False
    return bool(_libc().mlockall(_MCL_CURRENT | _MCL_FUTURE) == 0)


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None)


def _is_capable(capability: int) -> bool:
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/self/status").read_text(encoding="ascii", errors="replace").splitlines()
        return bool(int(next(line for line in lines if line.startswith("CapEff:")).split()[1], 16) & capability)
    return False


def _realtime_words(fifo: bool, locked: bool) -> str:
    got = [name for name, has in ((f"SCHED_FIFO {PRIORITY}", fifo), ("locked memory", locked)) if has]
    need = [
        name
        for name, has in (
            (f"SCHED_FIFO (LimitRTPRIO={PRIORITY} or CAP_SYS_NICE)", fifo),
            ("locked memory (LimitMEMLOCK=infinity or CAP_IPC_LOCK)", locked),
        )
        if not has
    ]
    words = f"real time: {' and '.join(got)}" if got else "real time: at normal priority"
    return words + (f"; not permitted: {', '.join(need)}" if need else "")
