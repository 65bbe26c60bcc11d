"""Who speaks on the link: strangers on other ports, second vehicles, companions, what is no multirotor; and the vehicle
that comes back from another port."""

from __future__ import annotations

from companion.flight.phases import Phase
from companion.mavlink_common import (
    MAV_AUTOPILOT_ARDUPILOTMEGA,
    MAV_AUTOPILOT_INVALID,
    MAV_COMP_ID_MISSIONPLANNER,
    MAV_COMP_ID_ONBOARD_COMPUTER,
    MAV_TYPE_FIXED_WING,
    MAV_TYPE_GCS,
    MAV_TYPE_GROUND_ROVER,
    MAV_TYPE_ONBOARD_CONTROLLER,
    MAV_TYPE_QUADROTOR,
)
from companion.world.events import Impostor, LinkCut, Order, PortChange, Saying, Stranger, When
from trials.faults.case import BEFORE_FLIGHT, Begin, Case, End

BEAT = frozenset({Saying.HEARTBEAT})
STATE = frozenset({Saying.STATE})
MODE = frozenset({Saying.MODE, Saying.HEARTBEAT})
ALL = frozenset(Saying)
COMPANION = {
    "component": MAV_COMP_ID_ONBOARD_COMPUTER, "type": MAV_TYPE_ONBOARD_CONTROLLER, "autopilot": MAV_AUTOPILOT_INVALID
}  # fmt: skip
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
        ("the vehicle's port, a fixed wing", "everything", Stranger(When(1.0), 3, type=MAV_TYPE_FIXED_WING, says=ALL, own_port=False)),
        ("the vehicle's port, a ground station", "heartbeats",
         Stranger(When(1.0), 255, MAV_COMP_ID_MISSIONPLANNER, MAV_TYPE_GCS, MAV_AUTOPILOT_INVALID, own_port=False,
                  says=BEAT)),
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
         events=(Stranger(When(1.0), 2, type=MAV_TYPE_FIXED_WING, says=BEAT),)),
    Case("a companion of system 9 before the flight", End.FLOWN, duration=2.0,
         events=(Stranger(When(0.0), 9, own_port=False, **COMPANION),)),
    Case("another companion of our system in flight", End.HELD, "another companion", phase=Phase.FOLLOW,
         events=(Stranger(When(1.0), 1, own_port=False, **COMPANION),)),
    *(Case(f"the vehicle is a {name}", End.REFUSED, name, begin=begin, levels=BEFORE_FLIGHT, events=(Impostor(When(0.0), kind),))
      for kind, name in ((MAV_TYPE_FIXED_WING, "fixed wing"), (MAV_TYPE_GROUND_ROVER, "rover"))
      for begin in (Begin.ON_THE_GROUND,)),
    Case("the vehicle's autopilot is not PX4", End.REFUSED, "PX4", begin=Begin.ON_THE_GROUND, levels=BEFORE_FLIGHT,
         events=(Impostor(When(0.0), MAV_TYPE_QUADROTOR, MAV_AUTOPILOT_ARDUPILOTMEGA),)),
    Case("heartbeats of a rover in flight", End.FLOWN, phase=Phase.FOLLOW, events=(Impostor(When(1.0), MAV_TYPE_GROUND_ROVER),)),
)  # fmt: skip

OTHER_PORT = (
    Case("the vehicle sends from another port in flight", End.FAILSAFE, "no state", phase=Phase.FOLLOW, within=0.5,
         or_end=(End.HELD,), events=(PortChange(When(2.0, 2.0)),)),
    Case("another port after 3 s of silence, on the ground", End.FLOWN, begin=Begin.ON_THE_GROUND, duration=1.0,
         events=(LinkCut(When(1.5, 4.5)), PortChange(When(4.0, 4.0)))),
)  # fmt: skip

CASES = (*IN_FLIGHT, *BEFORE, *OTHER_PORT)
