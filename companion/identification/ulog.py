"""A ULog file of PX4 -> the topics that identification needs, as arrays. Read with pyulog (the extra ``ulog``)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.vehicle import CompanionError

Array = NDArray[np.float64]
FIELDS: dict[str, tuple[str, ...]] = {
    "vehicle_angular_velocity": ("xyz[0]", "xyz[1]", "xyz[2]"),
    "vehicle_rates_setpoint": ("roll", "pitch", "yaw"),
    "vehicle_torque_setpoint": ("xyz[0]", "xyz[1]", "xyz[2]"),
    "vehicle_thrust_setpoint": ("xyz[2]",),
    "vehicle_acceleration": ("xyz[0]", "xyz[1]", "xyz[2]"),
    "vehicle_attitude": ("q[0]", "q[1]", "q[2]", "q[3]"),
    "vehicle_local_position": ("vx", "vy", "vz", "z"),
    "vehicle_land_detected": ("landed",),
    "battery_status": ("voltage_v",),
}
"""What is read of each topic; units and frames are PX4's (rad/s, m/s^2, FRD; m/s, m, NED; torque and thrust 0..1)."""
NEEDED = tuple(name for name in FIELDS if name not in ("vehicle_land_detected", "battery_status"))
"""Without these nothing can be found."""
SETPOINTS = ("vehicle_torque_setpoint", "vehicle_thrust_setpoint")
"""What the mixer was asked for; before SETPOINTS_SINCE PX4 logged actuator_controls_0 instead."""
SETPOINTS_SINCE = 0x010E0000
"""Number: PX4 1.14, as ver_sw_release (the logs of 1.12 and 1.13 that were looked at have none)."""
SIMULATED_AIRFRAMES = (1001, 1002, 1100, 1101, 1102, 1103)
"""Number: SYS_AUTOSTART of PX4's airframes for a simulator in the loop (HIL) and on the board (SIH)."""


class Series(NamedTuple):
    """One topic. ``t``: s since the log began, of the samples that it tells of; ``x``: one row a sample."""

    t: Array
    x: Array

    @property
    def period(self) -> float:
        """s between two samples, the median."""
        return float(np.median(np.diff(self.t))) if len(self.t) > 1 else float("inf")


class Log(NamedTuple):
    """``topics``: by name. ``parameters``: at the beginning. ``identity``: what PX4 says it is. ``lost``: s of
    dropouts. ``hardware``: PX4's name of its board, empty where the log does not say."""

    topics: Mapping[str, Series]
    parameters: Mapping[str, float]
    identity: str
    lost: float
    hardware: str

    @property
    def simulator(self) -> str:
        """By what the log is known to be of a simulator; empty where it is of a vehicle."""
        if self.hardware.endswith("SITL"):
            return self.hardware
        in_the_loop, airframe = self.parameters.get("SYS_HITL", 0.0), self.parameters.get("SYS_AUTOSTART", 0.0)
        if in_the_loop > 0.0:
            return f"SYS_HITL {in_the_loop:g}"
        return f"SYS_AUTOSTART {airframe:g}" if airframe in SIMULATED_AIRFRAMES else ""


def read(file: BinaryIO, name: str) -> Log:
    """The log in an open file. CompanionError: it is none, or lacks what is needed."""
    try:
        from pyulog import ULog
    except ImportError:
        raise CompanionError("reading a ULog needs pyulog: pip install 'px4-path-companion[ulog]'") from None
    try:
        log = ULog(file, list(FIELDS))
    except Exception as error:  # whatever a damaged file makes of a parser
        raise CompanionError(f"{name} is no ULog, or a damaged one: {type(error).__name__}: {error}") from None
    topics: dict[str, Series] = {}
    for data in log.data_list:
        if data.multi_id == 0 and data.name in FIELDS and data.name not in topics:
            series = _series(data.data, FIELDS[data.name], log.start_timestamp)
            if series is not None:
                topics[data.name] = series
    missing = [each for each in NEEDED if each not in topics]
    if missing:
        raise CompanionError(f"{name} {_lacking(missing, log.msg_info_dict, list(log.message_formats))}")
    parameters = {str(key): float(value) for key, value in log.initial_parameters.items()}
    told, lost = log.msg_info_dict, sum(each.duration for each in log.dropouts) / 1000.0
    return Log(topics, parameters, _identity(told), lost, str(told.get("ver_hw", "")))


def _lacking(missing: Sequence[str], told: Mapping[str, Any], formats: Sequence[str]) -> str:
    """What is to be said of a log without the topics ``missing``, and what to do. ``formats``: of its messages."""
    system = told.get("sys_name", "PX4")
    if system != "PX4" or not any(each.startswith("vehicle_") for each in formats):
        writer = f"it was written by {system}" if system != "PX4" else "it has no vehicle_* topics"
        return f"is no log of PX4's flight: {writer}. Give a log that PX4 wrote (companion vehicle log fetches it)"
    release = told.get("ver_sw_release")
    old = isinstance(release, int) and release < SETPOINTS_SINCE
    if set(missing) & set(SETPOINTS) and (old or any(each.startswith("actuator_controls") for each in formats)):
        version = f"PX4 {_version(release)}" if isinstance(release, int) and release else "an old PX4"
        return (
            f"is of {version}: before 1.14 PX4 logs no torque and thrust setpoints, and nothing can be fitted. "
            "companion vehicle from --connect LINK writes a vehicle file from PX4's parameters"
        )
    return f"lacks {', '.join(missing)}; log with SDLOG_PROFILE 25 (default, system identification, high rate)"


def _series(data: Mapping[str, Any], fields: tuple[str, ...], begin: int) -> Series | None:
    """The columns of one topic in the order of their stamps, without what is not finite."""
    if any(field not in data for field in fields) or len(data["timestamp"]) < 2:
        return None
    stamps = np.asarray(data["timestamp"], dtype=np.float64)
    sampled = np.asarray(data.get("timestamp_sample", stamps), dtype=np.float64)
    t = 1e-6 * (np.where(sampled > 0.0, sampled, stamps) - begin)
    x = np.column_stack([np.asarray(data[field], dtype=np.float64) for field in fields])
    kept = np.isfinite(t) & np.isfinite(x).all(axis=1)
    order = np.argsort(t[kept], kind="stable")
    t, x = t[kept][order], x[kept][order]
    new = np.concatenate([[True], np.diff(t) > 0.0])
    return Series(t[new], x[new]) if new.sum() > 1 else None


def _identity(told: Mapping[str, Any]) -> str:
    release = told.get("ver_sw_release")
    version = _version(release) if isinstance(release, int) else "of unknown version"
    parts = [f"PX4 {version}"]
    if "ver_sw" in told:
        parts.append(f"git {str(told['ver_sw'])[:10]}")
    if "sys_uuid" in told:
        parts.append(f"uid {told['sys_uuid']}")
    return ", ".join(parts)


def _version(release: int) -> str:
    return ".".join(str(release >> shift & 0xFF) for shift in (24, 16, 8))
