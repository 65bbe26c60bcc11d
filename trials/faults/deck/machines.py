"""What the machine itself loses: motors, and who holds or pushes it."""

from __future__ import annotations

from companion.flight.phases import Phase
from companion.world.events import Hold, MotorFailure, Push, When
from trials.faults.case import Begin, Case, End

CASES = (
    Case("one motor at 50 %", End.HELD, "motor|thrust", phase=Phase.FOLLOW, loses_thrust=True, within=3.0,
         or_end=(End.ENDED,), events=(MotorFailure(When(2.0), 1, 0.5),)),
    Case("one motor at 50 %, joining", End.HELD, "motor|thrust", phase=Phase.JOIN, begin=Begin.BESIDE, loses_thrust=True,
         within=3.0, or_end=(End.ENDED,), events=(MotorFailure(When(1.5), 3, 0.5),)),
    Case("one motor at 80 %", End.FLOWN, phase=Phase.FOLLOW, events=(MotorFailure(When(2.0), 2, 0.8),)),
    Case("one motor dead", End.ENDED, "motor|propeller|thrust", phase=Phase.FOLLOW, loses_thrust=True, within=1.0,
         events=(MotorFailure(When(2.0), 1),), watched_for=0.0),
    Case("every motor at 85 %", End.FLOWN, phase=Phase.FOLLOW, events=(MotorFailure(When(2.0), None, 0.85),)),
    Case("every motor at 50 %", End.ENDED, "motor|thrust", phase=Phase.FOLLOW, loses_thrust=True, within=3.0,
         or_end=(End.HELD,), events=(MotorFailure(When(2.0), None, 0.5),), watched_for=0.0),
    Case("pushed with 8 N for 1 s", End.FLOWN, phase=Phase.FOLLOW, events=(Push(When(2.0, 3.0), (8.0, 0.0, 0.0)),)),
    Case("held for 3 s", End.FLOWN, phase=Phase.FOLLOW, duration=8.0, events=(Hold(When(2.0, 5.0)),)),
    Case("COM_OF_LOSS_T set to 0.3 already", End.FLOWN, parameters={"COM_OF_LOSS_T": 0.3}, duration=2.0),
)  # fmt: skip
