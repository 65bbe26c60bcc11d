"""What steering learned in flight: recorded, drawn, and the same when the record is fed again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.lib.recfunctions import repack_fields

from companion.flight.phases import Phase
from companion.record.replay import load_flight, replay
from companion.record.report import write_report
from companion.record.report.palette import PHASES
from companion.record.table import load_table
from companion.vehicle import OutputLevel
from tests.support.flights import flight

pytestmark = pytest.mark.xdist_group("report_estimates")

LEARNED = ("pace", "thrust_scale", "drag", "push_north", "delay", "rate_lag", "motor_lag")


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rates") / "flight"
    flight(vehicle="sih", level=OutputLevel.RATES, duration=2.5, record=folder)
    return folder


def test_estimates_are_recorded_and_replayed(flown: Path) -> None:
    assert replay(load_flight(flown)).difference is None
    table = load_table(flown / "flight.npy")
    followed = table[(table["phase"] == list(Phase).index(Phase.FOLLOW)) & np.isfinite(table["alpha"])]
    assert len(followed) > 200
    assert 0.9 < followed["thrust_scale"][-1] < 1.1
    assert followed["drag"][-1] == pytest.approx(1.0, abs=0.5)
    assert np.max(np.abs(followed["push_north"])) < 1.0
    assert (followed["rate_lag"] > 0.0).all()
    assert (followed["motor_lag"] > 0.0).all()
    assert (followed["pace"] <= 1.0).all()
    assert (followed["setpoint"] == 2).all()


def test_they_have_their_figures(flown: Path) -> None:
    page = write_report(flown).read_text(encoding="utf-8")
    assert "What it learned about the vehicle" in page
    assert 'id="figure-machine"' in page
    assert 'id="figure-surroundings"' in page
    assert "Body rate p, deg/s" in page
    assert ">rate loop<" in page and ">motors<" in page


def test_a_record_from_before_them_still_has_its_page(flown: Path) -> None:
    whole = np.load(flown / "flight.npy")
    try:
        older = [name for name in whole.dtype.names if name not in LEARNED]
        np.save(flown / "flight.npy", repack_fields(whole[older]))
        assert "What it learned" not in write_report(flown).read_text(encoding="utf-8")
    finally:
        np.save(flown / "flight.npy", whole)


def test_every_phase_has_its_colour() -> None:
    assert set(PHASES) == {phase.value for phase in Phase}
