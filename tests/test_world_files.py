"""World files: the shipped ones, every key, every fault with its line."""

from __future__ import annotations

import pytest

from companion.config.document import parse
from companion.config.faults import ConfigError
from companion.config.places import names
from companion.config.world import LinkModel, TruthModel, WorldModel, load_world, world_from
from companion.world import Deviations, Home, Link, World

EVERYTHING = """\
name: gale
wind_mps: [5, -3.5, 0]
home: {latitude_deg: 52, longitude_deg: 13.4, altitude_m: 34}
link:
  delay_down_s: 0.02
  delay_up_s: 0.01
truth:
  mass_kg: 2.2
  inertia_kgm2: [0.02, 0.03, 0.04]
  motor_lag_s: 0.03
  drag_per_s: 0.3
  thrust_scale: 0.9
  angular_drag_nms: 0.01
"""


def faults_of(text: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        world_from(parse(text, "gale.yaml"))
    return [str(fault) for fault in caught.value.faults]


def test_the_shipped_worlds() -> None:
    assert load_world("ideal") == World()
    assert load_world("sih") == World("sih", link=Link(0.0, 0.004), truth=Deviations(angular_drag=0.025))
    assert {name: load_world(name).name for name in names("worlds")} == {name: name for name in names("worlds")}


def test_every_key_arrives() -> None:
    assert world_from(parse(EVERYTHING, "gale.yaml")) == World(
        name="gale",
        wind_n=(5.0, -3.5, 0.0),
        home=Home(52.0, 13.4, 34.0),
        link=Link(0.02, 0.01),
        truth=Deviations(2.2, (0.02, 0.03, 0.04), 0.03, 0.3, 0.9, 0.01),
    )


def test_all_faults_at_once_each_with_its_line() -> None:
    text = EVERYTHING.replace("-3.5", "calm").replace("0.02\n  delay_up_s: 0.01", "-1\n  delay_upp_s: 0.01")
    assert faults_of(text.replace("[0.02, 0.03, 0.04]", "[1, 1, 9]").replace("latitude_deg: 52, ", "")) == [
        "gale.yaml:2: wind_mps[1]: 'calm' is not a number; expected a number: "
        "the velocity of the air over the ground [north, east, down], in m/s",
        "gale.yaml:3: home.latitude_deg: missing; expected the latitude, in degrees",
        "gale.yaml:5: link.delay_down_s: -1 is too small; expected at least 0: "
        "the delay from vehicle to companion, in s",
        "gale.yaml:6: link.delay_upp_s: unknown key; did you mean delay_up_s?",
        "gale.yaml:9: truth.inertia_kgm2: [1.0, 1.0, 9.0] is no rigid body's; "
        "expected each moment to be at most the sum of the others",
    ]


def test_unknown_worlds_are_named_with_the_known() -> None:
    with pytest.raises(ConfigError, match=r"mars(:1)?: no world of this name; expected a path, or one of ideal, "):
        load_world("mars")


@pytest.mark.parametrize("model", [WorldModel, LinkModel, TruthModel])
def test_every_key_says_what_it_is(model: type[WorldModel]) -> None:
    assert all(field.description for field in model.model_fields.values())
