"""A MAVSDK client that knows nothing of the plant: python -m tests.sim_bridge.clients.with_mavsdk URL; its findings as JSON lines.

It is written as one would for a PX4 vehicle and flies everything MAVSDK offers a quadrotor.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable
from typing import Any

from mavsdk import Configuration, Mavsdk
from mavsdk.logging import log_subscribe
from mavsdk.plugins import action, events, geofence, info, mission, mission_raw, offboard, param, telemetry

PATIENCE = 60.0


def say(what: str, value: Any) -> None:
    print(json.dumps({what: value}), flush=True)


def wait(happens: Callable[[], bool]) -> bool:
    """Whether it happens before patience ends."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if happens():
            return True
        time.sleep(0.02)
    return False


class Flight:
    """A vehicle and the plugins it is flown with."""

    def __init__(self, system: Any) -> None:
        self.telemetry = telemetry.Telemetry(system)
        self.action = action.Action(system)
        self.offboard = offboard.Offboard(system)
        self.param = param.Param(system)
        self.mission = mission.Mission(system)
        self.raw = mission_raw.MissionRaw(system)
        self.fence = geofence.Geofence(system)
        self.info = info.Info(system)
        self.events = events.Events(system)

    @property
    def place(self) -> tuple[float, float, float]:
        now = self.telemetry.position_velocity_ned()
        return (now.position.north_m, now.position.east_m, now.position.down_m)

    @property
    def velocity(self) -> tuple[float, float, float]:
        now = self.telemetry.position_velocity_ned()
        return (now.velocity.north_m_s, now.velocity.east_m_s, now.velocity.down_m_s)

    def is_in(self, mode: str) -> bool:
        return bool(self.telemetry.flight_mode().name == mode)

    def is_near(self, north: float, east: float, down: float, within: float = 0.7) -> bool:
        return math.dist(self.place, (north, east, down)) < within

    def may_arm(self) -> bool:
        """Whether the health report lets the vehicle be armed as it is."""
        try:
            return bool(self.events.get_health_and_arming_checks_report().current_mode_intention.can_arm_or_run)
        except events.EventsError:
            return False

    def refused(self, call: Callable[[], Any]) -> str:
        """The result somebody is refused with."""
        try:
            call()
        except (action.ActionError, offboard.OffboardError, param.ParamError) as error:
            return str(error.result.name if hasattr(error.result, "name") else error.result)
        return "not refused"

    def ground(self) -> None:
        say("armed too early", self.refused(self.action.arm))
        say("healthy", wait(self.telemetry.health_all_ok))
        say("may arm", wait(self.may_arm))
        say("identity", self.info.get_version().flight_sw_major)
        every = self.param.get_all_params()
        say("parameters", len(every.int_params) + len(every.float_params))
        self.param.set_param_float("MIS_TAKEOFF_ALT", 6.0)
        self.param.set_param_int("COM_OBL_RC_ACT", 5)
        say("set", [self.param.get_param_float("MIS_TAKEOFF_ALT"), self.param.get_param_int("COM_OBL_RC_ACT")])
        say("unknown parameter", self.refused(lambda: self.param.get_param_float("NOT_THERE")))
        say("battery", self.telemetry.battery().remaining_percent)
        say("home known", wait(lambda: abs(self.telemetry.home().latitude_deg - 47.397742) < 1e-4))

    def plans(self) -> None:
        home = self.telemetry.home()
        point = geofence.Point
        metre = 1.0 / 111_194.9
        corners = [
            point(home.latitude_deg + n * 60.0 * metre, home.longitude_deg + e * 90.0 * metre)
            for n, e in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        inside = geofence.FenceType.INCLUSION
        circle = geofence.Circle(point(home.latitude_deg, home.longitude_deg), 80.0, inside)
        self.fence.upload_geofence(geofence.GeofenceData([geofence.Polygon(corners, inside)], [circle]))
        say("fence back", len(self.raw.download_geofence()))
        legs = [(15.0, 0.0, 8.0, 3.0), (15.0, 20.0, 8.0, 5.0)]
        items = [self._item(home.latitude_deg + n * metre, home.longitude_deg + e * 1.48 * metre, up, speed)
                 for n, e, up, speed in legs]  # fmt: skip
        self.mission.upload_mission(mission.MissionPlan(items))
        say("mission back", len(self.mission.download_mission().mission_items))

    def _item(self, latitude: float, longitude: float, up: float, speed: float) -> Any:
        nothing = math.nan
        return mission.MissionItem(
            latitude, longitude, up, speed, True, nothing, nothing, mission.MissionItem.CameraAction.NONE, nothing,
            nothing, 1.0, nothing, nothing, mission.MissionItem.VehicleAction.NONE,
        )  # fmt: skip

    def up_and_about(self) -> None:
        self.action.arm()
        self.action.takeoff()
        say("took off", wait(lambda: self.is_in("HOLD") and self.place[2] < -5.0))
        say("in air", self.telemetry.in_air())
        home = self.telemetry.home()
        north = home.latitude_deg + 10.0 / 111_194.9
        self.action.goto_location(north, home.longitude_deg, home.absolute_altitude_m + 8.0, 90.0)
        say("went there", wait(lambda: self.is_near(10.0, 0.0, -8.0)))
        say("heading", wait(lambda: abs(self.telemetry.heading().heading_deg - 90.0) < 3.0))

    def outside(self) -> None:
        """Every kind of offboard setpoint."""
        kinds = self.offboard
        say("no setpoint", self.refused(kinds.start))
        kinds.set_position_ned(offboard.PositionNedYaw(0.0, 0.0, -8.0, 0.0))
        kinds.start()
        say("offboard", wait(lambda: self.is_in("OFFBOARD")))
        say("position", wait(lambda: self.is_near(0.0, 0.0, -8.0)))
        kinds.set_velocity_ned(offboard.VelocityNedYaw(2.0, 0.0, 0.0, 0.0))
        say("velocity", wait(lambda: self.velocity[0] > 1.4))
        kinds.set_velocity_body(offboard.VelocityBodyYawspeed(0.0, 2.0, 0.0, 0.0))
        say("velocity of the body", wait(lambda: self.velocity[1] > 1.3))
        kinds.set_position_velocity_ned(
            offboard.PositionNedYaw(5.0, 0.0, -10.0, 0.0), offboard.VelocityNedYaw(0.0, 0.0, 0.0, 0.0)
        )
        say("position and velocity", wait(lambda: self.is_near(5.0, 0.0, -10.0)))
        kinds.set_acceleration_ned(offboard.AccelerationNed(0.0, 1.5, 0.0))
        say("acceleration", wait(lambda: self.velocity[1] > 0.7))
        home = self.telemetry.home()
        above_home = offboard.PositionGlobalYaw.AltitudeType.REL_HOME
        kinds.set_position_global(
            offboard.PositionGlobalYaw(home.latitude_deg, home.longitude_deg, 9.0, 0.0, above_home)
        )
        say("global position", wait(lambda: self.is_near(0.0, 0.0, -9.0)))
        kinds.set_attitude(offboard.Attitude(0.0, -10.0, 0.0, 0.5))
        say("attitude", wait(lambda: self.velocity[0] > 0.5))
        kinds.set_attitude_rate(offboard.AttitudeRate(0.0, 0.0, 40.0, 0.49))
        body = self.telemetry.attitude_angular_velocity_body
        say("rates", wait(lambda: body().yaw_rad_s > 0.4))
        kinds.set_velocity_ned(offboard.VelocityNedYaw(0.0, 0.0, 0.0, 0.0))
        time.sleep(0.5)
        kinds.stop()
        say("hold", wait(lambda: self.is_in("HOLD")))

    def planned(self) -> None:
        self.mission.start_mission()
        say("mission finished", wait(self.mission.is_mission_finished))
        say("mission progress", self.mission.mission_progress().current)
        say("where it ends", wait(lambda: self.is_near(15.0, 20.0, -8.0, 2.0)))
        self.action.land()
        say("landing", wait(lambda: self.is_in("LAND")))
        say("disarmed", wait(lambda: not self.telemetry.armed()))
        self.mission.clear_mission()
        self.fence.clear_geofence()
        say("cleared", len(self.raw.download_mission()))


def main(url: str) -> None:
    log_subscribe(lambda *_: True)
    sdk = Mavsdk(Configuration.create_manual(1, 191, True))
    try:
        say("connected", str(sdk.add_any_connection(url)))
        system = sdk.first_autopilot(20.0)
        say("discovered", system is not None)
        flight = Flight(system)
        for part in (flight.ground, flight.plans, flight.up_and_about, flight.outside, flight.planned):
            part()
    finally:
        sdk.destroy()


if __name__ == "__main__":
    main(sys.argv[1])
