"""Speed and yaw along a path: the paper's alpha (Def. 3.2) and beta (Def. 3.3).

Both are functions of where the vehicle is, never of time. On an implicit path they are expressions in x, y, z of the
mission; on a curve they are functions of the arc length s. All evaluate on floats and on any other scalars, so that the
law can differentiate them.

speed       alpha: a number, an expression, a profile, or what `auto` is made of
yaw         beta: a number, an expression, a profile, along the path, towards a point
ends        how the speed rises from rest, and falls to rest at an open end
over_arc    functions of arc length: a formula's derivatives, polynomial pieces
tables      samples -> profiles
"""

from companion.profiles.ends import StoppingSpeed
from companion.profiles.over_arc import ArcProfile, Four, hermite, interpolated
from companion.profiles.speed import (
    AutoSpeed,
    ConstantSpeed,
    Speed,
    SpeedExpression,
    SpeedOverArc,
    SpeedProfile,
    Variables,
)
from companion.profiles.tables import speed_table, yaw_table
from companion.profiles.yaw import ConstantYaw, LookAt, TangentYaw, Triple, Yaw, YawExpression, YawOverArc, YawProfile

__all__ = [
    "ArcProfile",
    "AutoSpeed",
    "ConstantSpeed",
    "ConstantYaw",
    "Four",
    "LookAt",
    "Speed",
    "SpeedExpression",
    "SpeedOverArc",
    "SpeedProfile",
    "StoppingSpeed",
    "TangentYaw",
    "Triple",
    "Variables",
    "Yaw",
    "YawExpression",
    "YawOverArc",
    "YawProfile",
    "hermite",
    "interpolated",
    "speed_table",
    "yaw_table",
]
