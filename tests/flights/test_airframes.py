"""Unknown airframes with rough files, sensors that shake and wind: some of those that bench.airframes flies."""

from __future__ import annotations

import math

import pytest

from trials.airframes import drawn, flown

PATH_MOST, YAW_MOST = 0.06, math.radians(4.0)
"""m and rad RMS, believed, on the figure-eight at 3 m/s with its nose along the path, from 12 s of following on."""


@pytest.mark.parametrize("seed", range(0, 10, 2))
def test_an_airframe_that_nobody_knows_holds_path_and_nose(seed: int) -> None:
    result = flown(seed, duration=18.0, settle=12.0)
    assert result.reason is None, drawn(seed).words()
    assert result.believed is not None
    assert result.believed.path < PATH_MOST, drawn(seed).words()
    assert result.believed.yaw < YAW_MOST, drawn(seed).words()
