"""Where the vehicle is and what to do next: what Ctrl-C says."""

from __future__ import annotations

import pytest

from companion import pilot
from companion.daemon.conductor import Conductor
from companion.daemon.vehicle_words import describe_vehicle
from companion.flight.phases import Phase
from companion.vehicle import Fact, Landed, Mode, VehicleStatus
from tests.support.flights import Flown, flight, once


def said(armed: bool, mode: Mode, landed: Landed) -> VehicleStatus:
    """What a vehicle said, however long ago."""
    return VehicleStatus(Fact(armed, 0.0, 1.0), Fact(mode, 0.0, 1.0), landed=Fact(landed, 0.0, 1.0))


@pytest.fixture(scope="module")
def stopped() -> Flown:
    """A flight that was stopped in the air."""
    return flight(duration=None, meddle=once(2.0, lambda f: f.conductor.stop()))


def test_in_the_air(stopped: Flown) -> None:
    now = stopped.between.now
    words = describe_vehicle(stopped.conductor, now)
    assert words is not None
    assert words.startswith("the vehicle is in Hold, armed, 10.0 m above home and ")
    assert words.endswith(
        "m from it; it stays there until somebody takes it: by remote control or from a ground station"
    )
    late = describe_vehicle(stopped.conductor, now + 4.0)
    assert late is not None and ", last heard 4 s ago; " in late


@pytest.mark.parametrize(
    ("status", "place", "do"),
    [
        (said(True, Mode.OFFBOARD, Landed.IN_AIR), "Offboard, armed, 10", "select another mode now"),
        (said(True, Mode.LAND, Landed.LANDING), "in Land, armed, 10", "it flies by itself: watch it"),
        (said(True, Mode.HOLD, Landed.ON_GROUND), "armed, on the ground", "disarm it before anybody"),
        (said(False, Mode.HOLD, Landed.ON_GROUND), "disarmed, on the ground", "can be walked up to"),
        (VehicleStatus(), "in an unknown mode", "look at it, and take it by remote control"),
    ],
)
def test_each_place_has_its_advice(stopped: Flown, status: VehicleStatus, place: str, do: str) -> None:
    stopped.conductor.telemetry.status = status
    words = describe_vehicle(stopped.conductor, stopped.between.now)
    assert words is not None
    assert place in words and do in words.split("; ")[1]


def test_nobody_was_heard(stopped: Flown, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stopped.conductor.link, "identity", None)
    assert describe_vehicle(stopped.conductor, 0.0) is None


def test_a_stop_that_a_landing_answers_is_not_silence(stopped: Flown) -> None:
    conductor = Conductor(stopped.conductor.orders, None, 0.0)
    conductor.memory = pilot.begin(0.0)._replace(phase=Phase.LAND)
    conductor.stop()
    conductor.stop()
    assert conductor.notes == ["told to stop: land goes on to its end; a second time ends at once"]


def test_a_stop_after_the_flight_leaves_nothing_to_do_at_once(stopped: Flown) -> None:
    conductor, now = stopped.conductor, stopped.between.now
    assert conductor.done
    conductor.stop()
    conductor.on_timer(now)
    assert conductor.next_timer() > now
