"""A tick of the pilot as a row of the flight table, and its first part back as what the pilot saw."""

from __future__ import annotations

import enum
import math
from typing import Any, TypeVar

from companion.flight.phases import Phase, Request
from companion.flight.situation import Answer
from companion.mavlink_common import MavResult
from companion.pilot import Memory, Observation, Outcome, yaw_error
from companion.record.table import Row
from companion.record.tick_columns import FACTS
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
        ages += _NOT_SAID if fact is None else fact[1:]
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
        return (math.nan,) * 15
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
