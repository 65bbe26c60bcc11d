"""What a ground station sees of the companion, and the factor on the speed it may set in flight."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.daemon.ground import GroundSide
from companion.flight.conduct import Conduct, ControlAuthority
from companion.flight.phases import Phase
from companion.law.gains import Level
from companion.law.speed_scale import SpeedScale
from companion.mavlink.announcing import SAME_AGAIN, TEXT_PERIOD, WAITING_MAX, Announcer
from companion.mavlink.codec import Decoder, Encoder, Frame
from companion.mavlink.dialect import Format, Value, message
from companion.mavlink.own_parameters import Own, OwnParameters
from companion.mavlink.upload import Place, Upload
from companion.pilot import Outcome, begin, completed
from companion.plan import Plan, prepared
from companion.record.replay import load_flight, replay
from companion.vehicle import OutputLevel
from sim_bridge.world_events import GROUND_STATION
from tests.support.flights import Flown, Operator, flight

ME = (1, 191)


class Said:
    """Collects what is sent."""

    def __init__(self) -> None:
        self.sent: list[tuple[Format, tuple[Value, ...]]] = []

    def __call__(self, fmt: Format, values: tuple[Value, ...]) -> None:
        fmt.pack(*values)  # it fits
        self.sent.append((fmt, values))

    def named(self) -> list[dict[str, Value]]:
        return [fmt.named(values) for fmt, values in self.sent]


def frame(name: str, **fields: Value) -> Frame:
    (decoded,) = Decoder().datagram(Encoder(255, 190).message(message(name), **fields))
    return decoded


def test_words_are_few_and_whole() -> None:
    said = Said()
    announcer = Announcer(said)
    announcer.say("short", 0.0)
    announcer.say("short", 0.1)  # said just now
    announcer.say("x" * 70, 0.1)
    announcer.on_timer(0.1)
    announcer.on_timer(0.2)
    assert [values["text"] for values in said.named()] == ["short"]
    announcer.on_timer(0.1 + TEXT_PERIOD)
    assert [(values["text"], values["chunk_seq"]) for values in said.named()[1:]] == [("x" * 50, 0), ("x" * 20, 1)]
    assert len({values["id"] for values in said.named()[1:]}) == 1
    assert announcer.next_timer() == math.inf
    for i in range(50):
        announcer.say(f"line {i}", 10.0)
    now, before = 10.0, len(said.sent)
    while announcer.next_timer() < math.inf:
        now = max(now, announcer.next_timer())
        announcer.on_timer(now)
    assert len(said.sent) - before == WAITING_MAX
    announcer.say("short", now + SAME_AGAIN)
    announcer.on_timer(now + SAME_AGAIN)
    assert said.named()[-1]["text"] == "short"


def test_own_parameters_speak_the_protocol() -> None:
    said = Said()
    own = OwnParameters(said, 191, {"PF_SPEED_SCALE": Own(1.0, 0.0, 1.3)})
    own.receive(frame("PARAM_REQUEST_LIST", target_system=1, target_component=0), 1)
    own.receive(frame("PARAM_REQUEST_READ", target_system=1, target_component=191, param_index=0), 1)
    own.receive(
        frame("PARAM_REQUEST_READ", target_system=1, target_component=191, param_id="PF_SPEED_SCALE", param_index=-1), 1
    )  # fmt: skip
    assert len(said.sent) == 3
    assert all(values["param_value"] == 1.0 and values["param_count"] == 1 for values in said.named())
    for other in ({"target_system": 2}, {"target_component": 1}):
        own.receive(frame("PARAM_REQUEST_LIST", **{"target_system": 1, "target_component": 191, **other}), 1)
    assert len(said.sent) == 3
    wanted = {"target_system": 1, "target_component": 191, "param_id": "PF_SPEED_SCALE", "param_type": 9}
    assert own.receive(frame("PARAM_SET", param_value=0.5, **wanted), 1) == (
        "PF_SPEED_SCALE set to 0.5 by the ground station"
    )  # fmt: skip
    own.receive(frame("PARAM_SET", param_value=9.0, **wanted), 1)
    assert own.named["PF_SPEED_SCALE"].value == 1.3
    own.receive(frame("PARAM_SET", param_value=math.nan, **wanted), 1)
    own.receive(frame("PARAM_SET", param_value=1.0, **{**wanted, "param_id": "OTHER"}), 1)
    assert own.named["PF_SPEED_SCALE"].value == 1.3


def test_an_upload_survives_silence_and_says_what_came_of_it() -> None:
    said = Said()
    upload = Upload(said, [Place(47.0, 8.0, 500.0), Place(47.001, 8.0, 500.0)], 1)
    upload.on_timer(0.0)
    upload.on_timer(0.5)
    upload.on_timer(1.0)
    assert [values["count"] for values in said.named()] == [2, 2]
    upload.receive(frame("MISSION_REQUEST_INT", seq=1, target_system=1, target_component=191), 1.1)
    assert said.named()[-1]["x"] == 470010000
    upload.receive(frame("MISSION_REQUEST_INT", seq=7, target_system=1, target_component=191), 1.2)
    assert len(said.sent) == 3
    upload.receive(frame("MISSION_ACK", type=0), 1.3)
    assert upload.outcome is not None
    assert "2 waypoints accepted" in upload.outcome
    silent = Upload(said, [], 1)
    while silent.outcome is None:
        silent.on_timer(max(silent.next_timer(), 0.0))
    assert "no answer" in silent.outcome


def test_seen_and_slowed_from_the_ground() -> None:
    """A ground station reads words and errors, stops the vehicle on its path, and lets it go on faster."""
    heard: list[Frame] = []
    decoder = Decoder()
    speeds: list[tuple[float, float]] = []

    def station(flown: Flown, now: float) -> None:
        speeds.append((now, math.hypot(*flown.between.truth.v_n)))
        operator = Operator(flown.between.bridge)
        for at, scale in ((6.0, 0.0), (11.0, 1.2)):
            if math.isclose(now, at, abs_tol=1e-6):
                operator.says("PARAM_SET", target_system=1, target_component=191, param_id="PF_SPEED_SCALE",
                              param_value=scale, param_type=9)  # fmt: skip

    def overhear(flown: Flown) -> None:
        bridge = flown.between.bridge
        flown.between.bridge.receive(Encoder(255, 190).message(message("HEARTBEAT"), type=6, autopilot=8))
        datagrams = bridge.datagrams

        def listened() -> list[tuple[int, bytes]]:
            out = datagrams()
            for endpoint, data in out:
                if endpoint == GROUND_STATION:
                    heard.extend(decoder.datagram(data))
            return out

        bridge.datagrams = listened  # type: ignore[method-assign]

    flown = flight(
        level=OutputLevel.RATES, duration=17.0, conduct=Conduct(speed_scale_max=1.5), meddle=station, prepare=overhear,
    )  # fmt: skip
    memory = flown.conductor.memory
    assert memory is not None
    assert completed(memory), flown.notes
    assert max(speed for now, speed in speeds if 10.0 < now < 11.0) < 0.1
    assert all(abs(speed - 3.6) < 0.15 for now, speed in speeds if 15.5 < now < 16.5)
    assert max(error for now, error in flown.path_errors if now > 6.0) < 0.05
    ours = [f for f in heard if (f.system, f.component) == ME]
    texts = [f.format.named(f.values)["text"] for f in ours if f.format.name == "STATUSTEXT"]
    assert any("follow" in text for text in texts)
    numbers = [f.format.named(f.values) for f in ours if f.format.name == "NAMED_VALUE_FLOAT"]
    assert {values["name"] for values in numbers} == {"pf_path", "pf_speed", "pf_yaw"}
    assert 4.0 < len(numbers) / 3.0 / 17.0 < 6.0
    assert any(f.format.name == "HEARTBEAT" for f in ours)
    assert any(f.format.name == "PARAM_VALUE" for f in ours)


def test_gains_and_limits_are_set_where_nothing_flies_on_them_and_replayed(tmp_path: Path) -> None:
    """While the pilot flies they are taken, within their ranges; in the middle of the path they stay as they are."""
    wanted = {2.0: ("PF_POLE_PATH", 4.0), 2.1: ("PF_TUBE", 3.0), 2.2: ("PF_FLOOR", 99.0), 7.0: ("PF_POLE_PATH", 3.0),
              10.5: ("PF_POLE_YAW", 2.0)}  # fmt: skip
    modes = {3.0: (6, 0), 10.0: (4, 3), 11.0: (6, 0)}

    def operate(flown: Flown, now: float) -> None:
        operator = Operator(flown.between.bridge)
        for at, (name, value) in wanted.items():
            if math.isclose(now, at, abs_tol=1e-6):
                operator.says("PARAM_SET", target_system=1, target_component=191, param_id=name, param_value=value,
                              param_type=9)  # fmt: skip
        for at, mode in modes.items():
            if math.isclose(now, at, abs_tol=1e-6):
                operator.commands(176, 1.0, *mode)
        if math.isclose(now, 15.0, abs_tol=1e-6):
            flown.conductor.stop()

    flown = flight(
        level=OutputLevel.RATES, duration=None, conduct=Conduct(ControlAuthority.PILOT), meddle=operate,
        record=tmp_path / "flown", time_out=16.0,
    )  # fmt: skip
    plan = flown.conductor.plan
    assert plan is not None and plan.mission.gains is not None
    assert plan.mission.gains.h1 == pytest.approx((64.0, 48.0, 12.0)) and plan.mission.gains.h4 == pytest.approx((2.0,))
    limits = plan.conduct.limits
    assert limits.tube == 3.0 and limits.floor is not None and limits.floor < 10.0
    assert any(note.startswith("PF_POLE_PATH stays 4: it can be set only while") for note in flown.notes)
    assert any(error < 0.05 for now, error in flown.path_errors if 13.0 < now < 15.0)
    read = load_flight(tmp_path / "flown")
    assert [since for since, _ in read.plans[1:]] == pytest.approx([2.0, 2.1, 2.2, 10.5], abs=0.05)
    assert replay(read).difference is None


def test_what_is_told_as_set_is_set() -> None:
    """Also between the tick that begins to fly and the next one; and a limit that is set leaves the gains automatic."""
    notes: list[str] = []
    ground = GroundSide(Said(), notes.append, 1.3)
    plan = prepared(load_mission("circle_r5", Level.RATES), load_vehicle("x500"), OutputLevel.RATES, (0.0, 0.0, 0.0))
    ground.offer(plan)

    def after_a_tick_in(phase: Phase, name: str, value: float) -> Plan:
        quiet = Outcome(None, None, (), None, SpeedScale())
        ground.report(plan, begin(0.0)._replace(phase=phase), quiet, False, 0.0)
        wanted = {"param_id": name, "param_value": value, "param_type": 9}
        ground.receive(frame("PARAM_SET", target_system=1, target_component=191, **wanted), 1, 0.0, of_vehicle=False)
        return ground.apply_settings(plan, 0.0, None)

    assert plan.path_pole is not None
    assert after_a_tick_in(Phase.STAND_BY, "PF_TUBE", 3.0).path_pole == plan.path_pole
    assert after_a_tick_in(Phase.SETTLE, "PF_POLE_PATH", 3.0) is plan
    assert "PF_POLE_PATH stays 7: it can be set only while" in notes[-1]
    assert after_a_tick_in(Phase.STAND_BY, "PF_POLE_PATH", 3.0).path_pole is None
    assert ground.apply_settings(plan, 0.0, None) is plan


def test_the_curve_is_drawn_on_the_map() -> None:
    def draw(flown: Flown) -> None:
        orders = flown.conductor.orders
        flown.conductor.orders = orders.__class__(**{**orders.__dict__, "draw": True})

    flown = flight(duration=2.0, prepare=draw)
    assert "the curve on the ground station's map: 60 waypoints accepted" in flown.notes
