"""Who speaks on the link: strangers on other ports, second vehicles, companions, what is no multirotor; and the vehicle
that comes back from another port."""

from __future__ import annotations

from companion.flight.phases import Phase
from companion.world.events import Impostor, LinkCut, Order, PortChange, Saying, Stranger, When
from trials.faults.case import BEFORE_FLIGHT, Begin, Case, End

BEAT = frozenset({Saying.HEARTBEAT})
STATE = frozenset({Saying.STATE})
MODE = frozenset({Saying.MODE, Saying.HEARTBEAT})
ALL = frozenset(Saying)
COMPANION = {"component": 191, "type": 18, "autopilot": 8}
ELSEWHERE = (50.0, 0.0, 3.0)

IN_FLIGHT = tuple(
    Case(f"{who} in flight: {what}", End.FLOWN, phase=Phase.FOLLOW, events=(event,))
    for who, what, event in (
        ("another port, our ids", "heartbeats", Stranger(When(1.0), says=BEAT)),
        ("another port, our ids", "mode Land, disarmed", Stranger(When(1.0), says=MODE, mode=Order.LAND, armed=False)),
        ("another port, our ids", "states 50 m away", Stranger(When(1.0), says=STATE, position_n=ELSEWHERE)),
        ("another port, our ids", "everything", Stranger(When(1.0), says=ALL, mode=Order.LAND, position_n=ELSEWHERE)),
        ("another port, system 2", "everything", Stranger(When(1.0), 2, says=ALL, mode=Order.LAND)),
        ("the vehicle's port, system 2", "everything", Stranger(When(1.0), 2, says=ALL, mode=Order.LAND, own_port=False)),
        ("the vehicle's port, a fixed wing", "everything", Stranger(When(1.0), 3, type=1, says=ALL, own_port=False)),
        ("the vehicle's port, a ground station", "heartbeats",
         Stranger(When(1.0), 255, 190, 6, 8, own_port=False, says=BEAT)),
        ("the vehicle's port, a companion of system 9", "heartbeats",
         Stranger(When(1.0), 9, own_port=False, **COMPANION)),
        ("another port, a companion of system 9", "heartbeats", Stranger(When(1.0), 9, **COMPANION)),
    )
)  # fmt: skip

BEFORE = (
    Case("a second vehicle on another port before the flight", End.REFUSED, "two", begin=Begin.ON_THE_GROUND, levels=BEFORE_FLIGHT,
         events=(Stranger(When(1.0), 2, says=ALL, armed=False),)),
    Case("our own ids on another port before the flight", End.REFUSED, "two", begin=Begin.ON_THE_GROUND, levels=BEFORE_FLIGHT,
         events=(Stranger(When(1.0), says=ALL, armed=False),)),
    Case("a second vehicle on the vehicle's port before the flight", End.REFUSED, "two", begin=Begin.ON_THE_GROUND, levels=BEFORE_FLIGHT,
         events=(Stranger(When(1.0), 2, says=BEAT, own_port=False),)),
    Case("a fixed wing on another port before the flight", End.FLOWN, begin=Begin.ON_THE_GROUND, duration=1.0,
         events=(Stranger(When(1.0), 2, type=1, says=BEAT),)),
    Case("a companion of system 9 before the flight", End.FLOWN, duration=2.0,
         events=(Stranger(When(0.0), 9, own_port=False, **COMPANION),)),
    Case("another companion of our system in flight", End.HELD, "another companion", phase=Phase.FOLLOW,
         events=(Stranger(When(1.0), 1, own_port=False, **COMPANION),)),
    *(Case(f"the vehicle is a {name}", End.REFUSED, name, begin=begin, levels=BEFORE_FLIGHT, events=(Impostor(When(0.0), kind),))
      for kind, name in ((1, "fixed wing"), (10, "rover"))
      for begin in (Begin.ON_THE_GROUND,)),
    Case("the vehicle's autopilot is not PX4", End.REFUSED, "PX4", begin=Begin.ON_THE_GROUND, levels=BEFORE_FLIGHT,
         events=(Impostor(When(0.0), 2, 3),)),
    Case("heartbeats of a rover in flight", End.FLOWN, phase=Phase.FOLLOW, events=(Impostor(When(1.0), 10),)),
)  # fmt: skip

OTHER_PORT = (
    Case("the vehicle sends from another port in flight", End.FAILSAFE, "no state", phase=Phase.FOLLOW, within=0.5,
         or_end=(End.HELD,), events=(PortChange(When(2.0, 2.0)),)),
    Case("another port after 3 s of silence, on the ground", End.FLOWN, begin=Begin.ON_THE_GROUND, duration=1.0,
         events=(LinkCut(When(1.5, 4.5)), PortChange(When(4.0, 4.0)))),
)  # fmt: skip

CASES = (*IN_FLIGHT, *BEFORE, *OTHER_PORT)
