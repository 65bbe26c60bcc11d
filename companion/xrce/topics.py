"""PX4's topics as samples: the layout (CDR without a header) of exactly those that are spoken here, by MESSAGE_VERSION.

A topic's name on the wire is ``rt/NAMESPACE/fmu/in/NAME_vN`` (``out`` for what PX4 publishes); ``_vN`` is the message's
MESSAGE_VERSION where that is not 0. 1.15 has no versions yet, and one layout of its own. Layouts: msg/*.msg of
PX4 at its releases, read in its history (1.15 of 2024, 1.16 of spring 2025, main of 2 March 2026).
"""

from __future__ import annotations

import re
import struct
from typing import Any, NamedTuple

from companion.vehicle import CompanionError

_SIZES = {"Q": 8, "q": 8, "d": 8, "I": 4, "f": 4, "H": 2, "B": 1, "b": 1, "?": 1, "s": 1}
_FIELD = re.compile(r"(\w+):(\d*)(\w|\?)")
_NAME = re.compile(r"rt(?:/[A-Za-z0-9_]+)*/fmu/(in|out)/([a-z0-9_]+?)(?:_v(\d+))?")


class TopicError(CompanionError):
    """A topic that PX4 has in a layout that is not known here."""


class Topic(NamedTuple):
    """A topic's ``name`` and MESSAGE_VERSION. ``to_px4``: PX4 reads it, rather than publishes it."""

    name: str
    version: int
    to_px4: bool

    def wire_name(self, namespace: str = "") -> str:
        """The name on the wire. ``namespace``: such as ``px4_1``."""
        parts = ["rt", *([namespace] if namespace else []), "fmu", "in" if self.to_px4 else "out"]
        return "/".join([*parts, self.name + (f"_v{self.version}" if self.version else "")])


def parse(wire_name: str) -> Topic | None:
    """The topic of a name on the wire; None: it is none of PX4's."""
    found = _NAME.fullmatch(wire_name)
    return None if found is None else Topic(found[2], int(found[3] or 0), found[1] == "in")


class Layout:
    """A message's fields in order, ``NAME:COUNTcode`` each, with struct's letters; each aligned to its size.

    ``pack`` and ``unpack`` take and give the flat values: one a scalar, one an array element, one ``bytes`` a string.
    ``code``: as ``struct`` has it, without the byte order.
    """

    __slots__ = ("code", "fields", "pack", "size", "unpack_from", "zero")

    def __init__(self, text: str) -> None:
        code, at, flat = "", 0, 0
        self.fields: dict[str, int | slice] = {}
        for name, count, letter in _FIELD.findall(text):
            size, number = _SIZES[letter], int(count or 1)
            code += "x" * (-at % size) + count + letter
            at += -at % size + size * number
            values = 1 if letter == "s" else number
            self.fields[name] = slice(flat, flat + values) if values > 1 else flat
            flat += values
        packer = struct.Struct("<" + code)
        self.code = code
        self.size, self.pack, self.unpack_from = packer.size, packer.pack, packer.unpack_from
        self.zero = packer.unpack(bytes(packer.size))

    def encode(self, **values: Any) -> bytes:
        """A sample; fields left out are zero."""
        flat = list(self.zero)
        for name, value in values.items():
            flat[self.fields[name]] = value
        return self.pack(*flat)

    def decode(self, sample: bytes) -> dict[str, Any] | None:
        """The fields of a sample; None: it is too short. More than there is in the layout is not looked at."""
        if len(sample) < self.size:
            return None
        flat = self.unpack_from(sample)
        return {name: flat[where] for name, where in self.fields.items()}


_STAMPS = "timestamp:Q timestamp_sample:Q"
_VECTOR = f"{_STAMPS} xyz:3f"
_REGISTER = (
    "timestamp:Q request_id:Q name:25s px4_ros2_api_version:H register_arming_check:? register_mode:? "
    "register_mode_executor:? enable_replace_internal_mode:? replace_internal_mode:B activate_mode_immediately:?"
)
_REGISTERED = (
    "timestamp:Q request_id:Q name:25s px4_ros2_api_version:H success:? arming_check_id:b mode_id:b mode_executor_id:b"
)
_CHECK_REPLY = (
    "timestamp:Q request_id:B registration_id:B health_component_index:B health_component_is_present:? "
    "health_component_warning:? health_component_error:? can_arm_and_run:? num_events:B events:200s "
    "mode_req_angular_velocity:? mode_req_attitude:? mode_req_local_alt:? mode_req_local_position:? "
    "mode_req_local_position_relaxed:? mode_req_global_position:? {}mode_req_mission:? mode_req_home_position:? "
    "mode_req_prevent_arming:? mode_req_manual_control:?"
)
_CONTROL_MODE = (
    "timestamp:Q flag_armed:? flag_multicopter_position_control_enabled:? flag_control_manual_enabled:? "
    "flag_control_auto_enabled:? flag_control_offboard_enabled:? flag_control_position_enabled:? "
    "flag_control_velocity_enabled:? flag_control_altitude_enabled:? flag_control_climb_rate_enabled:? "
    "flag_control_acceleration_enabled:? flag_control_attitude_enabled:? flag_control_rates_enabled:? "
    "flag_control_allocation_enabled:? flag_control_termination_enabled:? source_id:B"
)
_STATUS = (  # its beginning: what follows differs between the versions and is of no use here
    "timestamp:Q armed_time:Q takeoff_time:Q arming_state:B latest_arming_reason:B latest_disarming_reason:B "
    "nav_state_timestamp:Q nav_state_user_intention:B nav_state:B"
)
_ATTITUDE = "yaw_sp_move_rate:f q_d:4f thrust_body:3f"

ATTITUDE_1_15 = Layout(f"timestamp:Q euler:3f {_ATTITUDE} reset_integral:? fw_control_yaw_wheel:?")
"""vehicle_attitude_setpoint of a PX4 that has no versions yet."""

LAYOUTS: dict[tuple[str, int], Layout] = {
    ("offboard_control_mode", 0): Layout(
        "timestamp:Q position:? velocity:? acceleration:? attitude:? body_rate:? thrust_and_torque:? direct_actuator:?"
    ),
    ("actuator_motors", 0): Layout(f"{_STAMPS} reversible_flags:H control:12f"),
    ("vehicle_torque_setpoint", 0): Layout(_VECTOR),
    ("vehicle_thrust_setpoint", 0): Layout(_VECTOR),
    ("vehicle_rates_setpoint", 0): Layout("timestamp:Q roll:f pitch:f yaw:f thrust_body:3f reset_integral:?"),
    ("vehicle_attitude_setpoint", 0): Layout(f"timestamp:Q {_ATTITUDE} reset_integral:? fw_control_yaw_wheel:?"),
    ("vehicle_attitude_setpoint", 1): Layout(f"timestamp:Q {_ATTITUDE}"),
    ("vehicle_control_mode", 0): Layout(_CONTROL_MODE),
    ("config_control_setpoints", 0): Layout(_CONTROL_MODE),
    ("vehicle_status", 0): Layout(_STATUS),
    ("vehicle_status", 1): Layout(_STATUS),
    ("vehicle_status", 2): Layout(_STATUS),
    ("register_ext_component_request", 0): Layout(_REGISTER),
    ("register_ext_component_request", 1): Layout(f"{_REGISTER} not_user_selectable:?"),
    ("register_ext_component_reply", 0): Layout(_REGISTERED),
    ("register_ext_component_reply", 1): Layout(f"{_REGISTERED} not_user_selectable:?"),
    ("unregister_ext_component", 0): Layout(
        "timestamp:Q name:25s arming_check_id:b mode_id:b mode_executor_id:b"
    ),
    ("arming_check_request", 0): Layout("timestamp:Q request_id:B"),
    ("arming_check_request", 1): Layout("timestamp:Q request_id:B valid_registrations_mask:I"),
    ("arming_check_reply", 0): Layout(_CHECK_REPLY.format("")),
    ("arming_check_reply", 1): Layout(_CHECK_REPLY.format("mode_req_global_position_relaxed:? ")),
    ("mode_completed", 0): Layout("timestamp:Q result:B nav_state:B"),
    ("timesync_status", 0): Layout(
        "timestamp:Q source_protocol:B remote_timestamp:Q observed_offset:q estimated_offset:q round_trip_time:I"
    ),
}  # fmt: skip
"""Every layout that is known, by the topic's name and its MESSAGE_VERSION."""


def layout(topic: Topic, *, versioned: bool) -> Layout:
    """The layout of a topic. ``versioned``: this PX4 numbers its messages (any of its topics has a ``_vN``), as it does
    from 1.16 on. TopicError: this version is not known here."""
    if topic.name == "vehicle_attitude_setpoint" and not versioned:
        return ATTITUDE_1_15
    found = LAYOUTS.get((topic.name, topic.version))
    if found is None:
        known = " and ".join(str(version) for name, version in sorted(LAYOUTS) if name == topic.name)
        raise TopicError(
            f"PX4 has {topic.name} in version {topic.version}, and version {known or 'none'} of it is known here; "
            "take a companion made for this PX4, or fly over MAVLink, without --xrce"
        )
    return found
