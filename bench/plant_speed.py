"""How fast the plant is: python bench/plant_speed.py [seconds of plant time, default 20]

Physics alone, beside RotorPy's in the same run, and the whole bridge with about 1000 messages a second, flown three
ways and in three worlds. Microseconds of one core a step, the best of three runs, and how many times real time that is.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np
from rotorpy.vehicles.hummingbird_params import quad_params
from rotorpy.vehicles.multirotor import Multirotor

from companion.config.vehicle import load_vehicle
from companion.config.world.world import load_world
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.world import World
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Plant

STREAMS = {"ATTITUDE_QUATERNION": 4000, "ODOMETRY": 4000, "LOCAL_POSITION_NED": 8000, "HIGHRES_IMU": 8000}
OFFBOARD = {"command": 176, "param1": 1.0, "param2": 6.0}
RUNS = 3


def show(name: str, steps_per_second: int, seconds: float, run: Callable[[int], float]) -> float:
    """Time ``run`` of so many steps, which gives back the messages a second it sent; the time of a step, s."""
    steps = round(seconds * steps_per_second)
    took, messages = [], 0.0
    for _ in range(RUNS):
        began = time.thread_time()
        messages = run(steps)
        took.append(time.thread_time() - began)
    best = min(took)
    print(
        f"{name:34} {best / steps * 1e6:7.1f} us a step {steps / best:9.0f} steps/s "
        f"{seconds / best:7.0f} x real time {messages:7.0f} messages/s",
        flush=True,
    )
    return best / steps


def physics(name: str, steps_per_second: int) -> Callable[[int], float]:
    """The machine alone, at hover."""
    vehicle = load_vehicle(name)
    each = vehicle.weight / 4.0
    command = each / vehicle.rotors[0].thrust_max

    def run(steps: int) -> float:
        plant = Plant(vehicle, World(), steps_per_second)
        plant.fly((0.0, 0.0, -10.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (each,) * 4)
        step, commands = plant.step, (command,) * 4
        for _ in range(steps):
            step(commands)
        return 0.0

    return run


def rotorpy() -> Callable[[int], float]:
    """RotorPy's multirotor with its own integrator and settings, at hover."""
    machine = Multirotor(quad_params, aero=False)
    speeds = np.full(4, np.sqrt(machine.mass * machine.g / 4.0 / machine.k_eta))
    state = {name: np.zeros(3) for name in ("x", "v", "w", "wind")}
    state |= {"q": np.array([0.0, 0.0, 0.0, 1.0]), "rotor_speeds": speeds}

    def run(steps: int) -> float:
        now = state
        for _ in range(steps):
            now = machine.step(now, {"cmd_motor_speeds": speeds}, 0.004)
        return 0.0

    return run


def whole(name: str, flown: str, endpoints: int, world: str = "ideal") -> Callable[[int], float]:
    """The bridge with full streams, in hold or in offboard with a setpoint a step."""
    vehicle, surroundings = load_vehicle(name), load_world(world)
    encoder = Encoder(1, 191)

    def sent(kind: str, **fields: object) -> bytes:
        return encoder.message(message(kind), target_system=1, target_component=1, **fields)

    def run(steps: int) -> float:
        bridge = Bridge(vehicle, surroundings, direct=flown == "motors", endpoints=endpoints)
        for kind, interval in STREAMS.items():
            bridge.receive(sent("COMMAND_LONG", command=511, param1=float(message(kind).id), param2=float(interval)))
        hover = bridge.autopilot.cascade
        if flown == "motors":
            setpoint = sent("SET_ACTUATOR_CONTROL_TARGET", controls=(*hover.commands, 0.0, 0.0, 0.0, 0.0))
        else:
            setpoint = sent("SET_ATTITUDE_TARGET", type_mask=0x80, thrust=hover.hover)
        if flown != "hold":
            bridge.receive(setpoint)
            bridge.receive(sent("COMMAND_LONG", **OFFBOARD))
        messages = 0
        for _ in range(steps):
            if flown != "hold":
                bridge.receive(setpoint)
            bridge.step()
            messages += len(bridge.datagrams())
        return messages / bridge.now

    return run


def main() -> None:
    """Run and print everything."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20.0
    ours = show("physics, x500 at 4 ms", 250, seconds, physics("x500", 250))
    theirs = show("RotorPy at 4 ms", 250, min(seconds, 2.0), rotorpy())
    print(f"{'':34} {theirs / ours:7.0f} times RotorPy's steps per second")
    show("physics, paper at 1 ms", 1000, seconds, physics("paper", 1000))
    for flown in ("hold", "rates", "motors"):
        show(f"bridge, x500, {flown}", 250, seconds, whole("x500", flown, 1))
    show("bridge, x500, rates, two links", 250, seconds, whole("x500", "rates", 2))
    for world in ("sih", "outdoor", "storm"):
        show(f"bridge, x500, rates, {world}", 250, seconds, whole("x500", "rates", 1, world))
    show("bridge, paper, motors", 1000, seconds, whole("paper", "motors", 1))


if __name__ == "__main__":
    main()
