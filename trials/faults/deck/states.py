"""What the vehicle says wrongly of its state: stamps, numbers that are none, what stands still, what jumps."""

from __future__ import annotations

import math

from companion.flight.phases import Phase
from companion.vehicle import OutputLevel
from companion.world.events import (
    ClockJump,
    EstimatorReset,
    Event,
    FrozenState,
    NotANumber,
    OdometryFrames,
    OffsetState,
    Part,
    Silence,
    Stamps,
    When,
    WrongStamps,
)
from trials.faults.case import BEFORE_FLIGHT, LEVELS, Begin, Case, End

NOISE = 1e-6
HUGE = 3e38
STEP = 0.004


def one(event: type[NotANumber] | type[OffsetState], **values: object) -> Event:
    """A single state that is wrong."""
    return event(When(2.0, 2.0 + STEP), **values)  # type: ignore[arg-type]


STAMPS = (
    *(Case(f"stamps {words}{', on the ground' if ground else ''}", End.REFUSED, "stamp", begin=begin, levels=BEFORE_FLIGHT,
           events=(WrongStamps(When(0.0), stamps),))
      for stamps, words in ((Stamps.ZERO, "always 0"), (Stamps.MILLISECONDS, "in ms"), (Stamps.HUGE, "near 2^64"))
      for begin in (Begin.ON_THE_PATH, Begin.ON_THE_GROUND)
      for ground in (begin is Begin.ON_THE_GROUND,)),
    *(Case(f"stamps {words} from the middle of the path on", End.HELD, phase=Phase.FOLLOW, within=0.5,
           events=(WrongStamps(When(2.0), stamps),))
      for stamps, words in (
          (Stamps.ZERO, "0"), (Stamps.MILLISECONDS, "in ms"), (Stamps.HUGE, "near 2^64"))),
    Case("stamps frozen from the middle of the path on", End.HELD, phase=Phase.FOLLOW, within=0.5,
         events=(WrongStamps(When(2.0), Stamps.FROZEN),), levels=LEVELS[:2]),
    Case("stamps frozen from the middle of the path on at motors, and PX4 lands", End.ENDED, phase=Phase.FOLLOW,
         within=0.5, events=(WrongStamps(When(2.0), Stamps.FROZEN),), parameters={"COM_OBL_RC_ACT": 4},
         levels=LEVELS[2:]),
    Case("one stamp near 2^64", End.FLOWN, phase=Phase.FOLLOW, events=(WrongStamps(When(2.0, 2.0 + STEP), Stamps.HUGE),)),
    Case("the clock jumps 3 s ahead", End.HELD, "clock", phase=Phase.FOLLOW, within=0.5,
         events=(ClockJump(When(2.0, 2.0), 3.0),)),
    Case("the clock jumps 0.3 s ahead", End.FLOWN, or_end=(End.HELD,), phase=Phase.FOLLOW,
         events=(ClockJump(When(2.0, 2.0), 0.3),)),
    Case("the clock jumps 3 s back", End.HELD, phase=Phase.FOLLOW, within=0.5,
         events=(ClockJump(When(4.0, 4.0), -3.0),)),
)  # fmt: skip

NUMBERS = (
    *(Case(f"the {part.value} is {words} for good", End.HELD, phase=Phase.FOLLOW, within=0.5,
           events=(NotANumber(When(2.0), part, value),))
      for part in (Part.POSITION, Part.ATTITUDE) for value, words in ((math.nan, "NaN"), (HUGE, "3e38"))),
    *(Case(f"one ODOMETRY {words}", End.FLOWN, phase=Phase.FOLLOW, events=(one(NotANumber, value=value),))
      for value, words in ((math.nan, "of NaN"), (HUGE, "of 3e38 m"), (math.inf, "that is infinite"))),
    Case("one ODOMETRY of 3e38 m while settling", End.FLOWN, phase=Phase.SETTLE,
         events=(NotANumber(When(0.1, 0.1 + STEP), value=HUGE),)),
    Case("ODOMETRY in LOCAL_ENU", End.REFUSED, "ODOMETRY.*frame|frame.*ODOMETRY", levels=BEFORE_FLIGHT,
         events=(OdometryFrames(When(0.0), 4, 1),)),
    Case("ODOMETRY in LOCAL_ENU, on the ground", End.REFUSED, "ODOMETRY.*frame|frame.*ODOMETRY",
         begin=Begin.ON_THE_GROUND, levels=BEFORE_FLIGHT, events=(OdometryFrames(When(0.0), 4, 1),)),
    Case("ODOMETRY in LOCAL_ENU from the middle of the path on", End.HELD, phase=Phase.FOLLOW, within=0.5,
         events=(OdometryFrames(When(2.0), 4, 1),)),
    Case("the position falls silent", End.HELD, phase=Phase.FOLLOW, within=0.5,
         events=(Silence(When(2.0), Part.POSITION),)),
)  # fmt: skip

STANDING = (
    *(Case(f"{part.value} frozen{' but for 1e-6 of noise' if noise else ''}", End.HELD, phase=Phase.FOLLOW, within=0.5,
           tilt_max=45.0, events=(FrozenState(When(2.0), part, noise),))
      for part in (Part.POSITION, Part.ATTITUDE, Part.STATE) for noise in (0.0, NOISE)),
    *(Case(f"{part.value} frozen but for 1e-6 of noise, joining", End.HELD, phase=Phase.JOIN, tilt_max=45.0,
           begin=Begin.BESIDE, events=(FrozenState(When(1.5), part, NOISE),))
      for part in (Part.POSITION, Part.ATTITUDE)),
    Case("position frozen but for 1e-3 of noise", End.HELD, phase=Phase.FOLLOW, within=1.5, tilt_max=45.0,
         events=(FrozenState(When(2.0), Part.POSITION, 1e-3),)),
    Case("attitude frozen but for 1e-3 of noise", End.HELD, phase=Phase.FOLLOW, within=1.5, tilt_max=45.0,
         events=(FrozenState(When(2.0), Part.ATTITUDE, 1e-3),), levels=(OutputLevel.RATES, OutputLevel.MOTORS)),
    Case("attitude frozen but for 1e-3 of noise, at attitude, where PX4 holds what is sent", End.HELD,
         phase=Phase.FOLLOW, tilt_max=45.0, or_end=(End.FLOWN,), events=(FrozenState(When(2.0), Part.ATTITUDE, 1e-3),),
         levels=(OutputLevel.ATTITUDE,)),
    *(Case(f"{part.value} frozen for 0.15 s", End.FLOWN, phase=Phase.FOLLOW,
           events=(FrozenState(When(2.0, 2.15), part, 0.0),))
      for part in (Part.POSITION, Part.ATTITUDE)),
)  # fmt: skip

JUMPS = (
    Case("a jump of 20 m without a count, believed by the vehicle", End.HELD, phase=Phase.FOLLOW, within=0.3,
         tilt_max=45.0, events=(EstimatorReset(When(2.0, 2.0), (20.0, 0.0, 0.0), counted=False),)),
    Case("a jump of 20 m without a count, only said", End.HELD, phase=Phase.FOLLOW, within=0.3, tilt_max=45.0,
         events=(OffsetState(When(2.0), (20.0, 0.0, 0.0)),)),
    Case("a jump of 20 m up without a count, only said", End.HELD, phase=Phase.FOLLOW, within=0.3, tilt_max=45.0,
         events=(OffsetState(When(2.0), (0.0, 0.0, -20.0)),)),
    Case("a jump of 20 m without a count, joining", End.HELD, phase=Phase.JOIN, begin=Begin.BESIDE, within=0.3,
         tilt_max=45.0, events=(OffsetState(When(1.0), (20.0, 0.0, 0.0)),)),
    Case("a jump of 20 m that is counted", End.HELD, "moved", phase=Phase.FOLLOW, within=0.3, tilt_max=45.0,
         events=(EstimatorReset(When(2.0, 2.0), (20.0, 0.0, 0.0)),)),
    Case("a jump of 3 m that is counted", End.FLOWN, phase=Phase.FOLLOW, events=(
         EstimatorReset(When(2.0, 2.0), (3.0, 0.0, 0.0)),)),
    Case("a jump of 3 m without a count, only said", End.HELD, or_end=(End.FLOWN,), phase=Phase.FOLLOW,
         events=(OffsetState(When(2.0), (3.0, 0.0, 0.0)),)),
    Case("20 m off for one state", End.FLOWN, or_end=(End.HELD,), phase=Phase.FOLLOW, tilt_max=45.0,
         events=(one(OffsetState, position_n=(20.0, 0.0, 0.0)),)),
    Case("20 m off every other tenth of a second", End.HELD, phase=Phase.FOLLOW, within=0.5, tilt_max=45.0,
         events=tuple(OffsetState(When(2.0 + 0.2 * i, 2.1 + 0.2 * i), (20.0, 0.0, 0.0)) for i in range(10))),
    Case("the heading off by 90 degrees without a count", End.HELD, phase=Phase.FOLLOW, lost_max=3.0,
         events=(OffsetState(When(2.0), yaw=math.radians(90.0)),)),
    Case("the velocity off by 3 m/s without a count", End.HELD, phase=Phase.FOLLOW,
         events=(OffsetState(When(2.0), velocity_n=(3.0, 0.0, 0.0)),)),
    Case("a heading reset of 30 degrees that is counted", End.FLOWN, phase=Phase.FOLLOW,
         events=(EstimatorReset(When(2.0, 2.0), yaw=math.radians(30.0)),)),
)  # fmt: skip

CASES = (*STAMPS, *NUMBERS, *STANDING, *JUMPS)
