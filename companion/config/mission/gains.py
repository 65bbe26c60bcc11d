"""Gains as a mission file writes them: poles, or the gains themselves; for the level that is flown."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, field_validator

from companion.config.syntax.document import Document
from companion.config.syntax.faults import Fault
from companion.config.syntax.schema import Strict
from companion.law.gains import Gains, Level, default_gains, from_poles, poles_of

Numbers = Annotated[list[float], Field(min_length=1, max_length=4)]
PATH_POLE_MIN = {Level.MOTORS: 1.5, Level.RATES: 1.0}
"""1/s; slower poles are not gentler but unsafe: small gains make large errors, where the law is far from linear."""
OTHER_POLE_MIN = 0.1
POLE_MAX = 15.0


class PolesModel(Strict):
    """Where the roots of the error dynamics lie."""

    path: Numbers | None = None
    """the roots for h1 and h2 in 1/s, negative: 4 at motors, 3 at rates"""
    speed: Numbers | None = None
    """the roots for h3 in 1/s, negative: 3 at motors, 2 at rates"""
    yaw: Numbers | None = None
    """the roots for h4 in 1/s, negative: 2 at motors, 1 at rates"""

    @field_validator("path", "speed", "yaw")
    @classmethod
    def _stable(cls, poles: list[float] | None) -> list[float] | None:
        if poles is not None and max(poles) >= 0.0:
            raise ValueError(f"{poles} is not stable; expected negative numbers")
        return poles


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


def gains_from(
    document: Document, model: GainsModel, level: Level, faults: list[Fault], *, check: bool
) -> Gains | None:
    """The gains of a file at a level; what is wrong with them goes into ``faults``. ``check``: they are to be flown."""
    counts = dict(zip(("h1", "h2", "h3", "h4"), level.degrees, strict=True))
    default = default_gains(level)
    chosen: dict[str, tuple[float, ...]] = {}
    poles = model.poles
    for output, count in counts.items():
        kind = {"h1": "path", "h2": "path", "h3": "speed", "h4": "yaw"}[output]
        listed: list[float] | None = getattr(model, output)
        rooted: list[float] | None = getattr(poles, kind) if poles is not None else None
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
                faults += _too_slow_or_fast(document, key, chosen[output], kind, level)
    return Gains(**chosen) if len(chosen) == len(counts) else None


def _too_slow_or_fast(
    document: Document, key: tuple[str, ...], gains: tuple[float, ...], kind: str, level: Level
) -> list[Fault]:
    """Why gains may not be flown."""
    roots = poles_of(gains)
    slowest, fastest = min(-root.real for root in roots), max(abs(root) for root in roots)
    if slowest <= 1e-6:
        return [document.fault(key, f"{list(gains)} is not stable; expected roots with negative real parts")]
    least = PATH_POLE_MIN[level] if kind == "path" else OTHER_POLE_MIN
    if slowest < 0.99 * least:
        message = f"slowest root {-slowest:.3g}; expected {-least:g} or faster: slow gains let errors grow too large"
        return [document.fault(key, message)]
    if fastest > POLE_MAX:
        message = f"fastest root {-fastest:.3g}; expected {-POLE_MAX:g} or slower: the vehicle cannot follow it"
        return [document.fault(key, message)]
    return []
