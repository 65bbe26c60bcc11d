"""What was once seen to go wrong on a link that is dirty in an ordinary way, and the cases of the deck that hold it."""

from __future__ import annotations

SEEN: dict[str, tuple[str, ...]] = {
    "every datagram twice, or only ODOMETRY, also 3 or 15 ms later": (
        "every datagram twice", "every datagram twice, 3 ms later", "every datagram twice, 15 ms later",
        "ODOMETRY twice", "ODOMETRY twice, 3 ms later", "ODOMETRY twice, 15 ms later",
    ),
    "stamps always 0, or in ms": (
        "stamps always 0", "stamps always 0, on the ground", "stamps in ms", "stamps in ms, on the ground",
    ),
    "the last ODOMETRY again for ever": (
        "the last ODOMETRY again for ever", "the last ODOMETRY again for ever at motors, and PX4 lands",
        "the last ODOMETRY again for ever, while settling",
    ),
    "the state later and later, no gap": (
        "the state later and later, 0.1 s a second", "only ODOMETRY later and later, 0.1 s a second",
    ),
    "120 or 150 ms each way from the start": (
        "120 ms each way from the start", "120 ms each way from the start, on the ground",
        "150 ms each way from the start",
    ),
    "the downlink lost in take-off, the operator lands": (
        "the operator's land in take off, the downlink cut 1.1 s before",
    ),
    "the downlink lost in abort, hand back, land, arm; the operator lands, holds, disarms": (
        "the operator lands in abort, the downlink cut",
        "the operator's land in hand back, the downlink cut 1.1 s before",
        "the operator's hold in land, the downlink cut",
        "the operator disarms 60 ms after the arming, the downlink cut",
    ),
    "the operator disarms 60 ms after ARM was accepted, the link whole": (
        "the operator disarms 60 ms after the arming", "the operator disarms 0.6 s after the arming",
    ),
    "OFFBOARD lost on the way up, the operator lands": ("OFFBOARD is lost on the way up, the operator lands",),
    "HEARTBEAT and CURRENT_MODE silent, the operator lands": (
        "HEARTBEAT and CURRENT_MODE silent, the operator lands", "CURRENT_MODE silent, the operator lands",
    ),
    "strangers on another port; a companion of another system": (
        "another port, our ids in flight: heartbeats", "another port, our ids in flight: states 50 m away",
        "another port, our ids in flight: everything", "another port, system 2 in flight: everything",
        "the vehicle's port, a companion of system 9 in flight: heartbeats",
        "another port, a companion of system 9 in flight: heartbeats",
    ),
    "a fixed wing or a rover": ("the vehicle is a fixed wing", "the vehicle is a rover"),
    "bytes cut anywhere into datagrams": (
        "bytes cut into datagrams of 77", "bytes cut into datagrams of 20",
        "bytes cut into datagrams of 77, from the ground",
    ),
    "no ODOMETRY, in another frame, no EXTENDED_SYS_STATE; 14 states a second": (
        "ODOMETRY never heard", "ODOMETRY in LOCAL_ENU", "EXTENDED_SYS_STATE never heard", "14 states a second",
    ),
    "an ODOMETRY of 3e38 m; stamps near 2^64": (
        "one ODOMETRY of 3e38 m", "one stamp near 2^64", "stamps near 2^64 from the middle of the path on",
    ),
    "position or attitude frozen but for 1e-6; a jump of 20 m without a count": (
        "position frozen but for 1e-6 of noise", "attitude frozen but for 1e-6 of noise",
        "a jump of 20 m without a count, believed by the vehicle", "a jump of 20 m without a count, only said",
    ),
    "COM_OF_LOSS_T 0.3": ("COM_OF_LOSS_T set to 0.3 already",),
    "one motor at 50 %": ("one motor at 50 %", "one motor at 50 %, joining"),
}  # fmt: skip
