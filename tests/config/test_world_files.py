"""World files: the shipped ones, every key, every fault with its line."""

from __future__ import annotations

import math

import pytest
from pydantic import BaseModel

from companion.config.syntax.document import parse
from companion.config.syntax.faults import ConfigError
from companion.config.syntax.file_lookup import names
from companion.config.syntax.schema import Strict
from companion.config.world import actor_keys, event_keys, keys, link_event_keys
from companion.config.world.world import load_world, world_from
from companion.world import Battery, Deviations, Errors, Home, Link, Way, World, events
from companion.world.air import DrydenGusts, Gusts
from companion.world.estimate import Drift, Noise
from companion.world.events import After, Part, When
from companion.world.machine import RotorDynamics
from companion.world.words import event_in_words, event_kind

EVERYTHING = """\
name: gale
wind_mps: [5, -3.5, 0]
home: {latitude_deg: 52, longitude_deg: 13.4, altitude_m: 34}
link:
  down: {delay_s: 0.02, jitter_s: 0.01, loss: 0.1, duplicated: 0.02, reordered: 0.03, duplicate_delay_s: 0.004}
  up: {delay_s: 0.01}
truth:
  mass_kg: 2.2
  inertia_kgm2: [0.02, 0.03, 0.04]
  motor_lag_s: 0.03
  drag_per_s: 0.3
  rotor_drag_per_s: 0.2
  quadratic_drag_per_m: 0.02
  thrust_scale: 0.9
  angular_drag_nms: 0.01
gusts: {sigma_mps: [1, 2, 0.5], length_m: 10}
battery: {capacity_mah: 5000, resistance_ohm: 0.02, full_current_a: 60, idle_current_a: 1, charge: 0.5, full_v: 25, empty_v: 20}
estimate:
  position: {white_m: 0.005, wander_m: [0.03, 0.03, 0.05], wander_s: 3}
  velocity: {white_mps: 0.01, wander_mps: 0.03}
  attitude: {white_deg: 0.06, wander_deg: 0.3, wander_s: 2}
  gyro: {white_dps: 0.6, wander_dps: 0.1, wander_s: 20, smooth: true}
  drift: {speed_mps: 0.025, time_s: 1.5}
events:
  - {kind: push, force_n: [5, 0, -1], from_s: 20, to_s: 22, after: offboard}
  - {kind: hold, from_s: 30, to_s: 34}
  - {kind: wind, wind_mps: [0, 9, 0], from_s: 40}
  - {kind: motor_failure, motor: 3, thrust_left: 0.2, from_s: 50}
  - {kind: estimator_reset, at_s: 12, position_m: [0.5, 0, 0], velocity_mps: [0, 0, 0.1], yaw_deg: 180}
  - {kind: clock_jump, at_s: 13, by_s: -5}
  - {kind: nan_state, from_s: 14, to_s: 14.1, part: position}
  - {kind: silence, from_s: 15, to_s: 16, part: attitude}
  - {kind: link_cut, from_s: 17, to_s: 18, way: up, after: offboard}
  - {kind: link_cut, from_s: 18, messages: [HEARTBEAT, CURRENT_MODE]}
  - {kind: link_duplicate, from_s: 19, delay_s: 0.003, way: down}
  - {kind: link_repeat, from_s: 20, messages: [ODOMETRY]}
  - {kind: link_delay, from_s: 21, delay_s: 0.05, growth: 0.1, link: both}
  - {kind: link_thin, from_s: 22, rate_hz: 14}
  - {kind: link_recut, from_s: 23, size: 100, wait_s: 0.01}
  - {kind: motor_failure, from_s: 24, thrust_left: 0.9, after: armed}
  - {kind: estimator_reset, at_s: 25, position_m: [20, 0, 0], counted: false}
  - {kind: nan_state, from_s: 26, value: huge}
  - {kind: frozen_state, from_s: 27, part: attitude, noise: 1e-6}
  - {kind: offset_state, from_s: 28, position_m: [0, 20, 0], velocity_mps: [0, 0, 1], yaw_deg: 90}
  - {kind: wrong_stamps, from_s: 29, stamps: milliseconds}
  - {kind: odometry_frames, from_s: 30, pose: 4, velocity: 12}
  - {kind: impostor, from_s: 31, type: rover, autopilot: ardupilot}
  - {kind: operator, at_s: 0.06, order: disarm, after: armed}
  - {kind: sticks, from_s: 32, to_s: 33, roll: 0.5, throttle: -1}
  - {kind: stranger, from_s: 34, system: 2, component: 191, type: onboard_controller, autopilot: none, says: [heartbeat, state],
     mode: land, armed: false, position_m: [50, 0, -1], port: vehicle}
  - {kind: port_change, at_s: 35}
  - {kind: payload_drop, at_s: 36, mass_kg: 0.5}
"""


def faults_of(text: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        world_from(parse(text, "gale.yaml"))
    return [str(fault) for fault in caught.value.faults]


def test_the_shipped_worlds() -> None:
    assert load_world("ideal") == World()
    assert {"ideal", "sih", "outdoor", "storm", "lab"} <= set(names("worlds"))
    assert {name: load_world(name).name for name in names("worlds")} == {name: name for name in names("worlds")}
    assert load_world("sih").link == Link(up=Way(0.004))
    assert load_world("sih").truth == Deviations(angular_drag=0.025)
    assert math.hypot(*load_world("outdoor").wind_n) == pytest.approx(5.0)
    assert load_world("outdoor").estimate.position.wander == (0.03, 0.03, 0.03)


def test_every_key_arrives() -> None:
    degree = math.radians(1.0)
    assert world_from(parse(EVERYTHING, "gale.yaml")) == World(
        name="gale",
        wind_n=(5.0, -3.5, 0.0),
        gusts=Gusts((1.0, 2.0, 0.5), (10.0, 10.0, 10.0)),
        home=Home(52.0, 13.4, 34.0),
        link=Link(Way(0.02, 0.01, 0.1, 0.02, 0.03, 0.004), Way(0.01)),
        truth=Deviations(2.2, (0.02, 0.03, 0.04), 0.03, 0.3, 0.9, 0.01, 0.2, 0.02),
        battery=Battery(18000.0, 0.02, 60.0, 1.0, 0.5, 25.0, 20.0),
        estimate=Errors(
            position=Noise((0.005,) * 3, (0.03, 0.03, 0.05), 3.0),
            velocity=Noise((0.01,) * 3, (0.03,) * 3),
            attitude=Noise((0.06 * degree,) * 3, (0.3 * degree,) * 3, 2.0),
            gyro=Noise((0.6 * degree,) * 3, (0.1 * degree,) * 3, 20.0, smooth=True),
            drift=Drift((0.025,) * 3, 1.5),
        ),
        events=(
            events.Push(When(20.0, 22.0, After.OFFBOARD), (5.0, 0.0, -1.0)),
            events.Hold(When(30.0, 34.0)),
            events.Wind(When(40.0), (0.0, 9.0, 0.0)),
            events.MotorFailure(When(50.0), 3, 0.2),
            events.EstimatorReset(When(12.0, 12.0), (0.5, 0.0, 0.0), (0.0, 0.0, 0.1), math.pi),
            events.ClockJump(When(13.0, 13.0), -5.0),
            events.NotANumber(When(14.0, 14.1), Part.POSITION),
            events.Silence(When(15.0, 16.0), Part.ATTITUDE),
            events.LinkCut(When(17.0, 18.0, After.OFFBOARD), down=False, up=True),
            events.LinkCut(When(18.0), messages=frozenset({"HEARTBEAT", "CURRENT_MODE"})),
            events.LinkDuplicate(When(19.0), up=False, delay=0.003),
            events.LinkRepeat(When(20.0), messages=frozenset({"ODOMETRY"})),
            events.LinkDelay(When(21.0), ground_station=True, delay=0.05, growth=0.1),
            events.LinkThin(When(22.0), rate=14.0),
            events.LinkRecut(When(23.0), size=100, wait=0.01),
            events.MotorFailure(When(24.0, after=After.ARMED), None, 0.9),
            events.EstimatorReset(When(25.0, 25.0), (20.0, 0.0, 0.0), counted=False),
            events.NotANumber(When(26.0), Part.STATE, 3e38),
            events.FrozenState(When(27.0), Part.ATTITUDE, 1e-6),
            events.OffsetState(When(28.0), (0.0, 20.0, 0.0), (0.0, 0.0, 1.0), 0.5 * math.pi),
            events.WrongStamps(When(29.0), events.Stamps.MILLISECONDS),
            events.OdometryFrames(When(30.0), 4, 12),
            events.Impostor(When(31.0), 10, 3),
            events.Operator(When(0.06, 0.06, After.ARMED), events.Order.DISARM),
            events.Sticks(When(32.0, 33.0), roll=0.5, throttle=-1.0),
            events.Stranger(
                When(34.0),
                2,
                191,
                18,
                8,
                frozenset({events.Saying.HEARTBEAT, events.Saying.STATE}),
                events.Order.LAND,
                armed=False,
                position_n=(50.0, 0.0, -1.0),
                own_port=False,
            ),
            events.PortChange(When(35.0, 35.0)),
            events.PayloadDrop(When(36.0, 36.0), 0.5),
        ),
    )


def test_the_other_ways_to_say_it() -> None:
    world = world_from(
        parse("name: a\ngusts: {wind_at_6m_mps: 15}\ntruth: {rotors: {inertia_kgm2: 1e-5, thrust_factor: 8e-6}}", "a")
    )
    assert world.gusts == DrydenGusts(15.0)
    assert world.truth.rotors == RotorDynamics(1e-5, 8e-6)


def test_all_faults_at_once_each_with_its_line() -> None:
    text = EVERYTHING.replace("-3.5", "calm").replace("{delay_s: 0.01}", "{delay_s: -1, jiter_s: 0.01}")
    assert faults_of(text.replace("[0.02, 0.03, 0.04]", "[1, 1, 9]").replace("latitude_deg: 52, ", "")) == [
        "gale.yaml:2: wind_mps[1]: 'calm' is not a number; expected a number: "
        "the mean velocity of the air over the ground [north, east, down], in m/s",
        "gale.yaml:3: home.latitude_deg: missing; expected the latitude, in degrees",
        "gale.yaml:6: link.up.delay_s: -1 is too small; expected at least 0: the delay, in s",
        "gale.yaml:6: link.up.jiter_s: unknown key; did you mean jitter_s?",
        "gale.yaml:9: truth.inertia_kgm2: [1.0, 1.0, 9.0] is no rigid body's; "
        "expected each moment to be at most the sum of the others",
    ]


@pytest.mark.parametrize(
    ("good", "bad", "said"),
    [
        ("motor: 3", "motor: 5", "28: events[3].motor: 5 is too large; expected at most 4: which motor in"),
        ("from_s: 30, to_s: 34", "from_s: 34, to_s: 30", "26: events[1]: ends at 30 s but begins at 34 s; expected"),
        ("kind: hold", "kind: hug", "26: events[1].kind: 'hug' is not known; expected 'push', 'hold', 'wind', "),
        ("kind: hold, ", "", "26: events[1].kind: missing; expected what happens at a time (kind push, hold, "),
        (
            "after: offboard}\n  - {kind: hold",
            "after: lunch}\n  - {kind: hold",
            "25: events[0].after: 'lunch' is not kn",
        ),
        (
            "mass_kg: 0.5",
            "mass_kg: 0",
            "53: events[27].mass_kg: 0 is too small; expected more than 0: how much lighter",
        ),
        ("way: up", "way: left", "33: events[8].way: 'left' is not known; expected 'both', 'down' or 'up'"),
        (
            "[ODOMETRY]",
            "[ODOMETER]",
            "36: events[11].messages: 'ODOMETER' is no message of the common dialect; did you m",
        ),
        (
            "size: 100",
            "messages: [PING]",
            "39: events[14].messages: cannot be given: bytes are cut anew whatever",
        ),
        (
            "order: disarm",
            "order: fly",
            "48: events[23].order: 'fly' is not known; expected 'hold', 'land', 'return', ",
        ),
        ("at_s: 12, ", "", "29: events[4].at_s: missing; expected when, in s"),
        ("length_m: 10", "length_m: 0", "16: gusts.length_m: [0.0, 0.0, 0.0] is too short; expected at least 0.1 m"),
        (", length_m: 10", "", "16: gusts: expected sigma_mps and length_m, or wind_at_6m_mps alone"),
        ("empty_v: 20", "empty_v: 30", "17: battery: is empty at 30 V and full at 25 V; expected empty below full"),
        ("white_m: 0.005", "white_m: wrong", "19: estimate.position.white_m: 'wrong' is not a list; expected"),
        ("white_m: 0.005", "white_m: -1", "19: estimate.position.white_m: -1 is too small; expected at least 0"),
    ],
)
def test_a_fault_in_what_happens_or_errs(good: str, bad: str, said: str) -> None:
    assert good in EVERYTHING
    faults = faults_of(EVERYTHING.replace(good, bad, 1))
    assert faults[0].startswith(f"gale.yaml:{said}"), faults
    assert all(fault.startswith(f"gale.yaml:{said[:3]}") for fault in faults)


def test_unknown_worlds_are_named_with_the_known() -> None:
    with pytest.raises(
        ConfigError,
        match=r"mars(:1)?: no world of this name; (did you mean .*)?expected a path, or one of ([a-z]+, )*ideal, ",
    ):
        load_world("mars")


def models() -> list[type[BaseModel]]:
    modules = (event_keys, link_event_keys, actor_keys, keys)
    found = {each for module in modules for each in vars(module).values() if isinstance(each, type)}
    return sorted((m for m in found if issubclass(m, Strict) and m is not Strict), key=lambda m: m.__name__)


@pytest.mark.parametrize("model", models())
def test_every_key_says_what_it_is(model: type[BaseModel]) -> None:
    assert all(field.description for field in model.model_fields.values())


def test_every_event_has_a_kind_as_files_spell_it_and_words() -> None:
    world = world_from(parse(EVERYTHING, "gale.yaml"))
    kinds = [line.split("kind: ")[1].split(",")[0] for line in EVERYTHING.splitlines() if "kind: " in line]
    assert [event_kind(event) for event in world.events] == kinds
    words = [event_in_words(event) for event in world.events]
    assert "the operator asks for disarm" in words
    assert "link cut both ways, CURRENT_MODE, HEARTBEAT" in words
    assert "every motor gives 90 % of its thrust" in words
    assert "a payload of 0.5 kg falls off" in words
