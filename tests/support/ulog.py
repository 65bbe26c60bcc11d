"""Writes ULog files: what PX4's logger would have logged of a flight of the stand-in. pyulog only reads."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from companion.daemon.conductor import Conductor
from companion.frames import Vec3, rotation_matrix
from companion.identification.ulog import FIELDS
from companion.vehicle import GRAVITY, OutputLevel, Vehicle
from companion.world import World
from sim_bridge.autopilot.parameters import of
from sim_bridge.bridge import Bridge
from sim_bridge.control.filters import ButterworthLowPass
from sim_bridge.noise import RandomStream, normals
from sim_bridge.plant import Truth
from trials.measured import course, measure_flight

MAGIC = b"ULog\x01\x12\x35\x01"
FORMATS = {
    "vehicle_angular_velocity": ("uint64_t timestamp_sample", "float[3] xyz"),
    "vehicle_rates_setpoint": ("float roll", "float pitch", "float yaw"),
    "vehicle_torque_setpoint": ("float[3] xyz",),
    "vehicle_thrust_setpoint": ("float[3] xyz",),
    "vehicle_acceleration": ("uint64_t timestamp_sample", "float[3] xyz"),
    "vehicle_attitude": ("uint64_t timestamp_sample", "float[4] q"),
    "vehicle_local_position": ("float vx", "float vy", "float vz", "float z"),
    "vehicle_land_detected": ("bool landed",),
    "battery_status": ("float voltage_v",),
    "actuator_controls_0": ("float[8] control",),
    "cell": ("float voltage",),
}
"""As in PX4's .msg files, without the fields that nobody reads here."""
CUTOFFS = {"gyro": 40.0, "accelerometer": 30.0}
"""Hz: IMU_GYRO_CUTOFF and IMU_ACCEL_CUTOFF, which what PX4 logs has passed."""
SIZES = {"uint64_t": "Q", "float": "f", "bool": "?"}

Row = tuple[int, Sequence[float]]
"""us, and the fields of a message after its timestamp."""


def written(
    file: Path, topics: Mapping[str, Sequence[Row]], parameters: Mapping[str, float], release: int = 0x011000FF,
    system: str = "PX4", hardware: str = "PX4_FMU_V6X",
) -> Path:  # fmt: skip
    """A ULog with these messages, of a PX4 of this ``release`` on this ``hardware``."""
    out = bytearray(MAGIC + struct.pack("<Q", 0))

    def message(kind: str, body: bytes) -> None:
        out.extend(struct.pack("<HB", len(body), ord(kind)) + body)

    message("B", bytes(40))
    for name in topics:
        fields = ";".join(("uint64_t timestamp", *FORMATS[name]))
        message("F", f"{name}:{fields};".encode())
    for key, value in (
        ("char[5] sys_uuid", b"00abc"), ("uint32_t ver_sw_release", struct.pack("<I", release)),
        (f"char[{len(system)}] sys_name", system.encode()), (f"char[{len(hardware)}] ver_hw", hardware.encode()),
    ):  # fmt: skip
        message("I", bytes([len(key)]) + key.encode() + value)
    for name, number in parameters.items():
        key = f"{'int32_t' if isinstance(number, int) else 'float'} {name}".encode()
        message("P", bytes([len(key)]) + key + struct.pack("<i" if isinstance(number, int) else "<f", number))
    for number, name in enumerate(topics):
        message("A", struct.pack("<BH", 0, number) + name.encode())
    rows = [(at, number, name, values) for number, (name, told) in enumerate(topics.items()) for at, values in told]
    for at, number, name, values in sorted(rows, key=lambda row: row[0]):
        code = "<Q" + "".join(
            SIZES[kind.split("[")[0]] * (int(kind.split("[")[1][:-1]) if "[" in kind else 1)
            for kind in (each.split()[0] for each in FORMATS[name])
        )
        message("D", struct.pack("<H", number) + struct.pack(code, at, *values))
    file.write_bytes(out)
    return file


@dataclass
class Logger:
    """PX4's logger on board of the stand-in. ``every``: steps between two samples of each topic; 1 where absent."""

    every: Mapping[str, int] = field(default_factory=dict)
    accelerometer_std: Vec3 = (0.0, 0.0, 0.0)
    topics: dict[str, list[Row]] = field(default_factory=lambda: {name: [] for name in FIELDS})
    bridge: Bridge | None = None
    torque: Vec3 = (0.0, 0.0, 0.0)
    thrust: float = 0.0

    def prepare(self, conductor: Conductor, bridge: Bridge) -> None:
        """Listen in on the mixer."""
        self.bridge = bridge
        mixer = bridge.autopilot.cascade._mixer
        mix = mixer.mix

        def heard(torque: Vec3, thrust: float) -> object:
            self.torque, self.thrust = torque, thrust
            return mix(torque, thrust)

        mixer.mix = heard  # type: ignore[method-assign, assignment]
        self._draw = normals(7, RandomStream.SAID)
        self._filters = {
            name: [ButterworthLowPass(cutoff, bridge.step_s) for _ in range(3)] for name, cutoff in CUTOFFS.items()
        }

    def _filtered(self, name: str, values: Sequence[float]) -> list[float]:
        return [each.update(value) for each, value in zip(self._filters[name], values, strict=True)]

    def watch(self, conductor: Conductor, truth: Truth, now: float) -> None:
        """One step."""
        bridge = self.bridge
        assert bridge is not None
        us = round(truth.t_boot * 1e6)
        step = round(truth.t_boot / bridge.step_s)
        estimate = bridge.autopilot.estimate
        r = rotation_matrix(truth.q_nb)
        force_n = (truth.a_n[0], truth.a_n[1], truth.a_n[2] - GRAVITY)
        force_b = [
            sum(r[3 * i + k] * force_n[i] for i in range(3)) + std * self._draw()
            for k, std in enumerate(self.accelerometer_std)
        ]
        cells = bridge.plant.cells
        told: dict[str, Sequence[float]] = {
            "vehicle_angular_velocity": (us, *self._filtered("gyro", estimate.w_b)),
            "vehicle_rates_setpoint": [0.0 if rate is None else rate for rate in bridge.autopilot.cascade.rates_wanted],
            "vehicle_torque_setpoint": self.torque,
            "vehicle_thrust_setpoint": (0.0, 0.0, -self.thrust),
            "vehicle_acceleration": (us, *self._filtered("accelerometer", force_b)),
            "vehicle_attitude": (us, *estimate.q_nb),
            "vehicle_local_position": (*estimate.v_n, estimate.p_n[2]),
            "vehicle_land_detected": (truth.on_ground,),
            "battery_status": (16.0 if cells is None else cells.voltage,),
        }
        for name, values in told.items():
            if step % self.every.get(name, 1) == 0:
                # a setpoint was made before the step that it has just acted in
                made = us - round(1e6 * bridge.step_s) if name.endswith("_setpoint") else us
                self.topics[name].append((made + 1, values))


def logged(
    file: Path, vehicle: Vehicle, where: World, *, mission: str = "figure8", speed: float = 4.0, duration: float = 30.0,
    every: Mapping[str, int] | None = None, accelerometer_std: Vec3 = (0.0, 0.0, 0.0),
) -> Path:  # fmt: skip
    """Fly and log."""
    logger = Logger(every or {}, accelerometer_std)
    measure_flight(
        course(mission, speed), vehicle, where, OutputLevel.RATES, duration=duration,
        prepare=logger.prepare, watch=logger.watch,
    )  # fmt: skip
    return written(file, logger.topics, of(vehicle, where.home, where.battery))
