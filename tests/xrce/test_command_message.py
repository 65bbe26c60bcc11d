"""The compiled message of a setpoint: the bytes that its samples make one by one, again and again."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.vehicle import AttitudeSetpoint, MotorSetpoint, OutputLevel, RateSetpoint, Setpoint, TorqueSetpoint
from companion.xrce import wire
from companion.xrce.agent import Reader
from companion.xrce.command_message import FLAG, MODE, TOPICS, CommandMessage
from companion.xrce.topics import ATTITUDE_1_15, LAYOUTS, Layout, Topic

STAMP = 42_252_000
THRUST = {"xyz": (0.0, 0.0, -0.55)}
CASES: list[tuple[OutputLevel, Setpoint, list[dict[str, Any]]]] = [
    (OutputLevel.MOTORS, MotorSetpoint((0.4, 0.5, 0.6, 0.7)), [
        {"timestamp_sample": STAMP, "control": (0.4, 0.5, 0.6, 0.7, *(math.nan,) * 8)}, {"timestamp_sample": STAMP, **THRUST},
    ]),
    (OutputLevel.TORQUES, TorqueSetpoint((0.1, -0.2, 0.05), 0.55), [
        {"timestamp_sample": STAMP, "xyz": (0.1, -0.2, 0.05)}, {"timestamp_sample": STAMP, **THRUST},
    ]),
    (OutputLevel.RATES, RateSetpoint((0.1, -0.2, 0.3), 0.55), [
        {"roll": 0.1, "pitch": -0.2, "yaw": 0.3, "thrust_body": (0.0, 0.0, -0.55)},
    ]),
    (OutputLevel.ATTITUDE, AttitudeSetpoint((0.8, 0.6, 0.0, 0.0), 0.55), [
        {"q_d": (0.8, 0.6, 0.0, 0.0), "thrust_body": (0.0, 0.0, -0.55)},
    ]),
]  # fmt: skip


@pytest.mark.parametrize(("level", "setpoint", "values"), CASES, ids=[level.value for level, _, _ in CASES])
@pytest.mark.parametrize("with_mode", [True, False], ids=["mode", "no mode"])
@pytest.mark.parametrize("before_versions", [False, True], ids=["main", "1.15"])
def test_it_is_what_its_samples_make(
    level: OutputLevel, setpoint: Setpoint, values: list[dict[str, Any]], with_mode: bool, before_versions: bool
) -> None:
    names = [*([MODE] if with_mode else []), *TOPICS[level]]
    told = [*([{FLAG[level]: True}] if with_mode else []), *values]
    readers = [Reader(Topic(name, 0, True), k, bytes((0, k, 0x80, k))) for k, name in enumerate(names)]
    layouts: list[Layout] = [LAYOUTS[name, 0] for name in names]
    if before_versions and level is OutputLevel.ATTITUDE:
        layouts[-1] = ATTITUDE_1_15
    message = CommandMessage(level, 0x81, readers, layouts)
    for sequence in (0, 65535):
        samples = [
            (reader.ids, layout.encode(**each)) for reader, layout, each in zip(readers, layouts, told, strict=True)
        ]
        assert message.encode(sequence, setpoint, STAMP) == wire.encode_samples(0x81, sequence, samples)
