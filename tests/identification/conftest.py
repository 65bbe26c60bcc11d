"""A log of the stand-in with PX4's own noise, and what is found in it: the fit takes seconds."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from companion.identification.from_log import Findings, identify
from companion.identification.ulog import read
from tests.support.ulog import logged
from trials.measured import machine, world

SIH_ACCELEROMETER = (0.5, 1.7, 1.4)
"""m/s^2: what PX4's simulation adds while armed (px4_noisy.md)."""


@pytest.fixture(scope="session")
def log_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = dataclasses.replace(world("sih_noisy"), wind_n=(2.0, -1.0, 0.0))
    file = tmp_path_factory.mktemp("log") / "flight.ulg"
    return logged(file, machine("sih"), where, speed=3.5, duration=25.0, accelerometer_std=SIH_ACCELEROMETER)


@pytest.fixture(scope="session")
def found(log_file: Path) -> Findings:
    with log_file.open("rb") as opened:
        return identify(read(opened, log_file.name))
