"""What PX4's parameters say of the vehicle: a vehicle file whose gaps are told.

PX4 knows where its rotors sit and which way they turn, its gains and its limits. It does not know mass, inertia or the
thrust in newtons, and flies all the same, because only their ratios count: of two vehicles with the same thrust over
weight and the same torque over inertia neither can be told from the other. So can the law at rates and attitude; at
motors and in ``check`` newtons matter.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from companion.identification.description import Description, Entry, Source
from companion.identification.quadrotor import refuse_others
from companion.vehicle import GRAVITY, CompanionError

Values = Mapping[str, float]

MASS_PER_ARM = 7.0
"""kg a metre of arm. Engineering choice: x500 8, sih 3.5, a 5 inch racer 6."""
GYRATION_OF_ARM = (0.45, 0.45, 0.62)
"""Radii of gyration over the arm, roll, pitch, yaw: x500 (0.42, 0.42, 0.57), sih (0.56, 0.56, 0.61)."""
ARM = 0.25
"""m, where PX4 holds only the shape of the frame. Engineering choice: a 500 mm frame."""
SHAPE_ONLY = 0.75
"""m: an arm this long on every rotor is no length but a 1 (PX4's own airframes for simulation are written so)."""
PLACE_DEFAULT = 0.0
"""m, CA_ROTORn_PX, PY, PZ as PX4 ships them: a set that holds only what was changed lacks these."""
SIMULATED = frozenset({
    "SIH_MASS", "SIH_IXX", "SIH_IYY", "SIH_IZZ", "SIH_L_ROLL", "SIH_L_PITCH", "SIH_T_MAX", "SIH_Q_MAX", "SIH_T_TAU",
    "SIH_KDV",
})  # fmt: skip
"""Names of what PX4's simulation knows of its machine: with one missing it is not described fully."""
KM_DEFAULT = 0.05
"""CA_ROTORn_KM as PX4 ships it: then only its sign says something."""
TORQUE_PER_THRUST = 0.016
"""m, where PX4 has KM_DEFAULT: x500's (engineering choice)."""
MOTOR_LAG = 0.03
"""s, of motors and propellers of 5 to 15 inches: 15 to 60 ms (engineering choice)."""
DRAG = 0.2
"""1/s: a usual figure; in flight it is found within seconds."""
YAW_RATE_MAX = 85.0
"""deg/s: more of it takes the motors' range from thrust and tilt (the default of vehicle files)."""
LAG_BELIEVED = (0.03, 0.12)
"""s: the lag of a rate loop computed from guessed inertias is believed within this."""
QUAD_X = ((1.0, 1.0, 1.0), (-1.0, -1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0))
"""Forward, right and the sign of KM in PX4's motor order, where a firmware has no CA_ROTOR*."""


def describe_parameters(
    values: Values, *, name: str, origin: tuple[str, ...] = (), mass: float | None = None, arm: float | None = None
) -> Description:
    """A vehicle file of PX4's parameters. ``mass`` (kg) and ``arm`` (m, of the longest): as the user measured them.
    CompanionError: it is no quadrotor with upright rotors."""
    refuse_others(values)
    entries: dict[str, Any] = {}
    places, place_words, place_source = _places(values, arm)
    length = max(math.hypot(x, y) for x, y, _ in places)
    entries["mass_kg"] = weight = _mass(values, length, mass)
    inertia = _inertia(values, weight.value, length)
    entries["inertia_kgm2"] = inertia
    hover = values.get("MPC_THR_HOVER", 0.5)
    entries["rotors"], torque = _rotors(values, places, (place_words, place_source), weight, hover)
    entries |= _response(values, weight.value, inertia.value, places, torque, hover)
    entries["hover_thrust"] = Entry(hover, Source.PX4, "MPC_THR_HOVER, 0..1; a flight learns it, and from-log finds it")
    entries["link_delay_s"] = Entry(0.01, Source.USUAL, "s; measured when flying")
    entries["state_rate_hz"] = Entry(250, Source.USUAL, "Hz; how often it is asked for its state")
    entries["motors"] = Entry("px4", Source.PX4, "it mixes by itself")
    entries["limits"] = _limits(values)
    return Description(name, origin, entries, tuple(_notes(values)))


def _places(values: Values, arm: float | None) -> tuple[list[tuple[float, float, float]], str, Source]:
    """Where the rotors sit, m; how that is known."""
    known = any(f"CA_ROTOR{i}_P{axis}" in values for i in range(4) for axis in "XY")
    if known:
        places = [tuple(values.get(f"CA_ROTOR{i}_P{axis}", PLACE_DEFAULT) for axis in "XYZ") for i in range(4)]
        words, source = "CA_ROTOR*_PX, PY, PZ", Source.PX4
    else:
        places = [(x, y, 0.0) for x, y, _ in QUAD_X]
        words, source = "PX4 says nothing of its rotors (no CA_ROTOR*); a quad X is assumed", Source.ASSUMED
    longest = max(math.hypot(x, y) for x, y, *_ in places)
    if longest <= 0.0:
        raise CompanionError("every rotor sits in the middle (CA_ROTOR*_PX, PY); set the vehicle up in PX4 first")
    told = None
    if arm is not None:
        told, words = arm, f"{words}, the longest arm {arm:g} m as given"
        source = source if source is Source.ASSUMED else Source.GIVEN
    elif _simulated(values):
        told, words = math.hypot(values["SIH_L_ROLL"], values["SIH_L_PITCH"]), f"{words}, as long as SIH_L_ROLL, PITCH"
    elif min(math.hypot(x, y) for x, y, *_ in places) > SHAPE_ONLY:
        told, source = ARM, Source.ASSUMED
        told_of = f" say the shape only ({longest:.3g} is no length)" if known else f", its arm {ARM:g} m"
        words += f"{told_of}; measure the arm and give --arm"
    factor = 1.0 if told is None else told / longest
    return [(x * factor, y * factor, z * factor) for x, y, z in places], words, source


def _simulated(values: Values) -> bool:
    """Whether the vehicle is PX4's own simulation, which knows its machine (SIH)."""
    set_up = 10040 <= values.get("SYS_AUTOSTART", 0) < 10050 or values.get("SYS_HITL", 0) == 2
    return set_up and values.keys() >= SIMULATED


def _mass(values: Values, length: float, mass: float | None) -> Entry:
    if mass is not None:
        return Entry(mass, Source.GIVEN, "kg")
    if _simulated(values):
        return Entry(values["SIH_MASS"], Source.PX4, "kg, SIH_MASS")
    return Entry(
        round(MASS_PER_ARM * length, 2), Source.ASSUMED,
        f"kg; guessed from an arm of {length:.2f} m. Weigh it ready to take off and give --mass",
    )  # fmt: skip


def _inertia(values: Values, mass: float, length: float) -> Entry:
    if _simulated(values):
        return Entry([values[f"SIH_I{axis}"] for axis in ("XX", "YY", "ZZ")], Source.PX4, "kg m^2, SIH_IXX, IYY, IZZ")
    guessed = [float(f"{mass * (k * length) ** 2:.3g}") for k in GYRATION_OF_ARM]
    return Entry(
        guessed, Source.ASSUMED, "kg m^2; guessed from mass and arm, half or double is possible. from-log helps"
    )


def _rotors(
    values: Values, places: list[tuple[float, float, float]], placed: tuple[str, Source], mass: Entry, hover: float
) -> tuple[list[Entry], float]:
    """The rotors, and the torque over thrust (m) of the first."""
    words, source = placed
    simulated = _simulated(values)
    thrust = values["SIH_T_MAX"] if simulated else mass.value * GRAVITY / hover / 4.0
    if source is not Source.ASSUMED and any(f"CA_ROTOR{i}_KM" not in values for i in range(4)):
        words, source = f"{words}; spins of a quad X assumed (no CA_ROTOR*_KM)", Source.ASSUMED
    rows = []
    torque = TORQUE_PER_THRUST
    for i, (x, y, z) in enumerate(places):
        km = values.get(f"CA_ROTOR{i}_KM", KM_DEFAULT * QUAD_X[i][2])
        shipped = abs(abs(km) - KM_DEFAULT) < 1e-6 or km == 0.0
        torque = values["SIH_Q_MAX"] / values["SIH_T_MAX"] if simulated else TORQUE_PER_THRUST if shipped else abs(km)
        row = {
            "position_m": [x, y, z], "spin": "ccw" if km > 0.0 else "cw", "thrust_max_n": thrust,
            "torque_per_thrust_m": torque,
        }  # fmt: skip
        if i == 0:
            thrust_words = "SIH_T_MAX and Q_MAX" if simulated else "thrust: weight over MPC_THR_HOVER"
            torque_words = (
                "" if simulated else "; torque over thrust a usual one" if shipped else "; torque CA_ROTOR*_KM"
            )
            guess = Source.ASSUMED if Source.ASSUMED in (source, mass.source) else source
            rows.append(Entry(row, guess, f"{words}; {thrust_words}{torque_words}"))
        else:
            rows.append(Entry(row, rows[0].source, f"motor {i + 1}"))
    return rows, torque


def _response(
    values: Values, mass: float, inertia: list[float], places: list[tuple[float, float, float]], torque: float,
    hover: float,
) -> dict[str, Entry]:  # fmt: skip
    """Lags and drag."""
    if _simulated(values):
        lag = Entry(values["SIH_T_TAU"], Source.PX4, "s, SIH_T_TAU")
        drag = Entry(values["SIH_KDV"] / mass, Source.PX4, "1/s, SIH_KDV over mass")
    else:
        lag = Entry(MOTOR_LAG, Source.ASSUMED, "s, of a motor's thrust; from-log finds it")
        drag = Entry(DRAG, Source.USUAL, "1/s, drag over mass and speed; found in flight, and by from-log")
    return {
        "motor_lag_s": lag,
        "drag_per_s": drag,
        "rate_loop_lag_s": _rate_loop_lag(values, inertia, places, mass, hover),
    }


def _rate_loop_lag(
    values: Values, inertia: list[float], places: list[tuple[float, float, float]], mass: float, hover: float
) -> Entry:
    """1 / (K P B) + D / P, B being the angular acceleration of a torque setpoint of 1: four motors, each by 0.7071."""
    per_unit = mass * GRAVITY / hover * math.sqrt(0.5)
    lags = []
    for axis, name in enumerate(("ROLL", "PITCH")):
        p, d, k = (
            values.get(f"MC_{name}RATE_{gain}", usual) for gain, usual in (("P", 0.15), ("D", 0.003), ("K", 1.0))
        )
        lever = sum(abs(place[1 - axis]) for place in places) / 4.0
        if p * k * lever <= 0.0:
            return Entry(0.06, Source.USUAL, "s; MC_ROLLRATE_P, PITCHRATE_P are zero")
        lags.append(inertia[axis] / (k * p * per_unit * lever) + d / p)
    mean = sum(lags) / 2.0
    words = f"s; by MC_*RATE_P, D, K and the inertia roll {1e3 * lags[0]:.0f}, pitch {1e3 * lags[1]:.0f} ms"
    low, high = LAG_BELIEVED
    if not low <= mean <= high:
        return Entry(0.06, Source.USUAL, f"{words} (not believed)")
    return Entry(float(f"{mean:.2g}"), Source.PX4, words)


def _limits(values: Values) -> dict[str, Entry]:
    rates = [
        values.get(f"MC_{name}RATE_MAX", usual) for name, usual in (("ROLL", 220.0), ("PITCH", 220.0), ("YAW", 200.0))
    ]
    roll, pitch, yaw = rates[0], rates[1], min(rates[2], YAW_RATE_MAX)
    ends = [v for v in (values.get("FD_FAIL_R", 60.0), values.get("FD_FAIL_P", 60.0)) if v > 0.0]
    detector = min(ends, default=180.0)
    tilt = min(values.get("MPC_TILTMAX_AIR", 45.0), 80.0, detector - 5.0)
    return {
        "tilt_deg": Entry(tilt, Source.PX4, "deg, MPC_TILTMAX_AIR"),
        "body_rate_dps": Entry([roll, pitch, yaw], Source.PX4, f"deg/s, MC_*RATE_MAX, yaw {YAW_RATE_MAX:g} at most"),
        "speed": Entry(values.get("MPC_XY_VEL_MAX", 12.0), Source.PX4, "m/s, MPC_XY_VEL_MAX"),
        "failure_detector_deg": Entry(detector, Source.PX4, "deg, FD_FAIL_R and FD_FAIL_P" + ("" if ends else ": off")),
    }


TOLD = (
    ("attitude gains", ("MC_ROLL_P", "MC_PITCH_P", "MC_YAW_P")),
    ("rate gains, roll", ("MC_ROLLRATE_P", "MC_ROLLRATE_I", "MC_ROLLRATE_D", "MC_ROLLRATE_K")),
    ("rate gains, pitch", ("MC_PITCHRATE_P", "MC_PITCHRATE_I", "MC_PITCHRATE_D", "MC_PITCHRATE_K")),
    ("rate gains, yaw", ("MC_YAWRATE_P", "MC_YAWRATE_I", "MC_YAWRATE_D", "MC_YAWRATE_K", "MC_YAW_TQ_CUTOFF")),
    ("thrust curve and battery", ("THR_MDL_FAC", "MC_BAT_SCALE_EN", "MPC_USE_HTE")),
    ("when setpoints stop", ("COM_OF_LOSS_T", "COM_OBL_RC_ACT")),
    ("sticks", ("COM_RC_OVERRIDE", "MAN_OVERRIDE_SPD", "NAV_RCL_ACT", "COM_RCL_EXCEPT", "NAV_DLL_ACT")),
)
"""What the companion reads itself before a flight, for people to see."""


def _notes(values: Values) -> list[str]:
    """What no key holds, as comments: read again before every flight."""
    lines = ["", "What PX4 holds besides, read again before every flight (companion preflight says what is advised):"]
    for what, names in TOLD:
        known = [f"{name} {values[name]:.6g}" for name in names if name in values]
        if known:
            lines.append(f"  {what}: {', '.join(known)}")
    if values.get("THR_MDL_FAC", 0.0) == 0.0:
        lines.append(
            "  THR_MDL_FAC 0 means thrust goes with the command; most propellers want about 0.3: from-log says"
        )
    return lines
