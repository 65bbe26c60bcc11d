"""Flight modes that others bring over XRCE: registered, asked, selected, and what becomes of them."""

from __future__ import annotations

import pytest

from companion.mavlink.dialect import message
from companion.mavlink.modes import Mode
from tests.support.plant_client import REQUEST
from tests.support.xrce_agent import XrceClient, at_rates, check_reply, rates, registration, unregistration

FIRST = 23
"""NAVIGATION_STATE_EXTERNAL1."""


class Bringer(XrceClient):
    """Brings a mode, and answers for it while ``answers``."""

    def __init__(self) -> None:
        super().__init__()
        self.answers, self.can_run = True, True
        self._answered = 0
        self.connect()
        self.write(registration("Path"))
        self.run(0.1)

    def step(self) -> None:
        super().step()
        asked = self.samples.get("arming_check_request_v1", [])
        if len(asked) > self._answered:
            self._answered = len(asked)
            if self.answers:
                self.write(check_reply(asked[-1][1][8], 0, self.can_run))

    def turn(self) -> None:
        self.write(rates(0.0, 0.0, 0.4, self.bridge.autopilot.cascade.hover))


def test_a_mode_is_registered_asked_selected_and_taken_away() -> None:
    vehicle = Bringer()
    ((_, reply),) = vehicle.samples["register_ext_component_reply_v1"]
    assert reply[16:20] == b"Path"
    assert (reply[44], reply[45], reply[46], reply[47]) == (1, 0, FIRST, 255)
    assert vehicle.command(REQUEST, message("AVAILABLE_MODES").id, 0) == 0
    assert [mode["custom_mode"] for mode in vehicle.all("AVAILABLE_MODES") if mode["mode_name"] == "Path"] == [
        Mode.EXTERNAL1.custom_mode
    ]
    assert vehicle.mode(Mode.EXTERNAL1) == 0
    vehicle.write(at_rates(FIRST))
    vehicle.run(1.0, vehicle.turn)
    assert vehicle.flown is Mode.EXTERNAL1
    assert vehicle.bridge.truth.w_b[2] == pytest.approx(0.4, abs=0.1)
    status = vehicle.samples["vehicle_status_v2"][-1][1]
    assert status[41] == FIRST  # nav_state
    vehicle.write(unregistration("Path", 0, FIRST))
    vehicle.run(0.1)
    assert vehicle.flown is Mode.HOLD


def test_a_mode_that_says_it_cannot_be_flown_is_refused() -> None:
    vehicle = Bringer()
    vehicle.can_run = False
    vehicle.run(0.7)
    assert vehicle.mode(Mode.EXTERNAL1) == 1
    assert vehicle.mode(Mode.EXTERNAL2) == 1  # nobody brought it
    vehicle.can_run = True
    vehicle.run(0.7)
    assert vehicle.mode(Mode.EXTERNAL1) == 0


def test_a_silent_mode_is_left_after_a_second_and_its_last_setpoint_stands_until_then() -> None:
    vehicle = Bringer()
    vehicle.run(0.7)
    assert vehicle.mode(Mode.EXTERNAL1) == 0
    vehicle.write(at_rates(FIRST))
    vehicle.run(0.5, vehicle.turn)
    vehicle.answers = False
    took = vehicle.run_until(lambda: vehicle.flown is not Mode.EXTERNAL1, 3.0)
    assert 0.9 < took < 1.35
    assert vehicle.bridge.truth.w_b[2] == pytest.approx(0.4, abs=0.1)
    assert vehicle.flown is Mode.RETURN


def test_setpoints_that_stop_while_the_answers_come_are_missed_by_nobody() -> None:
    vehicle = Bringer()
    vehicle.run(0.7)
    assert vehicle.mode(Mode.EXTERNAL1) == 0
    vehicle.write(at_rates(FIRST))
    vehicle.run(0.5, vehicle.turn)
    vehicle.run(4.0)
    assert vehicle.flown is Mode.EXTERNAL1
