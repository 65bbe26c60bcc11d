"""What a human does meanwhile: every order in every phase, with a whole link and with half of one; Ctrl-C."""

from __future__ import annotations

from companion.flight.conduct import ControlAuthority, Finish
from companion.flight.phases import Phase
from companion.world.events import Event, LinkCut, Order, Sticks, When
from trials.faults.case import BEFORE_FLIGHT, Begin, Case, End, at
from trials.faults.deck.links import STATUS, down, up

Place = tuple[Phase, float, Begin, Finish]
TAKE_OFF: Place = (Phase.TAKE_OFF, 1.5, Begin.ON_THE_GROUND, Finish.HOLD)
TAKE_OVER: Place = (Phase.TAKE_OVER, 0.02, Begin.ON_THE_PATH, Finish.HOLD)
SETTLE: Place = (Phase.SETTLE, 0.15, Begin.ON_THE_PATH, Finish.HOLD)
JOIN: Place = (Phase.JOIN, 1.0, Begin.BESIDE, Finish.HOLD)
FOLLOW: Place = (Phase.FOLLOW, 0.5, Begin.ON_THE_PATH, Finish.HOLD)
HAND_BACK: Place = (Phase.HAND_BACK, 0.0, Begin.ON_THE_PATH, Finish.HOLD)
LAND: Place = (Phase.LAND, 1.0, Begin.ON_THE_PATH, Finish.LAND)
RETURN: Place = (Phase.RETURN, 1.0, Begin.ON_THE_PATH, Finish.RETURN)


def ordered(order: Order, place: Place, *events: Event, cut: str = "", **others: object) -> Case:
    """The operator's order in a phase, ``events`` beside it."""
    phase, t, begin, finish = place
    name = f"the operator's {order.value} in {phase.value}{cut}"
    return Case(name, End.OPERATORS, phase=phase, begin=begin, finish=finish, duration=1.0,
                events=(*events, at(t, order)), **others)  # type: ignore[arg-type]  # fmt: skip


WHOLE_LINK = (
    ordered(Order.LAND, TAKE_OFF),
    ordered(Order.RETURN, TAKE_OFF),
    *(ordered(order, place) for place in (TAKE_OVER, SETTLE, JOIN, FOLLOW) for order in (Order.LAND, Order.RETURN)),
    *(ordered(Order.HOLD, place) for place in (SETTLE, JOIN, FOLLOW)),
    ordered(Order.LAND, HAND_BACK, or_end=(End.FLOWN,)),
    ordered(Order.HOLD, LAND),
    ordered(Order.RETURN, LAND),
    ordered(Order.HOLD, RETURN),
    ordered(Order.LAND, RETURN),
    Case("the operator's position in follow, sticks in hand", End.OPERATORS, phase=Phase.FOLLOW,
         events=(Sticks(When(0.0)), at(1.0, Order.POSITION))),
    Case("the operator's land in rest", End.OPERATORS, phase=Phase.REST, mission="line", duration=60.0,
         events=(at(0.1, Order.LAND),)),
    Case("the operator's kill in follow", End.OPERATORS, phase=Phase.FOLLOW, loses_thrust=True,
         events=(at(1.0, Order.KILL),), watched_for=3.0),
    Case("the operator's kill in join", End.OPERATORS, phase=Phase.JOIN, begin=Begin.BESIDE, loses_thrust=True,
         events=(at(0.5, Order.KILL),), watched_for=3.0),
    Case("the operator disarms 60 ms after the arming", End.OPERATORS, phase=Phase.ARM, begin=Begin.ON_THE_GROUND,
         events=(at(0.06, Order.DISARM),), watched_for=8.0),
    Case("the operator disarms 0.6 s after the arming", End.OPERATORS, phase=Phase.ARM, begin=Begin.ON_THE_GROUND,
         events=(at(0.6, Order.DISARM),), watched_for=8.0),
    Case("the operator's land a moment after the arming", End.OPERATORS, phase=Phase.ARM, begin=Begin.ON_THE_GROUND,
         events=(at(0.5, Order.LAND),), watched_for=4.0, or_end=(End.ENDED,)),
)  # fmt: skip

HALF_A_LINK = (
    # HOLD may be asked for until 1 s after the last status; whoever lands it before is taken back once, to Hold
    *(ordered(order, (phase, t + 1.1, begin, finish), down(t), cut=", the downlink cut 1.1 s before", watched_for=4.0)
      for order, (phase, t, begin, finish) in (
          (Order.LAND, TAKE_OFF), (Order.LAND, TAKE_OVER), (Order.LAND, JOIN), (Order.LAND, FOLLOW),
          (Order.RETURN, FOLLOW))),
    # in real time HOLD may be accepted before the link is cut
    ordered(Order.LAND, (Phase.HAND_BACK, 1.1, *HAND_BACK[2:]), down(), cut=", the downlink cut 1.1 s before",
            watched_for=4.0, or_end=(End.FLOWN,)),
    ordered(Order.HOLD, (Phase.LAND, 1.5, *LAND[2:]), down(1.0), cut=", the downlink cut"),
    Case("the operator lands in abort, the downlink cut", End.HELD, or_end=(End.OPERATORS,), phase=Phase.FOLLOW,
         watched_for=4.0, events=(down(1.0), at(1.35, Order.LAND))),
    Case("the operator disarms 60 ms after the arming, the downlink cut", End.OPERATORS, phase=Phase.ARM,
         begin=Begin.ON_THE_GROUND, events=(down(0.05), at(0.06, Order.DISARM)), watched_for=12.0),
    Case("OFFBOARD is lost on the way up, the operator lands", End.OPERATORS, phase=Phase.TAKE_OVER,
         events=(up(0.0, 1.5, frozenset({"COMMAND_LONG"})), at(0.7, Order.LAND)), watched_for=4.0),
    Case("HOLD is lost on the way up, the operator lands", End.OPERATORS, or_end=(End.FLOWN,), phase=Phase.FOLLOW,
         duration=1.0, events=(up(0.9, 2.5, frozenset({"COMMAND_LONG"})), at(1.7, Order.LAND)), watched_for=4.0),
    Case("HEARTBEAT and CURRENT_MODE silent, the operator lands", End.OPERATORS, phase=Phase.FOLLOW, duration=20.0,
         events=(down(1.0, messages=STATUS), at(1.5, Order.LAND)), watched_for=4.0),
    Case("CURRENT_MODE silent, the operator lands", End.OPERATORS, phase=Phase.FOLLOW, duration=20.0,
         events=(down(1.0, messages=frozenset({"CURRENT_MODE"})), at(1.5, Order.LAND)), watched_for=4.0),
    Case("the downlink cut for 3 s, the operator lands meanwhile", End.OPERATORS, phase=Phase.FOLLOW, watched_for=6.0,
         events=(down(1.0, 4.0), at(2.5, Order.LAND))),
    Case("both ways cut for 3 s, the operator lands meanwhile", End.OPERATORS, phase=Phase.FOLLOW, watched_for=6.0,
         events=(LinkCut(When(1.0, 4.0)), at(2.5, Order.LAND))),
    Case("the downlink cut in join for 0.8 s, the operator returns", End.HELD, or_end=(End.OPERATORS,), phase=Phase.JOIN,
         begin=Begin.BESIDE, watched_for=4.0, events=(down(1.0, 1.8), at(1.5, Order.RETURN))),
)  # fmt: skip

BEFORE = (
    Case("in Land when the companion comes", End.REFUSED, "Land", levels=BEFORE_FLIGHT, events=(at(0.0, Order.LAND),), watched_for=25.0),
    Case("in Return when the companion comes", End.REFUSED, "Return", levels=BEFORE_FLIGHT, events=(at(0.0, Order.RETURN),)),
    Case("in Mission, armed by another, when the companion comes", End.REFUSED, begin=Begin.ON_THE_GROUND, levels=BEFORE_FLIGHT,
         events=(at(5.0, Order.TAKE_OFF), at(5.1, Order.ARM)), phase=None, or_end=(End.ENDED,)),
)  # fmt: skip

STOPPED = (
    *(Case(f"Ctrl-C in {phase.value}", End.ENDED, "stopped by the user", phase=phase, begin=begin, stop_at=t,
           duration=3.0, finish=finish)
      for phase, t, begin, finish in (TAKE_OVER, SETTLE, JOIN, FOLLOW)),
    *(Case(f"Ctrl-C in {phase.value}", End.DISARMED, "stopped by the user", phase=phase, begin=Begin.ON_THE_GROUND,
           stop_at=t, duration=3.0, watched_for=5.0)
      for phase, t in ((Phase.PREFLIGHT, 0.5), (Phase.ARM, 0.1), (Phase.TAKE_OFF, 0.1))),
    Case("Ctrl-C in take off, at once", End.DISARMED, "stopped by the user", phase=Phase.TAKE_OFF,
         begin=Begin.ON_THE_GROUND, stop_at=0.0, watched_for=8.0),
    Case("Ctrl-C in take off, in the air", End.HELD, "stopped by the user", phase=Phase.TAKE_OFF,
         begin=Begin.ON_THE_GROUND, stop_at=3.0, watched_for=8.0),
)  # fmt: skip

PILOTS = (
    Case("the pilot's start, and he lands", End.OPERATORS, authority=ControlAuthority.PILOT, or_end=(End.ENDED,),
         events=(at(1.0, Order.OFFBOARD), at(3.0, Order.LAND)), stop_at=4.0),
    Case("the pilot's start, the downlink cut", End.FAILSAFE, authority=ControlAuthority.PILOT, or_end=(End.ENDED,),
         events=(at(1.0, Order.OFFBOARD), down(3.0)), stop_at=6.0),
)  # fmt: skip

CASES = (*WHOLE_LINK, *HALF_A_LINK, *BEFORE, *STOPPED, *PILOTS)
