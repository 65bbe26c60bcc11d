"""The vehicle's parameters: read with PX4's types, unknown names tolerated, set and confirmed; and the output level."""

from __future__ import annotations

import math
import random
import struct

import pytest

from companion.flight.output import LOSS_TIME_MAX, chosen, unreachable
from companion.mavlink.codec import Decoder, Encoder, Frame
from companion.mavlink.dialect import Format, Value, message
from companion.mavlink.parameters import RETRY_AFTER, TRIES, TUNING, VALUE, Parameters
from companion.vehicle import CompanionError, MotorInterface, OutputLevel, Tuning, Vehicle
from sim_bridge.autopilot.mavlink.parameter_link import ParameterLink
from sim_bridge.autopilot.parameters import defaults

PX4 = Tuning(offboard_loss_time=1.0, offboard_loss_action=0)


class Pair:
    """Our side and the stand-in's, joined."""

    def __init__(self, loss: float = 0.0) -> None:
        self.rng, self.loss = random.Random(3), loss
        self.theirs = defaults()
        self.ours = Parameters(self._up)
        self.link = ParameterLink(self.theirs, 1, self._down)

    def _up(self, fmt: Format, values: tuple[Value, ...]) -> None:
        frame = arrived(191, fmt, values)
        if self.rng.random() >= self.loss:
            {"PARAM_REQUEST_READ": self.link.send_requested, "PARAM_SET": self.link.change}[frame.format.name](frame)

    def _down(self, fmt: Format, values: tuple[Value, ...]) -> None:
        if self.rng.random() >= self.loss:
            self.ours.receive(arrived(1, fmt, values))


def arrived(component: int, fmt: Format, values: tuple[Value, ...]) -> Frame:
    (frame,) = Decoder().datagram(Encoder(1, component).encode(fmt, values))
    return frame


def test_what_matters_is_read_in_one_go() -> None:
    pair = Pair()
    pair.ours.ask(TUNING.values(), 1, 0.0)
    assert pair.ours.settled
    tuning = pair.ours.tuning()
    assert (tuning.roll_p, tuning.offboard_loss_time, tuning.offboard_loss_action) == (4.0, 1.0, 0)
    assert (tuning.yaw_p, tuning.smoothing) == pytest.approx((2.8, 50.0))
    assert tuning.fail_roll == pytest.approx(math.radians(60))
    assert None not in tuning


def test_unknown_names_and_silence_are_none() -> None:
    pair = Pair()
    pair.ours.ask(["NO_SUCH_THING"], 1, 0.0)
    assert pair.ours.settled  # PARAM_ERROR
    assert pair.ours.value("NO_SUCH_THING") is None
    silent = Parameters(lambda fmt, values: None)
    silent.ask(["COM_OF_LOSS_T"], 1, 0.0)
    now = 0.0
    while not silent.settled:
        now = silent.next_timer()
        silent.on_timer(now)
    assert now == pytest.approx(RETRY_AFTER * TRIES)
    assert silent.tuning() == Tuning()


def test_a_third_of_the_messages_lost() -> None:
    pair = Pair(loss=0.3)
    pair.ours.ask(TUNING.values(), 1, 0.0)
    while not pair.ours.settled:
        pair.ours.on_timer(pair.ours.next_timer())
    assert pair.ours.tuning().offboard_loss_time == 1.0
    pair.ours.change("COM_OF_LOSS_T", 0.3, 10.0)
    while not pair.ours.settled:
        pair.ours.on_timer(pair.ours.next_timer())
    assert pair.theirs["COM_OF_LOSS_T"] == pytest.approx(0.3)


def test_whole_numbers_go_as_bits() -> None:
    pair = Pair()
    pair.ours.ask(["COM_OBL_RC_ACT"], 1, 0.0)
    pair.ours.change("COM_OBL_RC_ACT", 5, 0.0)
    assert pair.theirs["COM_OBL_RC_ACT"] == 5
    assert isinstance(pair.theirs["COM_OBL_RC_ACT"], int)
    minus_one = struct.unpack("<f", struct.pack("<i", -1))[0]  # a NaN as a float
    assert math.isnan(minus_one)
    pair.ours.change("COM_OBL_RC_ACT", -1, 0.0)
    assert pair.ours.value("COM_OBL_RC_ACT") == -1


def test_auto_flies_attitude_where_px4_is_slow_to_notice_and_says_why() -> None:
    choice = chosen(OutputLevel.RATES, PX4, auto=True, consent=False)
    assert choice.level is OutputLevel.ATTITUDE
    assert "COM_OF_LOSS_T is 1 s" in choice.why
    assert "--set-parameters" in choice.why
    quick = PX4._replace(offboard_loss_time=0.3)
    assert chosen(OutputLevel.RATES, quick, auto=True, consent=False).level is OutputLevel.RATES
    unknown = chosen(OutputLevel.RATES, Tuning(), auto=True, consent=True)
    assert unknown.level is OutputLevel.ATTITUDE


def test_rates_asked_for_are_offered_and_with_consent_made_safe() -> None:
    with pytest.raises(CompanionError, match=r"set COM_OF_LOSS_T to 0\.3, or give --set-parameters"):
        chosen(OutputLevel.RATES, PX4, auto=False, consent=False)
    choice = chosen(OutputLevel.RATES, PX4, auto=False, consent=True)
    assert choice.level is OutputLevel.RATES
    assert choice.settings == (("COM_OF_LOSS_T", LOSS_TIME_MAX),)
    terminate = PX4._replace(offboard_loss_action=6)
    choice = chosen(OutputLevel.RATES, terminate, auto=False, consent=True)
    assert ("COM_OBL_RC_ACT", 5) in choice.settings
    with pytest.raises(CompanionError, match="Terminate"):  # not even at attitude
        chosen(OutputLevel.ATTITUDE, terminate, auto=True, consent=False)


def test_a_limit_is_compared_as_px4_holds_it() -> None:
    held = PX4._replace(offboard_loss_time=0.30000001192092896, offboard_loss_action=5)
    assert chosen(OutputLevel.RATES, held, auto=False, consent=False).settings == ()
    over = PX4._replace(offboard_loss_time=0.3001, offboard_loss_action=5)
    assert chosen(OutputLevel.RATES, over, auto=False, consent=True).settings == (("COM_OF_LOSS_T", 0.3),)


def test_motors_are_flown_where_px4_notices_at_once() -> None:
    with pytest.raises(CompanionError, match=r"set COM_OF_LOSS_T to 0\.1, or give --set-parameters"):
        chosen(OutputLevel.MOTORS, PX4, auto=True, consent=False)
    assert chosen(OutputLevel.MOTORS, PX4, auto=False, consent=True).settings == (("COM_OF_LOSS_T", 0.1),)
    quick = PX4._replace(offboard_loss_time=0.10000000149011612, offboard_loss_action=5)
    assert chosen(OutputLevel.MOTORS, quick, auto=False, consent=False).settings == ()


def test_motors_only_where_the_vehicle_declares_them() -> None:
    machine = Vehicle("v", 1.0, (0.1, 0.1, 0.1), ())
    assert "motors: px4" in (unreachable(machine, OutputLevel.MOTORS, True) or "")
    direct = Vehicle("v", 1.0, (0.1, 0.1, 0.1), (), motors=MotorInterface.DIRECT)
    assert "1.14" in (unreachable(direct, OutputLevel.MOTORS, False) or "")
    assert unreachable(direct, OutputLevel.MOTORS, True) is None


def test_only_what_was_asked_for_is_kept() -> None:
    pair = Pair()
    pair.link.send_requested(arrived(191, *read("MC_ROLL_P")))  # somebody else's question, answered to all
    assert pair.ours.values == {}


def read(name: str) -> tuple[Format, tuple[Value, ...]]:
    fmt = message("PARAM_REQUEST_READ")
    return fmt, fmt.values(target_system=1, target_component=1, param_id=name, param_index=-1)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_value_that_is_no_number_is_not_known(value: float) -> None:
    ours = Parameters(lambda fmt, values: None)
    ours.ask(["COM_OF_LOSS_T"], 1, 0.0)
    ours.receive(arrived(1, VALUE, VALUE.values(param_value=value, param_id="COM_OF_LOSS_T", param_type=9)))
    assert ours.value("COM_OF_LOSS_T") is None
    assert not ours.settled
