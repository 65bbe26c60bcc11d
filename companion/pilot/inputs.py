"""What the guards look at, gathered from what is remembered and what is seen."""

from __future__ import annotations

import math

from companion.flight import conditions, preflight, safety
from companion.flight.bench import fault as bench_fault
from companion.flight.conduct import ControlAuthority
from companion.flight.link_needs import NEEDS, RATE_WANTED
from companion.flight.phases import FLOWN, PHASES, Phase
from companion.flight.situation import Situation
from companion.frames import clamped
from companion.pilot.memory import Memory, Observation
from companion.pilot.targets import END_WITHIN, goes_back, is_at, remaining, rests
from companion.plan import Plan
from companion.vehicle import KnownStatus, Mode, RateSetpoint, VehicleStatus

REHEARSED_FOR = 5.0
"""s of rehearsal where no duration is given. Engineering choice."""
RESTS_FOR = 4.0
"""s of holding the place after which the thrust is known well enough, whatever its variance (engineering choice)."""
THRUST_WATCHED = (Phase.JOIN, Phase.FOLLOW, Phase.REST)
"""The phases in which the thrust that comes is held against what is commanded."""
FOLLOWS_FOR = 0.6
"""s after its CURRENT_MODE said OFFBOARD that a vehicle is taken to follow what is commanded: PX4 sends one every 0.5 s
and on change. A HEARTBEAT is too old a word: who lands meanwhile would be told that his thrust does not answer."""
COMMANDED_FOR = 1.1
"""s, the same for commands over XRCE, where PX4's client says over that link at once that OFFBOARD was left: one
CURRENT_MODE may be lost. At FOLLOWS_FOR a single lost one would end the flight. Engineering choice."""
THRUST_AFTER = 0.3
"""s that the thrust was followed before it is judged, after settling. Engineering choice."""
THRUST_AFTER_AT_ONCE = 4.0
"""s, the same where nothing was settled. Engineering choice."""
STILL = 0.15
"""m/s and rad/s below which the vehicle stands. Engineering choice."""


def safety_inputs(
    plan: Plan, memory: Memory, observation: Observation, status: KnownStatus, now: float
) -> conditions.SafetyInputs:
    """What the safety rows look at at ``now``, s by our clock."""
    state, progress, limits = memory.state, memory.path.progress, plan.conduct.limits
    watch, (_, _, place_stands, attitude_stands, velocity_off, rates_off, response) = memory.watch, memory.agreement
    if state is None:
        return conditions.SafetyInputs(status, rate=observation.rate, companions=observation.companions)
    x, y, z = state.p_n
    fence, home = plan.mission.fence_n, limits.home
    steered = memory.steering.steered if memory.phase in FLOWN else None
    follows = follows_commands(observation.status, now)
    asked = None if steered is None else steered.setpoint
    turning = math.hypot(*state.w_b)
    return conditions.SafetyInputs(
        status=status,
        following=memory.phase is Phase.FOLLOW and memory.path.reached,
        path_error=0.0 if progress is None else progress.path_error,
        height=None if limits.ground is None else limits.ground - z,
        fence_margin=math.inf if fence is None else fence.margin(state.p_n),
        from_home=None if home is None else math.hypot(x - home[0], y - home[1]),
        above_home=None if home is None else home[2] - z,
        tilt=state.tilt,
        tilt_error=0.0 if steered is None else math.acos(clamped(steered.command.aligned, -1.0, 1.0)),
        rate_error=math.dist(asked.rates_b, state.w_b) if isinstance(asked, RateSetpoint) else None,
        body_rate=turning,
        still=turning < STILL and math.hypot(*state.v_n) < STILL,
        saturated=steered is not None and steered.saturated,
        thrust_share=0.0 if steered is None or not follows else steered.thrust_share,
        sinking=state.v_n[2],
        round_trip=observation.round_trip,
        late=watch.late,
        needs=NEEDS[plan.level],
        jump=watch.jump,
        flagged=watch.flagged,
        same_place=watch.same_place or place_stands,
        same_attitude=watch.same_attitude or attitude_stands,
        velocity_off=velocity_off,
        rates_off=rates_off,
        clock_jump=watch.clock_jump,
        behind=observation.behind,
        rate=observation.rate,
        gaps=len([ended for ended in watch.gaps if now - ended < conditions.GAPS_WITHIN]),
        companions=observation.companions,
        body_rate_max=_body_rate_max(plan),
        specific_thrust_commanded=response.commanded if follows and is_thrust_judged(plan, memory) else 0.0,
        specific_thrust_made=response.made,
        rotor_left=1.0 if steered is None else steered.rotor_left,
    )


def _body_rate_max(plan: Plan) -> float | None:
    """rad/s that the vehicle may turn at most, where its own rate loop does not see to that."""
    limits = plan.vehicle.limits
    if limits is None or not plan.level.without_rate_loop:
        return None
    return conditions.TURNS_TOO_FAST * max(limits.body_rates)


def takes_commands(status: VehicleStatus, now: float) -> bool:
    """Whether commands over XRCE may go out, as far as CURRENT_MODE tells."""
    return follows_commands(status, now, COMMANDED_FOR)


def follows_commands(status: VehicleStatus, now: float, within: float = FOLLOWS_FOR) -> bool:
    """Whether the vehicle follows what is commanded, as far as it said ``within`` the last s."""
    mode, intended = status.mode, status.intended  # only CURRENT_MODE says what is intended
    if mode is None or intended is None:
        return False
    return mode.value_at(now) is Mode.OFFBOARD and now - intended.at < within


def is_thrust_judged(plan: Plan, memory: Memory) -> bool:
    """Whether the thrust was followed for long enough that its scale is known, and is to be judged in this phase."""
    known = memory.agreement.thrust_response.known > (THRUST_AFTER_AT_ONCE if plan.conduct.at_once else THRUST_AFTER)
    return known and memory.phase in THRUST_WATCHED


def situation(
    plan: Plan,
    memory: Memory,
    observation: Observation,
    status: KnownStatus,
    verdict: safety.Verdict,
    now: float,
    law_error: str | None,
) -> Situation:
    """What the transitions look at."""
    conduct, phase, request, watch = plan.conduct, memory.phase, memory.request, memory.watch
    missing = missing_now(plan, memory, observation, status, now) if phase is Phase.PREFLIGHT else None
    armed, asking = observation.status.armed, request.asking
    at_end = phase is Phase.FOLLOW and remaining(plan, memory) < END_WITHIN
    return Situation(
        phase=phase,
        now=now,
        entered=memory.entered,
        status=status,
        mode_seen=request.mode_seen,
        state_at=memory.state_at,
        answer=request.answer,
        from_ground=memory.from_ground,
        authority=conduct.authority,
        finish=conduct.finish,
        faulty=memory.fault is not None,
        stop=observation.stop,
        missing=missing,
        settled=_settled(plan, memory, now),
        joined=rests(plan, memory, now) if phase is Phase.REST else conduct.at_once or is_at(memory),
        at_end=at_end,
        goes_back=goes_back(plan, memory),
        finished=_finished(plan, memory, now),
        law_error=law_error or bench_fault(memory.shown),
        verdict=verdict if PHASES[phase].steers else safety.NO_FAULT,
        decided_in=request.decided_in,
        asked=0 if asking is None else asking.tries,
        asked_at=math.inf if asking is None else asking.sent_at,
        unusable=watch.unusable,
        late=watch.late,
        answered=now - request.answered_at,
        armed_heard=math.inf if armed is None else now - armed.at,
        flown_in=conduct.own_mode or "OFFBOARD",
    )


def _settled(plan: Plan, memory: Memory, now: float) -> bool:
    """Whether the thrust that carries the vehicle is known, or carries it at rest where it is to be."""
    if plan.conduct.at_once or (memory.steering.steered is not None and memory.steering.steered.converged):
        return True
    return now - memory.entered > RESTS_FOR and is_at(memory)


def missing_now(plan: Plan, memory: Memory, observation: Observation, status: KnownStatus, now: float) -> str | None:
    """What is not there that a flight needs; None: it may begin."""
    conduct = plan.conduct
    return preflight.missing(preflight.PreflightInputs(
        status, conduct.authority, conduct.finish, conduct.limits, memory.state is not None,
        RATE_WANTED if conduct.at_once and observation.rate is None else observation.rate,
        observation.companions,
        None if memory.state_at is None else now - memory.state_at,
        1.0 if conduct.at_once else observation.clock_rate,
        observation.round_trip,
        NEEDS[plan.level],
    ))  # fmt: skip


def _finished(plan: Plan, memory: Memory, now: float) -> str | None:
    """Why the flight is over, if it is."""
    state, conduct = memory.state, plan.conduct
    if state is None:
        return None
    if memory.phase is Phase.REHEARSE:
        if conduct.authority is ControlAuthority.BENCH:
            return "every side was shown, and the command turned it back" if memory.shown.complete else None
        lasts = plan.duration or REHEARSED_FOR
        return f"rehearsed for {lasts:g} s: nothing was commanded" if now - memory.entered >= lasts else None
    if memory.phase not in (Phase.FOLLOW, Phase.REST) or memory.path.follow_from is None:
        return None
    # the first state after it, so that all of the duration was followed
    if plan.duration is not None and state.t_boot - memory.path.follow_from > plan.duration + 1e-6:
        return f"followed for {plan.duration:g} s"
    if memory.phase is Phase.REST:
        return "flew to the end of the path" if rests(plan, memory, now) and not goes_back(plan, memory) else None
    if plan.laps is not None and plan.table.closed and memory.path.progress is not None:
        laps = memory.path.progress.travelled / plan.table.length
        if laps >= plan.laps:
            return f"flew {plan.laps:g} laps"
    return None
