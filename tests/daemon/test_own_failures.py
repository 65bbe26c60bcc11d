"""What fails on our own side: the disk, the terminal, our own code. Nothing of it is silent, and none of it is the flight's."""

from __future__ import annotations

import contextlib
import errno
import itertools
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from companion import pilot
from companion.cli import terminal
from companion.cli.commands import app
from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.daemon.conductor import Conductor, Orders
from companion.daemon.last_resort import LastResort
from companion.daemon.loop import clock
from companion.daemon.rhythm import Rhythm
from companion.daemon.scribe import PERIOD, Helper, Scribe
from companion.law.gains import law_level
from companion.library import simulation as simulate
from companion.mavlink.codec import Decoder, Frame
from companion.mavlink_common import MAV_CMD_COMPONENT_ARM_DISARM, MAV_CMD_DO_SET_MODE, MAV_CMD_NAV_TAKEOFF
from companion.mission import Origin
from companion.record import growing
from companion.record.folder import Recorder
from companion.record.replay import load_flight, replay
from companion.record.table import read_table
from companion.record.tlog import records
from companion.vehicle import (
    AttitudeSetpoint,
    CompanionError,
    MotorSetpoint,
    OutputLevel,
    RateSetpoint,
    TorqueSetpoint,
)
from companion.xrce.agent import Agent
from companion.xrce.commands import Commands
from tests.support.flights import Flown, Operator, flight, once

pytestmark = pytest.mark.xdist_group("real time")
LEVEL = 82  # SET_ATTITUDE_TARGET
SET_MODE = MAV_CMD_DO_SET_MODE


def sim(folder: Path, *words: str) -> Result:
    return CliRunner().invoke(
        app, ["sim", "circle_r5", "--output", "rates", "--duration", "2", "--settle", "1", "--json", "--no-report",
              "--record", str(folder), *words],
    )  # fmt: skip


def orders(over_xrce: bool) -> Orders:
    level = OutputLevel.MOTORS
    mission, vehicle = load_mission("circle_r5", law_level(level)), load_vehicle("sih")
    return Orders(mission, vehicle, level, 5.0, Origin.LOCAL, over_xrce=over_xrce)


def fail_after(monkeypatch: pytest.MonkeyPatch, owner: Any, name: str, calls: int) -> None:
    """From so many calls on ``owner.name`` raises."""
    really: Callable[..., Any] = getattr(owner, name)
    count = [0]

    def failing(*given: Any, **more: Any) -> Any:
        count[0] += 1
        if count[0] > calls:
            raise ZeroDivisionError(f"{name} at \x1b[31mfault")
        return really(*given, **more)

    monkeypatch.setattr(owner, name, failing)


def sent(folder: Path) -> list[tuple[float, Frame]]:
    """What the companion sent, and when, from the log."""
    decoder = Decoder()
    data = (folder / "link.tlog").read_bytes()
    frames = [(at, frame) for at, raw in records(data) for frame in decoder.datagram(raw)]
    return [(at, frame) for at, frame in frames if frame.component == 191]


@pytest.mark.parametrize("udp", [False, True], ids=["lockstep", "real time"])
def test_a_pilot_that_fails_in_the_air(udp: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """HOLD is asked for, the vehicle is levelled for 0.3 s at most, the record is closed, one sentence, exit 1."""
    fail_after(monkeypatch, pilot, "compute_setpoint", 150)
    result = sim(tmp_path / "flight", *(["--udp"] if udp else []))
    assert result.exit_code == 1
    figures = json.loads(result.stdout)
    assert figures["outcome"] == "aborted"
    assert "the companion itself failed (ZeroDivisionError: compute_setpoint at " in figures["reason"]
    assert ": HOLD was asked for, and the vehicle is in Hold; " in figures["reason"]
    assert figures["phases"] and figures["loop"]["ticks"] > 10
    assert "Traceback" not in result.stderr and "\x1b" not in result.stderr
    assert "Traceback" in (tmp_path / "flight" / "failure.txt").read_text()
    assert replay(load_flight(tmp_path / "flight")).difference is None  # up to the tick that failed
    frames = sent(tmp_path / "flight")
    failed_at = min(
        at for at, f in frames if f.format.id == LEVEL and f.format.named(f.values)["body_roll_rate"] != 0.0
    )
    holds = [at for at, f in frames if f.format.name == "COMMAND_LONG"
             and f.format.named(f.values)["command"] == SET_MODE and f.format.named(f.values)["param3"] == 3.0]  # fmt: skip
    assert 1 <= len(holds) <= 3 and holds[-1] - holds[0] <= 1.5
    late = [at for at, f in frames if f.format.id == LEVEL and at > holds[0]]
    assert failed_at < holds[0] and late and late[-1] - holds[0] <= pilot.LEVEL_FOR + 0.02
    assert any(f.format.name == "PARAM_SET" for at, f in frames if at > holds[0]) == any(
        f.format.name == "PARAM_SET" for at, f in frames if at < holds[0]
    )  # what was set for the flight is set back


@pytest.mark.parametrize(
    ("owner", "name", "calls"),
    [(pilot, "supervise", 400), (Conductor, "receive", 500), (Conductor, "take_in", 500), (Conductor, "on_timer", 10),
     (Conductor, "finish_tick", 500), (Conductor, "datagrams", 2000), (Conductor, "_conclude", 1500)],
)  # fmt: skip
def test_whatever_fails_the_vehicle_is_handed_back(
    owner: Any, name: str, calls: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fail_after(monkeypatch, owner, name, calls)
    result = sim(tmp_path / "flight", "--duration", "6")
    assert result.exit_code == 1
    assert f"the companion itself failed (ZeroDivisionError: {name} at" in json.loads(result.stdout)["reason"]
    assert "Traceback" not in result.stderr
    assert "ZeroDivisionError" in (tmp_path / "flight" / "failure.txt").read_text()
    if name not in (
        "finish_tick",
        "datagrams",
    ):  # where nothing can be sent or recorded any more, PX4's own failsafe acts
        modes = [f for _, f in sent(tmp_path / "flight") if f.format.name == "COMMAND_LONG"
                 and f.format.named(f.values)["command"] == SET_MODE]  # fmt: skip
        assert modes[-1].format.named(modes[-1].values)["param3"] == 3.0


def test_a_failure_on_the_ground_commands_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fail_after(monkeypatch, pilot, "compute_setpoint", 0)
    result = sim(tmp_path / "flight", "--from-ground")
    assert result.exit_code == 1
    assert "nothing more was sent; look at the vehicle" in json.loads(result.stdout)["reason"]
    assert not [f for _, f in sent(tmp_path / "flight") if f.format.id == LEVEL]
    asked = {
        f.format.named(f.values)["command"] for _, f in sent(tmp_path / "flight") if f.format.name == "COMMAND_LONG"
    }
    assert not asked & {SET_MODE, MAV_CMD_COMPONENT_ARM_DISARM, MAV_CMD_NAV_TAKEOFF}


def test_a_failure_after_the_operator_took_over_is_not_his(monkeypatch: pytest.MonkeyPatch) -> None:
    """The pilot fails in the very moment at which the operator lands: nothing is asked for any more."""
    flown: list[Flown] = []
    flight(
        duration=3.0,
        prepare=flown.append,
        meddle=once(2.0, lambda f: Operator(f.between.bridge).commands(SET_MODE, 1, 4, 6)),
    )
    resort = LastResort(flown[0].conductor, ValueError("x"), flown[0].between.now)
    for step in range(100):
        resort.on_timer(flown[0].between.now + 0.02 * step)
        asked = [data for data in resort.datagrams() if data[7:10] == b"\x4c\x00\x00"]
        assert not asked
        if resort.done:
            break
    assert resort.done and not resort.asked


@pytest.mark.parametrize("value", [math.nan, math.inf])
@pytest.mark.parametrize("over_xrce", [False, True], ids=["MAVLink", "XRCE"])
def test_a_setpoint_that_is_not_finite_is_never_sent(value: float, over_xrce: bool) -> None:
    """PX4 takes a NaN for "stop this motor"."""
    conductor = Conductor(orders(over_xrce), None, 0.0)
    upright = (1.0, 0.0, 0.0, 0.0)
    for setpoint in (
        RateSetpoint((0.0, 0.0, 0.0), value), RateSetpoint((0.0, value, 0.0), 0.5), AttitudeSetpoint(upright, value),
        AttitudeSetpoint((value, 0.0, 0.0, 0.0), 0.5), MotorSetpoint((0.5, 0.5, value, 0.5)),
        TorqueSetpoint((0.0, 0.0, value), 0.5), TorqueSetpoint((0.0, 0.0, 0.0), value),
    ):  # fmt: skip
        with pytest.raises(CompanionError, match="not finite"):
            conductor.queue(setpoint, 1.0, 0.0)
    conductor.queue(RateSetpoint((0.1, 0.2, 0.3), 0.5), 1.0, 0.0)


def test_the_last_resort_commands_over_xrce_by_its_own_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """PX4's word that it flies on commands is as old as it is, also where nothing arrives over MAVLink any more; and
    what fails in XRCE takes neither HOLD nor the link's time away."""
    flown = flight(
        vehicle="sih", xrce=True, duration=60.0, time_out=7.0, prepare=lambda f: f.conductor.link.peers.call(0)
    )
    conductor, now = flown.conductor, flown.between.now
    assert conductor.xrce is not None and conductor.xrce.sent > 0, flown.notes
    asked: list[float] = []
    monkeypatch.setattr(Commands, "send", lambda self, setpoint, t_boot, at, says: asked.append(at))
    resort = LastResort(conductor, ValueError("x"), now)
    for step in range(1, 6):
        resort.on_timer(now + 0.02 * step)
    assert asked == pytest.approx([now + 0.02 * step for step in range(6)])
    monkeypatch.setattr(Agent, "receive", fail)
    monkeypatch.setattr(Agent, "datagrams", fail)
    conductor.xrce.receive(b"", now)
    assert conductor.xrce.datagrams(now) == []


def fail(*_: object) -> None:
    raise ZeroDivisionError("XRCE")


def test_what_fails_between_two_ticks_is_caught_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The rhythm, the warm-up, systemd: in the control thread, outside of the conductor's doors."""
    fail_after(monkeypatch, Rhythm, "add_arrival", 150)
    result = sim(tmp_path / "flight", "--udp")
    assert result.exit_code == 1
    assert ": HOLD was asked for, and the vehicle is in Hold; " in json.loads(result.stdout)["reason"]


def test_figures_that_cannot_be_computed_leave_the_outcome(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise IndexError("no such figure")

    monkeypatch.setattr("companion.library.outcome.summary", fail)
    result = sim(tmp_path / "flight")
    assert result.exit_code == 0
    figures = json.loads(result.stdout)
    assert figures["outcome"] == "completed"
    assert "the figures could not be computed (IndexError: no such figure" in figures["notes"][0]
    text = CliRunner().invoke(app, ["sim", "circle_r5", "--duration", "1", "--record", str(tmp_path / "text")])
    assert text.exit_code == 0 and text.stdout.startswith("completed")


@pytest.fixture(scope="module")
def ticks(tmp_path_factory: pytest.TempPathFactory) -> int:
    """How many ticks the flight of ``sim`` has."""
    folder = tmp_path_factory.mktemp("whole") / "flight"
    assert sim(folder).exit_code == 0
    return len(read_table(folder / "flight.npy").rows)


@pytest.mark.parametrize("waits", [True, False])
def test_a_disk_that_fills_up_in_flight(
    waits: bool, ticks: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    really, room = os.pwrite, 60_000

    def pwrite(descriptor: int, data: bytes, at: int) -> int:
        if at + len(data) > room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return really(descriptor, data, at)

    monkeypatch.setattr(growing.os, "pwrite", pwrite)
    if not waits:
        monkeypatch.setattr("companion.record.table.ROWS_WAITING", 50)
    result = sim(tmp_path / "flight")
    assert result.exit_code == 0
    figures = json.loads(result.stdout)
    assert figures["outcome"] == "completed"
    assert (figures["follow"]["duration_s"] > 1.9) == waits  # what waited for the disk is in the figures
    left = len(read_table(tmp_path / "flight" / "flight.npy").rows)
    (lacks,) = [int(note.split()[3]) for note in figures["notes"] if "ticks of flight.npy" in note]
    assert left + lacks == ticks
    assert result.stderr.count("the record cannot be written (No space left on device)") == 1
    assert replay(load_flight(tmp_path / "flight")).difference is None


def test_a_folder_deleted_in_flight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    really = simulate.fly

    def fly(conductor: Conductor, bridge: Any, watch: Any, time_out: float, *, survive: bool) -> Any:
        def meddle(conductor: Conductor, truth: Any) -> None:
            if 2.0 < bridge.now < 2.01:
                shutil.rmtree(tmp_path / "flight", ignore_errors=True)
            watch(conductor, truth)

        return really(conductor, bridge, meddle, time_out, survive=survive)

    monkeypatch.setattr(simulate, "fly", fly)
    result = sim(tmp_path / "flight")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["follow"]["duration_s"] == pytest.approx(2.0, abs=0.1)  # from the open file
    assert f"the flight folder {tmp_path / 'flight'} was deleted; the flight goes on" in result.stderr


def test_a_helper_that_fails_says_so_once_and_goes_on() -> None:
    class Clumsy(Helper):
        worked = 0

        def work(self, now: float) -> None:
            self.worked += 1
            raise KeyError("x")

    lines: Any = []
    helper = Clumsy("scribe", lines, clock)
    for _ in range(3):
        helper._work()
    assert helper.worked == 3
    assert lines == ["the scribe failed (KeyError: 'x'); the flight goes on"]


def test_a_power_cut_costs_less_than_two_seconds() -> None:
    """Between two syncs with everything in between, when the thread looks every PERIOD."""
    synced: list[float] = []
    now = [0.0]

    class Fake:
        words: tuple[()] = ()

        def flush(self, *, sync: bool) -> None:
            if sync:
                synced.append(now[0])

    scribe = Scribe(Fake(), [], lambda: now[0])  # type: ignore[arg-type]
    for step in range(100):
        now[0] = step * (PERIOD + 0.01)
        scribe._work()
    assert max(b - a for a, b in itertools.pairwise(synced)) + PERIOD < 1.5


def test_a_tick_that_cannot_be_recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fail_after(monkeypatch, sys.modules["companion.record.rows"], "row", 300)
    result = sim(tmp_path / "flight")
    assert result.exit_code == 0
    assert result.stderr.count("a tick could not be recorded (ZeroDivisionError") == 1
    assert len(read_table(tmp_path / "flight" / "flight.npy").rows) == 300


def test_a_disk_that_does_not_answer_is_left_alone(tmp_path: Path) -> None:
    flown: list[Flown] = []
    flight(duration=0.5, record=tmp_path / "flight", prepare=flown.append)
    recorder = flown[0].conductor._recorder
    assert isinstance(recorder, Recorder)
    recorder.abandon()
    recorder.flush(sync=True)
    recorder.close()
    assert recorder.table is None and not recorder.keep("summary.json", "{}")
    assert "the disk does not answer" in recorder.words[-1]


def test_a_screen_that_is_stopped_holds_nothing_up(monkeypatch: pytest.MonkeyPatch) -> None:
    read, write = os.pipe()
    with open(write, "w", encoding="utf-8") as stopped:
        monkeypatch.setattr(sys, "stderr", stopped)
        os.set_blocking(write, False)
        with contextlib.suppress(BlockingIOError):
            while os.write(write, b"x" * 4096):
                pass
        os.set_blocking(write, True)
        begun = time.monotonic()
        terminal.say("one line more")
        assert time.monotonic() - begun < 2.0 * terminal.PATIENCE
        os.set_blocking(read, False)
        while os.read(read, 1 << 16)[-1:] == b"x":
            terminal.say("now there is room")
            if b"room" in os.read(read, 1 << 20):
                break
    os.close(read)


def test_a_killed_daemon_leaves_its_record(tmp_path: Path) -> None:
    """kill -9 in flight: what is left ends at most 2 s before."""
    process = subprocess.Popen(
        [sys.executable, "-m", "companion", "sim", "circle_r5", "--udp", "--record", "flight"],
        cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    assert process.stderr is not None
    plants = []
    try:
        while not (line := process.stderr.readline()).startswith("follow"):
            assert line or process.poll() is None
        plants = [int(pid) for pid in Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()]
        time.sleep(1.5)  # a real process, and a real disk
        process.send_signal(signal.SIGKILL)
        killed_at = clock()
        process.wait(10.0)
    finally:
        process.kill()
        for pid in plants:
            os.kill(pid, signal.SIGKILL)
        process.stderr.close()
        process.wait(10.0)
    recorded = load_flight(tmp_path / "flight")
    assert killed_at - recorded.table["now"][-1] < 2.0
    assert recorded.table["now"][-1] - recorded.table["now"][0] > 1.0
    assert replay(recorded).difference is None
    *_, (last, _) = records((tmp_path / "flight" / "link.tlog").read_bytes())
    assert time.time() - (clock() - killed_at) - last < 2.0
    assert "-> follow" in (tmp_path / "flight" / "notes.txt").read_text()
