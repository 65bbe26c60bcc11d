"""Who the vehicle is, what it can do, which mode it is in."""

from __future__ import annotations

from typing import NamedTuple

from companion import mavlink_common as mav
from companion.mavlink.dialect import message
from companion.mavlink.modes import Mode, mode_of
from companion.mavlink_common import (
    MAV_AUTOPILOT_PX4,
    MAV_TYPE_QUADROTOR,
)
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.flight_modes.setpoints import BELOW_ATTITUDE
from sim_bridge.autopilot.mavlink.files import GENERAL_METADATA, GENERAL_METADATA_URI
from sim_bridge.autopilot.messages.parts import Values

CAPABILITIES = 0xE8FF
"""MAV_PROTOCOL_CAPABILITY as PX4's simulation tells them."""
SET_ACTUATOR_TARGET = 0x0400
"""MAV_PROTOCOL_CAPABILITY_SET_ACTUATOR_TARGET: this autopilot takes motor commands."""
VERSION = 1 << 24 | 19 << 16  # 1.19.0, development
SYSTEM_VERSION = 6 << 24 | 1 << 16 | 255
"""Of the operating system: 6.1.0, a release."""
BUILD = (0, 0, 0, 0x52, 0x4F, 0x54, 0x4F, 0x52)
"""Where PX4 tells the hash of its build: a sign of the stand-in for those who look."""
UID = 0x5354_414E_4449_4E31
"""Of the vehicle; any number will do."""


def heartbeat(a: Autopilot) -> Values:
    """HEARTBEAT."""
    return (a.commander.mode.custom_mode, MAV_TYPE_QUADROTOR, MAV_AUTOPILOT_PX4, _base_mode(a), _system_status(a), 3)


def _base_mode(a: Autopilot) -> int:
    mode = a.commander.mode
    bits = mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | (mav.MAV_MODE_FLAG_SAFETY_ARMED if a.commander.armed else 0)
    by_hand, stabilized = mav.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED, mav.MAV_MODE_FLAG_STABILIZE_ENABLED
    if mode is Mode.OFFBOARD:
        return bits | (0 if a.setpoint is None or isinstance(a.setpoint, BELOW_ATTITUDE) else stabilized)
    if mode is Mode.ACRO:
        return bits | by_hand
    if mode is Mode.ORBIT:
        return bits | stabilized
    automatic = mav.MAV_MODE_FLAG_GUIDED_ENABLED | mav.MAV_MODE_FLAG_AUTO_ENABLED
    return bits | stabilized | (automatic if mode.main == 4 else by_hand)


def _system_status(a: Autopilot) -> int:
    """MAV_STATE: 0 not ready, 3 standing by, 4 active, 5 in a failsafe, 8 terminated."""
    if a.commander.mode is Mode.TERMINATION:
        return 8
    if a.commander.armed:
        return 4 if a.commander.failsafe is None else 5
    return 3 if a.commander.can_run(a.commander.mode, a.t) else 0


def autopilot_version(a: Autopilot) -> Values:
    """AUTOPILOT_VERSION; the capability to take motor commands is there exactly when they are taken."""
    return message("AUTOPILOT_VERSION").values(
        capabilities=CAPABILITIES | (SET_ACTUATOR_TARGET if a.direct else 0),
        uid=UID,
        flight_sw_version=VERSION,
        middleware_sw_version=VERSION,
        os_sw_version=SYSTEM_VERSION,
        board_version=1,
        flight_custom_version=BUILD,
        middleware_custom_version=BUILD,
    )


def protocol_version(a: Autopilot) -> Values:
    """PROTOCOL_VERSION: MAVLink 2."""
    return message("PROTOCOL_VERSION").values(version=200, min_version=100, max_version=203)


STANDARD_MODES = {
    Mode.POSITION: 1, Mode.ORBIT: 2, Mode.ALTITUDE: 4, Mode.RETURN: 5, Mode.MISSION: 6, Mode.LAND: 7, Mode.TAKEOFF: 8,
}  # fmt: skip
"""MAV_STANDARD_MODE; 0 for the others."""


def current_mode(a: Autopilot) -> Values:
    """CURRENT_MODE: what is flown, and what the operator meant."""
    mode = a.commander.mode
    return (mode.custom_mode, a.commander.user_intended_mode.custom_mode, STANDARD_MODES.get(mode, 0))


class Available(NamedTuple):
    """A row of AVAILABLE_MODES. ``properties``: 1 advanced, 2 not selectable by a user. Standard modes have no name."""

    main: int
    sub: int
    standard: int
    properties: int
    name: str


EXTERNAL_MODES = tuple(Available(4, sub, 0, 2, "(Mode not available)") for sub in range(11, 19))
"""PX4's external modes 1 to 8, as long as nobody has registered them."""
AVAILABLE = (
    Available(1, 0, 0, 1, "Manual"),
    Available(2, 0, 4, 0, ""),
    Available(3, 0, 1, 0, ""),
    Available(4, 4, 6, 1, ""),
    Available(4, 3, 0, 1, "Hold"),
    Available(4, 5, 5, 1, ""),
    Available(3, 2, 0, 1, "Position Slow"),
    Available(4, 19, 0, 1, "Guided Course"),
    Available(11, 0, 0, 1, "Altitude Cruise"),
    Available(5, 0, 0, 1, "Acro"),
    Available(4, 20, 0, 3, "Descend"),
    Available(10, 0, 0, 3, "Termination"),
    Available(6, 0, 0, 1, "Offboard"),
    Available(7, 0, 0, 1, "Stabilized"),
    Available(4, 2, 8, 1, ""),
    Available(4, 6, 7, 1, ""),
    Available(4, 8, 0, 1, "Follow Target"),
    Available(4, 9, 0, 1, "Precision Landing"),
    Available(3, 1, 2, 1, ""),
    Available(4, 10, 0, 1, "VTOL Takeoff"),
    *EXTERNAL_MODES,
)
"""What AVAILABLE_MODES lists, in its order."""


def available_mode(a: Autopilot, index: int) -> Values:
    """AVAILABLE_MODES number ``index``, counted from 1. A mode that somebody brought has his name."""
    mode = AVAILABLE[index - 1]
    brought = a.commander.external_modes.of(mode_of(mode.main << 16 | mode.sub << 24))
    if brought is not None:
        mode = mode._replace(properties=0, name=brought.name.rstrip(b"\0").decode("ascii", "replace"))
    return message("AVAILABLE_MODES").values(
        number_modes=len(AVAILABLE), mode_index=index, standard_mode=mode.standard,
        custom_mode=mode.main << 16 | mode.sub << 24, properties=mode.properties, mode_name=mode.name,
    )  # fmt: skip


def component_information(a: Autopilot) -> Values:
    """COMPONENT_INFORMATION: the old form of COMPONENT_METADATA."""
    return message("COMPONENT_INFORMATION").values(
        time_boot_ms=a.estimate.time_us // 1000,
        general_metadata_file_crc=GENERAL_METADATA.crc,
        general_metadata_uri=GENERAL_METADATA_URI,
    )


def component_metadata(a: Autopilot) -> Values:
    """COMPONENT_METADATA: where the description of the component lies."""
    return message("COMPONENT_METADATA").values(
        time_boot_ms=a.estimate.time_us // 1000, file_crc=GENERAL_METADATA.crc, uri=GENERAL_METADATA_URI
    )


def flight_information(a: Autopilot) -> Values:
    """FLIGHT_INFORMATION: nothing of it is kept."""
    return message("FLIGHT_INFORMATION").values(time_boot_ms=a.estimate.time_us // 1000)


def storage_information(a: Autopilot) -> Values:
    """STORAGE_INFORMATION: one store, ready, in MiB."""
    return message("STORAGE_INFORMATION").values(
        time_boot_ms=a.estimate.time_us // 1000, storage_id=1, storage_count=1, status=2,
        total_capacity=1024.0, used_capacity=0.0, available_capacity=1024.0,
    )  # fmt: skip
