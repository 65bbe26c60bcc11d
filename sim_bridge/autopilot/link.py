"""One endpoint of the vehicle: the messages that come by it, the streams and answers that go."""

from __future__ import annotations

import math

from companion.mavlink.codec import Decoder, Encoder, Frame
from companion.mavlink.dialect import Value, message
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commander import Result, Text
from sim_bridge.autopilot.commands import NOT_GIVEN, NOT_GIVEN_CAST, SET_MODE, Command, execute, set_mode
from sim_bridge.autopilot.messages import BUILDERS, Values
from sim_bridge.autopilot.setpoints import ACTUATORS, ATTITUDE_TARGET, actuator_controls, attitude_target
from sim_bridge.autopilot.streams import Streams

SYSTEM, COMPONENT = 1, 1
GROUND_STATION = 6  # MAV_TYPE_GCS
TEXT_SIZE = 50

_ACK = message("COMMAND_ACK")
_COMMAND_LONG, _COMMAND_INT = message("COMMAND_LONG"), message("COMMAND_INT")
_HEARTBEAT = message("HEARTBEAT")
_INTERVAL = message("MESSAGE_INTERVAL")
_PING, _TIMESYNC = message("PING"), message("TIMESYNC")
_SET_MODE = message("SET_MODE")
_TEXT = message("STATUSTEXT")


class Link:
    """A link to one peer. ``outbox``: the datagrams to send, oldest first. Commands for others are not answered."""

    def __init__(self, autopilot: Autopilot, streams: Streams) -> None:
        self._autopilot = autopilot
        self._streams = streams
        self._encoder = Encoder(SYSTEM, COMPONENT)
        self._texts = 0
        self.decoder = Decoder()
        self.outbox: list[bytes] = []
        self.hears_ground_station = False
        self.peers: set[tuple[int, int]] = set()
        self._handlers = {
            _COMMAND_INT.id: self._command_int,
            _COMMAND_LONG.id: self._command_long,
            _HEARTBEAT.id: self._heartbeat,
            _PING.id: self._ping,
            _SET_MODE.id: self._set_mode,
            _TIMESYNC.id: self._timesync,
            ACTUATORS.id: self._actuators,
            ATTITUDE_TARGET.id: self._attitude_target,
        }

    def receive(self, datagram: bytes) -> list[Frame]:
        """Take a datagram in; the frames in it. Garbage is counted by the decoder and never raises."""
        frames = self.decoder.datagram(datagram)
        for frame in frames:
            self.peers.add((frame.system, frame.component))
            handler = self._handlers.get(frame.format.id)
            if handler is not None:
                handler(frame)
        return frames

    def stream(self, now_us: int, built: dict[int, Values]) -> None:
        """Send what is due at ``now_us`` of the bridge's clock. ``built``: what has been put together in this step."""
        for msgid in self._streams.due(now_us):
            fmt, build = BUILDERS[msgid]
            values = built.get(msgid)
            if values is None:
                values = built[msgid] = build(self._autopilot)
            self.outbox.append(self._encoder.encode(fmt, values))

    def say(self, text: Text) -> None:
        """Send a text, in pieces if it is long, to a peer that has a ground station."""
        data = text.text.encode("utf-8", "replace")
        if self.hears_ground_station:
            for piece, at in enumerate(range(0, len(data), TEXT_SIZE)):
                values = (text.severity.value, data[at : at + TEXT_SIZE], self._texts & 0xFFFF, piece)
                self.outbox.append(self._encoder.encode(_TEXT, values))
            self._texts += 1

    def send(self, msgid: int) -> None:
        """Send a message that has a builder, now."""
        fmt, build = BUILDERS[msgid]
        self.outbox.append(self._encoder.encode(fmt, build(self._autopilot)))

    def tell_interval(self, msgid: int) -> None:
        """Send MESSAGE_INTERVAL for a message."""
        self.outbox.append(self._encoder.encode(_INTERVAL, (self._streams.interval(msgid), msgid & 0xFFFF)))

    def set_interval(self, msgid: int, interval_us: int) -> bool:
        """Change a stream's interval. False: it cannot be."""
        return self._streams.set_interval(msgid, interval_us)

    def _acknowledge(self, command: int, result: Result, frame: Frame) -> None:
        values = (command, result.value, 0, 0, frame.system, frame.component)
        self.outbox.append(self._encoder.encode(_ACK, values))

    def _command_long(self, frame: Frame) -> None:
        a, b, c, d, e, f, g, command, system, component, _ = frame.values
        if not _for_us(system, component):
            return
        if NOT_GIVEN_CAST in (e, f):
            self._acknowledge(command, Result.DENIED, frame)
            return
        self._execute(command, (a, b, c, d, e, f, g), frame)

    def _command_int(self, frame: Frame) -> None:
        a, b, c, d, x, y, z, command, system, component, *_ = frame.values
        if _for_us(system, component):
            e, f = (math.nan if value == NOT_GIVEN else float(value) for value in (x, y))
            self._execute(command, (a, b, c, d, e, f, z), frame)

    def _execute(
        self, command: int, parameters: tuple[float, float, float, float, float, float, float], frame: Frame
    ) -> None:
        asked = Command(command, parameters, frame.system, frame.component)
        self._acknowledge(command, execute(asked, self._autopilot, self), frame)

    def _set_mode(self, frame: Frame) -> None:
        custom, system, base = frame.values
        if system in (0, SYSTEM):
            self._acknowledge(SET_MODE, set_mode(base, custom >> 16 & 0xFF, custom >> 24, self._autopilot), frame)

    def _heartbeat(self, frame: Frame) -> None:
        if frame.values[1] == GROUND_STATION:
            self.hears_ground_station = True

    def _ping(self, frame: Frame) -> None:
        time_usec, sequence, system, component = frame.values
        if system == 0 and component == 0:  # a request to everybody
            self.outbox.append(self._encoder.encode(_PING, (time_usec, sequence, frame.system, frame.component)))

    def _timesync(self, frame: Frame) -> None:
        theirs, ours = frame.values[:2]
        if theirs == 0:  # a request: their time comes back with ours
            self.outbox.append(self._encoder.encode(_TIMESYNC, (self._autopilot.estimate.time_us * 1000, ours)))

    def _attitude_target(self, frame: Frame) -> None:
        if _targets_us(frame):
            demand = attitude_target(frame.values)
            if demand is not None:
                self._autopilot.offboard(demand)

    def _actuators(self, frame: Frame) -> None:
        if _targets_us(frame):
            demand = actuator_controls(frame.values)
            if demand is not None:
                self._autopilot.offboard(demand)


def _for_us(system: Value, component: Value) -> bool:
    return system in (0, SYSTEM) and component in (0, COMPONENT)


def _targets_us(frame: Frame) -> bool:
    where = frame.format.where
    return _for_us(frame.values[where["target_system"]], frame.values[where["target_component"]])
