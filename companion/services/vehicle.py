"""A vehicle over MAVSDK, for what may take its time: parameters, rates, place, geofence and curve."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from companion.fence import Circle, Fence, Polygon
from companion.frames import Vec3
from companion.geodesy import LocalFrame
from companion.mavlink_common import (
    MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION,
    MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
    MAV_CMD_NAV_WAYPOINT,
    MAV_FRAME_GLOBAL_INT,
    MAV_MISSION_TYPE_FENCE,
    MAV_MISSION_TYPE_MISSION,
)
from companion.places.origins import VehicleLocation
from companion.vehicle import CompanionError

RATE_ASKED = 100.0
"""Hz of ODOMETRY that preflight asks for."""
RATE_OVER = 1.5
"""s over which the rate of ODOMETRY is measured."""
HEARTBEAT_WITHIN = 10.0
"""s for a first heartbeat, which comes every second."""
IDENTITY_WITHIN = 3.0
"""s for a vehicle's AUTOPILOT_VERSION (engineering choice)."""
PLACE_WITHIN = 15.0
"""s for a place (engineering choice)."""


class ServiceError(CompanionError):
    """The vehicle did not do, or not say, what was asked of it."""


class NoVehicleHeardError(ServiceError):
    """No autopilot was heard."""


@dataclass(frozen=True)
class ConnectedVehicle:
    """One vehicle that was found. ``system``: MAVSDK's."""

    system: Any

    def parameters(self) -> dict[str, float]:
        """Every parameter by name."""
        from mavsdk.plugins.param import Param, ParamError

        try:
            every = Param(self.system).get_all_params()
        except ParamError as error:
            raise ServiceError(f"the vehicle does not answer for its parameters: {error}") from None
        return {each.name: each.value for each in (*every.int_params, *every.float_params)}

    def identity(self) -> str:
        """What it says it is: the firmware's version and the hardware's uid."""
        from mavsdk.plugins.info import Info, InfoError

        told = Info(self.system)
        ends = time.monotonic() + IDENTITY_WITHIN
        while True:
            try:
                version, uid = told.get_version(), told.get_identification().hardware_uid
            except InfoError:
                if time.monotonic() > ends:
                    return "PX4 of unknown version"
                time.sleep(0.2)
                continue
            number = f"{version.flight_sw_major}.{version.flight_sw_minor}.{version.flight_sw_patch}"
            named = f", uid {uid}" if uid.strip("0") else ""  # PX4's simulation says zeros
            return f"PX4 {number}, git {version.flight_sw_git_hash}{named}"

    def state_rate(self) -> float:
        """Hz of ODOMETRY that arrive when RATE_ASKED are asked for."""
        from mavsdk.plugins.telemetry import Telemetry, TelemetryError

        telemetry = Telemetry(self.system)
        arrived = [0]

        def count(*_: Any) -> None:
            arrived[0] += 1

        try:
            telemetry.set_rate_odometry(RATE_ASKED)
        except TelemetryError:
            return 0.0
        handle = telemetry.subscribe_odometry(count)
        time.sleep(RATE_OVER)
        telemetry.unsubscribe_odometry(handle)
        return arrived[0] / RATE_OVER

    def location(self) -> VehicleLocation:
        """Where it is. ServiceError: it does not know."""
        from mavsdk.plugins.telemetry import LandedState, Telemetry, TelemetryError

        telemetry = Telemetry(self.system)
        ends = time.monotonic() + PLACE_WITHIN
        while True:
            try:
                origin = telemetry.get_gps_global_origin()
                break
            except TelemetryError:
                if time.monotonic() > ends:
                    message = "the vehicle does not say where its local frame is (GPS_GLOBAL_ORIGIN); wait for its GPS"
                    raise ServiceError(message) from None
                time.sleep(0.5)
        frame = LocalFrame(origin.latitude_deg, origin.longitude_deg, origin.altitude_m)
        _wait(lambda: math.isfinite(telemetry.home().latitude_deg), 3.0)
        _wait(lambda: math.isfinite(telemetry.position_velocity_ned().position.north_m), 3.0)
        _wait(lambda: telemetry.landed_state() != LandedState.UNKNOWN, 5.0)
        home, place = telemetry.home(), telemetry.position_velocity_ned().position
        if not math.isfinite(place.north_m):
            raise ServiceError("the vehicle does not know where it is; wait for its GPS")
        known = math.isfinite(home.latitude_deg)
        return VehicleLocation(
            (place.north_m, place.east_m, place.down_m),
            telemetry.landed_state() == LandedState.ON_GROUND,
            frame,
            (home.latitude_deg, home.longitude_deg, home.absolute_altitude_m) if known else None,
        )

    def read_plan(self, text: str) -> Any:
        """A QGroundControl plan as MAVSDK reads it. ServiceError: it does not."""
        from mavsdk.plugins.mission_raw import MissionRaw, MissionRawError

        try:
            return MissionRaw(self.system).import_qgroundcontrol_mission_from_string(text)
        except MissionRawError as error:
            raise ServiceError(f"MAVSDK cannot read the plan: {error}") from None

    def upload(self, points: Sequence[Vec3], fence: Fence | None, frame: LocalFrame) -> None:
        """Put a curve into its mission and a fence into its geofence. ServiceError: it took one of them not."""
        from mavsdk.plugins.mission_raw import MissionRaw, MissionRawError

        raw = MissionRaw(self.system)
        try:
            raw.upload_mission(
                [
                    _item(i, MAV_CMD_NAV_WAYPOINT, MAV_MISSION_TYPE_MISSION, frame.to_global(p))
                    for i, p in enumerate(points)
                ]
            )
            if fence is not None:
                raw.upload_geofence(fence_items(fence, frame))
        except MissionRawError as error:
            raise ServiceError(f"the vehicle did not take the curve or the fence: {error}") from None


@contextmanager
def connect_vehicle(url: str) -> Iterator[ConnectedVehicle]:
    """The vehicle at an address. ServiceError: it cannot be opened; NoVehicleHeardError: nobody is heard there."""
    from mavsdk import ComponentType, Configuration, Mavsdk
    from mavsdk.connection_result import ConnectionResult
    from mavsdk.logging import log_subscribe

    log_subscribe(lambda *_: True)  # it would write to stdout
    # a ground station, not a companion: another companion on the link is refused by ``fly``
    sdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    try:
        result = sdk.add_any_connection(url)
        if result != ConnectionResult.SUCCESS:
            raise ServiceError(f"{url} cannot be opened ({result}); is it in use by another program?")
        system = sdk.first_autopilot(HEARTBEAT_WITHIN)
        if system is None:
            raise NoVehicleHeardError(
                f"no vehicle: no autopilot was heard on {url} within {HEARTBEAT_WITHIN:g} s; is it on, and does it "
                "send here?"
            )
        yield ConnectedVehicle(system)
    finally:
        sdk.destroy()


def fence_items(fence: Fence, frame: LocalFrame) -> list[Any]:
    """The geofence as mission items; coordinates of ``fence`` are those of the local frame."""
    items: list[Any] = []
    for area in fence.areas:
        corners = area.corners if isinstance(area, Polygon) else (area.center,)
        if isinstance(area, Circle):
            kind, first = (
                (MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION if area.inside else MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION),
                area.radius,
            )
        else:
            kind, first = (
                (
                    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
                    if area.inside
                    else MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION
                ),
                float(len(corners)),
            )
        for north, east in corners:
            items.append(_item(len(items), kind, MAV_MISSION_TYPE_FENCE, frame.to_global((north, east, 0.0)), first))
    return items


def _item(number: int, command: int, kind: int, place: tuple[float, float, float], first: float = 0.0) -> Any:
    from mavsdk.plugins.mission_raw import MissionItem

    latitude, longitude, altitude = place
    x, y = round(latitude * 1e7), round(longitude * 1e7)
    current = int(number == 0 and kind == MAV_MISSION_TYPE_MISSION)
    return MissionItem(
        number, MAV_FRAME_GLOBAL_INT, command, current, 1, first, 0.0, 0.0, math.nan, x, y,
        altitude if kind == MAV_MISSION_TYPE_MISSION else 0.0, kind,
    )  # fmt: skip


def _wait(happens: Any, patience: float) -> None:
    ends = time.monotonic() + patience
    while not happens() and time.monotonic() < ends:
        time.sleep(0.05)
