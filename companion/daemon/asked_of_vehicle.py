"""What the daemon asks of the vehicle, as MAVLink commands: the flight's requests, and the streams it needs."""

from __future__ import annotations

from companion.daemon.ground import WANTED as GROUND_WANTED
from companion.flight.phases import Request
from companion.flight.situation import Answer
from companion.mavlink import link, requests, telemetry
from companion.mavlink.parameters import WANTED as PARAMETERS_WANTED
from companion.mavlink_common import MavResult
from companion.vehicle import Mode

WANTED = link.WANTED | telemetry.WANTED | PARAMETERS_WANTED | GROUND_WANTED
"""The messages that a companion looks at, by their ids."""
COMMANDS = {
    Request.ARM: requests.ARM,
    Request.DISARM: requests.DISARM,
    Request.TAKE_OFF: requests.AUTO_TAKE_OFF,
    Request.OFFBOARD: requests.set_mode(Mode.OFFBOARD),
    Request.HOLD: requests.set_mode(Mode.HOLD),
    Request.LAND: requests.AUTO_LAND,
    Request.RETURN: requests.set_mode(Mode.RETURN),
}
"""The command of each request of the flight."""


def streams(state_rate: float) -> tuple[requests.Command, ...]:
    """Asks for what a flight looks at; ``state_rate``: Hz of ODOMETRY. PX4 caps each at what it has."""
    return (
        requests.stream(telemetry.ODOMETRY.id, state_rate),
        requests.stream(telemetry.CURRENT_MODE.id, 20.0),
        requests.stream(telemetry.EXTENDED_SYS_STATE.id, 10.0),
        requests.stream(telemetry.ESTIMATOR_STATUS.id, 5.0),
        requests.stream(telemetry.BATTERY_STATUS.id, 1.0),
        requests.request(telemetry.GPS_GLOBAL_ORIGIN.id),
        requests.request(telemetry.HOME_POSITION.id),
    )


def answer_to(command: requests.Command, result: int) -> Answer | None:
    """The answer to a request of the flight that a MAV_RESULT is; None where the command is not one."""
    for request, known in COMMANDS.items():
        if known == command and result in set(MavResult):
            return Answer(request, MavResult(result))
    return None
