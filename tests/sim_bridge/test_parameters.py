"""The parameter protocol: PX4's types, answers, errors and order; what a parameter does."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import pytest

from sim_bridge.autopilot.parameters import VOLATILE, defaults, table
from tests.support.plant_client import NAN, Client

INT32, REAL32, UINT32 = 6, 9, 5
DOES_NOT_EXIST, READ_ONLY, TYPE_UNSUPPORTED, TYPE_MISMATCH = 1, 5, 6, 7


def bits(number: int) -> float:
    """An integer as PX4 sends it: its bytes in a float."""
    (value,) = struct.unpack("<f", struct.pack("<i", number))
    return float(value)


def integer(fields: dict[str, Any]) -> int:
    (value,) = struct.unpack("<i", struct.pack("<f", fields["param_value"]))
    return int(value)


def parameters(client: Client, since: int = 0) -> list[tuple[str, dict[str, Any]]]:
    """What was said about parameters on the first link."""
    return [(h.name, h.fields) for h in client.heard[since:] if h.name.startswith("PARAM_") and h.endpoint == 0]


def read(client: Client, name: str = "", index: int = -1, **target: int) -> list[tuple[str, dict[str, Any]]]:
    before = len(client.heard)
    client.send("PARAM_REQUEST_READ", param_id=name, param_index=index, **target)
    return parameters(client, before)


def set_(client: Client, name: str, value: float, kind: int) -> list[tuple[str, dict[str, Any]]]:
    before = len(client.heard)
    client.send("PARAM_SET", param_id=name, param_value=value, param_type=kind)
    return parameters(client, before)


def test_the_table_is_believable() -> None:
    rows = table()
    assert len(rows) > 800
    assert list(rows) == sorted(rows)
    assert all(len(name) <= 16 for name in rows)
    assert rows["COM_OBL_RC_ACT"] == 0 and isinstance(rows["COM_OBL_RC_ACT"], int)
    assert rows["COM_OF_LOSS_T"] == 1.0 and isinstance(rows["COM_OF_LOSS_T"], float)


def test_read_by_name_and_index_at_once() -> None:
    client = Client("sih")
    ((name, value),) = read(client, "COM_OF_LOSS_T")
    assert name == "PARAM_VALUE"
    assert (value["param_id"], value["param_value"], value["param_type"]) == ("COM_OF_LOSS_T", 1.0, REAL32)
    assert value["param_count"] == len(table())
    ((_, again),) = read(client, index=value["param_index"])
    assert again == value
    ((_, value),) = read(client, "SYS_AUTOSTART", target_component=0)
    assert (integer(value), value["param_type"]) == (10040, INT32)


def test_who_is_not_named_is_not_asked() -> None:
    client = Client("sih")
    assert read(client, "COM_OF_LOSS_T", target_system=0) == []
    assert read(client, "COM_OF_LOSS_T", target_system=2) == []
    assert read(client, "COM_OF_LOSS_T", target_component=191) == []


def test_errors() -> None:
    client = Client("sih")
    for answer, error, name in (
        (read(client, "NO_SUCH_THING"), DOES_NOT_EXIST, "NO_SUCH_THING"),
        (read(client, index=5000), DOES_NOT_EXIST, ""),
        (set_(client, "NO_SUCH_THING", 1.0, REAL32), DOES_NOT_EXIST, "NO_SUCH_THING"),
        (set_(client, "COM_OBL_RC_ACT", 3.0, REAL32), TYPE_MISMATCH, "COM_OBL_RC_ACT"),
        (set_(client, "COM_OF_LOSS_T", bits(1), INT32), TYPE_MISMATCH, "COM_OF_LOSS_T"),
        (set_(client, "COM_OBL_RC_ACT", bits(1), UINT32), TYPE_UNSUPPORTED, "COM_OBL_RC_ACT"),
        (set_(client, "_HASH_CHECK", 0.0, REAL32), READ_ONLY, "_HASH_CHECK"),
    ):
        ((kind, fields),) = answer
        assert (kind, fields["error"], fields["param_id"]) == ("PARAM_ERROR", error, name)
        assert (fields["target_system"], fields["target_component"]) == (1, 191)
    assert client.bridge.autopilot.parameters == defaults() | client.bridge.autopilot.parameters.defaults


def test_a_set_is_answered_at_once_and_told_again_on_all_links() -> None:
    client = Client("sih")
    client.run(0.1)
    ((kind, fields),) = set_(client, "COM_OBL_RC_ACT", bits(5), INT32)
    assert (kind, integer(fields)) == ("PARAM_VALUE", 5)
    assert client.bridge.autopilot.parameters["COM_OBL_RC_ACT"] == 5
    before = len(client.heard)
    client.run(0.05)
    again = [(h.endpoint, integer(h.fields)) for h in client.heard[before:] if h.name == "PARAM_VALUE"]
    assert again == [(0, 5), (1, 5)]
    before = len(client.heard)
    assert len(set_(client, "COM_OBL_RC_ACT", bits(5), INT32)) == 1
    client.run(0.05)  # nothing has changed: nothing to tell
    assert len(parameters(client, before)) == 1


@pytest.mark.parametrize("value", [99.0, -3.0, NAN, float("inf")])
def test_any_value_of_the_right_type_is_taken(value: float) -> None:
    client = Client("sih")
    ((kind, fields),) = set_(client, "COM_OF_LOSS_T", value, REAL32)
    assert kind == "PARAM_VALUE"
    assert fields["param_value"] == pytest.approx(value, nan_ok=True)
    client.run(1.0)


def test_integers_keep_every_bit() -> None:
    client = Client("sih")
    for number in (-1, 0x7F800001, -(2**31), 2**31 - 1):
        raw = struct.pack("<i", number)
        client.bridge.autopilot.parameters.unpack("COM_OBL_RC_ACT", raw)
        assert client.bridge.autopilot.parameters.packed("COM_OBL_RC_ACT") == raw


def test_the_list_is_complete_in_order_and_takes_a_second() -> None:
    client = Client("sih")
    client.send("PARAM_REQUEST_LIST")
    client.run(1.5)
    values = client.all("PARAM_VALUE")
    assert (values[0]["param_id"], values[0]["param_type"], values[0]["param_index"]) == ("_HASH_CHECK", UINT32, 65535)
    assert [value["param_id"] for value in values[1:]] == list(table())
    assert [value["param_index"] for value in values[1:]] == list(range(len(table())))
    times = [h.at for h in client.heard if h.name == "PARAM_VALUE"]
    assert 0.8 < times[-1] - times[0] < 1.1
    assert not client.all("PARAM_VALUE", 1)


def test_the_hash_is_that_of_names_and_values() -> None:
    client = Client("sih")
    parameters = client.bridge.autopilot.parameters
    data = b"".join(name.encode() + parameters.packed(name) for name in table() if name not in VOLATILE)
    ((_, fields),) = read(client, "_HASH_CHECK")
    assert fields["param_index"] == 65535
    crc = zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF  # PX4 leaves out both inversions
    assert struct.pack("<f", fields["param_value"]) == struct.pack("<I", crc)
    parameters["COM_OF_LOSS_T"] = 0.5
    assert read(client, "_HASH_CHECK")[0][1]["param_value"] != fields["param_value"]


def test_a_list_ends_when_somebody_knows_the_hash_and_starts_over_when_asked_twice() -> None:
    client = Client("sih")
    client.send("PARAM_REQUEST_LIST")
    client.run(0.1)
    set_(client, "_HASH_CHECK", 0.0, UINT32)
    before = len(client.all("PARAM_VALUE"))
    client.run(0.5)
    assert len(client.all("PARAM_VALUE")) == before
    client.heard.clear()
    client.send("PARAM_REQUEST_LIST")
    client.run(0.1)
    client.send("PARAM_REQUEST_LIST")
    client.run(1.5)
    names = [value["param_id"] for value in client.all("PARAM_VALUE")]
    assert names.count("_HASH_CHECK") == 1
    assert names.count("ASPD_SCALE_1") == 2
    assert names[-1] == list(table())[-1]


def test_parameters_describe_the_vehicle() -> None:
    parameters = Client("sih").bridge.autopilot.parameters
    assert parameters["SIH_MASS"] == 1.0
    assert parameters["MPC_THR_HOVER"] == 0.5
    assert (parameters["CA_ROTOR0_PX"], parameters["CA_ROTOR2_KM"]) == (1.0, -0.05)
    assert Client("x500").bridge.autopilot.parameters["SIH_MASS"] == 2.0


def test_a_reset_brings_the_defaults_back() -> None:
    client = Client("sih", landed=True)
    set_(client, "COM_OF_LOSS_T", 5.0, REAL32)
    assert client.command(245, 2) == 0
    assert client.bridge.autopilot.parameters["COM_OF_LOSS_T"] == 1.0
    assert client.command(245, 9) is None
