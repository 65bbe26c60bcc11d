"""The keys of a study file."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from companion.config.syntax.schema import Strict

Number = Annotated[float, Field(ge=-1e9, le=1e9)]
Pair = Annotated[list[Number], Field(min_length=2, max_length=2)]
Formula = Annotated[str, Field(max_length=2000)]
Choices = Annotated[list[Any], Field(min_length=1, max_length=1000)]


class VaryModel(Strict):
    """How one value varies: exactly one of these."""

    choice: Choices | None = None
    """each of these values, as a grid with every other choice and range"""
    range: Annotated[list[Number], Field(min_length=3, max_length=3)] | None = None
    """[from, to, how many]: evenly spaced values, as a grid"""
    uniform: Pair | None = None
    """[lowest, highest], evenly likely in between, in the unit of the key (no unit of its own)"""
    loguniform: Pair | None = None
    """[lowest, highest], both positive, the logarithm evenly likely, no unit of its own"""
    normal: Pair | None = None
    """[mean, standard deviation], no unit of its own"""
    weibull: Pair | None = None
    """[scale, shape], as wind speeds are told, no unit of its own"""
    formula: Formula | Annotated[list[Formula | Number], Field(min_length=1, max_length=100)] | None = None
    """a number, or a list of them, made of others that vary and have names of their own (mass*told)"""

    @field_validator("range")
    @classmethod
    def _counts(cls, given: list[float] | None) -> list[float] | None:
        if given is not None and not (given[2] == int(given[2]) and 2 <= given[2] <= 1000):
            raise ValueError(f"{given[2]:g} values; expected [from, to, how many] with a whole number from 2 to 1000")
        return given

    @field_validator("uniform", "loguniform")
    @classmethod
    def _rises(cls, given: list[float] | None) -> list[float] | None:
        if given is not None and not given[0] < given[1]:
            raise ValueError(f"{given} does not rise; expected [lowest, highest]")
        return given

    @field_validator("loguniform", "weibull")
    @classmethod
    def _positive(cls, given: list[float] | None) -> list[float] | None:
        if given is not None and not min(given) > 0.0:
            raise ValueError(f"{given} holds a number that is not positive; expected both above 0")
        return given

    @field_validator("normal")
    @classmethod
    def _spreads(cls, given: list[float] | None) -> list[float] | None:
        if given is not None and not given[1] > 0.0:
            raise ValueError(f"{given[1]:g} is no standard deviation; expected [mean, deviation] with one above 0")
        return given

    @model_validator(mode="after")
    def _one(self) -> VaryModel:
        if len(self.model_fields_set) != 1:
            raise ValueError(f"{len(self.model_fields_set)} ways to vary; expected exactly one")
        return self

    @property
    def formulas(self) -> list[str]:
        """Those that it is made by; empty where it is drawn or chosen."""
        given = self.formula
        return [] if given is None else [given] if isinstance(given, str) else [str(each) for each in given]


class RequireModel(Strict):
    """What a figure must be."""

    min: Number | None = None
    """at least this, no unit of its own"""
    max: Number | None = None
    """at most this, no unit of its own"""

    @model_validator(mode="after")
    def _any(self) -> RequireModel:
        if not self.model_fields_set:
            raise ValueError("says nothing; expected min, max or both")
        return self


class StudyModel(Strict):
    """A study: one mission flown many times, each time a little different."""

    study: Annotated[str, Field(min_length=1, max_length=80)]
    """the study's name"""
    mission: str
    """the mission: a name in configs/missions, or a file beside this one"""
    vehicle: str | None = None
    """the vehicle, as the companion is told of it; the mission's own, else x500"""
    world: str = "ideal"
    """the simulated world"""
    output: Literal["auto", "motors", "rates", "attitude"] = "auto"
    """what is sent to the vehicle"""
    duration: Annotated[float, Field(ge=0.1, le=36000.0)] | None = None
    """how long the path is followed, in s; the mission's laps where absent"""
    settle: Annotated[float, Field(ge=0.0, le=36000.0)] = 10.0
    """s after which a flight counts as settled"""
    flights: Annotated[int, Field(ge=1, le=1_000_000)] | None = None
    """how many flights; once through the grid where absent"""
    seed: Annotated[int, Field(ge=0, le=2_000_000_000)] = 0
    """what chance begins from, no unit: flight i has the seed of the study plus i"""
    sampling: Literal["sobol", "latin", "random", "saltelli"] = "sobol"
    """how what is no grid is drawn: a Sobol sequence, a Latin hypercube, at random, or Saltelli's design, which gives
    Sobol indices and asks for 2^k (draws + 2) flights"""
    vary: dict[str, VaryModel] = Field(default_factory=dict)
    """what varies: mission, vehicle, world, or any of their keys (world.truth.mass_kg), or flight.output, flight.seed,
    flight.duration, flight.settle, or a name of your own for the formulas of others"""
    from_ground: bool = False
    """whether a flight begins on the ground, disarmed, and ends there"""
    completed: bool = True
    """whether a flight must be completed to pass; false where giving up in order is an answer too"""
    require: dict[str, RequireModel] = Field(default_factory=dict)
    """what is required of a flight: figures of the summary (truth.settled.path_error_m.rms), each with min,
    max or both"""
    pass_rate: Annotated[float, Field(ge=0.0, le=1.0)] = 1.0
    """the least share of flights that must be completed and meet what is required, 0 to 1"""
    confidence: Annotated[float, Field(ge=0.5, le=0.9999)] = 0.95
    """how sure the bounds of the pass rate are, no unit"""
