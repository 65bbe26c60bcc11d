"""What arrives is taken in: whether a state is one, how old it is, and whether it agrees with the one before.

A state counts when its stamp lies after that of the last one and it is no older than STATE_AGE_MAX. Anything else is no
state, however often it comes.
"""

from __future__ import annotations

import math

from companion.flight import conditions
from companion.flight.interruptions import STATE_AGE_MAX
from companion.flight.phases import Phase, Request
from companion.frames import Vec3, conjugate, multiply
from companion.pilot.memory import OWN_MODE, Memory, Observation, StateAgreement, StateWatch, Sums
from companion.pilot.thrust_response import ThrustResponse
from companion.vehicle import Mode, VehicleState

CLOCK_BACK = 1.0
"""s by which a state must be older than the last one to be the sign of a clock set back, and not merely late.
Engineering choice."""
OLDER_IN_A_ROW = 5
"""Number of states older than the last one, with none between them that is newer, after which the clock was set
back. Engineering choice: a second route brings them between the first one's."""
NEW_CLOCK_AFTER = 1.0
"""s without a state after which an earlier stamp begins anew, while nothing flies: the vehicle was switched on anew.
Engineering choice."""
JUMP_MIN = 1.0
"""m beside the place where the last state's velocity leads that are a jump: a quarter of a second at 30 m/s^2.
Engineering choice."""
MOVES = 0.1
"""m/s from which on a position must change from state to state. Engineering choice."""
TURNS = 0.02
"""rad/s from which on an attitude must. Engineering choice."""
WINDOW = 0.06
"""s over which what moved is compared with what velocity and rates say (engineering choice)."""
MOVES_SURELY = 1.0
"""m/s from which on a change of less than STANDS of what the velocity makes of it is none: five standard deviations of
the velocity of a PX4 that shakes. Recorded in such a session: a vehicle that stood said 0.64 m/s for seconds."""
TURNS_SURELY = 0.06
"""rad/s, the same of an attitude and the body rates. Engineering choice."""
STANDS = 0.1
"""Share of the change that velocity or rates make of a state, below which it counts as not moved. In PX4's EKF velocity
and the derivative of the position disagree by up to 1.1 m/s (its simulation with noise, main of March 2026): a position
that crept at 0.16 m/s, with a velocity of 0.53, was a false alarm at 0.3. At 0.1 the longest false alarm of six flights
there and of the recorded one was 8 ms, of the 150 that count (32 in three flights of the stand-in's ``sih_noisy``)."""


def take_in(memory: Memory, observation: Observation, now: float, *, clock_may_stand: bool) -> Memory:
    """The memory with what was seen. ``clock_may_stand``: a simulated vehicle whose clock waits for the first setpoint.
    A state that counts is ``memory.state`` afterwards."""
    memory = _take_in_answer(memory, observation, now)
    new, old, watch = observation.state, memory.state, memory.watch
    if new is None:
        if watch.jump or watch.clock_jump:
            watch = watch._replace(jump=0.0, clock_jump=0.0)
        return memory._replace(watch=watch)
    if old is None or memory.state_at is None:
        return memory._replace(
            state=new, state_at=now - observation.late,
            watch=watch._replace(arrived_at=now), agreement=memory.agreement._replace(checked=new),
        )  # fmt: skip
    passed = new.t_boot - old.t_boot
    begins_anew = clock_may_stand and passed == 0.0
    if memory.phase in (Phase.PREFLIGHT, Phase.STAND_BY):
        begins_anew = begins_anew or (passed < 0.0 and now - memory.state_at > NEW_CLOCK_AFTER)
    if (passed <= 0.0 and not begins_anew) or observation.late > STATE_AGE_MAX:
        watch = _unusable(watch, passed, observation.late)
        return memory._replace(watch=watch)
    jump, flagged = 0.0, new.resets != old.resets
    (x, y, z), (u, v, w), (a, b, c) = old.p_n, old.v_n, new.p_n
    off = max(abs(a - x - u * passed), abs(b - y - v * passed), abs(c - z - w * passed))
    ahead = passed - (now - watch.arrived_at)
    if (flagged or (off > JUMP_MIN and ahead < conditions.CLOCK_JUMP)) and not begins_anew:
        jump = math.hypot(a - x - u * passed, b - y - v * passed, c - z - w * passed)
    gaps = watch.gaps
    if now - watch.arrived_at > conditions.GAP:
        gaps = (*(ended for ended in gaps if now - ended < conditions.GAPS_WITHIN), now)
    same_place, same_attitude = watch.same_place, watch.same_attitude
    if passed > 0.0:
        same_place = new.p_n == old.p_n and (same_place or math.hypot(*new.v_n) > MOVES)
        same_attitude = new.q_nb == old.q_nb and (same_attitude or math.hypot(*new.w_b) > TURNS)
    watch = StateWatch(
        arrived_at=now, late=observation.late, gaps=gaps, jump=jump, flagged=flagged, clock_jump=max(ahead, 0.0),
        older=0, unusable=None, same_place=same_place, same_attitude=same_attitude,
    )  # fmt: skip
    runs = memory.clock_runs or passed > 0.0
    return memory._replace(state=new, state_at=now - observation.late, watch=watch, clock_runs=runs)


def _take_in_answer(memory: Memory, observation: Observation, now: float) -> Memory:
    """The memory with the answer to what the phase asks for, and whether telemetry shows its own mode."""
    request, answer = memory.request, observation.answer
    asking, before = request.asking, request.answer
    answers = asking is not None and answer is not None and answer.request is asking.request
    if answer is not None and answers and (before is None or not before.accepted):
        memory = memory._replace(request=request._replace(answer=answer, answered_at=now))
        if answer.accepted and answer.request in (Request.ARM, Request.HOLD):
            part = "armed" if answer.request is Request.ARM else "hold_accepted"
            memory = memory._replace(done=memory.done._replace(**{part: True}))
    mode = observation.status.mode
    if memory.request.mode_seen or mode is None or mode.value is not OWN_MODE.get(memory.phase, Mode.UNKNOWN):
        return memory
    request = memory.request._replace(mode_seen=True)
    if request.answer is None or not request.answer.accepted:  # it was lost, or is behind
        request = request._replace(answered_at=now)
    return memory._replace(request=request)


def _unusable(watch: StateWatch, passed: float, late: float) -> StateWatch:
    """What is remembered of a state that is none."""
    older = watch.older + 1 if passed < -CLOCK_BACK else 0
    clock_jump = passed if older == OLDER_IN_A_ROW else 0.0
    if passed == 0.0:
        why = "the same one comes again and again (the stamp of ODOMETRY stands still)"
    elif passed < 0.0:
        why = f"what comes is {-passed:.1f} s older than the last one"
    else:
        why = f"they come {late:.2f} s late"
    return watch._replace(jump=0.0, clock_jump=clock_jump, older=older, unusable=why)


NO_SUMS = Sums()


def compare_states(agreement: StateAgreement, new: VehicleState, response: ThrustResponse) -> StateAgreement:
    """The agreement once a state was compared with the one before, and the thrust with what was commanded
    (``response``). Nothing of it is needed before the setpoint is sent."""
    old = agreement.checked
    if old is None or new.resets != old.resets or not 0.0 < new.t_boot - old.t_boot < WINDOW:
        return agreement._replace(
            checked=new, sums=NO_SUMS, place_stands=False, attitude_stands=False, thrust_response=response
        )
    dt = new.t_boot - old.t_boot
    keep = 1.0 - dt / WINDOW
    (north, east, down), (u, v, w) = old.p_n, new.p_n
    turn, x, y, z = multiply(conjugate(old.q_nb), new.q_nb)
    moved, by_velocity, turned, by_rates = agreement.sums
    moved = _summed(moved, keep, (u - north, v - east, w - down), 1.0)
    by_velocity = _summed(by_velocity, keep, new.v_n, dt)
    turned = _summed(turned, keep, (x, y, z), 2.0 if turn >= 0.0 else -2.0)
    by_rates = _summed(by_rates, keep, new.w_b, dt)
    should_move, should_turn = math.hypot(*by_velocity), math.hypot(*by_rates)
    return StateAgreement(
        checked=new,
        sums=Sums(moved, by_velocity, turned, by_rates),
        place_stands=should_move > MOVES_SURELY * WINDOW and math.hypot(*moved) < STANDS * should_move,
        attitude_stands=should_turn > TURNS_SURELY * WINDOW and math.hypot(*turned) < STANDS * should_turn,
        velocity_off=math.dist(moved, by_velocity) / WINDOW,
        rates_off=math.dist(turned, by_rates) / WINDOW,
        thrust_response=response,
    )


def _summed(total: Vec3, keep: float, more: Vec3, factor: float) -> Vec3:
    return (keep * total[0] + factor * more[0], keep * total[1] + factor * more[1], keep * total[2] + factor * more[2])
