"""What becomes of the payload's commands is told: accepted, refused, begun and not ended, never answered."""

from __future__ import annotations

from companion.daemon.payload import Payload
from companion.mavlink.requests import ANSWER_WITHIN, Command, Requests
from companion.mavlink_common import MAV_CMD_DO_SET_SERVO, MavResult
from companion.mission import PathAction

SERVO = PathAction(number=4, command=MAV_CMD_DO_SET_SERVO, params=(1.0, 1500.0, 0.0, 0.0, 0.0, 0.0, 0.0), s=12.0)


class Flown:
    """One command sent at 10 s, and answered as told."""

    def __init__(self) -> None:
        self.said: list[str] = []
        sent: list[Command] = []
        self.payload = Payload(self.said.append)
        self.link = Requests(lambda command, confirmation: sent.append(command))
        self.payload.send((SERVO,), self.link, 10.0)
        assert [command.id for command in sent] == [MAV_CMD_DO_SET_SERVO]

    def answer(self, result: MavResult, now: float) -> None:
        found = self.link.match_acknowledgement(MAV_CMD_DO_SET_SERVO, result, now)
        assert found is not None and self.payload.take_answer(*found, now)


def test_a_command_that_is_begun_is_waited_for_until_it_ends() -> None:
    flown = Flown()
    flown.answer(MavResult.IN_PROGRESS, 10.1)
    flown.answer(MavResult.IN_PROGRESS, 11.0)
    flown.payload.on_timer(11.1 + 0.5 * ANSWER_WITHIN)
    assert flown.said == []
    flown.answer(MavResult.ACCEPTED, 11.9)
    flown.payload.finish()
    assert flown.said == ["payload: 1 commands sent, 1 accepted by the vehicle"]


def test_a_command_that_is_begun_may_fail_or_never_end() -> None:
    failed, silent = Flown(), Flown()
    for flown in (failed, silent):
        flown.answer(MavResult.IN_PROGRESS, 10.1)
    failed.answer(MavResult.FAILED, 10.2)
    silent.payload.on_timer(10.1 + ANSWER_WITHIN)
    assert "failed" in failed.said[0].lower()
    assert "no answer" in silent.said[0]
