"""circle_r5 on the stand-in's PX4 and the vehicle sih, by a level over XRCE or by rates over MAVLink: its path error."""

from __future__ import annotations

import math

from companion.daemon.conductor import Conductor
from companion.library.lockstep import fly
from companion.vehicle import OutputLevel
from sim_bridge.plant import Truth
from trials.deaths import placed

SETTLED, DURATION, TIME_OUT = 8.0, 14.0, 60.0
"""s from the first setpoint until errors count, of the path, and of the whole at most."""


def path_error(level: OutputLevel, world: str, speed: float, seed: int = 0) -> float:
    """m, root mean square, the vehicle's own, in the same seconds of the same world at every level. ValueError: it was
    not flown."""
    bridge, conductor = placed(level, own_mode=False, duration=DURATION, speed=speed, world=world, seed=seed)
    errors: list[float] = []
    begun = math.inf

    def watch(conductor: Conductor, truth: Truth) -> None:
        nonlocal begun
        last = conductor.last
        if last is None or last.now != bridge.now or last.outcome.setpoint is None:
            return
        begun = min(begun, bridge.now)
        if bridge.now - begun > SETTLED and last.memory.path.progress is not None:
            errors.append(last.memory.path.progress.path_error)

    fly(conductor, bridge, watch, TIME_OUT)
    if bridge.now - begun < DURATION:
        raise ValueError(
            f"{level.value} at {speed:g} m/s in {world}: not flown: {conductor.refusal or conductor.notes}"
        )
    return math.sqrt(sum(error * error for error in errors) / len(errors))
