"""The errors xi and the inputs u of a flight over time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.allocation import Allocation
from companion.frames import euler_from_rotation, rotation_matrix, wrap
from companion.law.bare import bare_law, state_names
from companion.law.errors import LawError
from companion.law.flight import model_of
from companion.law.gains import Level, default_gains, law_level
from companion.paths.implicit import ImplicitPath
from companion.plan import Plan
from companion.px4_allocation import Px4Allocation
from companion.vehicle import CompanionError, OutputLevel

Array = NDArray[np.float64]


class Signals(NamedTuple):
    """``t``: s of following, one a row of ``values``; ``names``: one a column; ``signals["h1"]`` is a column."""

    t: Array
    values: Array
    names: tuple[str, ...]

    def __getitem__(self, key: object) -> Array:  # type: ignore[override]
        return self.values[:, self.names.index(str(key))]


def xi_names(level: Level) -> tuple[str, ...]:
    """h1, h1', ..., h4 ..., as many as the level has."""
    degrees = zip(("h1", "h2", "h3", "h4"), level.degrees, strict=True)
    return tuple(name + "'" * k for name, degree in degrees for k in range(degree))


def xi_of(plan: Plan, estimated: dict[str, Array]) -> Signals:
    """xi (Eq. 8) at every followed state, as the vehicle told it; nan where the law is not defined, h4 wrapped.

    CompanionError: the path is a curve, which has no h1 and h2.
    """
    if not isinstance(plan.mission.path, ImplicitPath):
        raise CompanionError(
            f"{plan.mission.name} is flown as a curve and has no h1 and h2; its errors are in "
            "flight.followed: path_error, speed_error, yaw_error"
        )
    level = law_level(plan.level)
    law = bare_law(plan.mission.specification(plan.direction), level, model_of(plan.vehicle), default_gains(level))
    names, wanted = xi_names(level), state_names(level)
    rows = np.full((len(estimated["t"]), len(names)), np.nan)
    for i, chi in enumerate(_states(estimated, wanted)):
        try:
            rows[i] = law(chi.tolist()).xi
        except LawError:
            continue
        rows[i, names.index("h4")] = wrap(float(rows[i, names.index("h4")]))
    return Signals(estimated["t"], rows, names)


def u_of(plan: Plan, estimated: dict[str, Array]) -> Signals:
    """What the vehicle was told. At rates zeta_dot (N/s, before thrust limits), p, q, r (rad/s); at motors and torques
    zeta (N) and the moments u2, u3, u4 (N m); at attitude the quaternion and the normalised thrust."""
    sent = [estimated[f"sent_{i}"] for i in range(5)]
    if plan.level is OutputLevel.MOTORS:
        allocation = Allocation(plan.vehicle)
        commands = np.stack(sent[:4], axis=1)
        wrenches = [allocation.wrench((a, b, c, d)) for a, b, c, d in commands.tolist()]
        return Signals(estimated["t"], np.array(wrenches).reshape(-1, 4), ("zeta", "u2", "u3", "u4"))
    if plan.level is OutputLevel.TORQUES:
        mixer = Px4Allocation(plan.vehicle)
        wrenches = [mixer.wrench((x, y, z), t) for x, y, z, t in np.stack(sent[:4], axis=1).tolist()]
        return Signals(estimated["t"], np.array(wrenches).reshape(-1, 4), ("zeta", "u2", "u3", "u4"))
    if plan.level is OutputLevel.RATES:
        return Signals(
            estimated["t"], np.stack([estimated["zeta_dot"], *sent[:3]], axis=1), ("zeta_dot", "p", "q", "r")
        )
    return Signals(estimated["t"], np.stack(sent, axis=1), ("q_w", "q_x", "q_y", "q_z", "thrust"))


def _states(estimated: dict[str, Array], names: tuple[str, ...]) -> Array:
    """The extended states (``state_names``), one a row."""
    columns = {
        "x": estimated["north"], "y": estimated["east"], "z": estimated["down"],
        "u": estimated["v_north"], "v": estimated["v_east"], "w": estimated["v_down"],
        **{name: estimated[name] for name in ("p", "q", "r", "zeta", "zeta_dot")},
    }  # fmt: skip
    attitude = np.stack([estimated[f"q_{axis}"] for axis in "wxyz"], axis=1)
    angles = [euler_from_rotation(rotation_matrix((w, x, y, z))) for w, x, y, z in attitude.tolist()]
    columns["psi"], columns["theta"], columns["phi"] = np.array(angles).reshape(-1, 3).T
    return np.stack([columns[name] for name in names], axis=1)
