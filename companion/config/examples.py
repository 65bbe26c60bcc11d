"""Commented examples of every kind of file, for ``companion new``: each can be checked and flown as it is."""

from __future__ import annotations

import math

from companion.config.json_schemas import editor_line
from companion.geodesy import Home
from companion.mavlink_common import MAV_CMD_DO_CHANGE_SPEED, MAV_CMD_NAV_TAKEOFF, MAV_CMD_NAV_WAYPOINT
from companion.plans.items import Item, Plan
from companion.plans.writing import plan_text

PATHS = {
    "circle": """\
  kind: circle
  center: [0, 0, 10] # m
  radius: 6 # m
  # normal: [0, 0.3, 1] # what stands on its plane; vertical where absent
""",
    "ellipse": """\
  kind: ellipse
  center: [0, 0, 12] # m
  axes: [9, 5] # m, half of its length along x and across
  # normal: [0, -0.3, 1] # what stands on its plane; vertical where absent
""",
    "lissajous": """\
  kind: lissajous # center + amplitude * sin(frequency * u + phase), u from 0 to 360 degrees: here a figure-eight
  center: [0, 0, 12] # m
  amplitude: [12, 7, 1] # m
  frequency: [1, 2, 1] # swings in one round, whole numbers
  phase_deg: [90, 0, 0]
""",
    "line": """\
  kind: line
  from: [0, 0, 10] # m
  to: [40, 30, 14] # m
""",
    "polyline": """\
  kind: polyline # straight legs with rounded corners
  points: # m
    - [0, 0, 10]
    - [30, 0, 10]
    - [30, 20, 12]
    - [0, 20, 12]
  closed: true # whether the last point is joined to the first
  corner_tolerance: 1.5 # m, how far from a corner the path may pass it
""",
    "spline": """\
  kind: spline # a smooth curve through the points
  points: # m; a place on the earth will do as well: {lat: 47.3977, lon: 8.5456, above_home: 10} (degrees, m)
    - [0, 0, 10]
    - [14, 4, 12]
    - [22, 16, 14]
    - [6, 22, 12]
  closed: true # whether it runs on from the last point to the first
""",
    "expression": """\
  kind: expression # a curve of your own, in a parameter u
  constants: {size: 4.0, height: 12.0} # names for numbers
  x: size*(sin(u) + 2*sin(2*u)) # m; + - * / **, sqrt sin cos tan asin acos atan atan2 exp log abs hypot, pi
  y: size*(cos(u) - 2*cos(2*u))
  z: height - sin(3*u)
  u: [0, 6.283185307179586] # from, to; sin and cos take radians
  closed: true # whether the end is the beginning
""",
    "helix": """\
  kind: helix # turns about a vertical axis
  center: [0, 0, 10] # m, of the first turn
  radius: 7 # m
  pitch: 2 # m a turn climbs; negative sinks
  turns: 3
""",
    "implicit": """\
  kind: implicit # all points where h1 and h2 are zero
  constants: {r: 6.0, height: 10.0} # names for numbers
  h1: hypot(x, y) - r # m; + - * / **, sqrt sin cos tan asin acos atan atan2 exp log abs hypot, pi
  h2: z - height
  near: [0, 6, 10] # m, a point near the part that is meant
""",
    "plan": """\
  kind: plan # the route of a QGroundControl .plan, or of a .waypoints
  file: {plan} # seen from this file
  corner_tolerance: 1.0 # m, how far from a waypoint the path may pass it
  # smooth: true # a smooth curve through the waypoints instead of straight legs
""",
}
"""The path of each kind of mission, in frame: enu."""

OPEN = frozenset({"line", "helix", "plan"})
MISSION = """\
mission: my-{kind} # its name
# vehicle: x500 # whom it is for: a name in configs/vehicles, or a file; --vehicle says another
frame: enu # x east, y north, z up; or ned: x north, y east, z DOWN
{origin}
path:
{path}
speed: {speed}
yaw: {yaw}
# heading: twist # which heading yaw is: projected (of the nose seen from above), or twist for tilts beyond 45 degrees
{around}
# gains: {{poles: {{path: [-3, -3, -3], speed: [-2, -2], yaw: [-2]}}}} # 1/s; as many as --output rates needs
# fence: # where the vehicle may be, in m
#   - inside: [[-60, -60], [60, -60], [60, 60], [-60, 60]] # corners [x, y]
#   - outside: {{center: [90, 0], radius: 10}}
# start: # the state a simulated flight begins in; a hover at the path where absent
#   {{position: [0, 0, 10], velocity: [0, 0, 0], heading_deg: 0, pitch_deg: 0, roll_deg: 0, rates_dps: [0, 0, 0]}}
"""
ORIGIN = """\
# origin: takeoff # what it counts from: takeoff, home, local (the vehicle's own frame), or [lat, lon, m above the sea]
# rotate_deg: 30 # turns its axes clockwise seen from above
"""
SPEED = """\
3.0 # m/s; negative runs the other way
# speed: auto # as fast as the vehicle can
# speed: {auto: {margin: 0.9, speed_max: 6.0, reverse: false}} # the same, with options
# speed: {table: [[0, 2.0], [20, 4.0]]} # m/s at m along the path
"""
YAW = """\
tangent # the nose along the path
# yaw: 90 # degrees clockwise from north; an expression will do as well
# yaw: {tangent: 90} # along the path, plus degrees
# yaw: {look_at: [5, 5, 0]} # always facing a point, m
# yaw: {table: [[0, 0], [20, 90]]} # degrees at m along the path
"""
PLAN_SPEED = "plan # as the plan says, and slower where the vehicle must be; a number in m/s is the same all the way\n"
PLAN_YAW = "plan # as the plan says; tangent, degrees and {look_at: [x, y, z]} do as well\n"

VEHICLE = """\
name: my-quadrotor
mass_kg: 2.0 # ready to take off
inertia_kgm2: [0.022, 0.022, 0.04] # roll, pitch, yaw; 220 kg cm2 are 0.022
gravity: 9.80665 # m/s2
rotors: # four, in the autopilot's motor order; places are forward, right, down from the centre of mass
  - {position_m: [0.17, 0.17, 0.0], spin: ccw, thrust_max_n: 8.5, torque_per_thrust_m: 0.016, command: [0, 1]}
  - {position_m: [-0.17, -0.17, 0.0], spin: ccw, thrust_max_n: 8.5, torque_per_thrust_m: 0.016, command: [0, 1]}
  - {position_m: [0.17, -0.17, 0.0], spin: cw, thrust_max_n: 8.5, torque_per_thrust_m: 0.016, command: [0, 1]}
  - {position_m: [-0.17, 0.17, 0.0], spin: cw, thrust_max_n: 8.5, torque_per_thrust_m: 0.016, command: [0, 1]}
motor_lag_s: 0.025 # how late a rotor's thrust follows
drag_per_s: 0.2 # 1/s, drag over mass and speed
hover_thrust: auto # the throttle that hovers, 0..1; auto learns it in flight
rate_loop_lag_s: 0.06 # how late the autopilot turns as it is told
link_delay_s: 0.01 # from the state to the setpoint that answers it
state_rate_hz: 250 # how often the vehicle is asked for its state
motors: px4 # who mixes: px4, or direct for a vehicle that takes motor commands
limits: # or none
  tilt_deg: 45
  body_rate_dps: [220, 220, 85] # roll, pitch, yaw
  speed: 12 # m/s
  failure_detector_deg: 60 # PX4's FD_FAIL_R and FD_FAIL_P; paths stay 10 degrees under it
"""

WORLD = """\
name: my-world
wind_mps: [3.0, 0.0, 0.0] # where the air goes to: north, east, down
gusts: {sigma_mps: 0.5, length_m: 7.5}
home: {latitude_deg: 47.397742, longitude_deg: 8.545594, altitude_m: 489.4} # where the local frame begins
link:
  down: {delay_s: 0.005, jitter_s: 0.003, loss: 0.001, duplicated: 0.0, reordered: 0.0} # vehicle to companion
  up: {delay_s: 0.005, jitter_s: 0.003, loss: 0.001, duplicated: 0.0, reordered: 0.0}
truth: {mass_kg: 2.05, thrust_scale: 0.98} # the machine as it is, where its vehicle file is wrong
# battery: {capacity_mah: 5000, resistance_ohm: 0.02, full_current_a: 60} # one that sags
estimate: # how wrong the vehicle's idea of its state is
  position: {white_m: 0.005, wander_m: 0.03, wander_s: 3.0}
  velocity: {white_mps: 0.01, wander_mps: 0.03, wander_s: 1.0}
  attitude: {white_deg: 0.06, wander_deg: 0.2, wander_s: 2.0}
  gyro: {white_dps: 0.5}
  drift: {speed_mps: 0.01, time_s: 1.5}
events: # what happens at a time, s
  - {kind: push, from_s: 20, to_s: 21, force_n: [0, 4, 0]} # north, east, down
"""
STUDY = """\
study: my-study # its name
mission: circle_r5 # a name in configs/missions, or a file beside this one
vehicle: x500 # what the companion is told
world: outdoor # what is so
output: rates # auto, motors, rates or attitude
duration: 20 # s of following; the mission's laps where absent
settle: 5 # s after which a flight counts as settled
# from_ground: true # a flight begins on the ground, and ends there
flights: 32
seed: 1 # flight i has seed 1 + i
# sampling: latin # how draws are made: sobol, latin, random, or saltelli, which gives Sobol indices
vary: # mission, vehicle, world, any of their keys, flight.duration ..., or names of your own for formulas
  mission.speed: {choice: [2, 4]} # m/s; a grid of every choice and range with every other
  mass: {normal: [2.0, 0.1]} # kg; also uniform, loguniform, weibull: drawn
  world.truth.mass_kg: {formula: mass}
  world.truth.inertia_kgm2: {formula: [0.011*mass, 0.011*mass, 0.02*mass]}
  world.wind_mps[0]: {uniform: [-4, 4]} # m/s, to the north
# completed: false # giving up in order passes too
require: # of each flight: figures of its summary
  truth.settled.path_error_m.rms: {max: 0.15} # m
pass_rate: 0.95 # the least share of flights that must pass
confidence: 0.95 # how sure the bounds of that share are
"""
KINDS = (*PATHS, "vehicle", "world", "study")
_WHOLE = {"vehicle": VEHICLE, "world": WORLD, "study": STUDY}


def example(kind: str, plan_file: str = "") -> str:
    """The text of an example of ``kind``. ``plan_file``: the name of the plan that an example of kind plan flies."""
    if kind in _WHOLE:
        return editor_line(f"{kind}.schema.json") + _WHOLE[kind]
    plan = kind == "plan"
    origin = "# origin: takeoff # flies the plan's shape from there; where absent it is flown where it was drawn\n"
    around = "laps: 2 # how many times around; until told to stop where absent"
    if kind in OPEN:
        around = "# repeat: back-and-forth # what it does at its end; it ends there where absent"
    return editor_line("mission.schema.json") + MISSION.format(
        kind=kind,
        origin=origin if plan else ORIGIN,
        path=PATHS[kind].replace("{plan}", plan_file),
        speed=PLAN_SPEED if plan else SPEED,
        yaw=PLAN_YAW if plan else YAW,
        around=around,
    ).replace("\n\n\n", "\n\n")


def example_plan() -> str:
    """The text of a small plan: a take-off, four waypoints, a change of speed."""
    latitude, longitude, altitude = 47.397742, 8.545594, 488.0
    items: list[Item] = []

    def waypoint(north: float, east: float, height: float, command: int = MAV_CMD_NAV_WAYPOINT) -> None:
        place = (round(latitude + north / 111194.93, 8), round(longitude + east / 75270.0, 8), height)
        items.append(Item(command, 3, (0.0, 0.0, 0.0, math.nan, *place), len(items) + 1, ()))

    waypoint(0.0, 0.0, 10.0, MAV_CMD_NAV_TAKEOFF)
    waypoint(30.0, 0.0, 10.0)
    items.append(Item(MAV_CMD_DO_CHANGE_SPEED, 2, (1.0, 3.0, -1.0, 0.0, 0.0, 0.0, 0.0), len(items) + 1, ()))
    waypoint(30.0, 25.0, 12.0)
    waypoint(0.0, 25.0, 12.0)
    return plan_text(Plan(tuple(items), Home(latitude, longitude, altitude), 5.0))
