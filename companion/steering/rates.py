"""Body rates and thrust: the paper's design one order earlier, for a vehicle that mixes its own motors.

Jerk -> body rates and the rate of the thrust. Between a state and the effect of its command lie the link and the rate
loop; so the law is evaluated where its command acts, at the state predicted under the commands already sent. What the
vehicle does not say (thrust scale, drag, wind, its estimator's bias) is observed on the way.

Thrust goes out normalised, hover_thrust at one g. PX4 makes it linear in the force by its own THR_MDL_FAC before it
reaches the motors, and MPC_THR_HOVER counts in the same units, so nothing is to be inverted here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from companion.estimation.kalman import DRAG, KAPPA
from companion.estimation.lag import Lag, begun_anew, first_lag, followed_lag
from companion.estimation.learned import FLOWN_MIN, Learned
from companion.estimation.observer import Observed, Prior, Seen, can_wait, expected, first_observed, observed
from companion.estimation.prediction import Ahead, Known, predicted
from companion.estimation.response import LAG_MIN, YAW_TORQUE_LAG, Inner, Response, Sent, corrected, followed
from companion.frames import Heading, Quaternion, Vec3, rotation_matrix, turned, upright_error, wrap
from companion.law.bare import LawError
from companion.law.flight import Command, Flying, Law
from companion.law.hold import HoldLaw
from companion.steering.encoding import Encoding
from companion.steering.pace import Course, Means, Pace, paced, slowed
from companion.steering.steering import Aim, Along, Estimates, Steered
from companion.steering.thrust import ThrustRange, thrust_range
from companion.vehicle import Setpoint, Vehicle, VehicleState

TILTING_MAX = 4.0
"""rad/s of roll and pitch rate."""
THRUST_MIN, THRUST_MAX = 0.05, 0.97
"""Normalised: the range that is sent. A little is left for the vehicle's own rate loop."""
MOVING = 0.5
"""m/s: a vehicle told to fly faster is expected to move."""
YAW_LEAD, YAW_LEAD_OVER_LAG = 0.36, 6.0
"""s, how much earlier than it is wanted a yaw rate is asked for: the lag of PX4's yaw loop for what turns at 1 to 3
rad/s. A vehicle whose other rate loops are quicker than PX4's usual ones is not led by more than so many of their lags.
"""
YAW_ONCE_MORE = 1.0
"""Of a missing yaw rate, for PX4's usual loops: it doubles the gain of a soft yaw loop, which would leave a heading
that gusts have turned away for long. Up to 1 no loop that is stable by itself is made unstable by it. Where PX4 smooths
what it is sent, it comes late and would swing the nose at 4 to 8 rad/s; there it is less."""
YAW_SUM_GAIN, YAW_SUM_MAX, YAW_SUM_WITHIN = 0.07, 0.3, 0.3
"""Of the square of the yaw gain (a quarter would put both poles of the heading at half the gain); rad/s; rad of error
within which it is summed."""
YAW_SHARE, TILT_SHARE, YAW_ROOM_MIN = 0.2, 0.06, 0.05
"""Of the motors' range that 1 rad/s of yaw rate error takes (MC_YAWRATE_P), and one of roll or pitch (a large one lasts
less long than yaw's torque is filtered); rad/s that are always left to yaw."""
SLOPE_OVER = 0.05
"""s over which the slope of the yaw rate is taken."""
STRAINED = 0.9
"""Normalised thrust above which single motors meet their limits and nothing is learned."""
LEAN_MARGIN, LEAN_MOST = math.radians(2.0), math.radians(80.0)
"""rad: the steady lean of a path may be so much over the vehicle's limit, and stays so much under its failure detector.
"""
PX4_STEP, DELAY_MAX, DELAY_SLEW = 0.004, 0.2, 0.05
"""s: a setpoint acts at PX4's next step; the longest delay that is believed; s of change a second."""
KEPT = 0.06
"""s that commands are kept after they have acted."""
GAP_MAX = 0.5
"""s without a state after which what was flown meanwhile is not known."""
LEVEL_GAIN, LEVEL_RATE_MAX = 3.0, 2.0


class RateMemory(NamedTuple):
    """``state``: the last one, with ``inner`` at its stamp and ``p_n``, ``v_n`` where it is believed to be then.
    ``observed``: what was learned up to it, or up to the one before where ``to_learn`` is still to be learned from.
    ``sent``: the commands that act at or after it. ``zeta``: N, the thrust at the horizon. ``limited``: whether the
    last command met a limit. ``yaw_sum``: rad/s, what a heading error that stays has added up to. ``pace``: see there.
    ``moving``: whether it was told to fly somewhere. ``lag``: of its rate loop, as found, and its ``response`` with
    it. ``delay``: s from a state to the effect of its command on the motors, as followed; None before the first step.
    ``slope``: rad/s^2, of the yaw rate, as last taken. ``asked``: where it is to be taken next: at what was asked of
    the law, and what it answered."""

    state: VehicleState
    observed: Observed
    p_n: Vec3
    v_n: Vec3
    inner: Inner
    sent: tuple[Sent, ...]
    zeta: float
    lag: Lag
    response: Response
    to_learn: Seen | None = None
    limited: bool = False
    yaw_sum: float = 0.0
    pace: Pace = Pace()
    moving: bool = False
    delay: float | None = None
    slope: float = 0.0
    asked: tuple[Flying, Command, Aim] | None = None


@dataclass(frozen=True, slots=True)
class RateSteering:
    """The law at the level of rates for one vehicle. ``hover_thrust``: normalised, as told; the rest is observed.
    ``encoding``: rates as they are, or as the attitude that PX4's own loop turns back into them; what it smooths makes
    the rate loop so much later."""

    law: Law
    hold: HoldLaw
    vehicle: Vehicle
    range: ThrustRange
    response: Response
    hover_thrust: float
    prior: Prior
    encoding: Encoding
    yaw_gain: float
    course: Course | None = None
    lean: float = math.inf
    lag: float = 0.06
    heading: Heading = Heading.PROJECTED

    def begin(self, state: VehicleState) -> RateMemory:
        """Hovering, as far as anybody knows."""
        return self._begun(state, self.prior)

    def steer(
        self, memory: RateMemory, state: VehicleState, dt: float, aim: Aim, link_delay: float | None = None
    ) -> Steered:
        """See Steering."""
        memory = self.learn(memory)
        gap = state.t_boot - memory.state.t_boot
        if dt == 0.0 or gap > GAP_MAX:
            memory = self._again(memory, state)
        elif gap > 0.0:
            memory = self._seen(memory, state, gap)
        vehicle, belief = self.vehicle, memory.observed.belief
        most_lift = THRUST_MAX * belief.kappa * vehicle.gravity / self.hover_thrust
        pace = Pace()
        if isinstance(aim, Along) and self.course is not None:
            means = Means(most_lift, self.lean, belief.drag, belief.disturbance_n, vehicle.gravity)
            pace = paced(memory.pace, self.course, aim.s, aim.ramp, means, dt)
            aim = Along(aim.s, slowed(aim.ramp, pace))
        acts_after = self._delay(memory.delay, link_delay, dt)
        half = 0.5 * dt  # a command is held until the next one
        smoothing = self.encoding.smoothing
        lag = memory.response.lag  # with the smoothing
        there = self._ahead(memory, acts_after + half + lag)
        zeta = memory.zeta
        flying = Flying(
            p_n=there.p_n,
            v_n=there.v_n,
            r_nb=rotation_matrix(there.q_nb),
            zeta=zeta,
            disturbance=belief.disturbance_n,
            drag=belief.drag,
            s=aim.s if isinstance(aim, Along) else 0.0,
        )
        command = self._asked(flying, aim)
        per_lift = vehicle.mass * belief.kappa
        highest = min(self.range.high, most_lift * vehicle.mass)
        # the rate loop of a vehicle that is held must not wind up; its thrust settles at what the path asks of a
        # vehicle at rest that leans like this, so that it is not flung away when it is let go
        stuck = memory.observed.stuck
        later, slope, bound = self.range.integrated(zeta, command.zeta_derivative, dt, highest)
        p, q, r = command.turn
        yaw_sum = self._yaw_summed(memory.yaw_sum, command, dt)
        yaw_lead = min(YAW_LEAD, YAW_LEAD_OVER_LAG * vehicle.rate_loop_lag)
        # what the yaw rate will be short of is asked for once more
        once_more = YAW_ONCE_MORE * yaw_lead / YAW_LEAD * (1.0 - smoothing / lag) ** 2
        r += (yaw_lead - lag) * memory.slope + once_more * (r - there.w_b[2])
        r -= memory.inner.yaw_trim + yaw_sum
        # yaw is turned by torque that thrust and tilting may need when it comes: near the top it waits
        share = (zeta + slope * YAW_TORQUE_LAG) / (vehicle.mass * most_lift) * THRUST_MAX
        share += TILT_SHARE * (abs(p - there.w_b[0]) + abs(q - there.w_b[1]))
        room = max(YAW_ROOM_MIN, (THRUST_MAX - share) / YAW_SHARE)
        turning = there.w_b[2] - memory.inner.yaw_trim
        r = min(max(r, turning - room), turning + room)
        gain = memory.lag.gain
        less, clipped = self._clipped((0.0, 0.0, 0.0) if stuck else (p / gain, q / gain, r))
        rates = (less[0] * gain, less[1] * gain, less[2])
        # thrust answers sooner than the rates do
        lift = (zeta + slope * (half - (lag - self.response.motor_lag))) / per_lift
        wanted = lift * self.hover_thrust / vehicle.gravity
        thrust = min(max(wanted, THRUST_MIN), THRUST_MAX)
        lift = thrust * vehicle.gravity / self.hover_thrust
        # what is smoothed is not held as well: PX4's model moves on when a new setpoint comes; its loop runs in steps
        followed_after = acts_after + max(half, smoothing, 0.5 * PX4_STEP) - 0.5 * PX4_STEP
        q_nb = self._ahead(memory, followed_after).q_nb if self.encoding.needs_attitude else state.q_nb
        at = max(state.t_boot + acts_after, memory.sent[-1].at)
        sent = (*memory.sent, Sent(at, rates, lift))
        limited = bound or clipped or thrust != wanted
        after = memory._replace(
            sent=sent, zeta=later, yaw_sum=yaw_sum, pace=pace, limited=limited or thrust > STRAINED,
            delay=acts_after,
            # every other step is often enough for a slope
            asked=(flying, command, aim) if memory.asked is None else None,
            moving=isinstance(aim, Along) and abs(command.alpha * aim.ramp.factor) > MOVING,
        )  # fmt: skip
        return Steered(
            setpoint=self.encoding.setpoint(less, thrust, q_nb),
            memory=after,
            command=command,
            zeta=later,
            zeta_dot=slope,
            thrust_n=lift * per_lift,
            saturated=limited,
            thrust_share=thrust,
            converged=memory.observed.converged,
            pace=pace.factor,
            estimates=Estimates(
                belief.kappa, belief.drag, belief.disturbance_n, belief.bias_n, acts_after, lag - smoothing
            ),
        )

    def learn(self, memory: RateMemory) -> RateMemory:
        """See Steering."""
        seen, asked = memory.to_learn, memory.asked
        if seen is None:
            return memory
        state, lag, response = memory.state, memory.lag, memory.response
        known = observed(memory.observed, seen, self.vehicle.gravity)
        slope = memory.slope if asked is None else self._yaw_slope(*asked)
        # what was clipped or held did not happen as it was sent
        if seen.limited or known.stuck:
            lag = begun_anew(lag, state.w_b)
        else:
            lag = followed_lag(lag, response.motor_lag, memory.sent, state.t_boot, state.w_b)
        if lag.value != memory.lag.value:
            response = _response(lag, response.motor_lag)
        return memory._replace(
            observed=known, p_n=known.belief.p_n, v_n=known.belief.v_n, to_learn=None, slope=slope, lag=lag,
            response=response,
        )  # fmt: skip

    def _asked(self, flying: Flying, aim: Aim) -> Command:
        return self.law(flying, aim.ramp) if isinstance(aim, Along) else self.hold(flying, *aim)

    def _yaw_summed(self, yaw_sum: float, command: Command, dt: float) -> float:
        """The sum of the heading error, which a yaw loop that falls short of its peaks would leave behind."""
        error = wrap(command.yaw - command.beta)
        if abs(error) < YAW_SUM_WITHIN:
            yaw_sum += YAW_SUM_GAIN * self.yaw_gain * self.yaw_gain * error * dt
        return min(max(yaw_sum, -YAW_SUM_MAX), YAW_SUM_MAX)

    def _yaw_slope(self, flying: Flying, command: Command, aim: Aim) -> float:
        """rad/s^2, how the yaw rate the law asks for is about to change: asked again, a moment later in the motion it
        wants, the heading error as it is. PX4's yaw loop is several times slower than the tilting ones and needs this
        lead; none where the law is not defined then, which it will say itself when it comes there."""
        h, vehicle = SLOPE_OVER, self.vehicle
        r, lift = flying.r_nb, flying.zeta / vehicle.mass
        (x, y, z), (vx, vy, vz), (dx, dy, dz), c = flying.p_n, flying.v_n, flying.disturbance, flying.drag
        ax, ay, az = dx - lift * r[2] - c * vx, dy - lift * r[5] - c * vy, vehicle.gravity + dz - lift * r[8] - c * vz
        g = 0.5 * h
        p, q, s = command.turn
        # without the part that turns the heading error out
        per_turn = 1.0 if self.heading is Heading.TWIST else (r[0] * r[0] + r[3] * r[3]) / max(r[8], 0.2)
        s += self.yaw_gain * wrap(command.yaw - command.beta) * per_turn
        later = flying._replace(
            p_n=(x + h * (vx + g * ax), y + h * (vy + g * ay), z + h * (vz + g * az)),
            v_n=(vx + h * ax, vy + h * ay, vz + h * az),
            r_nb=turned(r, (p, q, s), h),
            zeta=max(flying.zeta + h * command.zeta_derivative, 0.5 * flying.zeta),
        )
        try:
            return (self._asked(later, aim).turn[2] - command.turn[2]) / h
        except LawError:
            return 0.0

    def level(self, state: VehicleState | None, memory: RateMemory | None = None) -> Setpoint:
        """See Steering."""
        thrust, rates = self.hover_thrust, (0.0, 0.0, 0.0)
        q_nb: Quaternion = (1.0, 0.0, 0.0, 0.0)
        if memory is not None:
            thrust /= memory.observed.belief.kappa
            q_nb = memory.state.q_nb
        if state is not None:
            q_nb = state.q_nb
            error_x, error_y = upright_error(state.r_nb)
            most = LEVEL_RATE_MAX
            rates = (
                min(max(LEVEL_GAIN * error_x, -most), most), min(max(LEVEL_GAIN * error_y, -most), most), 0.0
            )  # fmt: skip
        return self.encoding.level(rates, min(max(thrust, THRUST_MIN), THRUST_MAX), q_nb)

    def learned(self, memory: RateMemory) -> Learned | None:
        """What this flight found out of its vehicle; None if it was too short or not settled."""
        known = memory.observed
        if known.flown < FLOWN_MIN or not known.converged:
            return None
        lag = memory.lag.value - self.encoding.smoothing
        return Learned(self.hover_thrust / known.belief.kappa, known.belief.drag, lag)

    def _again(self, memory: RateMemory, state: VehicleState) -> RateMemory:
        """A beginning that keeps what was learned of the vehicle."""
        belief = memory.observed.belief
        kappa = (belief.kappa, math.sqrt(belief.variance(KAPPA)))
        drag = (belief.drag, math.sqrt(belief.variance(DRAG)))
        again = self._begun(state, Prior(kappa, drag))
        lag = begun_anew(memory.lag, state.w_b)
        return again._replace(lag=lag, response=memory.response, delay=memory.delay)

    def _begun(self, state: VehicleState, prior: Prior) -> RateMemory:
        vehicle = self.vehicle
        r = state.r_nb
        known = first_observed(state.p_n, state.v_n, r, vehicle.gravity, prior)
        upright = max(r[8], 0.5)
        inner = Inner(state.w_b, (0.0, 0.0, 0.0), vehicle.gravity / (upright * known.belief.kappa))
        first = Sent(-math.inf, state.w_b, inner.lift)
        lag = first_lag(self.lag, state.w_b, self.response.lag)
        p_n, v_n = known.belief.p_n, known.belief.v_n
        response = _response(lag, self.response.motor_lag)
        return RateMemory(state, known, p_n, v_n, inner, (first,), vehicle.weight / upright, lag, response)

    def _seen(self, memory: RateMemory, state: VehicleState, gap: float) -> RateMemory:
        """What is known with a new state, ``gap`` s after the last one."""
        before, now = memory.state, state.t_boot
        inner, lift = followed(memory.inner, memory.response, memory.sent, before.t_boot, now)
        inner = corrected(inner, state.w_b, gap)
        # the thrust axis, a mean of both ends
        old, new = before.r_nb, state.r_nb
        half = 0.5 * lift
        lift_n = (half * (old[2] + new[2]), half * (old[5] + new[5]), half * (old[8] + new[8]))
        known, jumped = memory.observed, state.resets != before.resets
        seen = Seen(gap, lift_n, state.p_n, state.v_n, memory.limited, jumped, memory.moving)
        p_n, v_n = expected(known.belief, seen, self.vehicle.gravity)
        sent = memory.sent
        past = 0
        while past + 1 < len(sent) and sent[past + 1].at <= now - KEPT:
            past += 1
        memory = memory._replace(
            state=state, p_n=p_n, v_n=v_n, to_learn=seen, inner=inner, sent=sent[past:]
        )  # fmt: skip
        return memory if can_wait(known, seen, p_n, v_n) else self.learn(memory)

    def _delay(self, before: float | None, link_delay: float | None, dt: float) -> float:
        """s from a state to the effect of its command: the link there and back, and PX4's next step. It changes
        slowly, because the commands on their way are ordered by it."""
        now = self.vehicle.link_delay if link_delay is None else link_delay + PX4_STEP
        now = min(max(now, 0.0), DELAY_MAX)
        if before is None or dt == 0.0:
            return now
        most = DELAY_SLEW * dt
        return before + min(max(now - before, -most), most)

    def _ahead(self, memory: RateMemory, horizon: float) -> Ahead:
        """The vehicle ``horizon`` s after the last state."""
        belief = memory.observed.belief
        known = Known(belief.kappa, belief.drag, belief.disturbance_n, self.vehicle.gravity)
        state = memory.state
        return predicted(
            memory.p_n,
            memory.v_n,
            state.q_nb,
            memory.inner,
            known,
            memory.response,
            memory.sent,
            state.t_boot,
            horizon,
        )

    def _clipped(self, turn: Vec3) -> tuple[Vec3, bool]:
        """Rates within what the vehicle may be asked for, and whether roll or pitch had to give way."""
        limits = self.vehicle.limits
        if limits is None:
            return turn, False
        p_most, q_most, r_most = limits.body_rates
        p_most, q_most = min(p_most, TILTING_MAX), min(q_most, TILTING_MAX)
        p, q, r = turn
        clipped = (min(max(p, -p_most), p_most), min(max(q, -q_most), q_most), min(max(r, -r_most), r_most))
        return clipped, clipped[:2] != (p, q)


def _response(lag: Lag, motor_lag: float) -> Response:
    """The vehicle's response as found, on a grid of a millisecond."""
    return Response(round(lag.value, 3), motor_lag)


def rate_steering(
    law: Law,
    hold: HoldLaw,
    vehicle: Vehicle,
    encoding: Encoding,
    hover_thrust: float,
    prior: Prior,
    yaw_gain: float,
    course: Course | None = None,
    lag: float | None = None,
    heading: Heading = Heading.PROJECTED,
) -> RateSteering:
    """Steering for ``vehicle``. ``yaw_gain``: 1/s, of h4. ``course``: what lies ahead; None: the speed never yields.
    ``lag``: s, of its rate loop as last found; None: as its file says."""
    response = Response(max(vehicle.rate_loop_lag, LAG_MIN) + encoding.smoothing, vehicle.motor_lag)
    limits = vehicle.limits
    lean = math.inf
    if limits is not None:
        lean = math.tan(min(limits.tilt + LEAN_MARGIN, limits.failure_detector - LEAN_MARGIN, LEAN_MOST))
    return RateSteering(
        law=law,
        hold=hold,
        vehicle=vehicle,
        range=thrust_range(vehicle),
        response=response,
        hover_thrust=hover_thrust,
        prior=prior,
        encoding=encoding,
        yaw_gain=yaw_gain,
        course=course,
        lean=lean,
        lag=response.lag if lag is None else lag + encoding.smoothing,
        heading=heading,
    )
