"""What is looked at before a flight, and the real thing over UDP with MAVSDK."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from companion.cli.preflight import verdict
from companion.config.plan.qgroundcontrol import plan_from
from companion.config.vehicle import load_vehicle
from companion.fence import Circle, Fence, Polygon
from companion.geodesy import LocalFrame
from companion.services.audit import RULES, Weight, audit_parameters
from companion.services.plan_check import differences
from companion.services.vehicle import fence_items
from sim_bridge.autopilot.parameters import defaults

pytestmark = pytest.mark.xdist_group("real time")


def weights(**changes: float) -> dict[str, Weight]:
    return {finding.parameter: finding.weight for finding in audit_parameters({**defaults(), **changes})}


def test_px4s_defaults_are_no_danger_and_the_slow_failsafe_is_told() -> None:
    found = weights()
    assert Weight.DANGER not in found.values()
    assert found["COM_OF_LOSS_T"] is Weight.ADVICE
    assert set(found) == {rule.parameter for rule in RULES} - {"COM_RC_OVERRIDE"}
    assert all(rule.parameter in defaults() or rule.elsewhere in defaults() for rule in RULES)


def test_what_cuts_the_motors_is_a_danger() -> None:
    assert weights(COM_OBL_RC_ACT=7)["COM_OBL_RC_ACT"] is Weight.DANGER
    # Position and Altitude want sticks
    assert [weights(COM_OBL_RC_ACT=value)["COM_OBL_RC_ACT"] for value in (0, 1)] == [Weight.ADVICE] * 2
    assert [weights(COM_OBL_RC_ACT=value)["COM_OBL_RC_ACT"] for value in (3, 4, 5)] == [Weight.FINE] * 3
    assert weights(NAV_RCL_ACT=6)["NAV_RCL_ACT"] is Weight.DANGER
    assert weights(COM_OF_LOSS_T=0.3)["COM_OF_LOSS_T"] is Weight.FINE
    assert weights(GF_MAX_HOR_DIST=5.0)["GF_MAX_HOR_DIST"] is Weight.ADVICE


def test_sticks_take_over_in_offboard_by_either_parameter() -> None:
    """Up to 1.17 COM_RC_OVERRIDE, from 1.18 on MAN_OVERRIDE_SPD, which acts in offboard too."""
    assert weights()["MAN_OVERRIDE_SPD"] is Weight.FINE
    assert weights(MAN_OVERRIDE_SPD=-1.0)["MAN_OVERRIDE_SPD"] is Weight.ADVICE
    older = {name: value for name, value in defaults().items() if name != "MAN_OVERRIDE_SPD"}
    for value, weight in ((1, Weight.ADVICE), (3, Weight.FINE)):
        found = {finding.parameter: finding for finding in audit_parameters({**older, "COM_RC_OVERRIDE": value})}
        assert "MAN_OVERRIDE_SPD" not in found and found["COM_RC_OVERRIDE"].weight is weight
    assert found["COM_RC_OVERRIDE"].said == "3 (in auto modes and offboard)"
    without = [finding.parameter for finding in audit_parameters({}) if "OVERRIDE" in finding.parameter]
    assert without == ["COM_RC_OVERRIDE", "MAN_OVERRIDE_SPD"]


def test_lost_sticks_that_only_hold_are_no_danger() -> None:
    finding = next(f for f in audit_parameters({**defaults(), "NAV_RCL_ACT": 7}) if f.parameter == "NAV_RCL_ACT")
    assert finding.weight is Weight.FINE and finding.said == "7 (Hold, without a failsafe)"


def test_a_firmware_that_lacks_one_says_so() -> None:
    finding = next(f for f in audit_parameters({}) if f.parameter == "COM_OF_LOSS_T")
    assert finding.now is None
    assert "does not have it" in finding.why


def test_numbers_have_their_names_and_units() -> None:
    said = {
        finding.parameter: finding.said
        for finding in audit_parameters({**defaults(), "NAV_RCL_ACT": 2, "GF_ACTION": 99})
    }
    assert said["NAV_RCL_ACT"] == "2 (Return)" and said["COM_OF_LOSS_T"] == "1 s"
    assert said["GF_ACTION"] == "99 (not known to us)" and said["MPC_THR_HOVER"] == "0.5"
    assert next(f.said for f in audit_parameters({}) if f.parameter == "NAV_RCL_ACT") == "-"


def test_it_ends_with_a_verdict() -> None:
    fine = [finding._replace(weight=Weight.FINE) for finding in audit_parameters(defaults())]
    assert verdict(fine, 50.0).startswith("Ready to fly")
    advised = [fine[0]._replace(weight=Weight.ADVICE), *fine[1:]]
    assert verdict(advised, 50.0) == f"Can be flown. Better first: {fine[0].parameter}."
    cut = audit_parameters({**defaults(), "NAV_RCL_ACT": 6})
    assert verdict(cut, 50.0) == "Do not fly: NAV_RCL_ACT is 6 (Disarm)."
    assert verdict(fine, 5.0) == "Do not fly: only 5 states a second arrive."


def test_a_fence_as_px4_holds_it() -> None:
    fence = Fence((Polygon(((0.0, 0.0), (10.0, 0.0), (0.0, 10.0))), Circle((5.0, 5.0), 3.0, inside=False)))
    items = fence_items(fence, LocalFrame(47.397742, 8.545594, 489.4))
    assert [(item.command, item.param1, item.seq) for item in items] == [
        (5001, 3.0, 0), (5001, 3.0, 1), (5001, 3.0, 2), (5004, 3.0, 3),
    ]  # fmt: skip
    assert items[0].x == 473977420


def companion(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "companion", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


@pytest.fixture
def port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        number: int = free.getsockname()[1]
    return number


def test_a_vehicle_is_looked_at_and_the_curve_uploaded(port: int) -> None:
    plant = subprocess.Popen(
        [sys.executable, "-m", "sim_bridge", "--vehicle", "x500", "--ground-station", "none",
         "--connect", f"udpout://127.0.0.1:{port}"],
        stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        done = companion("preflight", "survey", "--connect", f"udpin://127.0.0.1:{port}", "--upload", "--json")
    finally:
        plant.terminate()
        plant.wait(20.0)
    document = json.loads(done.stdout)
    assert document["schema"] == "companion.preflight/1"
    assert {row["parameter"]: row["now"] for row in document["parameters"]}["COM_OF_LOSS_T"] == 1.0
    assert document["state_rate_hz"] > 20.0
    assert document["path"][-1] == "uploaded: the curve as 60 waypoints, and a fence of 1 area"
    assert any(line.startswith("plan: MAVSDK reads the same ") for line in document["path"])
    assert (done.returncode, document["ok"]) == (0, True)


def test_a_vehicle_file_is_made_of_what_a_vehicle_knows(port: int, tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    plant = subprocess.Popen(
        [sys.executable, "-m", "sim_bridge", "--vehicle", "x500", "--ground-station", "none",
         "--connect", f"udpout://127.0.0.1:{port}"],
        stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        done = companion("vehicle", "from", str(file), "--connect", f"udpin://127.0.0.1:{port}", "--mass", "2.1")
        again = companion("vehicle", "from", str(file), "--connect", f"udpin://127.0.0.1:{port}")
    finally:
        plant.terminate()
        plant.wait(20.0)
    assert done.returncode == 0, done.stderr
    assert load_vehicle(str(file)).mass == 2.1
    made = file.read_text()
    assert "# Made by companion vehicle from on 20" in made and ", git " in made
    assert ", uid " not in made  # which a simulation does not have
    assert again.returncode == 2 and "exists already" in again.stderr


def test_no_vehicle_and_bad_addresses(port: int, tmp_path: Path) -> None:
    done = companion("preflight", "--connect", "udpin:/127.0.0.1")
    assert done.returncode == 2
    assert "expected udpin://HOST:PORT" in done.stderr
    done = companion("fly", "circle_r5", "--connect", f"serial://{tmp_path}/missing:57600")
    assert done.returncode == 2
    done = companion("fly", "circle_r5", "--connect", "serial:///dev/ttyMISSING:57600")
    assert done.returncode == 2
    assert "cannot be opened: No such file or directory; is it plugged in?" in done.stderr
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as busy:
        busy.bind(("127.0.0.1", port))
        done = companion("fly", "circle_r5", "--connect", f"udpin://127.0.0.1:{port}")
    assert done.returncode == 2
    assert "in use" in done.stderr
    assert not done.stdout


def test_a_plan_that_mavsdk_reads_otherwise_is_told() -> None:
    text = Path(__file__).parents[2].joinpath("configs/missions/survey.plan").read_text()
    plan = plan_from(text, "survey.plan")[0]
    theirs = SimpleNamespace(mission_items=[], geofence_items=[])
    assert differences(plan, text, theirs)[0] == f"plan: we read {len(plan.items)} items, MAVSDK 0"
