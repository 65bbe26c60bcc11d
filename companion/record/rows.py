"""A tick of the pilot as a row of the flight table, and its first part back as what the pilot saw."""

from __future__ import annotations

import enum
import math
from typing import Any, TypeVar

from companion.flight.phases import Phase, Request
from companion.flight.situation import Answer
from companion.mavlink_common import MavResult
from companion.pilot import Memory, Observation, Outcome, yaw_error
from companion.record.table import Column, Row, dtype_of
from companion.steering.steering import Estimates
from companion.vehicle import (
    AttitudeSetpoint,
    Fact,
    Landed,
    Mode,
    MotorSetpoint,
    RateSetpoint,
    Setpoint,
    TorqueSetpoint,
    VehicleState,
    VehicleStatus,
)

NONE = -1
"""An index of nothing."""
FACTS = ("armed", "mode", "intended", "landed", "ready", "failsafe", "battery", "estimator")
"""The facts of VehicleStatus, each with the time when it was said."""

OBSERVATION_COLUMNS = (
    Column("now", "d", "s, our monotonic clock"),
    Column("fresh", "b", "1: a state arrived with this tick; the columns t_boot to resets are it"),
    Column("t_boot", "d", "s, the vehicle's stamp of the state"),
    *(Column(name, "d", "m, position in the vehicle's local frame") for name in ("north", "east", "down")),
    *(Column(name, "d", "m/s, velocity") for name in ("v_north", "v_east", "v_down")),
    *(Column(name, "d", "attitude quaternion, body to world") for name in ("q_w", "q_x", "q_y", "q_z")),
    *(Column(name, "d", "rad/s, body rates") for name in ("p", "q", "r")),
    Column("resets", "i", "the estimator's reset counter"),
    Column("armed", "b", "1 armed, 0 disarmed, -1 not said"),
    Column("mode", "b", "index of vehicle.Mode, -1 not said"),
    Column("intended", "b", "index of vehicle.Mode, the user's intention, -1 not said"),
    Column("landed", "b", "index of vehicle.Landed, -1 not said"),
    Column("ready", "b", "1 would accept arming, 0 not, -1 not said"),
    Column("failsafe", "b", "1 in a failsafe, 0 not, -1 not said"),
    Column("battery", "d", "what remains, 0..1, nan not said"),
    Column("estimator", "i", "flags of ESTIMATOR_STATUS, -1 not said"),
    Column("answer_to", "b", "index of phases.Request that was answered, -1 none"),
    Column("answer", "b", "MAV_RESULT, -1 none"),
    Column("stop", "b", "1: told to stop"),
    Column("link_delay", "d", "s, round trip of a message, nan not measured"),
    Column("rate", "d", "Hz of states, nan not measured"),
    Column("behind", "i", "states that arrived with this one and were passed over"),
    Column("companions", "i", "other companions that speak on the link"),
    Column("speed_scale", "d", "the factor on the mission's speed that is asked for"),
    Column("late", "d", "s by which the state is older than the youngest that the link has brought"),
    Column("clock_pace", "d", "s of the vehicle's clock a second of ours, nan not measured"),
    Column("was_armed", "b", "1: it was seen armed since it was first heard"),
    *(
        Column(f"{fact}_{part}", "d", meaning)
        for fact in FACTS
        for part, meaning in (("at", "s, our clock, when it was said, nan never"), ("lasts", "s for which that counts"))
    ),
)

OUTCOME_COLUMNS = (
    Column("phase", "b", "index of phases.Phase after the tick"),
    Column("request", "b", "index of phases.Request that stands, -1 none"),
    Column("asked", "b", "1: it was sent at this tick"),
    Column("payload", "i", "commands for the payload that were sent at this tick"),
    Column("setpoint", "b", "0 none, 1 motors, 2 rates, 3 attitude, 4 torques"),
    *(
        Column(
            f"sent_{i}",
            "d",
            "motors: commands; rates: p, q, r (rad/s), thrust; attitude: q, thrust; torques: shares, thrust",
        )
        for i in range(5)
    ),
)

LAW_COLUMNS = (
    Column("zeta", "d", "N, the thrust the law integrates"),
    Column("zeta_dot", "d", "N/s"),
    Column("thrust", "d", "N, the collective thrust sent"),
    Column("saturated", "b", "1: a limit was met"),
    Column("ramp", "d", "factor on the mission's speed"),
    Column("s", "d", "m, arc length of the nearest point of the path"),
    Column("travelled", "d", "m along the path since following began"),
    Column("path_error", "d", "m, distance to the path"),
    Column("speed", "d", "m/s along the path, mu . V"),
    Column("alpha", "d", "m/s, the mission's speed here"),
    Column("yaw", "d", "rad, heading"),
    Column("beta", "d", "rad, the mission's heading here"),
    Column("yaw_error", "d", "rad, wrapped"),
    Column("tilt", "d", "rad, lean of the thrust axis"),
    Column("pace", "f", "share of the mission's speed that was asked for; less than 1 where it could not be flown"),
    Column("thrust_scale", "f", "found: acceleration made over acceleration asked for"),
    Column("drag", "f", "1/s, found"),
    *(Column(f"push_{axis}", "f", "m/s^2, found: the disturbance") for axis in ("north", "east", "down")),
    *(Column(f"bias_{axis}", "f", "m/s, found: velocity over moving position") for axis in ("north", "east", "down")),
    Column("delay", "f", "s, from a state to the effect of its command on the motors"),
    Column("rate_lag", "f", "s, found: of the rate loop; NaN at motors and torques"),
    Column("yaw_lag", "f", "s, found: of the yaw rate loop"),
    Column("path_pole", "f", "1/s, of h1 and h2, where it was chosen and not written"),
    Column("latency", "f", "s from the arrival of the state to the return of the setpoint's send"),
)

COLUMNS = OBSERVATION_COLUMNS + OUTCOME_COLUMNS + LAW_COLUMNS
OUTCOME_DTYPE = dtype_of(OUTCOME_COLUMNS)

E = TypeVar("E", bound=enum.Enum)


def _index(member: enum.Enum | None) -> int:
    return NONE if member is None else _INDICES[type(member)][member]


_ENUMS: tuple[type[enum.Enum], ...] = (Mode, Landed, Request, MavResult, Phase)
_INDICES: dict[type[enum.Enum], dict[enum.Enum, int]] = {
    kind: {member: index for index, member in enumerate(kind)} for kind in _ENUMS
}


def _member(kind: type[E], index: int) -> E | None:
    return None if index == NONE else list(kind)[index]


def _unflag(value: int) -> bool | None:
    return None if value == NONE else bool(value)


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _unnumber(value: float) -> float | None:
    return None if math.isnan(value) else float(value)


_NO_STATE = (0, *(math.nan,) * 14, NONE)
"""The columns of a state where there is none."""
_NOT_SAID = (math.nan, math.nan)
"""The columns of when a fact was said and how long that counts, where it was not."""
_NOT_SENT = (math.nan,) * 5
"""The columns of a setpoint where none was sent."""


def observation_row(observation: Observation, now: float) -> Row:
    """The columns ``OBSERVATION_COLUMNS``."""
    state, answer = observation.state, observation.answer
    armed, mode, intended, landed, ready, failsafe, battery, estimator, was_armed = observation.status
    if state is None:
        state_row: Row = _NO_STATE
    else:
        state_row = (1, state.t_boot, *state.p_n, *state.v_n, *state.q_nb, *state.w_b, state.resets)
    ages: list[float] = []
    for fact in (armed, mode, intended, landed, ready, failsafe, battery, estimator):
        ages += _NOT_SAID if fact is None else (fact.at, fact.lasts)
    return (
        now,
        *state_row,
        NONE if armed is None else int(armed.value),
        NONE if mode is None else _index(mode.value),
        NONE if intended is None else _index(intended.value),
        NONE if landed is None else _index(landed.value),
        NONE if ready is None else int(ready.value),
        NONE if failsafe is None else int(failsafe.value),
        math.nan if battery is None else battery.value,
        NONE if estimator is None else estimator.value,
        NONE if answer is None else _index(answer.request),
        NONE if answer is None else _index(answer.reply),
        int(observation.stop),
        _number(observation.round_trip),
        _number(observation.rate),
        observation.behind,
        observation.companions,
        observation.speed_scale,
        observation.late,
        _number(observation.clock_rate),
        int(was_armed),
        *ages,
    )


def setpoint_row(setpoint: Setpoint | None) -> tuple[int, float, float, float, float, float]:
    """The columns ``setpoint`` and ``sent_0`` to ``sent_4``."""
    if isinstance(setpoint, MotorSetpoint):
        a, b, c, d = setpoint.commands
        return (1, a, b, c, d, math.nan)
    if isinstance(setpoint, RateSetpoint):
        return (2, *setpoint.rates_b, setpoint.thrust, math.nan)
    if isinstance(setpoint, TorqueSetpoint):
        return (4, *setpoint.torque_b, setpoint.thrust, math.nan)
    if isinstance(setpoint, AttitudeSetpoint):
        return (3, *setpoint.q_nb, setpoint.thrust)
    return (0, *_NOT_SENT)


def outcome_row(memory: Memory, outcome: Outcome) -> Row:
    """The columns ``OUTCOME_COLUMNS``."""
    return (
        _index(memory.phase),
        _index(outcome.request),
        int(outcome.sent),
        len(outcome.actions),
        *setpoint_row(outcome.setpoint),
    )


def row(observation: Observation, memory: Memory, outcome: Outcome, now: float, latency: float) -> Row:
    """One row of the flight table."""
    steered, progress, state = outcome.steered, memory.path.progress, memory.state
    return (
        *observation_row(observation, now),
        *outcome_row(memory, outcome),
        *(
            (math.nan,) * 3 + (0,)
            if steered is None
            else (steered.zeta, steered.zeta_dot, steered.thrust, int(steered.saturated))
        ),
        outcome.ramp.value,
        *((math.nan,) * 3 if progress is None else (progress.s, progress.travelled, progress.path_error)),
        *(
            (math.nan,) * 5
            if steered is None
            else (
                steered.command.speed,
                steered.command.alpha,
                steered.command.yaw,
                steered.command.beta,
                yaw_error(steered),
            )
        ),
        math.nan if state is None else state.tilt,
        math.nan if steered is None else steered.governor,
        *_found(None if steered is None else steered.estimates),
        latency,
    )


def _found(estimates: Estimates | None) -> Row:
    if estimates is None:
        return (math.nan,) * 12
    scale, drag, disturbance, bias, delay, *rest = estimates
    return (scale, drag, *disturbance, *bias, delay, *rest)


def observation_of(row: Any) -> tuple[Observation, float]:
    """What the pilot saw at a row of the table, and when."""
    state = None
    if row["fresh"]:
        state = VehicleState(
            t_boot=float(row["t_boot"]),
            p_n=(float(row["north"]), float(row["east"]), float(row["down"])),
            v_n=(float(row["v_north"]), float(row["v_east"]), float(row["v_down"])),
            q_nb=(float(row["q_w"]), float(row["q_x"]), float(row["q_y"]), float(row["q_z"])),
            w_b=(float(row["p"]), float(row["q"]), float(row["r"])),
            resets=int(row["resets"]),
        )
    values = (
        _unflag(row["armed"]),
        _member(Mode, row["mode"]),
        _member(Mode, row["intended"]),
        _member(Landed, row["landed"]),
        _unflag(row["ready"]),
        _unflag(row["failsafe"]),
        _unnumber(row["battery"]),
        None if row["estimator"] == NONE else int(row["estimator"]),
    )
    facts = [
        None if value is None else Fact(value, float(row[f"{name}_at"]), float(row[f"{name}_lasts"]))
        for name, value in zip(FACTS, values, strict=True)
    ]
    status = VehicleStatus(**dict(zip(FACTS, facts, strict=True)), was_armed=bool(row["was_armed"]))  # type: ignore[arg-type]
    request, reply = _member(Request, row["answer_to"]), _member(MavResult, row["answer"])
    answer = None if request is None or reply is None else Answer(request, reply)
    return Observation(
        state,
        status,
        answer,
        bool(row["stop"]),
        _unnumber(row["link_delay"]),
        _unnumber(row["rate"]),
        int(row["behind"]),
        int(row["companions"]),
        float(row["speed_scale"]),
        float(row["late"]),
        _unnumber(row["clock_pace"]),
    ), float(row["now"])
