"""A pymavlink client that knows nothing of the plant: python -m tests.sim_bridge.clients.with_pymavlink URL; findings as JSON lines.

mavutil as people's scripts use it: as a ground station, blocking, by name.
"""

from __future__ import annotations

import json
import math
import sys
import threading
import time
from typing import Any

from pymavlink import mavutil

PATIENCE = 60.0
MAV = mavutil.mavlink
HOME = (47.397742, 8.545594)


def say(what: str, value: Any) -> None:
    print(json.dumps({what: value}), flush=True)


class Flight:
    """A vehicle on a mavutil connection."""

    def __init__(self, url: str) -> None:
        self.link = mavutil.mavlink_connection(url, source_system=255, source_component=190)
        self.texts: list[str] = []
        self.link.message_hooks.append(self._note)
        threading.Thread(target=self._beat, daemon=True).start()
        say("heartbeat", self.link.wait_heartbeat(timeout=PATIENCE).autopilot)

    def _note(self, _: Any, message: Any) -> None:
        if message.get_type() == "STATUSTEXT":
            self.texts.append(message.text)

    def _beat(self) -> None:
        while True:
            self.link.mav.heartbeat_send(MAV.MAV_TYPE_GCS, MAV.MAV_AUTOPILOT_INVALID, 0, 0, 0)
            time.sleep(0.3)

    def ask(self, command: int, *parameters: float) -> int:
        """The result of a command."""
        given = (*parameters, *(0.0,) * (7 - len(parameters)))
        self.link.mav.command_long_send(1, 1, command, 0, *given)
        while True:
            answer = self.link.recv_match(type="COMMAND_ACK", blocking=True, timeout=5.0)
            if answer is None or answer.command == command:
                return -1 if answer is None else int(answer.result)

    def until(self, kind: str, condition: Any) -> bool:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            message = self.link.recv_match(type=kind, blocking=True, timeout=1.0)
            if message is not None and condition(message):
                return True
        return False

    def is_in(self, mode: str) -> bool:
        return self.until("HEARTBEAT", lambda m: m.get_srcSystem() == 1 and self.link.flightmode == mode)

    def heard(self, text: str) -> bool:
        """Whether it was said, or is within patience: a heartbeat may come before the words of the same moment."""
        return any(text in said for said in self.texts) or self.until("STATUSTEXT", lambda m: text in m.text)

    def parameters(self) -> None:
        """All of them; what UDP lost on a busy machine is asked for again, by index, as every ground station does."""
        self.link.param_fetch_all()
        names: dict[int, str] = {}
        count = None
        end = time.monotonic() + PATIENCE
        while (count is None or len(names) < count) and time.monotonic() < end:
            value = self.link.recv_match(type="PARAM_VALUE", blocking=True, timeout=2.0)
            if value is None:
                for index in set(range(count or 0)) - set(names):
                    self.link.mav.param_request_read_send(1, 1, b"", index)
            elif value.param_id != "_HASH_CHECK":
                names[value.param_index] = value.param_id
                count = value.param_count
        say("all parameters", len(set(names.values())) == count)
        self.link.param_set_send("RTL_RETURN_ALT", 12.0, MAV.MAV_PARAM_TYPE_REAL32)
        say("set", self.until("PARAM_VALUE", lambda m: m.param_id == "RTL_RETURN_ALT" and m.param_value == 12.0))

    def ready(self) -> None:
        say("ready", self.until("HEARTBEAT", lambda m: m.system_status == MAV.MAV_STATE_STANDBY))
        say("version", self.ask(MAV.MAV_CMD_REQUEST_MESSAGE, 148))
        say("faster", self.ask(MAV.MAV_CMD_SET_MESSAGE_INTERVAL, 32, 20_000))
        say("nonsense", self.ask(31000))

    def mission(self) -> None:
        legs = [(22, 0.0, 0.0), (16, 12.0, 0.0), (16, 12.0, 12.0)]
        self.link.waypoint_clear_all_send()
        say("cleared", self.link.recv_match(type="MISSION_ACK", blocking=True, timeout=5.0).type)
        self.link.waypoint_count_send(len(legs))
        for _ in legs:
            request = self.link.recv_match(type=["MISSION_REQUEST", "MISSION_REQUEST_INT"], blocking=True, timeout=5.0)
            command, north, east = legs[request.seq]
            x = HOME[0] + math.degrees(north / 6371000.0)
            y = HOME[1] + math.degrees(east / 6371000.0 / math.cos(math.radians(HOME[0])))
            self.link.mav.mission_item_int_send(
                1, 1, request.seq, 6, command, 0, 1, 0, 2.0 if command == 16 else 0, 0, math.nan, round(x * 1e7),
                round(y * 1e7), 7.0, 0,
            )  # fmt: skip
        say("uploaded", self.link.recv_match(type="MISSION_ACK", blocking=True, timeout=5.0).type)

    def fly(self) -> None:
        self.link.set_mode("MISSION")
        say("mode", self.is_in("MISSION"))
        self.link.arducopter_arm()
        self.link.motors_armed_wait()
        say("armed", bool(self.link.motors_armed()))
        say("reached", self.until("MISSION_ITEM_REACHED", lambda m: m.seq == 2))
        say("mode after", self.is_in("LOITER"))
        self.link.set_mode("RTL")
        say("returns", self.is_in("RTL"))
        self.link.motors_disarmed_wait()
        say("disarmed", not self.link.motors_armed())
        say("landed", self.heard("Landing detected"))
        say("armed text", self.heard("Armed by external command"))

    def offboard(self) -> None:
        self.link.set_mode("LOITER")
        say("loiter", self.is_in("LOITER"))
        say("arm", self.ask(MAV.MAV_CMD_COMPONENT_ARM_DISARM, 1))
        say("take off", self.ask(MAV.MAV_CMD_NAV_TAKEOFF, *(math.nan,) * 7))
        say("took off", self.is_in("LOITER"))
        say("no stream", self.ask(MAV.MAV_CMD_DO_SET_MODE, 1, 6, 0))
        end = time.monotonic() + PATIENCE
        asked, there = False, False
        while time.monotonic() < end and not there:
            self.link.mav.set_position_target_local_ned_send(
                0, 1, 1, MAV.MAV_FRAME_LOCAL_NED, 0b110111111000, -4.0, 0.0, -5.0, 0, 0, 0, 0, 0, 0, 0, 0
            )
            if not asked:
                say("offboard", self.ask(MAV.MAV_CMD_DO_SET_MODE, 1, 6, 0))
                asked = True
            where = self.link.recv_match(type="LOCAL_POSITION_NED", blocking=True, timeout=0.1)
            there = where is not None and math.dist((where.x, where.y, where.z), (-4.0, 0.0, -5.0)) < 0.7
        say("there", there)
        say("lost", self.is_in("RTL"))  # the stream has ended
        say("failsafe", self.heard("Failsafe activated"))
        say("land", self.ask(MAV.MAV_CMD_NAV_LAND, *(math.nan,) * 7))
        self.link.motors_disarmed_wait()
        say("down", True)


def main(url: str) -> None:
    flight = Flight(url)
    for part in (flight.parameters, flight.ready, flight.mission, flight.fly, flight.offboard):
        part()


if __name__ == "__main__":
    main(sys.argv[1])
