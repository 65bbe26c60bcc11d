"""Others who speak to the companion: a second vehicle, a copy of ours, another companion; what each says, and when."""

from __future__ import annotations

from companion import mavlink_common as mav
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.mavlink.modes import Mode
from companion.world.events import Order, Saying, Stranger

HEARTBEAT, CURRENT_MODE, ODOMETRY = message("HEARTBEAT"), message("CURRENT_MODE"), message("ODOMETRY")
PERIOD_US = {Saying.HEARTBEAT: 1_000_000, Saying.MODE: 100_000, Saying.STATE: 20_000}
"""us between two of what a stranger says: PX4's heartbeat, and what a companion asks for (engineering choice)."""
MAVLINK_VERSION = 3
"""HEARTBEAT's field, by the specification."""
MODES = {
    Order.HOLD: Mode.HOLD,
    Order.LAND: Mode.LAND,
    Order.RETURN: Mode.RETURN,
    Order.POSITION: Mode.POSITION,
    Order.ALTITUDE: Mode.ALTITUDE,
    Order.STABILIZED: Mode.STABILIZED,
    Order.MISSION: Mode.MISSION,
    Order.OFFBOARD: Mode.OFFBOARD,
    Order.TAKE_OFF: Mode.TAKEOFF,
}
"""The mode an order asks for."""
FIRST_STRANGER = 2
"""The bridge's endpoints from here on are those of strangers with a port of their own."""
CHANGED_PORT = 1000
"""Beyond every endpoint's number: the vehicle's later ports to the companion."""


def source(endpoint: int, ports_dialled: int) -> int:
    """The number that what comes from an endpoint has for a source in lockstep, where there are no sockets."""
    return CHANGED_PORT + ports_dialled if ports_dialled and endpoint == 0 else endpoint


class Speaker:
    """A stranger at work."""

    def __init__(self, who: Stranger) -> None:
        self.who = who
        self._encoder = Encoder(who.system, who.component)
        self._due_us = dict.fromkeys(sorted(who.says, key=lambda saying: saying.value), 0)

    def speak(self, now_us: int, boot_us: int) -> list[bytes]:
        """The datagrams due at ``now_us`` of the bridge's clock; ``boot_us``: what its stamps say."""
        due = [saying for saying, at_us in self._due_us.items() if at_us <= now_us]
        for saying in due:
            self._due_us[saying] = now_us + PERIOD_US[saying]
        return [self._datagram(saying, boot_us) for saying in due]

    def _datagram(self, saying: Saying, boot_us: int) -> bytes:
        who = self.who
        mode = MODES[who.mode].custom_mode
        if saying is Saying.HEARTBEAT:
            armed = mav.MAV_MODE_FLAG_SAFETY_ARMED if who.armed else 0
            return self._encoder.message(
                HEARTBEAT, custom_mode=mode, type=who.type, autopilot=who.autopilot,
                base_mode=mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | armed,
                system_status=mav.MAV_STATE_ACTIVE if who.armed else mav.MAV_STATE_STANDBY,
                mavlink_version=MAVLINK_VERSION,
            )  # fmt: skip
        if saying is Saying.MODE:
            return self._encoder.message(CURRENT_MODE, custom_mode=mode, intended_custom_mode=mode)
        x, y, z = who.position_n
        return self._encoder.message(
            ODOMETRY, time_usec=boot_us, frame_id=mav.MAV_FRAME_LOCAL_NED, child_frame_id=mav.MAV_FRAME_LOCAL_NED,
            q=(1.0, 0.0, 0.0, 0.0), x=x, y=y, z=z,
        )  # fmt: skip
