"""A ULog as arrays. Needs the library ``pyulog`` (extra ulog)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from companion.config.syntax.faults import ConfigError, Fault
from companion.record.series import is_rising
from companion.record.ulog.topics import BODY_RATES, TOPICS
from companion.vehicle import CompanionError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LogSeries:
    """One topic. ``t``: s, rising; ``columns``: our name -> one value a time."""

    t: Array
    columns: dict[str, Array]


def read_ulog(file: Path) -> dict[str, LogSeries]:
    """Topic -> its series, times in s of the log's clock. ConfigError: it is no ULog, or has no body rates.
    CompanionError: the library is missing."""
    try:
        from pyulog import ULog
    except ImportError:
        raise CompanionError(
            "the log cannot be read: the library pyulog is missing; pip install 'px4-path-companion[ulog]'"
        ) from None
    try:
        log = ULog(str(file), [topic.name for topic in TOPICS])
    except OSError as error:
        raise _fault(file, f"cannot be read: {error.strerror}") from None
    except Exception as error:  # a damaged file: pyulog raises whatever its parsing meets
        raise _fault(file, f"is no ULog that can be read ({error or type(error).__name__})") from None
    series = {data.name: data.data for data in reversed(log.data_list) if data.multi_id == 0}
    found: dict[str, LogSeries] = {}
    for topic in TOPICS:
        read = series.get(topic.name)
        if read is None:
            continue
        stamp = read[topic.stamp if topic.stamp in read else "timestamp"].astype(np.float64) * 1e-6
        rising = is_rising(stamp)
        found[topic.name] = LogSeries(stamp[rising], {
            column.name: read[column.field].astype(np.float64)[rising]
            for column in topic.columns if column.field in read
        })  # fmt: skip
    if BODY_RATES not in found or len(found[BODY_RATES].columns) < 3 or len(found[BODY_RATES].t) < 2:
        raise _fault(file, f"has no {BODY_RATES}, by which it is joined; expected a log of a flight (SDLOG_PROFILE 0)")
    return found


def _fault(file: Path, message: str) -> ConfigError:
    return ConfigError([Fault(str(file), 0, "", message)])
