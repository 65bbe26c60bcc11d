"""Flights that an earlier version recorded: what can still be done with them, and what is said of the rest."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from companion.config.syntax.faults import ConfigError
from companion.record.replay import load_flight, replay


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("older") / "flight"
    words = [sys.executable, "-m", "companion", "sim", "circle_r5", "--output", "rates", "--duration", "0.5"]
    subprocess.run([*words, "--no-report", "--record", str(folder)], check=True, capture_output=True)
    resolved = json.loads((folder / "resolved.json").read_text(encoding="utf-8"))
    resolved["conduct"]["manner"] = resolved["conduct"].pop("authority")
    (folder / "resolved.json").write_text(json.dumps(resolved), encoding="utf-8")
    return folder


def test_the_old_name_of_authority_is_read(flown: Path) -> None:
    flight = load_flight(flown)
    assert flight.plan.conduct.authority.value == "companion"
    assert replay(flight).difference is None


def test_a_record_without_todays_columns_is_told_apart(flown: Path) -> None:
    flight = load_flight(flown)
    kept = [name for name in flight.table.dtype.names or () if name not in ("late", "asked")]
    older = dataclasses.replace(flight, table=np.array(flight.table)[kept])
    with pytest.raises(ConfigError, match=r"another version .*: 2 columns .* late among them"):
        replay(older)
