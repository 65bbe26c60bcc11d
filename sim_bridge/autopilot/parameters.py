"""The figures a user may set, under PX4's names, with PX4's types and its defaults in simulation.

The table is parameters.txt. Most of it is only kept and told; what acts reads its own name here. A value is an ``int``
where PX4's parameter is an int32; the rest are float32 on the wire.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from companion.frames import Vec3
from companion.vehicle import Vehicle
from companion.world import Battery, Home
from sim_bridge.control.mixing import Mixer
from sim_bridge.control.rates import gains_for

TABLE = Path(__file__).with_name("parameters.txt")
HURRIED = ("COM_OF_LOSS_T", "COM_RC_LOSS_T", "COM_DL_LOSS_T", "COM_DISARM_PRFLT")
"""What waits for somebody outside, who lives by the wall's clock."""
CELL_FULL = 4.05
"""V, from which the number of a battery's cells is told."""
FLOAT_EPSILON = 1.1920929e-7
"""Of float32, relative: PX4 takes nearer values for the same."""
VOLATILE = frozenset(
    {"ASPD_SCALE_1", "COM_FLIGHT_UUID", "EKF2_MAG_DECL", "LND_FLIGHT_T_HI", "LND_FLIGHT_T_LO", "SENS_DPRES_OFF"}
)
"""What changes by itself and is left out of the hash."""

XRCE: Mapping[str, float] = {
    "UXRCE_DDS_AG_IP": 2130706433, "UXRCE_DDS_CFG": 0, "UXRCE_DDS_DOM_ID": 0, "UXRCE_DDS_FLCTRL": 0, "UXRCE_DDS_KEY": 1,
    "UXRCE_DDS_PRT": 8888, "UXRCE_DDS_PTCFG": 0, "UXRCE_DDS_RX_TO": -1, "UXRCE_DDS_SYNCC": 0, "UXRCE_DDS_SYNCT": 1,
    "UXRCE_DDS_TX_TO": 3,
}  # fmt: skip
"""What a vehicle with an XRCE client has beside the table."""


@cache
def table() -> Mapping[str, float]:
    """Name -> default, in the order of the index."""
    rows = (line.split() for line in TABLE.read_text(encoding="ascii").splitlines() if not line.startswith("#"))
    return {name: float(text) if "." in text or "e" in text else int(text) for name, text in rows}


class Parameters(dict[str, float]):
    """Values by name. ``defaults``: what a reset brings back; ``changes``: the names set over a link, oldest first."""

    def __init__(self, defaults: Mapping[str, float]) -> None:
        super().__init__(defaults)
        self.defaults = dict(defaults)
        self.names = tuple(defaults)
        self.index = {name: i for i, name in enumerate(self.names)}
        self.changes: list[str] = []

    def add(self, more: Mapping[str, float]) -> None:
        """More parameters, in their place among the names."""
        self.defaults = dict(sorted({**self.defaults, **more}.items()))
        before = dict(self)
        self.clear()
        self.update({name: before.get(name, value) for name, value in self.defaults.items()})
        self.names = tuple(self.defaults)
        self.index = {name: i for i, name in enumerate(self.names)}

    def is_integer(self, name: str) -> bool:
        """Whether a parameter is an int32 rather than a float32."""
        return isinstance(self.defaults[name], int)

    def packed(self, name: str) -> bytes:
        """The four bytes of a value as PX4 keeps and sends them."""
        value = self[name]
        return struct.pack("<i", int(value)) if self.is_integer(name) else _float32(value)

    def unpack(self, name: str, raw: bytes) -> None:
        """Set a value from its four bytes, and note that it was set if that changed it.

        As in PX4 a change from or to no number is none that anybody is told of.
        """
        (value,) = struct.unpack("<i" if self.is_integer(name) else "<f", raw)
        if abs(value - self[name]) > FLOAT_EPSILON:
            self.changes.append(name)
        self[name] = value

    def hurry(self, speed: float) -> None:
        """Lengthen the time-outs of links for a plant that runs ``speed`` times as fast as the clock, as PX4 does."""
        for name in HURRIED:
            whole = self.is_integer(name)
            value = self.defaults[name] * speed
            self[name] = self.defaults[name] = round(value) if whole else value

    def reset(self) -> None:
        """Everything back to its default."""
        for name, value in self.defaults.items():
            if self[name] != value:
                self[name] = value
                self.changes.append(name)

    @property
    def hash(self) -> int:
        """PX4's _HASH_CHECK: a CRC-32 without its inversions over names and values."""
        crc = 0xFFFFFFFF
        for name in self.names:
            if name not in VOLATILE:
                crc = zlib.crc32(self.packed(name), zlib.crc32(name.encode("ascii"), crc))
        return crc ^ 0xFFFFFFFF


def _float32(value: float) -> bytes:
    try:
        return struct.pack("<f", value)
    except OverflowError:
        return struct.pack("<f", float("inf") if value > 0.0 else float("-inf"))


def defaults() -> Parameters:
    """A fresh set, of no particular vehicle."""
    return Parameters(table())


def of(vehicle: Vehicle, home: Home, battery: Battery | None = None, rate_gains: Vec3 = (1.0, 1.0, 1.0)) -> Parameters:
    """A fresh set that describes a vehicle, where it stands, its battery where the world has one, and its rate gains,
    ``rate_gains`` being theirs over the usual ones."""
    found = dict(table())
    gains = gains_for(vehicle, Mixer(vehicle.rotors), rate_gains)
    for kind, by_axis in (("P", gains.proportional), ("I", gains.integral), ("D", gains.derivative)):
        for axis, gain in zip(("ROLL", "PITCH", "YAW"), by_axis, strict=True):
            found[f"MC_{axis}RATE_{kind}"] = float(f"{gain:.6g}")
    lever = max(abs(x) for rotor in vehicle.rotors for x in rotor.position_b[:2]) or 1.0
    for i, rotor in enumerate(vehicle.rotors):
        x, y, z = rotor.position_b
        found[f"CA_ROTOR{i}_PX"], found[f"CA_ROTOR{i}_PY"], found[f"CA_ROTOR{i}_PZ"] = x / lever, y / lever, z / lever
        found[f"CA_ROTOR{i}_KM"] = 0.05 * rotor.spin.reaction
    first = vehicle.rotors[0]
    (ixx, iyy, izz) = vehicle.inertia
    hover = vehicle.weight / vehicle.thrust_max
    found.update(
        MPC_THR_HOVER=max(0.1, min(0.8, round(hover, 1))),  # as coarse as airframe files state it
        SIH_MASS=vehicle.mass,
        SIH_IXX=ixx,
        SIH_IYY=iyy,
        SIH_IZZ=izz,
        SIH_T_MAX=first.thrust_max,
        SIH_Q_MAX=first.thrust_max * first.torque_per_thrust,
        SIH_L_ROLL=lever,
        SIH_L_PITCH=lever,
        SIH_T_TAU=vehicle.motor_lag,
        SIH_KDV=vehicle.drag * vehicle.mass,
        SIH_LOC_LAT0=home.latitude,
        SIH_LOC_LON0=home.longitude,
        SIH_LOC_H0=home.altitude,
    )
    if battery is not None:
        cells = max(1, round(battery.full / CELL_FULL))
        found.update(
            BAT1_CAPACITY=battery.capacity / 3.6,
            BAT1_N_CELLS=cells,
            BAT1_V_CHARGED=battery.full / cells,
            BAT1_V_EMPTY=battery.empty / cells,
        )
    return Parameters(found)
