"""The steering of each level put together for a vehicle."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.allocation import Allocation
from companion.calculus import machine_code
from companion.estimation.body_model import Body
from companion.estimation.estimator import Prior
from companion.estimation.rate_loop_model import LAG_MIN, YAW_INTEGRAL_RATE, alike
from companion.frames import Heading
from companion.law.flight import Law
from companion.law.gains import AUTO_POLE_RANGE, PATH_POLES, Level
from companion.law.hold import HoldLaw
from companion.steering.encoding import Encoding
from companion.steering.motors import MotorSteering
from companion.steering.path_poles import AS_WRITTEN, TILT_BEYOND, PoleChoice, steep_scale
from companion.steering.rates import RateSteering
from companion.steering.speed_governor import Course
from companion.steering.tilt_barrier import STEADY_AT_MOTORS, STEADY_UNDER_DETECTOR
from companion.steering.yaw import USUAL_THRUST_PER_RATE, ThrustPerRate, usual_yaw_lag
from companion.steering.yaw_forecast import recorded_forecast
from companion.thrust_range import thrust_range_of
from companion.vehicle import TILT_MARGIN, MotorInterface, Vehicle

TILT_MAX = math.radians(80.0)
"""rad, of a vehicle without a limit: its tangent is still a number. Engineering choice."""


def pole_choice(
    path_pole: float, vehicle: Vehicle, course: Course | None = None, level: Level = Level.RATES
) -> PoleChoice:
    """How far poles (1/s) that were chosen may be lowered: to the least that is chosen, AUTO_POLE_RANGE. ``course``:
    the path, which may be steep."""
    least, limits = min(1.0, -AUTO_POLE_RANGE[level][0] / path_pole), vehicle.limits
    steepest, most = math.inf if limits is None else limits.failure_detector, 1.0
    if course is not None:
        across, fastest = course.hardest
        lean = math.atan2(math.hypot(across, vehicle.drag * fastest), vehicle.gravity)
        most = max(steep_scale(lean + TILT_BEYOND, -path_pole, steepest), least)
    return PoleChoice(least, PATH_POLES[level][0] / path_pole, most, -path_pole, steepest)


def rate_steering(
    law: Law,
    hold: HoldLaw,
    vehicle: Vehicle,
    encoding: Encoding,
    hover_thrust: float,
    prior: Prior,
    yaw_gain: float,
    tilt_gain: float,
    course: Course | None = None,
    lag: float | None = None,
    heading: Heading = Heading.PROJECTED,
    per_rate: ThrustPerRate = USUAL_THRUST_PER_RATE,
    path_pole: float | None = None,
    yaw_lag: float | None = None,
    yaw_integral: float = YAW_INTEGRAL_RATE,
) -> RateSteering:
    """Steering for ``vehicle``. ``yaw_gain``: 1/s, of h4. ``tilt_gain``: 1/s, the law's largest on the tilt.
    ``course``: what lies ahead; None: the speed never yields. ``lag``: s, of its rate loop as last found; None: as its
    file says. ``per_rate``: what rate errors take of the motors' range. ``path_pole``: 1/s, of h1 and h2 where they
    were chosen; None: they are as written. ``yaw_lag``: s, of its yaw loop as last found; None: a usual one.
    ``yaw_integral``: 1/s, of its yaw rate loop."""
    whole = max(vehicle.rate_loop_lag, LAG_MIN) + encoding.smoothing
    rate_loop = alike(whole, vehicle.motor_lag, yaw_lag or usual_yaw_lag(vehicle.rate_loop_lag))
    rate_loop = rate_loop._replace(yaw_integral=yaw_integral)
    if course is not None:
        recorded_forecast(heading, machine_code.in_use)  # now and not in the first tick along the path
    return RateSteering(
        law=law,
        hold=hold,
        vehicle=vehicle,
        range=thrust_range_of(vehicle),
        rate_loop=rate_loop,
        hover_thrust=hover_thrust,
        prior=prior,
        encoding=encoding,
        yaw_gain=yaw_gain,
        tilt_gain=tilt_gain,
        course=course,
        tan_tilt_max=tan_tilt_max(vehicle, STEADY_UNDER_DETECTOR),
        lag=rate_loop.lag if lag is None else lag + encoding.smoothing,
        heading=heading,
        per_rate=per_rate,
        path_pole=math.nan if path_pole is None else path_pole,
        pole_choice=AS_WRITTEN if path_pole is None else pole_choice(path_pole, vehicle, course),
    )


def motor_steering(
    law: Law,
    hold: HoldLaw,
    vehicle: Vehicle,
    prior: Prior,
    rate_gain: float,
    lift_gain: float,
    course: Course | None = None,
    lag: float | None = None,
    yaw_lag: float | None = None,
    path_pole: float | None = None,
) -> MotorSteering:
    """Steering for ``vehicle``. ``rate_gain``, ``lift_gain``: 1/s, the law's largest on the body rates and on the rate
    of the thrust. ``course``, ``lag``, ``yaw_lag``, ``path_pole``: see ``rate_steering``; the lags are kept for a
    flight on rates.
    AllocationError: rotors that cannot make every thrust and torque."""
    allocation = Allocation(vehicle)
    _ = allocation.inverse
    guarded = _guarded(vehicle)
    return MotorSteering(
        law=law,
        hold=hold,
        vehicle=vehicle,
        allocation=allocation,
        range=thrust_range_of(vehicle),
        body=Body(vehicle.mass, vehicle.inertia, vehicle.motor_lag),
        prior=prior,
        rate_gain=rate_gain,
        lift_gain=lift_gain,
        course=course,
        limits=guarded.limits,
        tan_tilt_max=tan_tilt_max(guarded, STEADY_AT_MOTORS),
        rate_lag=vehicle.rate_loop_lag if lag is None else lag,
        yaw_lag=yaw_lag or 0.0,
        path_pole=math.nan if path_pole is None else path_pole,
        pole_choice=AS_WRITTEN if path_pole is None else pole_choice(path_pole, guarded, course, Level.MOTORS),
    )


def _guarded(vehicle: Vehicle) -> Vehicle:
    """``vehicle``, with the tilt at which we hand it back in the place of its failure detector where that comes first:
    where PX4 flies rates itself and is told motors instead. Simulated on sih_noisy, circle r5 at 7 m/s, handed back
    from 55 deg on: with a steady tilt of 49 deg one flight of four was, 49 told as 58; with 47 none."""
    limits = vehicle.limits
    if limits is None or vehicle.motors is MotorInterface.DIRECT:
        return vehicle
    if limits.caught_tilt >= limits.failure_detector - TILT_MARGIN:  # where rates are handed back too
        return vehicle
    return replace(vehicle, limits=replace(limits, failure_detector=limits.caught_tilt))


def tan_tilt_max(vehicle: Vehicle, under_detector: float) -> float:
    """Tangent of the steepest steady tilt of a path, ``under_detector`` rad at least; where it would be more, in wind,
    the speed gives way."""
    limits = vehicle.limits
    if limits is None:
        return math.inf
    return math.tan(min(limits.tilt + TILT_MARGIN, limits.failure_detector - under_detector, TILT_MAX))
