"""What goes to PX4's XRCE client and comes from it is kept beside link.tlog, and held against the flight's ticks."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from companion.record.table import Table, dtype_of
from companion.record.tick_columns import COLUMNS
from companion.record.xrce_log import NAME, XrceWriter, examined, latency_words, read_latency, records
from companion.vehicle import MotorSetpoint, OutputLevel
from companion.xrce import wire
from companion.xrce.commands import Commands
from companion.xrce.messages import SESSION
from companion.xrce.objects import WriteData
from companion.xrce.topics import LAYOUTS
from companion.xrce.wire import Message
from tests.xrce.captured import session

COMMANDS = (0.41, 0.52, 0.63, 0.74)
EPOCH = 1_790_000_000.0
BOOT = 0.2
"""s by our clock when PX4's read zero: sooner than in the captured session, so that its own stamps do not count."""


def flown(directory: Path, offset: int = 0) -> XrceWriter:
    """Five commands, each 4 ms after the stamp of its state, by PX4's clock. ``offset``: us that it takes from stamps."""
    writer, commands = XrceWriter(directory, EPOCH), Commands(OutputLevel.MOTORS)
    commands.tap = writer.add_datagram
    for each in session():
        if each.of_client:
            commands.receive(each.data, each.at)
            commands.datagrams(each.at)
    for index in range(5):
        now = 100.0 + 0.01 * index
        sample = LAYOUTS["vehicle_control_mode", 0].encode(
            timestamp=round((now - BOOT) * 1e6) - offset, flag_control_offboard_enabled=True
        )
        told = LAYOUTS["timesync_status", 0].encode(estimated_offset=offset)
        said = (WriteData(0, 0x0FF5, told), WriteData(0, 0x1155, sample))
        published = Message(SESSION, 1, 9000 + index, said)
        commands.receive(wire.encode(published), now)
        commands.send(MotorSetpoint(COMMANDS), now - BOOT, now, True)
        commands.datagrams(now + 0.004)
    writer.write()
    return writer


def table(commands: tuple[float, ...]) -> Table:
    """The ticks of these commands."""
    ticks = np.zeros(5, dtype=dtype_of(COLUMNS))
    ticks["setpoint"] = 1
    ticks["t_boot"] = [99.8 + 0.01 * index for index in range(5)]
    for i, command in enumerate(commands):
        ticks[f"sent_{i}"] = command
    return ticks


def test_the_traffic_is_kept_and_shows_the_commands_and_their_latency(tmp_path: Path) -> None:
    flown(tmp_path).close()
    kept = list(records((tmp_path / NAME).read_bytes()))
    assert [each.data for each in kept if not each.to_px4][:-5] == [each.data for each in session() if each.of_client]
    evidence = read_latency(tmp_path, table(COMMANDS))
    assert evidence is not None
    assert (evidence.commands, evidence.differing) == (5, None)
    assert evidence.latency == pytest.approx((0.004,) * 5, abs=2e-6)
    assert "4.0 ms median" in latency_words(evidence)


def test_stamps_on_the_agents_clock_are_taken_back_to_px4s(tmp_path: Path) -> None:
    """The captured client took 43 us from them: half a round trip."""
    flown(tmp_path, offset=3000).close()
    evidence = read_latency(tmp_path, table(COMMANDS))
    assert evidence is not None
    assert evidence.latency == pytest.approx((0.004,) * 5, abs=2e-6)


def test_a_command_that_is_not_its_ticks_setpoint_is_named(tmp_path: Path) -> None:
    flown(tmp_path).close()
    evidence = read_latency(tmp_path, table((0.41, 0.52, 0.63, 0.75)))
    assert evidence is not None
    assert evidence.differing == "the command for the state of 99.800 s"


def test_a_file_that_is_cut_or_missing_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    assert read_latency(tmp_path, table(COMMANDS)) is None
    flown(tmp_path).close()
    whole = (tmp_path / NAME).read_bytes()
    assert examined(whole[:-7], table(COMMANDS)).commands == 4
    assert examined(b"", table(COMMANDS)).commands == 0


def test_a_command_without_a_new_state_is_its_tick_too(tmp_path: Path) -> None:
    """An abort for want of states has none; its setpoint goes out with the last one's stamp."""
    writer = flown(tmp_path)
    writer.close()
    ticks = table(COMMANDS)
    ticks["t_boot"][1:] = np.nan
    data = (tmp_path / NAME).read_bytes()
    assert examined(data, ticks).differing == "the command for the state of 99.810 s"  # no tick has that stamp
    ticks = np.concatenate((table(COMMANDS), table(COMMANDS)[-1:]))
    ticks["t_boot"][-1], ticks["sent_0"][-1] = np.nan, 0.9
    assert examined(data, ticks).differing is None


def test_traffic_that_is_none_is_no_evidence(tmp_path: Path) -> None:
    flown(tmp_path).close()
    with (tmp_path / NAME).open("ab") as file:
        file.write(struct.pack(">QBH", 0, 1, 3) + b"???")
    assert read_latency(tmp_path, table(COMMANDS)) is None
