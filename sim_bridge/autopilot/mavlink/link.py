"""One endpoint of the vehicle: the messages that come by it, the streams and answers that go."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from companion import mavlink_common as mav
from companion.mavlink.codec import Decoder, Encoder, Frame
from companion.mavlink.dialect import Format, Value, message
from companion.mavlink.signing import SETUP_SIGNING
from companion.mavlink_common import (
    MAV_CMD_DO_SET_MODE,
    MAV_COMP_ID_MISSIONPLANNER,
    MAV_TYPE_GCS,
    MavResult,
)
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commander import events
from sim_bridge.autopilot.commander.commander import Text
from sim_bridge.autopilot.commands import Command, execute, is_integer_max, place_given, set_mode, stray
from sim_bridge.autopilot.flight_modes.manual_control import MANUAL_CONTROL, deflection
from sim_bridge.autopilot.mavlink import file_link, parameter_link
from sim_bridge.autopilot.mavlink.boot_messages import BootMessages
from sim_bridge.autopilot.mavlink.file_link import FileLink
from sim_bridge.autopilot.mavlink.parameter_link import ParameterLink
from sim_bridge.autopilot.mavlink.setpoint_link import COMPONENT, SYSTEM, SetpointLink, is_for_us
from sim_bridge.autopilot.mavlink.signing import KeyStore
from sim_bridge.autopilot.mavlink.streams import Streams
from sim_bridge.autopilot.messages import BUILDERS, EDITIONS, Values
from sim_bridge.autopilot.messages.identity import AVAILABLE, available_mode
from sim_bridge.autopilot.missions.protocol import MissionLink

HEARD_FOR_US = 2_500_000
"""us after its last heartbeat for which a ground station counts as listening."""
TEXT_SIZE = 50
"""characters of a STATUSTEXT."""
POLL_US = 10_000
"""The period at which PX4 looks at what it owes to a link."""
NOT_ON_REQUEST = frozenset({message("GPS_RAW_INT").id, message("TIME_ESTIMATE_TO_TARGET").id, message("PING").id})
"""Messages a request is denied for: whatever there is to say has been streamed already."""

NAN_CAST = 0x7FF80000
"""What becomes of NaN where somebody casts it to a coordinate of COMMAND_INT."""
KNOWN_TO_THE_LINK = frozenset({
    mav.MAV_CMD_DO_SET_MODE, mav.MAV_CMD_DO_AUTOTUNE_ENABLE, mav.MAV_CMD_INJECT_FAILURE,
    mav.MAV_CMD_GET_MESSAGE_INTERVAL, mav.MAV_CMD_SET_MESSAGE_INTERVAL, mav.MAV_CMD_REQUEST_MESSAGE,
})  # fmt: skip
"""Commands PX4's link deals with itself, whoever sends them."""

_ACK = message("COMMAND_ACK")
_AVAILABLE_MODES = message("AVAILABLE_MODES")
_COMMAND_LONG, _COMMAND_INT = message("COMMAND_LONG"), message("COMMAND_INT")
_HEARTBEAT = message("HEARTBEAT")
_INTERVAL = message("MESSAGE_INTERVAL")
_LINK_NODE_STATUS = message("LINK_NODE_STATUS")
_PING, _TIMESYNC = message("PING"), message("TIMESYNC")
_SET_MODE = message("SET_MODE")
_TEXT = message("STATUSTEXT")


class Link:
    """A link to one peer. ``outbox``: the datagrams to send, oldest first. Commands for others are not answered.

    ``alter``: what a world's events make of a message (by its id) that is streamed; None: it is not sent.
    ``boots``: the vehicle has just been switched on. ``keys``: what it signs with on all its links.
    """

    def __init__(self, autopilot: Autopilot, streams: Streams, keys: KeyStore, *, boots: bool = False) -> None:
        self._autopilot = autopilot
        self._keys = keys
        self._streams = streams
        self._encoder = Encoder(SYSTEM, COMPONENT)
        self._parameters = ParameterLink(autopilot.parameters, SYSTEM, self.emit)
        self._missions = MissionLink(
            autopilot.missions, autopilot.mission, SYSTEM, self.emit, autopilot.commander.texts.append
        )  # fmt: skip
        self._events = events.EventLink(autopilot.events, SYSTEM, self.emit)
        self._boot_messages = BootMessages(self._parameters.tell, self.emit) if boots else None
        self._builders = BUILDERS | {_LINK_NODE_STATUS.id: (_LINK_NODE_STATUS, self._link_node_status)}
        self._editions: dict[int, object] = {}
        self._texts = 0
        self._now_us = 0
        self._poll_at_us = 0
        self._ground_station_until_us = -1
        self._sent = 0
        self.alter: Callable[[int, Values], Values | None] | None = None
        self.decoder = Decoder()
        keys.attach(self._encoder, self.decoder)
        self.outbox: list[bytes] = []
        self.peers: set[tuple[int, int]] = set()
        self._handlers = {
            _COMMAND_INT.id: self._command_int,
            _COMMAND_LONG.id: self._command_long,
            _HEARTBEAT.id: self._heartbeat,
            _PING.id: self._ping,
            _SET_MODE.id: self._set_mode,
            _TIMESYNC.id: self._timesync,
            MANUAL_CONTROL.id: self._manual_control,
            SETUP_SIGNING.id: self._setup_signing,
            file_link.FTP.id: FileLink(SYSTEM, autopilot.log_files, self.emit).request,
            events.REQUEST.id: self._events.resend,
            parameter_link.READ.id: self._parameters.send_requested,
            parameter_link.LIST.id: self._parameters.list,
            parameter_link.SET.id: self._parameters.change,
            **self._missions.handlers,
            **SetpointLink(autopilot).handlers,
        }

    @property
    def hears_ground_station(self) -> bool:
        """Whether a ground station listens at the other end."""
        return self._now_us <= self._ground_station_until_us

    def receive(self, datagram: bytes, *, is_piece: bool = False) -> list[Frame]:
        """Take a datagram in; the frames in it. ``is_piece``: messages may begin in one and end in another. Garbage is
        counted by the decoder and never raises."""
        frames = (self.decoder.stream if is_piece else self.decoder.datagram)(datagram)
        for frame in frames:
            self.peers.add((frame.system, frame.component))
            handler = self._handlers.get(frame.format.id)
            if handler is not None:
                handler(frame)
        return frames

    def stream(self, now_us: int, built: dict[int, Values | None]) -> None:
        """Send what is due at ``now_us`` of the bridge's clock. ``built``: what has been put together in this step."""
        self._now_us = now_us
        due = self._streams.due(now_us)
        if due:
            self._send_streams(due, built)
        if now_us >= self._poll_at_us:
            self._poll_at_us = now_us + POLL_US
            self._parameters.poll(now_us)
            self._missions.poll(now_us)
            self._events.poll(now_us)
            if self._boot_messages is not None:
                self._boot_messages.poll(now_us)

    def _send_streams(self, due: Sequence[int], built: dict[int, Values | None]) -> None:
        """Send the streams that are due."""
        again, encode, alter, outbox = self._streams.again, self._encoder.encode, self.alter, self.outbox
        for msgid in due:
            if msgid in EDITIONS and not self._is_new(msgid):
                again(msgid, False)
                continue
            fmt, build = self._builders[msgid]
            if msgid in built:
                values = built[msgid]
            else:
                values = build(self._autopilot)
                if msgid != _LINK_NODE_STATUS.id:
                    built[msgid] = values
            if values is not None and alter is not None:
                values = alter(msgid, values)
            if values is None:
                again(msgid, False)
            else:
                outbox.append(encode(fmt, values))
                self._sent += 1
                again(msgid, True)

    def emit(self, fmt: Format, values: tuple[Value, ...]) -> None:
        """Queue a message."""
        self.outbox.append(self._encoder.encode(fmt, values))

    def say(self, text: Text) -> None:
        """Send a text, in pieces if it is long, to a peer that has a ground station."""
        if not self.hears_ground_station:
            return
        data = text.text.encode("utf-8", "replace")
        for piece, at in enumerate(range(0, len(data), TEXT_SIZE)):
            self.emit(_TEXT, (text.severity.value, data[at : at + TEXT_SIZE], self._texts & 0xFFFF, piece))
        self._texts += 1

    def request(self, msgid: int, argument: float) -> bool:
        """Send a message now. False: there is no such message, or it has nothing to say."""
        if msgid == _AVAILABLE_MODES.id:
            return self._list_modes(argument)
        if msgid not in self._builders or msgid in NOT_ON_REQUEST:
            return False
        fmt, build = self._builders[msgid]
        values = build(self._autopilot)
        if values is not None and self.alter is not None:
            values = self.alter(msgid, values)
        if values is None:
            return False
        self.emit(fmt, values)
        return True

    def tell_interval(self, msgid: int) -> None:
        """Send MESSAGE_INTERVAL for a message."""
        self.emit(_INTERVAL, (self._streams.interval(msgid), msgid & 0xFFFF))

    def set_interval(self, msgid: int, interval_us: int) -> bool:
        """Change a stream's interval. False: it cannot be."""
        return self._streams.set_interval(msgid, interval_us)

    def _is_new(self, msgid: int) -> bool:
        """Whether there is another edition than was sent last; it counts as sent then."""
        edition = EDITIONS[msgid](self._autopilot)
        if edition is None or edition == self._editions.get(msgid):
            return False
        self._editions[msgid] = edition
        return True

    def _list_modes(self, argument: float) -> bool:
        """One mode, or with 0 every one."""
        index = round(argument) if math.isfinite(argument) else 0
        if not 0 <= index <= len(AVAILABLE):
            return False
        for i in range(1, len(AVAILABLE) + 1) if index == 0 else (index,):
            self.emit(_AVAILABLE_MODES, available_mode(self._autopilot, i))
        return True

    def _link_node_status(self, autopilot: Autopilot) -> Values:
        """LINK_NODE_STATUS: what has gone over this link."""
        counters = self.decoder.counters
        return _LINK_NODE_STATUS.values(
            timestamp=autopilot.estimate.time_us,
            messages_sent=self._sent & 0xFFFFFFFF,
            messages_received=counters.frames & 0xFFFFFFFF,
            messages_lost=counters.lost & 0xFFFFFFFF,
            rx_parse_err=counters.bad_crc & 0xFFFF,
        )

    def _acknowledge(self, command: int, result: MavResult, frame: Frame) -> None:
        self.emit(_ACK, (command, result.value, 0, 0, frame.system, frame.component))

    def _command_long(self, frame: Frame) -> None:
        a, b, c, d, e, f, g, command, system, component, _ = frame.values
        if is_integer_max(e) and is_integer_max(f):
            self._acknowledge(command, MavResult.DENIED, frame)
        elif is_for_us(system, component):
            self._execute(command, (a, b, c, d, e, f, g), frame)

    def _command_int(self, frame: Frame) -> None:
        a, b, c, d, x, y, z, command, system, component, kind, *_ = frame.values
        if x == y == NAN_CAST:
            self._acknowledge(command, MavResult.DENIED, frame)
        elif is_for_us(system, component):
            self._execute(command, (a, b, c, d, *place_given(command, kind, x, y), z), frame)

    def _execute(
        self, command: int, parameters: tuple[float, float, float, float, float, float, float], frame: Frame
    ) -> None:
        if (frame.system, frame.component) == (SYSTEM, COMPONENT) and command not in KNOWN_TO_THE_LINK:
            return  # PX4 takes no orders from itself
        if stray(command, parameters):
            self._acknowledge(command, MavResult.DENIED, frame)
            return
        result = execute(Command(command, parameters, frame.system, frame.component), self._autopilot, self)
        if result is not None:
            self._acknowledge(command, result, frame)

    def _set_mode(self, frame: Frame) -> None:
        custom, system, base = frame.values
        if system in (0, SYSTEM):
            aloud = frame.component == MAV_COMP_ID_MISSIONPLANNER
            result = set_mode(base, custom >> 16 & 0xFF, custom >> 24, self._autopilot, aloud)
            self._acknowledge(MAV_CMD_DO_SET_MODE, result, frame)

    def _heartbeat(self, frame: Frame) -> None:
        kind = frame.values[1]
        self._autopilot.checks.contacts.notice_heartbeat(kind, self._autopilot.t)
        if kind == MAV_TYPE_GCS:
            self._ground_station_until_us = self._now_us + HEARD_FOR_US

    def _ping(self, frame: Frame) -> None:
        time_usec, sequence, system, component = frame.values
        if system == 0 and component == 0:  # a request to everybody
            self.emit(_PING, (time_usec, sequence, frame.system, frame.component))

    def _timesync(self, frame: Frame) -> None:
        theirs, ours = frame.values[:2]
        if theirs == 0:  # a request: their time comes back with ours
            self.emit(_TIMESYNC, (self._autopilot.estimate.time_us * 1000, ours))

    def _setup_signing(self, frame: Frame) -> None:
        self._keys.set_up(frame, SYSTEM, COMPONENT, armed=self._autopilot.commander.armed)

    def _manual_control(self, frame: Frame) -> None:
        position = deflection(frame, SYSTEM)
        if position is not None:
            self._autopilot.take_sticks(position, self)
