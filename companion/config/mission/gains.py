"""Gains as a mission file writes them: poles, or the gains themselves; for the level that is flown."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, GetJsonSchemaHandler, WithJsonSchema, field_validator

from companion.config.syntax.document import Document
from companion.config.syntax.faults import Fault
from companion.config.syntax.schema import Strict
from companion.law.gains import Gains, Level, default_gains, from_poles, poles_of

Numbers = Annotated[list[float], Field(min_length=1, max_length=4)]
PAIR_WITHIN = 1e-9
"""1/s that the conjugates of a pair may be apart as they are written."""


def _pole(value: Any) -> Any:
    """A root as a file writes it: a number, or text such as "-2+1.5j"; mathematicians' i is meant too."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return complex(value)
    try:
        if not isinstance(value, str):
            raise ValueError
        return complex(value.replace(" ", "").lower().replace("i", "j"))
    except ValueError:
        raise ValueError(f'{value!r} is no root; expected a number such as -2, or text such as "-2+1.5j"') from None


Pole = Annotated[
    complex,
    BeforeValidator(_pole),
    WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "string", "pattern": "^-[0-9.]+ *[+-] *[0-9.]+ *[ij]$"}]}),
]
Poles = Annotated[list[Pole], Field(min_length=1, max_length=4)]
PATH_POLE_MIN = {Level.MOTORS: 1.5, Level.RATES: 1.0}
"""1/s; slower poles are not gentler but unsafe: small gains make large errors, where the law is far from linear."""
OTHER_POLE_MIN = 0.1
"""1/s: slower holds nothing (engineering choice)."""
POLE_MAX = 15.0
"""1/s: faster than a rate loop follows (engineering choice)."""


class PolesModel(Strict):
    """Where the roots of the error dynamics lie."""

    path: Poles | None = None
    """the roots for h1 and h2 in 1/s, negative: 4 at motors, 3 at rates; complex ones in pairs: -2+1j, -2-1j"""
    speed: Poles | None = None
    """the roots for h3 in 1/s, negative: 3 at motors, 2 at rates"""
    yaw: Poles | None = None
    """the roots for h4 in 1/s, negative: 2 at motors, 1 at rates"""

    @field_validator("path", "speed", "yaw")
    @classmethod
    def _stable(cls, poles: list[complex] | None) -> list[complex] | None:
        if poles is None:
            return None
        if not all(math.isfinite(pole.real) and math.isfinite(pole.imag) for pole in poles):
            raise ValueError("holds a root that is not finite; expected negative numbers")
        if max(pole.real for pole in poles) >= 0.0:
            raise ValueError(f"{_poles_text(poles)} is not stable; expected negative numbers")
        if not _in_pairs(poles):
            raise ValueError(f"{_poles_text(poles)}: a complex root stands alone; expected pairs such as -2+1j, -2-1j")
        return poles


def _in_pairs(poles: list[complex]) -> bool:
    """Whether every complex root has its conjugate."""
    above, below = ([(p.real, abs(p.imag)) for p in poles if side * p.imag > 0.0] for side in (1.0, -1.0))
    return len(above) == len(below) and all(
        math.dist(up, down) <= PAIR_WITHIN for up, down in zip(sorted(above), sorted(below), strict=True)
    )


def _poles_text(poles: list[complex]) -> str:
    return "[" + ", ".join(f"{p.real:g}" if p.imag == 0.0 else f"{p.real:g}{p.imag:+g}j" for p in poles) + "]"


class GainsModel(Strict):
    """How hard errors are driven out: poles, or the gains themselves."""

    poles: PolesModel | None = None
    """the roots of the error dynamics, e.g. {path: [-2, -2, -2, -2], speed: [-2, -2, -2], yaw: [-2, -2]}, in 1/s"""
    h1: Numbers | None = None
    """gains k0, k1, .. of h1, in 1/s to the order: as many as its order at the level flown"""
    h2: Numbers | None = None
    """gains k0, k1, .. of h2, in 1/s to the order: as many as its order at the level flown"""
    h3: Numbers | None = None
    """gains k0, k1, .. of h3, in 1/s to the order: as many as its order at the level flown"""
    h4: Numbers | None = None
    """gains k0, k1, .. of h4, in 1/s to the order: as many as its order at the level flown"""


class _OrAuto:
    """What a schema says beside the model."""

    def __get_pydantic_json_schema__(self, core: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"anyOf": [{"const": "auto"}, handler(core)]}


GainsOrAuto = Annotated[GainsModel, BeforeValidator(lambda value: {} if value == "auto" else value), _OrAuto()]
"""The gains of a mission file, or auto."""


def gains_from(
    document: Document,
    model: GainsModel,
    level: Level,
    faults: list[Fault],
    *,
    check: bool,
    notes: list[str] | None = None,
) -> Gains | None:
    """The gains of a file at a level, None where it writes none; what is wrong with them goes into ``faults``.
    ``check``: they are to be flown.
    ``notes``: takes what is only advised against, where they are flown in simulation; None: that is a fault too."""
    if not model.model_fields_set:
        return None  # chosen for the vehicle
    counts = dict(zip(("h1", "h2", "h3", "h4"), level.degrees, strict=True))
    default = default_gains(level)
    chosen: dict[str, tuple[float, ...]] = {}
    poles = model.poles
    for output, count in counts.items():
        kind = {"h1": "path", "h2": "path", "h3": "speed", "h4": "yaw"}[output]
        listed: list[float] | None = getattr(model, output)
        rooted: list[complex] | None = getattr(poles, kind) if poles is not None else None
        if listed is not None and rooted is not None:
            message = f"given together with poles.{kind}; expected one of the two"
            faults.append(document.fault(("gains", output), message))
        elif listed is not None and len(listed) != count:
            message = f"{len(listed)} numbers; expected {count} at the level of {level.name.lower()}, or poles"
            faults.append(document.fault(("gains", output), message))
        elif rooted is not None and len(rooted) != count:
            message = f"{len(rooted)} numbers; expected {count} at the level of {level.name.lower()}"
            faults.append(document.fault(("gains", "poles", kind), message))
        else:
            chosen[output] = (
                tuple(listed) if listed is not None else from_poles(rooted) if rooted else getattr(default, output)
            )
            if check:
                key = ("gains", output) if listed is not None else ("gains", "poles", kind)
                faults += _too_slow_or_fast(document, key, chosen[output], kind, level, notes)
    return Gains(**chosen) if len(chosen) == len(counts) else None


def _too_slow_or_fast(
    document: Document, key: tuple[str, ...], gains: tuple[float, ...], kind: str, level: Level,
    notes: list[str] | None,
) -> list[Fault]:  # fmt: skip
    """Why gains may not be flown."""
    roots = poles_of(gains)
    slowest, fastest = min(-root.real for root in roots), max(abs(root) for root in roots)
    if slowest <= 1e-6:
        return [document.fault(key, f"{list(gains)} is not stable; expected roots with negative real parts")]
    least = PATH_POLE_MIN[level] if kind == "path" else OTHER_POLE_MIN
    if slowest < 0.99 * least:
        found = f"slowest root {-slowest:.3g}"
        if notes is not None:
            note = f"{'.'.join(key)}: {found}, where {-least:g} or faster is advised; simulated all the same, not flown"
            notes += [note] if note not in notes else []
            return []
        message = f"{found}; expected {-least:g} or faster: slow gains let errors grow too large"
        return [document.fault(key, message)]
    if fastest > POLE_MAX:
        message = f"fastest root {-fastest:.3g}; expected {-POLE_MAX:g} or slower: the vehicle cannot follow it"
        return [document.fault(key, message)]
    return []
