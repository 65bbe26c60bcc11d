"""The vehicle file against the autopilot's own account of the vehicle: rotors, their order, the thrust curve.

PX4's motor n sits where CA_ROTORn-1_PX and _PY say (m, body FRD; many airframes leave it at a shape, such as 1 and -1)
and turns as the sign of CA_ROTORn-1_KM says (positive: counter-clockwise seen from above). A motor command for another
rotor than was meant turns a vehicle over, so that what differs in shape or sense is a fault, not a note.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from companion.vehicle import Spin, Vehicle

SHAPE_AGREES = 0.15
"""Ratio to the mean arm, within which a rotor must sit where the vehicle file says. Engineering choice: no two
rotors of any quadrotor are nearer."""
COUNT, CURVE = "CA_ROTOR_COUNT", "THR_MDL_FAC"


def names(vehicle: Vehicle) -> tuple[str, ...]:
    """The parameters that are asked for."""
    rotors = range(len(vehicle.rotors))
    return (COUNT, CURVE, *(f"CA_ROTOR{n}_{part}" for n in rotors for part in ("PX", "PY", "KM")))


def differences(vehicle: Vehicle, told: Mapping[str, float | None]) -> list[str]:
    """Where the autopilot's rotors are not the vehicle file's, in words. ``told``: its parameters, None unknown."""
    unknown = [name for name in names(vehicle) if told.get(name) is None and name != CURVE]
    if unknown:
        return [f"PX4 does not say {unknown[0]}, so that its rotors cannot be compared with the vehicle file's"]
    said = {name: value for name, value in told.items() if value is not None}
    if said[COUNT] != len(vehicle.rotors):
        return [f"PX4 has {said[COUNT]:g} rotors (CA_ROTOR_COUNT), {vehicle.name} has {len(vehicle.rotors)}"]
    theirs = [(said[f"CA_ROTOR{n}_PX"], said[f"CA_ROTOR{n}_PY"]) for n in range(len(vehicle.rotors))]
    ours = [rotor.position_b[:2] for rotor in vehicle.rotors]
    found = []
    for n, (their, our) in enumerate(zip(_shape(theirs), _shape(ours), strict=True)):
        if math.dist(their, our) > SHAPE_AGREES:
            x, y = theirs[n]
            found.append(
                f"motor {n + 1} sits at ({x:g}, {y:g}) by CA_ROTOR{n}_PX and _PY, and at "
                f"({ours[n][0]:g}, {ours[n][1]:g}) by the vehicle file"
            )
        spin = Spin.CCW if said[f"CA_ROTOR{n}_KM"] > 0.0 else Spin.CW
        if spin is not vehicle.rotors[n].spin:
            own = vehicle.rotors[n].spin.value
            found.append(f"motor {n + 1} turns {spin.value} by CA_ROTOR{n}_KM, and {own} by the vehicle file")
    return found


def curve_words(told: Mapping[str, float | None]) -> str:
    """What PX4 makes of a motor command, for the pilot."""
    factor = told.get(CURVE)
    if factor is None:
        return (
            "PX4 does not say THR_MDL_FAC: the vehicle file takes a motor command as a share of thrust; see that the "
            "ESC or THR_MDL_FAC makes it so"
        )
    if factor == 0.0:
        return (
            "THR_MDL_FAC is 0: PX4 hands a motor command to the ESC as it is, and the vehicle file takes it as a share "
            "of thrust; where the ESC is not linear in thrust, set THR_MDL_FAC"
        )
    return f"THR_MDL_FAC is {factor:g}: PX4 takes a motor command as a share of thrust, as the vehicle file does"


def _shape(places: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Places as multiples of the mean arm."""
    arm = sum(math.hypot(x, y) for x, y in places) / len(places) or 1.0
    return [(x / arm, y / arm) for x, y in places]
