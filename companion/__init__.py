"""A quadrotor that flies a path, not a timetable: an offboard companion for PX4.

The natural way of the data, one tick:

     bytes ─► mavlink.codec ─► mavlink.telemetry ─► VehicleState(t_boot, p_n, v_n, q_nb, w_b)
                                                       │
                                  paths: where am I along the path, how far from it
                                                       │
       estimation: where it acts ─► steering ◄── law: outputs, feedback, flatness
                                                       │              flight: whose command counts
                            limits, encoding (motors: M^-1 instead) ─► Setpoint
     bytes ◄─ mavlink.codec ◄─ mavlink.setpoints ◄──────┘

    pilot.step(plan, memory, observation, now) -> (memory, outcome)   pure, and replayed bit for bit

From an ODOMETRY to a SET_ATTITUDE_TARGET, file by file:

    daemon/loop        the datagram is received; conductor.receive
    daemon/conductor   take_in: mavlink/codec, mavlink/telemetry -> a VehicleState; then one tick
    pilot/tick         compute_setpoint: the state looked at (pilot/intake), the aim chosen (pilot/targets)
    steering/rates     steer: estimate, predict, govern speed, law, yaw compensation, limits, encode (plan: which level)
    daemon/conductor   queue: mavlink/setpoints -> values, mavlink/codec -> bytes; daemon/loop sends them
    pilot/tick         supervise, after the send: guards, safety rows, phases. Where compute_setpoint gave none (not
                       calmly on the path), it runs before, and computes the setpoint or withholds it

The field's terms, the paper's letters and PX4's names side by side: docs/glossary.md.

The rooms, each standing on those above it (tests/test_architecture.py holds the table):

    frames       NED and FRD, quaternions, angles                    vehicle     the nouns every room shares
    calculus     exact derivatives of what a mission writes          geodesy     PX4's own map projection
    paths        where: implicit curves, arc length, placement       profiles    how fast, facing where (alpha, beta)
    law          the paper                                           mission     what is to be flown, as values
    places       what a mission counts from -> the local frame       fence       where a vehicle may be
    plans        what ground stations write                          mavlink_common  MAV_CMD_*, MAV_RESULT, ...: numbers
    allocation   M and M^-1                                          estimation  what the vehicle does not say
    px4_allocation  the same as PX4 does it                          thrust_range  the bounds of the thrust
    steering     state -> setpoint, one file an output level         flight      phases, guards: the state machine
    plan         a mission made ready to fly                         pilot       one tick
    settings     gains and limits that a ground station may set      version     of this software
    world        what a simulated world is                           mavlink     the wire
    config       files people write -> values                        xrce        PX4's topics, to its XRCE client
    daemon       the only sockets and clocks                         record      the evidence, and what is made of it
    library      what Python and the commands offer alike            services    MAVSDK, off the control path
    study        many flights, and how many of them pass             watch       the live page, a process of its own
    cli          the commands                                        identification  a vehicle file from PX4 or a log
    feasibility  what a mission will ask of a vehicle                plain_text  what a terminal may be given

The vehicle's software stand-in is its own package, ``sim_bridge``, with its own derivation of the physics.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from companion.version import __version__ as __version__

if TYPE_CHECKING:
    from companion.library.flights import Flight
    from companion.library.public import (
        check,
        compare,
        control_law,
        curve_path,
        implicit_path,
        load_mission,
        load_vehicle,
        load_world,
        new_mission,
        new_vehicle,
        new_world,
        path_through,
        simulate,
    )
    from companion.vehicle import CompanionError

__all__ = [
    "CompanionError",
    "Flight",
    "check",
    "compare",
    "control_law",
    "curve_path",
    "implicit_path",
    "load_mission",
    "load_vehicle",
    "load_world",
    "new_mission",
    "new_vehicle",
    "new_world",
    "path_through",
    "simulate",
]

_ELSEWHERE = {"CompanionError": "companion.vehicle", "Flight": "companion.library.flights"}


def __getattr__(name: str) -> Any:
    """The public names, looked up when they are first used: the rooms below import this package too."""
    if name not in __all__:
        raise AttributeError(f"module 'companion' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_ELSEWHERE.get(name, "companion.library.public")), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
