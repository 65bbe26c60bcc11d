"""Vehicle files that leave keys out: what no shipped file lacks must fly all the same.

A default of 0 that every shipped file writes over had once divided by zero in flight.
"""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

import companion
from companion.config.vehicle import VehicleModel

SIH = Path(__file__).resolve().parents[2] / "configs/vehicles/sih.yaml"
OPTIONAL = [name for name, field in VehicleModel.model_fields.items() if not field.is_required()]


def path_error(tmp_path: Path, output: str, *left_out: str) -> float:
    """cm RMS of a circle's first seconds in noise, with a file that lacks these keys."""
    keys = yaml.safe_load(SIH.read_text(encoding="utf-8"))
    file = tmp_path / "vehicle.yaml"
    file.write_text(yaml.safe_dump({key: value for key, value in keys.items() if key not in left_out}))
    flight = companion.simulate(
        "circle_r5", str(file), world="sih_noisy", output=output, duration=5.0, settle=2.0, seed=1
    )
    assert flight.summary["outcome"] == "completed", flight.summary["reason"]
    return 100.0 * float(flight.summary["settled"]["path_error_m"]["rms"])


@pytest.mark.parametrize("output", ["motors", "rates", "attitude"])
def test_a_file_of_what_must_be_given_flies(tmp_path: Path, output: str) -> None:
    assert path_error(tmp_path, output, *OPTIONAL) < 5.0


@pytest.mark.parametrize("key", OPTIONAL)
def test_every_key_may_be_left_out(tmp_path: Path, key: str) -> None:
    assert path_error(tmp_path, "rates", key) < 4.0
