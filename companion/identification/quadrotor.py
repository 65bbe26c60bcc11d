"""Whether PX4's parameters are a quadrotor's, with rotors that point upwards."""

from __future__ import annotations

from collections.abc import Mapping

from companion.mavlink_common import MAV_TYPE_GENERIC, MAV_TYPE_QUADROTOR, VEHICLE_WORDS
from companion.vehicle import CompanionError

AIRFRAMES = (0, 15)
"""CA_AIRFRAME of PX4: multirotors."""
TYPES = (MAV_TYPE_GENERIC, MAV_TYPE_QUADROTOR)
"""MAV_TYPE of PX4: a quadrotor, and what PX4 ships where nobody has said."""
UPRIGHT = -0.98
"""Number: CA_ROTORn_AZ up to which a rotor points upwards, within 11 degrees (engineering choice)."""
ROTORS_MAX = 12
"""Number of rotors that PX4 has parameters of."""


def refuse_others(values: Mapping[str, float]) -> None:
    """CompanionError: the vehicle is no quadrotor, or a rotor of it is tilted.

    CA_AIRFRAME and CA_ROTOR_COUNT say it. A PX4 without control allocation (up to 1.13) has neither, and some files
    hold only what was changed: there MAV_TYPE says it, and what a quadrotor does not have.
    """
    _refuse_airframe(values)
    for i in range(4):
        if values.get(f"CA_ROTOR{i}_AZ", -1.0) > UPRIGHT:
            raise CompanionError(f"rotor {i + 1} is tilted (CA_ROTOR{i}_AX, AY, AZ); rotors must point upwards")


def _refuse_airframe(values: Mapping[str, float]) -> None:
    airframe, count = values.get("CA_AIRFRAME", 0), values.get("CA_ROTOR_COUNT")
    if airframe not in AIRFRAMES or (count is not None and count != 4):
        told = "" if count is None else f", CA_ROTOR_COUNT {count:g}"
        raise _other(f"CA_AIRFRAME {airframe:g}{told}")
    if count is not None:
        return
    kind = values.get("MAV_TYPE", MAV_TYPE_GENERIC)
    if kind not in TYPES:
        raise _other(f"MAV_TYPE {kind:g}: {VEHICLE_WORDS.get(int(kind), 'another vehicle')}")
    surfaces = values.get("CA_SV_CS_COUNT", 0)
    if surfaces > 0:
        raise _other(f"CA_SV_CS_COUNT {surfaces:g}: it has control surfaces")
    for i in range(4, ROTORS_MAX):
        if any(values.get(f"CA_ROTOR{i}_P{axis}", 0.0) != 0.0 for axis in "XY"):
            raise _other(f"CA_ROTOR{i}_PX, PY: it has more than four rotors")


def _other(said: str) -> CompanionError:
    return CompanionError(f"the vehicle is no quadrotor ({said}); nothing was written")
