"""A mission made ready to fly: its law recorded for one vehicle at one output level, in the vehicle's own place."""

from __future__ import annotations

from dataclasses import dataclass

from companion.estimation.learned import Learned, prior_of
from companion.flight.conduct import Conduct
from companion.frames import Heading, Vec3
from companion.law.feedback import bounds_of
from companion.law.flight import Law, OverArc, curve_law, implicit_law, model_of
from companion.law.gains import Gains, Level, auto_gains, default_gains, law_level, mean_pole, path_pole_of
from companion.law.hold import HoldLaw, hold_law
from companion.mission import Mission
from companion.paths.arc import ArcTable
from companion.paths.implicit import ImplicitPath
from companion.profiles import SpeedProfile, YawProfile
from companion.profiles.ends import start_time
from companion.steering.assembly import motor_steering, rate_steering
from companion.steering.encoding import AsRates, as_attitude
from companion.steering.speed_governor import Course, course_of
from companion.steering.steering import Steering
from companion.steering.torques import torque_steering
from companion.steering.yaw import thrust_per_rate, yaw_integral
from companion.vehicle import OutputLevel, Tuning, Vehicle

HOVER_THRUST = 0.5
"""Normalised, where neither the vehicle nor its file says. PX4's own first guess (MPC_THR_HOVER)."""
HOLD = 0.004
"""s, half the time a command is held until the next one. PX4 is asked for states at 125 Hz."""
SPEED_SAMPLES = 400
"""Number of places along the path among which the greatest speed is looked for. Engineering choice."""
NOT_SAID = Tuning()
AS_USUAL = Conduct()


@dataclass(frozen=True)
class Plan:
    """What is to be flown, by one vehicle at one output level."""

    mission: Mission  # placed in the vehicle's local frame
    vehicle: Vehicle
    level: OutputLevel
    steering: Steering  # the law for the vehicle at the level
    table: ArcTable  # the mission's curve
    direction: float  # +1 along mu, -1 against
    ramp_time: float  # s until full speed, 0 for none
    laps: float | None  # after which following is finished; None: until told
    duration: float | None  # s after which it is; None: until told
    tuning: Tuning = NOT_SAID  # what the autopilot's parameters say
    conduct: Conduct = AS_USUAL  # how the flight is conducted
    learned: Learned | None = None  # what the vehicle's last flight left
    path_pole: float | None = None  # 1/s, of h1 and h2 where it was chosen and may be lowered; None: as written


def prepared(
    mission: Mission,
    vehicle: Vehicle,
    level: OutputLevel,
    origin_n: Vec3,
    duration: float | None = None,
    tuning: Tuning = NOT_SAID,
    conduct: Conduct = AS_USUAL,
    learned: Learned | None = None,
) -> Plan:
    """The plan for a mission whose origin lies at ``origin_n`` of the vehicle's local frame.

    ``tuning``: what its autopilot said. ``learned``: what its last flight found out. CompanionError: it cannot be
    flown. Takes tens of milliseconds: do it before the flight.
    """
    placed = mission.placed(origin_n)
    table = placed.table
    speeds = [placed.alpha(table.length * i / SPEED_SAMPLES) for i in range(SPEED_SAMPLES)]
    direction = 1.0 if speeds[0] > 0.0 else -1.0
    usual = default_gains(law_level(level))
    gains = gains_of(placed, vehicle, level, tuning, learned)
    chosen = placed.gains is None and vehicle.limits is not None
    path_pole = path_pole_of(gains) if chosen else None
    bounds = bounds_of(vehicle, mean_pole(gains.h1) if chosen else None)
    law: Law
    if isinstance(placed.path, ImplicitPath):
        over_arc = OverArc(
            table,
            placed.speed if isinstance(placed.speed, SpeedProfile) else None,
            placed.yaw if isinstance(placed.yaw, YawProfile) else None,
        )
        law = implicit_law(
            placed.specification(direction), law_level(level), model_of(vehicle), gains, bounds, over_arc
        )
    else:
        law = curve_law(
            placed.path, placed.speed, placed.yaw, law_level(level), model_of(vehicle), gains, bounds, direction,
            placed.heading,
        )  # fmt: skip
    course = None if bounds is None else course_of(table, placed.alpha, placed.closed, direction, placed.beta)
    hold = hold_law(law_level(level), model_of(vehicle), usual, bounds, placed.heading)
    ramp_time = 0.0 if vehicle.limits is None else start_time(max(map(abs, speeds)))
    return Plan(
        mission=placed,
        vehicle=vehicle,
        level=level,
        steering=_steering(law, hold, vehicle, level, tuning, gains, course, learned, placed.heading, path_pole),
        table=table,
        direction=direction,
        ramp_time=ramp_time,
        laps=placed.laps,
        duration=duration,
        tuning=tuning,
        conduct=conduct,
        learned=learned,
        path_pole=path_pole,
    )


def gains_of(mission: Mission, vehicle: Vehicle, level: OutputLevel, tuning: Tuning, learned: Learned | None) -> Gains:
    """The mission's gains; where it writes none, those that are chosen for the vehicle."""
    if mission.gains is not None:
        return mission.gains
    if vehicle.limits is None:  # the paper's: nothing is to be chosen of what it is to be
        return default_gains(law_level(level))
    lag = vehicle.rate_loop_lag if learned is None else learned.rate_lag
    if law_level(level) is Level.MOTORS:
        lag = vehicle.motor_lag
    if level is OutputLevel.ATTITUDE:
        lag += as_attitude(tuning).smoothing
    waiting = vehicle.dead_time + HOLD
    # at attitude PX4 holds the last thrust for a second: the height is to be caught without tilting far
    thrust_horizon = None if level is OutputLevel.ATTITUDE else vehicle.motor_lag + waiting
    return auto_gains(law_level(level), lag + waiting, thrust_horizon)


def _steering(
    law: Law,
    hold: HoldLaw,
    vehicle: Vehicle,
    level: OutputLevel,
    tuning: Tuning,
    gains: Gains,
    course: Course | None,
    learned: Learned | None,
    heading: Heading,
    path_pole: float | None,
) -> Steering:
    lag, yaw_lag = (None, None) if learned is None else (learned.rate_lag, learned.yaw_lag)
    highest_gain = max(gains.h1[-1], default_gains(law_level(level)).h1[-1])  # the hold's law has the usual gains
    if law_level(level) is Level.MOTORS:
        prior = prior_of(learned, vehicle.weight / vehicle.thrust_max, vehicle.drag)
        lift_gain = highest_gain if gains.vertical is None else max(gains.vertical[-1], highest_gain)
        motors = motor_steering(law, hold, vehicle, prior, highest_gain, lift_gain, course, lag, yaw_lag, path_pole)
        return motors if level is OutputLevel.MOTORS else torque_steering(motors)
    hover = tuning.hover_thrust or vehicle.hover_thrust or HOVER_THRUST
    encoding = AsRates() if level is OutputLevel.RATES else as_attitude(tuning)
    prior = prior_of(learned, hover, vehicle.drag)
    per_rate = thrust_per_rate(tuning)
    return rate_steering(
        law,
        hold,
        vehicle,
        encoding,
        hover,
        prior,
        gains.h4[0],
        highest_gain,
        course,
        lag,
        heading,
        per_rate,
        path_pole,
        yaw_lag,
        yaw_integral(tuning),
    )
