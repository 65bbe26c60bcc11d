"""What a vehicle says wrongly of itself and its state, or not at all: messages as they are -> as they are sent."""

from __future__ import annotations

import math
from collections.abc import Iterable

from companion.frames import Quaternion, Vec3, multiply
from companion.mavlink.dialect import Value, message
from companion.world.events import (
    FrozenState,
    Impostor,
    NotANumber,
    OdometryFrames,
    OffsetState,
    Part,
    Silence,
    Stamps,
    StateFault,
    WrongStamps,
)
from sim_bridge.noise import Draw

Values = tuple[Value, ...]

_ATTITUDE_ID, _QUATERNION_ID = message("ATTITUDE").id, message("ATTITUDE_QUATERNION").id
_LOCAL_ID, _GLOBAL_ID = message("LOCAL_POSITION_NED").id, message("GLOBAL_POSITION_INT").id
_ODOMETRY_ID, _HEARTBEAT_ID = message("ODOMETRY").id, message("HEARTBEAT").id

_POSITION, _ATTITUDE = frozenset({Part.POSITION, Part.STATE}), frozenset({Part.ATTITUDE, Part.STATE})
PARTS_SAID: dict[int, frozenset[Part]] = {
    _ATTITUDE_ID: _ATTITUDE,
    _QUATERNION_ID: _ATTITUDE,
    _LOCAL_ID: _POSITION,
    _GLOBAL_ID: _POSITION,
    _ODOMETRY_ID: _POSITION | _ATTITUDE,
}
"""Messages of the state, and the silences that silence them. ODOMETRY has both parts and stops with either."""
POSES: dict[int, tuple[tuple[frozenset[Part], slice], ...]] = {
    _ATTITUDE_ID: ((_ATTITUDE, slice(1, 4)),),
    _QUATERNION_ID: ((_ATTITUDE, slice(1, 5)),),
    _LOCAL_ID: ((_POSITION, slice(1, 4)),),
    _ODOMETRY_ID: ((_POSITION, slice(1, 4)), (_ATTITUDE, slice(4, 8))),
}
"""Where a message has position and attitude in numbers with a fraction, in wire order."""
MOTIONS: dict[int, tuple[tuple[frozenset[Part], slice], ...]] = {
    _ATTITUDE_ID: ((_ATTITUDE, slice(4, 7)),),
    _QUATERNION_ID: ((_ATTITUDE, slice(5, 8)),),
    _LOCAL_ID: ((_POSITION, slice(4, 7)),),
    _ODOMETRY_ID: ((_POSITION, slice(8, 11)), (_ATTITUDE, slice(11, 14))),
}
"""Where it has velocity and body rates."""
STAMP_MAX = {_ODOMETRY_ID: 2**64 - 1} | dict.fromkeys((_ATTITUDE_ID, _QUATERNION_ID, _LOCAL_ID, _GLOBAL_ID), 2**32 - 1)
"""The largest stamp of a message: us in ODOMETRY, ms elsewhere. It is the first value on the wire."""


class StateFaults:
    """The faults that are at work now. ``draw``: the source of their noise."""

    def __init__(self, draw: Draw) -> None:
        self._draw = draw
        self._faults: tuple[StateFault, ...] = ()
        self._kept: dict[tuple[int, int], Values] = {}

    def __bool__(self) -> bool:
        return bool(self._faults)

    def use(self, faults: Iterable[StateFault]) -> None:
        """These are at work from now on. One that was already keeps what it remembers."""
        before, self._faults = self._faults, tuple(faults)
        if self._faults != before:
            known = set(map(id, self._faults))
            self._kept = {key: kept for key, kept in self._kept.items() if key[0] in known}

    def alter(self, msgid: int, values: Values) -> Values | None:
        """What becomes of a message; None: it is not sent."""
        for fault in self._faults:
            if isinstance(fault, Silence):
                if fault.part in PARTS_SAID.get(msgid, ()):
                    return None
            elif isinstance(fault, Impostor):
                if msgid == _HEARTBEAT_ID:
                    values = (values[0], fault.type, fault.autopilot, *values[3:])
            elif msgid in PARTS_SAID:
                values = self._of_the_state(fault, msgid, values)
        return values

    def _of_the_state(self, fault: StateFault, msgid: int, values: Values) -> Values:
        if isinstance(fault, NotANumber):
            return _filled(msgid, values, fault)
        if isinstance(fault, WrongStamps):
            return (self._stamp(fault, msgid, values[0]), *values[1:])
        if isinstance(fault, FrozenState):
            return self._frozen(fault, msgid, values)
        if isinstance(fault, OffsetState):
            return _moved(fault, msgid, values)
        if isinstance(fault, OdometryFrames) and msgid == _ODOMETRY_ID:
            return (*values[:-5], fault.pose, fault.velocity, *values[-3:])
        return values

    def _stamp(self, fault: WrongStamps, msgid: int, stamp: Value) -> Value:
        match fault.stamps:
            case Stamps.ZERO:
                return 0
            case Stamps.MILLISECONDS:
                return stamp // 1000
            case Stamps.HUGE:
                return STAMP_MAX[msgid]
            case Stamps.FROZEN:
                return self._kept.setdefault((id(fault), msgid), (stamp,))[0]

    def _frozen(self, fault: FrozenState, msgid: int, values: Values) -> Values:
        """As it was when the fault began, and a little noise on it."""
        first = self._kept.setdefault((id(fault), msgid), values)
        changed = list(values)
        for parts, where in POSES.get(msgid, ()):
            if fault.part in parts:
                changed[where] = [x + fault.noise * self._draw() if fault.noise else x for x in first[where]]
        if msgid == _GLOBAL_ID and fault.part in _POSITION:
            changed[1:5] = first[1:5]
        return tuple(changed)


def _filled(msgid: int, values: Values, fault: NotANumber) -> Values:
    changed = list(values)
    for parts, where in (*POSES.get(msgid, ()), *MOTIONS.get(msgid, ())):
        if fault.part in parts:
            changed[where] = [fault.value] * (where.stop - where.start)
    return tuple(changed)


def _moved(fault: OffsetState, msgid: int, values: Values) -> Values:
    """The state elsewhere, otherwise moving, and turned about the vertical."""
    if msgid not in (_LOCAL_ID, _ODOMETRY_ID):
        return values
    changed = list(values)
    velocity = slice(8, 11) if msgid == _ODOMETRY_ID else slice(4, 7)
    changed[1:4] = _sum(values[1:4], fault.position_n)
    changed[velocity] = _sum(values[velocity], fault.velocity_n)
    if msgid == _ODOMETRY_ID and fault.yaw:
        half = 0.5 * fault.yaw
        w, x, y, z = values[4:8]
        attitude: Quaternion = (w, x, y, z)
        changed[4:8] = multiply((math.cos(half), 0.0, 0.0, math.sin(half)), attitude)
    return tuple(changed)


def _sum(a: Values, b: Vec3) -> list[float]:
    return [x + y for x, y in zip(a, b, strict=True)]
