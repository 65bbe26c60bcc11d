"""What was ordered and what the vehicle says of itself -> how this flight is conducted."""

from __future__ import annotations

from companion.flight.conduct import TILT_MARGIN, Conduct
from companion.frames import Vec3
from companion.paths.arc import ArcTable
from companion.vehicle import Tuning, Vehicle

FLOOR = 1.0
UNDER_THE_PATH = 0.5
"""m: the floor where none was ordered, and how far below the path it stays at least."""
SAMPLES = 200


def conducted(
    ordered: Conduct, vehicle: Vehicle, tuning: Tuning, table: ArcTable, home: Vec3 | None, stands_at: Vec3 | None
) -> Conduct:
    """``home``: of the vehicle, in its frame; ``stands_at``: where it stands if it does; None where not known."""
    limits = ordered.limits
    ground = home[2] if home is not None else stands_at[2] if stands_at is not None else None
    floor = limits.floor
    if floor is None and ground is not None:
        lowest = ground - max(float(point[2]) for point in table.samples(SAMPLES)[1])
        floor = min(FLOOR, lowest - UNDER_THE_PATH) if lowest > UNDER_THE_PATH else None
    tilt = None
    if vehicle.limits is not None:
        ends = (tuning.fail_roll, tuning.fail_pitch, vehicle.limits.failure_detector)
        tilt = min(angle for angle in ends if angle) - TILT_MARGIN
    return ordered._replace(
        limits=limits._replace(
            floor=floor,
            ground=ground,
            tilt=tilt if limits.tilt is None else limits.tilt,
            battery=tuning.battery_low or limits.battery,
            radius=tuning.fence_radius,
            height=tuning.fence_height,
            home=home,
        )
    )
