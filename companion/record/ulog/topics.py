"""Which of PX4's topics are laid beside our record, column by column."""

from __future__ import annotations

from typing import NamedTuple

BODY_RATES = "vehicle_angular_velocity"
"""The topic that the clocks are compared by."""
SAMPLED, PUBLISHED = "timestamp_sample", "timestamp"
"""When the sensors were read, which is what ODOMETRY is stamped with; when a setpoint was published."""


class Column(NamedTuple):
    """``field``: PX4's name of it in the log. ``name``, ``unit``, ``meaning``: ours."""

    field: str
    name: str
    unit: str
    meaning: str


class Topic(NamedTuple):
    """``name``: PX4's. ``stamp``: the field with its time, us."""

    name: str
    stamp: str
    columns: tuple[Column, ...]


def _many(field: str, names: str, unit: str, meaning: str) -> tuple[Column, ...]:
    return tuple(Column(f"{field}[{i}]", name, unit, meaning) for i, name in enumerate(names.split()))


THRUST = Column("thrust_body[2]", "thrust_z", "1", "thrust setpoint along the body's z axis, -1..0 pulls upwards")
TOPICS = (
    Topic("vehicle_local_position", SAMPLED, (
        Column("x", "north", "m", "PX4's estimate, local frame"),
        Column("y", "east", "m", "PX4's estimate, local frame"),
        Column("z", "down", "m", "PX4's estimate, local frame"),
        Column("vx", "v_north", "m/s", "PX4's estimate"),
        Column("vy", "v_east", "m/s", "PX4's estimate"),
        Column("vz", "v_down", "m/s", "PX4's estimate"),
        Column("heading", "heading", "rad", "PX4's estimate, clockwise from north"),
    )),
    Topic("vehicle_attitude", SAMPLED, _many("q", "q_w q_x q_y q_z", "1", "PX4's estimate, body FRD to NED")),
    Topic(BODY_RATES, SAMPLED, _many("xyz", "p q r", "rad/s", "gyro less its bias, body FRD")),
    Topic("vehicle_attitude_setpoint", PUBLISHED, (
        *_many("q_d", "q_w q_x q_y q_z", "1", "attitude setpoint, body FRD to NED"), THRUST,
    )),
    Topic("vehicle_rates_setpoint", PUBLISHED, (
        Column("roll", "p", "rad/s", "body rate setpoint"),
        Column("pitch", "q", "rad/s", "body rate setpoint"),
        Column("yaw", "r", "rad/s", "body rate setpoint"),
        THRUST,
    )),
    Topic("actuator_motors", PUBLISHED, _many("control", "motor_0 motor_1 motor_2 motor_3", "1", "command, 0..1")),
)  # fmt: skip
"""msg/*.msg of PX4 1.14 to 1.17; what a log lacks is left out."""
