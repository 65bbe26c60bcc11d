"""The numbers of MAVLink's common.xml: each as pymavlink's tables have it."""

from __future__ import annotations

import enum

import pytest
from pymavlink.dialects.v20 import development as tables

from companion import mavlink_common
from companion.mavlink_common import MavMissionResult, MavResult, MavSeverity

NOT_IN_THE_TABLES = {"MAV_CMD_EXTERNAL_ATTITUDE_ESTIMATE", "MAV_PROTOCOL_CAPABILITY_SET_ACTUATOR_TARGET"}
"""Newer or older than the tables: from the MAVLink specification and PX4."""
NUMBERS = {name: value for name, value in vars(mavlink_common).items() if name.startswith("MAV_")}


@pytest.mark.parametrize("name", sorted(set(NUMBERS) - NOT_IN_THE_TABLES))
def test_a_number_is_the_tables(name: str) -> None:
    assert getattr(tables, name) == NUMBERS[name]


@pytest.mark.parametrize(
    ("kind", "prefix", "newer"),
    [
        (MavResult, "MAV_RESULT_", {"CANCELLED", "COMMAND_UNSUPPORTED_MAV_FRAME"}),
        (MavSeverity, "MAV_SEVERITY_", set()),
        (MavMissionResult, "MAV_MISSION_", set()),
    ],
)
def test_an_enum_is_the_tables(kind: type[enum.IntEnum], prefix: str, newer: set[str]) -> None:
    for member in kind:
        assert member.name in newer or getattr(tables, prefix + member.name) == member
