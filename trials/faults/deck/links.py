"""What becomes of datagrams: twice, again, later, cut, thinned, in pieces; one direction, one message."""

from __future__ import annotations

from companion.flight.conduct import Finish
from companion.flight.phases import Phase
from companion.vehicle import OutputLevel
from companion.world import Link, Way
from companion.world.events import (
    Event,
    LinkCut,
    LinkDelay,
    LinkDuplicate,
    LinkRecut,
    LinkRepeat,
    LinkThin,
    When,
)
from trials.faults.case import BEFORE_FLIGHT, LEVELS, Begin, Case, End, Strike

ODOMETRY = frozenset({"ODOMETRY"})
STATUS = frozenset({"HEARTBEAT", "CURRENT_MODE"})
JITTER = Link(Way(jitter=0.06), Way(jitter=0.06))
BOTH_LATE = {delay: Link(Way(delay=delay), Way(delay=delay)) for delay in (0.06, 0.12, 0.15)}


def down(t: float = 0.0, until: float = float("inf"), messages: frozenset[str] = frozenset()) -> Event:
    """From ``t`` on nothing of the vehicle's comes any more, or nothing of these messages."""
    return LinkCut(When(t, until), up=False, messages=messages)


def up(t: float = 0.0, until: float = float("inf"), messages: frozenset[str] = frozenset()) -> Event:
    """From ``t`` on nothing gets to the vehicle any more, or nothing of these messages."""
    return LinkCut(When(t, until), down=False, messages=messages)


TWICE = tuple(
    Case(f"{what} twice{f', {1e3 * delay:.0f} ms later' if delay else ''}", End.FLOWN,
         events=(LinkDuplicate(When(0.0), messages=messages, delay=delay),))
    for what, messages in (("every datagram", frozenset[str]()), ("ODOMETRY", ODOMETRY))
    for delay in (0.0, 0.003, 0.015)
)  # fmt: skip

OTHERS_TWICE = (
    Case("HEARTBEAT and CURRENT_MODE twice, 0.3 s later", End.FLOWN, begin=Begin.ON_THE_GROUND, duration=1.0,
         events=(LinkDuplicate(When(0.0), messages=STATUS, delay=0.3),)),
    Case("every command twice, 15 ms later", End.FLOWN, begin=Begin.BESIDE, duration=1.0,
         events=(LinkDuplicate(When(0.0), down=False, delay=0.015),)),
    Case("every acknowledgement twice, 0.3 s later, from the ground", End.FLOWN, begin=Begin.ON_THE_GROUND, duration=1.0,
         events=(LinkDuplicate(When(0.0), messages=frozenset({"COMMAND_ACK"}), delay=0.3),)),
    Case("everything twice, reordered, a tenth lost", End.FLOWN,
         link=Link(Way(loss=0.1, duplicated=1.0, reordered=0.3, duplicate_delay=0.02),
                   Way(loss=0.1, duplicated=1.0, reordered=0.3, duplicate_delay=0.02))),
    Case("a third of everything lost", End.FLOWN, link=Link(Way(loss=0.33), Way(loss=0.33))),
    Case("up to 60 ms of jitter each way", End.FLOWN, link=JITTER, levels=LEVELS[:2]),
    Case("up to 60 ms of jitter each way, at motors", End.HELD, "there and back|each way", link=JITTER,
         or_end=(End.REFUSED, End.FLOWN), levels=LEVELS[2:]),
)  # fmt: skip

AGAIN = (
    Case("the last ODOMETRY again for ever", End.HELD, "no state|new state|stamp", phase=Phase.FOLLOW, within=0.5,
         events=(LinkRepeat(When(2.0), messages=ODOMETRY),), levels=LEVELS[:2]),
    Case("the last ODOMETRY again for ever at motors, and PX4 lands", End.ENDED, phase=Phase.FOLLOW, within=0.5,
         events=(LinkRepeat(When(2.0), messages=ODOMETRY),), parameters={"COM_OBL_RC_ACT": 4}, levels=LEVELS[2:]),
    Case("the last ODOMETRY again for ever, while settling", End.HELD, "no state|new state|stamp", within=0.5,
         phase=Phase.SETTLE, events=(LinkRepeat(When(0.1), messages=ODOMETRY),)),
    Case("the last ODOMETRY again for 0.15 s", End.FLOWN, phase=Phase.FOLLOW,
         events=(LinkRepeat(When(2.0, 2.15), messages=ODOMETRY),), levels=LEVELS[:2]),
    # PX4's own failsafe comes after 0.1 s without motor commands
    Case("the last ODOMETRY again for 0.15 s, at motors", End.HELD, "no new state", phase=Phase.FOLLOW,
         events=(LinkRepeat(When(2.0, 2.15), messages=ODOMETRY),), levels=LEVELS[2:]),
    Case("the last of every message again for ever", End.HELD, phase=Phase.FOLLOW, within=0.5, or_end=(End.FAILSAFE,),
         events=(LinkRepeat(When(2.0), up=False),)),
)  # fmt: skip

LATER = (
    Case("the state later and later, 0.1 s a second", End.HELD, phase=Phase.FOLLOW, lost_max=2.0, tilt_max=45.0,
         duration=20.0, events=(LinkDelay(When(1.0), up=False, growth=0.1),)),
    Case("only ODOMETRY later and later, 0.1 s a second", End.HELD, phase=Phase.FOLLOW, lost_max=2.0, tilt_max=45.0,
         duration=20.0, events=(LinkDelay(When(1.0), up=False, growth=0.1, messages=ODOMETRY),)),
    Case("the state later and later, 0.05 s a second", End.HELD, phase=Phase.FOLLOW, lost_max=2.0, tilt_max=45.0,
         duration=20.0, events=(LinkDelay(When(1.0), up=False, growth=0.05),)),
    Case("setpoints later and later, 0.1 s a second", End.HELD, phase=Phase.FOLLOW, lost_max=2.0, tilt_max=45.0,
         duration=20.0, events=(LinkDelay(When(1.0), down=False, growth=0.1),)),
    Case("everything 0.3 s later at once", End.HELD, phase=Phase.FOLLOW, lost_max=2.0,
         events=(LinkDelay(When(2.0), delay=0.3),)),
    Case("60 ms each way from the start", End.FLOWN, link=BOTH_LATE[0.06], levels=LEVELS[:2]),
    Case("60 ms each way from the start, at motors", End.REFUSED, link=BOTH_LATE[0.06],
         levels=LEVELS[2:]),
    Case("120 ms each way from the start", End.REFUSED, "ms|late|delay|s each way", link=BOTH_LATE[0.12]),
    Case("120 ms each way from the start, on the ground", End.REFUSED, "ms|late|delay|s each way",
         link=BOTH_LATE[0.12], begin=Begin.ON_THE_GROUND),
    Case("150 ms each way from the start", End.REFUSED, "ms|late|delay|s each way", link=BOTH_LATE[0.15]),
)  # fmt: skip

IN_PIECES = (
    Case("bytes cut into datagrams of 77", End.FLOWN, events=(LinkRecut(When(0.0), size=77),)),
    Case("bytes cut into datagrams of 20", End.FLOWN, events=(LinkRecut(When(0.0), size=20),)),
    Case("bytes gathered for 20 ms", End.FLOWN, events=(LinkRecut(When(0.0), size=1400, wait=0.02),)),
    Case("bytes cut into datagrams of 77, from the ground", End.FLOWN, begin=Begin.ON_THE_GROUND, duration=1.0,
         events=(LinkRecut(When(0.0), size=77),)),
    Case("14 states a second", End.REFUSED, "14 states a second", begin=Begin.ON_THE_GROUND,
         events=(LinkThin(When(0.0), up=False, messages=ODOMETRY, rate=14.0),)),
    Case("6 states a second", End.REFUSED, "6 states a second", levels=BEFORE_FLIGHT, begin=Begin.ON_THE_GROUND,
         events=(LinkThin(When(0.0), up=False, messages=ODOMETRY, rate=6.0),)),
    Case("14 states a second from the middle of the path on", End.FLOWN, phase=Phase.FOLLOW,
         events=(LinkThin(When(2.0), up=False, messages=ODOMETRY, rate=14.0),)),
)  # fmt: skip

CUT = (
    *(Case(f"both ways cut for {seconds:g} s", End.HELD, "no state", phase=Phase.FOLLOW, within=0.5,
           events=(LinkCut(When(2.0, 2.0 + seconds)),)) for seconds in (0.3, 1.0)),
    Case("both ways cut for good", End.FAILSAFE, phase=Phase.FOLLOW, within=0.5, events=(LinkCut(When(2.0)),)),
    Case("both ways cut for 0.15 s", End.FLOWN, phase=Phase.FOLLOW, events=(LinkCut(When(2.0, 2.15)),)),
    *(Case(f"the downlink cut in {phase.value}", End.HELD, phase=phase, begin=begin, finish=finish, duration=1.0,
           or_end=(End.FAILSAFE,), events=(down(t),))
      for phase, t, begin, finish in (
          (Phase.TAKE_OVER, 0.05, Begin.ON_THE_PATH, Finish.HOLD),
          (Phase.JOIN, 1.0, Begin.BESIDE, Finish.HOLD), (Phase.FOLLOW, 0.5, Begin.ON_THE_PATH, Finish.HOLD))),
    Case("the downlink cut in settle", End.HELD, phase=Phase.SETTLE, begin=Begin.BESIDE, or_end=(End.FAILSAFE,),
         events=(down(0.1),)),
    Case("the downlink cut in hand back", End.HELD, phase=Phase.HAND_BACK, duration=1.0, or_end=(End.FLOWN, End.ENDED),
         events=(down(),)),
    *(Case(f"the downlink cut in {phase.value}", End.ENDED, phase=phase, begin=begin, finish=finish, duration=1.0,
           events=(down(t),))
      for phase, t, begin, finish in (
          (Phase.ARM, 0.0, Begin.ON_THE_GROUND, Finish.HOLD), (Phase.TAKE_OFF, 1.0, Begin.ON_THE_GROUND, Finish.HOLD),
          )),
    *(Case(f"the downlink cut in {phase.value}", End.ENDED, "nothing heard from the vehicle for 30", phase=phase,
           finish=finish, duration=1.0, events=(down(1.0),), parameters={"RTL_RETURN_ALT": 12.0}, time_out=60.0)
      for phase, finish in ((Phase.LAND, Finish.LAND), (Phase.RETURN, Finish.RETURN))),
    Case("the downlink cut in release", End.ENDED, "", phase=Phase.FOLLOW, events=(up(2.0),), time_out=60.0,
         strikes=(Strike(Phase.RELEASE, (down(),)),), parameters={"COM_OBL_RC_ACT": 4}),
    *(Case(f"the uplink cut before {phase.value} is asked for", End.ENDED, "not begun within 6 s", phase=Phase.HAND_BACK,
           finish=finish, duration=1.0, events=(up(),), time_out=60.0)
      for phase, finish in ((Phase.LAND, Finish.LAND), (Phase.RETURN, Finish.RETURN))),
    Case("the uplink cut for good, and PX4 lands", End.ENDED, phase=Phase.FOLLOW, events=(up(2.0),),
         parameters={"COM_OBL_RC_ACT": 4}, says="HOLD was not answered", time_out=60.0),
    Case("the uplink cut for 0.15 s", End.FLOWN, phase=Phase.FOLLOW, events=(up(2.0, 2.15),), levels=LEVELS[:2]),
    Case("the uplink cut for 0.08 s at motors", End.FLOWN, phase=Phase.FOLLOW, events=(up(2.0, 2.08),),
         levels=LEVELS[2:]),
    Case("the uplink cut for 1 s, and PX4 lands", End.ENDED, phase=Phase.FOLLOW, events=(up(2.0, 3.0),),
         parameters={"COM_OBL_RC_ACT": 4}, levels=(OutputLevel.RATES, OutputLevel.MOTORS)),
    Case("the uplink cut for 1 s at attitude, where PX4 waits as long", End.FLOWN, phase=Phase.FOLLOW,
         events=(up(2.0, 3.0),), parameters={"COM_OBL_RC_ACT": 4}, levels=(OutputLevel.ATTITUDE,)),
    Case("the uplink cut in arm", End.ENDED, phase=Phase.ARM, begin=Begin.ON_THE_GROUND, events=(up(),)),
    Case("the uplink cut in take over", End.ENDED, phase=Phase.TAKE_OVER, events=(up(),)),
)  # fmt: skip

SILENT = (
    Case("HEARTBEAT and CURRENT_MODE silent", End.FAILSAFE, phase=Phase.FOLLOW, within=3.0, or_end=(End.HELD,),
         events=(down(1.0, messages=STATUS),), duration=20.0),
    Case("HEARTBEAT silent", End.FLOWN, phase=Phase.FOLLOW, events=(down(1.0, messages=frozenset({"HEARTBEAT"})),)),
    Case("CURRENT_MODE silent", End.FLOWN, or_end=(End.FAILSAFE, End.HELD), phase=Phase.FOLLOW,
         events=(down(1.0, messages=frozenset({"CURRENT_MODE"})),)),
    Case("CURRENT_MODE never heard", End.FLOWN, or_end=(End.REFUSED,), says="CURRENT_MODE",
         events=(down(messages=frozenset({"CURRENT_MODE"})),)),
    Case("COMMAND_ACK never heard", End.FLOWN, events=(down(messages=frozenset({"COMMAND_ACK"})),)),
    Case("COMMAND_ACK never heard, from the ground", End.FLOWN, begin=Begin.ON_THE_GROUND, duration=1.0,
         events=(down(messages=frozenset({"COMMAND_ACK"})),)),
    Case("TIMESYNC never heard", End.FLOWN, or_end=(End.REFUSED,), says="TIMESYNC",
         events=(down(messages=frozenset({"TIMESYNC"})),)),
    Case("battery and estimator silent", End.FLOWN,
         events=(down(messages=frozenset({"BATTERY_STATUS", "ESTIMATOR_STATUS"})),)),
    Case("EXTENDED_SYS_STATE silent in flight", End.FLOWN, phase=Phase.FOLLOW,
         events=(down(1.0, messages=frozenset({"EXTENDED_SYS_STATE"})),)),
    Case("EXTENDED_SYS_STATE never heard", End.REFUSED, "EXTENDED_SYS_STATE", levels=BEFORE_FLIGHT,
         events=(down(messages=frozenset({"EXTENDED_SYS_STATE"})),)),
    Case("EXTENDED_SYS_STATE never heard, on the ground", End.REFUSED, "EXTENDED_SYS_STATE", begin=Begin.ON_THE_GROUND,
         levels=BEFORE_FLIGHT,
         events=(down(messages=frozenset({"EXTENDED_SYS_STATE"})),)),
    Case("ODOMETRY never heard", End.REFUSED, "ODOMETRY", levels=BEFORE_FLIGHT, events=(down(messages=ODOMETRY),)),
    Case("ODOMETRY silent", End.HELD, "no state|no new state", phase=Phase.FOLLOW, within=0.5, events=(down(2.0, messages=ODOMETRY),)),
)  # fmt: skip

CASES = (*TWICE, *OTHERS_TWICE, *AGAIN, *LATER, *IN_PIECES, *CUT, *SILENT)
