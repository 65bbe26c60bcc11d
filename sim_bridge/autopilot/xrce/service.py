"""The one service PX4 offers over XRCE: vehicle_command, answered with its acknowledgement. Here nobody serves it."""

from __future__ import annotations

from companion.xrce.objects import BINARY, PX4_PARTICIPANT, Create, Kind

NAMES = (
    "vehicle_command",
    "px4_msgs::srv::dds_::VehicleCommand_Request_",
    "px4_msgs::srv::dds_::VehicleCommand_Response_",
)
"""The service and the types of its request and its reply."""
TOPICS = ("rq/fmu/vehicle_commandRequest", "rr/fmu/vehicle_commandReply")
"""Where requests come from and replies go."""


def replier(request: int, number: int) -> Create:
    """The object that replies."""
    text = b""
    for name in NAMES:
        text = _append(text, name)
    for name in TOPICS:
        text = _append(text + b"\x01", name)
    return Create(request, number << 4 | Kind.REPLIER, Kind.REPLIER, BINARY, text, PX4_PARTICIPANT)


def _append(text: bytes, name: str) -> bytes:
    data = name.encode() + b"\0"
    return text + bytes(-len(text) % 4) + len(data).to_bytes(4, "little") + data
