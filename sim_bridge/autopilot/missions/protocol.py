"""The mission protocol on one link, as PX4 speaks it: upload, download, clear, current, and what goes wrong."""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping

from companion.mavlink.codec import Frame
from companion.mavlink.dialect import Value, message
from companion.mavlink_common import (
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
    MavMissionResult,
    MavSeverity,
)
from sim_bridge.autopilot.commander.commander import Text
from sim_bridge.autopilot.missions.item_table import FENCE_AND_RALLY
from sim_bridge.autopilot.missions.items import ITEM, ITEM_INT, Item, checksum, of_a_fence, read
from sim_bridge.autopilot.missions.mission_messages import (
    ACK,
    COUNT,
    REQUEST,
    REQUEST_INT,
    MissionMessages,
    Peer,
    Progress,
    Send,
)
from sim_bridge.autopilot.missions.store import ALL, MOST, Kind, Store

GIVE_UP_US = 5_000_000
"""us of silence after which a transfer is given up."""
AGAIN_US = 250_000
"""us of silence after which the partner is asked again."""
TELL_US = 1_000_000
"""The period of MISSION_CURRENT."""
REACHED_AGAIN = 10
"""How many times it is told again that an item was reached."""
OUR_COMPONENTS = (0, 1, 190)
"""MAV_COMP_ID that a mission message may be meant for: all, the autopilot, the mission planner."""
TOO_FEW_CORNERS = 3
"""of a fence's polygon."""

_CLEAR, _LIST, _SET_CURRENT = (message(f"MISSION_{name}") for name in ("CLEAR_ALL", "REQUEST_LIST", "SET_CURRENT"))


Fields = Mapping[str, Value]
"""A message's, by their names."""


class State(enum.Enum):
    """What a link is in the middle of."""

    IDLE = enum.auto()
    RECEIVING = enum.auto()
    SENDING = enum.auto()


class MissionLink:
    """One link's side, of the vehicle with system id ``system``. ``send``: on this link; ``say``: to every operator."""

    def __init__(self, store: Store, progress: Progress, system: int, send: Send, say: Callable[[Text], None]) -> None:
        self._store, self._progress, self._system = store, progress, system
        self._messages, self._say = MissionMessages(store, progress, send), say
        self._state = State.IDLE
        self._kind = 0
        self._partner = (0, 0)
        self._items: list[Item] = []
        self._id = 0
        self._expected = self._count = 0
        self._current: int | None = None
        self._whole = True
        self._now = self._heard_us = self._sent_us = self._tell_at_us = 0
        self._told: tuple[int, bool] = (0, False)
        self._reached, self._reached_again = -1, 0
        handlers: Mapping[int, Callable[[Frame, Fields], None]] = {
            ACK.id: self._notice_acknowledgement,
            _CLEAR.id: self._clear,
            COUNT.id: self._begin_upload,
            _LIST.id: self._list,
            REQUEST.id: self._send_item,
            REQUEST_INT.id: self._send_item,
            _SET_CURRENT.id: self._set_current,
            ITEM.id: self._item,
            ITEM_INT.id: self._item,
        }
        self.handlers = {number: self._if_ours(handle) for number, handle in handlers.items()}

    def poll(self, now_us: int) -> None:
        """Tell how the mission goes and look after transfers. To be called every 10 ms."""
        self._now = now_us
        current = (self._store.current, self._progress.finished)
        if current != self._told:
            self._told = current
            self._messages.current()
        if self._progress.reached != self._reached:
            self._reached, self._reached_again = self._progress.reached, REACHED_AGAIN
            if self._reached >= 0:
                self._messages.say_reached(self._reached)
        elif now_us >= self._tell_at_us:
            self._tell_at_us = now_us + TELL_US
            self._messages.current()
            if self._reached >= 0 and self._reached_again > 0:
                self._reached_again -= 1
                self._messages.say_reached(self._reached)
        if self._state is State.IDLE:
            return
        if now_us - self._heard_us > GIVE_UP_US:
            self._complain("Mission sync timeout\t")
            self._finish()
        elif now_us - self._sent_us > AGAIN_US:
            if self._state is State.RECEIVING:
                self._ask()
            elif self._expected == 0:
                self._tell_count()

    def _if_ours(self, handle: Callable[[Frame, Fields], None]) -> Callable[[Frame], None]:
        """``handle``, for what is meant for this vehicle; the rest is passed over."""

        def handle_ours(frame: Frame) -> None:
            fields = frame.format.named(frame.values)
            if fields["target_system"] == self._system and fields["target_component"] in OUR_COMPONENTS:
                handle(frame, fields)

        return handle_ours

    def _list(self, frame: Frame, fields: Fields) -> None:
        sender, kind = (frame.system, frame.component), fields["mission_type"]
        if self._state is State.SENDING and self._expected == len(self._list_of(self._kind)):
            self._state = State.IDLE  # all was sent; the acknowledgement may have been lost
        again = self._state is State.SENDING and (self._kind, self._partner) == (kind, sender)
        if self._state is not State.IDLE and not again:
            self._say(Text(MavSeverity.INFO, "Mission download request ignored, already active\t"))
            return
        self._heard_us, self._state, self._kind, self._partner = self._now, State.SENDING, kind, sender
        self._expected, self._count = 0, len(self._list_of(kind))
        self._tell_count()

    def _send_item(self, frame: Frame, fields: Fields) -> None:
        self._whole = frame.format is REQUEST_INT
        if (frame.system, frame.component) != self._partner:
            self._complain("WPM: REJ. CMD: partner id mismatch\t")
        elif self._state is State.RECEIVING:
            self._complain("WPM: REJ. CMD: Busy\t")
        elif self._state is State.SENDING and fields["mission_type"] == self._kind:
            self._heard_us = self._now
            asked, items = fields["seq"], self._list_of(self._kind)
            if asked == self._expected < self._count:
                self._expected += 1
            elif asked != self._expected - 1:
                asked = len(items)
            if asked < len(items):
                self._sent_us = self._now
                self._messages.item(self._partner, self._kind, asked, items[asked], self._whole)
            else:
                self._state = State.IDLE
                self._acknowledge(self._partner, MavMissionResult.ERROR)
                self._complain("WPM: REJ. CMD: Req. WP was unexpected\t")

    def _notice_acknowledgement(self, frame: Frame, fields: Fields) -> None:
        if (frame.system, frame.component) != self._partner:
            self._complain("REJ. WP CMD: partner id mismatch\t")
        elif self._state is State.SENDING and fields["mission_type"] == self._kind:
            self._state = State.IDLE
        elif self._state is State.RECEIVING:
            if fields["type"] == MavMissionResult.UNSUPPORTED:  # the partner speaks the other kind of item
                self._whole = not self._whole
                self._ask()
            elif fields["type"] == MavMissionResult.OPERATION_CANCELLED:
                self._finish()

    def _begin_upload(self, frame: Frame, fields: Fields) -> None:
        sender, count = (frame.system, frame.component), fields["count"]
        if self._state is State.RECEIVING:
            self._heard_us = self._now
            if sender != self._partner:
                self._acknowledge(sender, MavMissionResult.ERROR)
            elif self._expected > 0:
                self._complain("WPM: REJ. CMD: Busy\t")
                self._acknowledge(sender, MavMissionResult.ERROR)
            else:
                self._ask()
            return
        if self._state is State.SENDING:
            self._complain("WPM: IGN MISSION_COUNT: Busy\t")
            self._acknowledge(sender, MavMissionResult.ERROR)
            return
        self._heard_us = self._now
        if self._store.transferring:  # on another link
            self._acknowledge(sender, MavMissionResult.ERROR)
            return
        self._partner, self._kind, self._id, self._reached = sender, fields["mission_type"], 0, -1
        most = MOST[Kind(self._kind)] if self._kind in tuple(Kind) else 0
        if count > most:
            self._acknowledge(sender, MavMissionResult.NO_SPACE)
        elif count == 0:
            if most:
                self._store.clear(Kind(self._kind))
            self._acknowledge(sender, MavMissionResult.ACCEPTED)
        else:
            self._state, self._store.transferring = State.RECEIVING, True
            self._expected, self._count, self._items, self._current = 0, count, [], None
            self._ask()

    def _item(self, frame: Frame, fields: Fields) -> None:
        self._whole = frame.format is ITEM_INT
        if (frame.system, frame.component) != self._partner:
            self._complain("REJ. MIS ITEM: partner id mismatch\t")
        elif fields["mission_type"] != self._kind:
            self._acknowledge(self._partner, MavMissionResult.ERROR)
        elif self._state is State.SENDING:
            self._complain("IGN MISSION_ITEM: Busy\t")
            self._acknowledge(self._partner, MavMissionResult.ERROR)
        elif self._state is State.IDLE:
            if self._expected == fields["seq"] + 1:  # the last one again: our acknowledgement was lost
                self._acknowledge(self._partner, MavMissionResult.ACCEPTED, self._id)
            else:
                self._complain("IGN MISSION_ITEM: No transfer\t")
                self._acknowledge(self._partner, MavMissionResult.ERROR)
        else:
            self._heard_us = self._now
            if fields["seq"] == self._expected:
                self._take(frame, fields["current"])

    def _take(self, frame: Frame, current: int) -> None:
        """The item that was asked for."""
        item = read(frame)
        if isinstance(item, MavMissionResult):
            self._complain("IGN MISSION_ITEM: Invalid item\t")
            self._acknowledge(self._partner, item)
            self._finish()
            return
        polygon = item.command in (
            MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
            MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
        )
        misplaced = self._kind == Kind.MISSION and item.command in FENCE_AND_RALLY
        if misplaced or (self._kind == Kind.FENCE and polygon and item.params[0] < TOO_FEW_CORNERS):
            self._acknowledge(self._partner, MavMissionResult.ERROR)
            self._finish()
            return
        self._id = checksum(frame, self._id)
        self._items.append(of_a_fence(item) if self._kind == Kind.FENCE else item)
        if current:
            self._current = self._expected
        self._expected += 1
        if self._expected < self._count:
            self._ask()
            return
        self._store.put(Kind(self._kind), tuple(self._items), self._id, self._current)
        self._finish()
        self._acknowledge(self._partner, MavMissionResult.ACCEPTED, self._id)

    def _clear(self, frame: Frame, fields: Fields) -> None:
        if self._state is not State.IDLE:
            self._complain("WPM: IGN CLEAR CMD: Busy\t")
            return
        self._kind = fields["mission_type"]
        for kind in Kind:
            if self._kind in (kind, ALL):
                self._store.clear(kind)
        self._acknowledge((frame.system, frame.component), MavMissionResult.ACCEPTED)

    def _set_current(self, frame: Frame, fields: Fields) -> None:
        if self._state is not State.IDLE:
            self._complain("WPM: IGN WP CURR CMD: Busy\t")
        elif not self._store.set_current(fields["seq"]):
            self._complain("WPM: WP CURR CMD: Not in list\t")

    def _list_of(self, kind: int) -> tuple[Item, ...]:
        return self._store.items[Kind(kind)] if kind in tuple(Kind) else ()

    def _finish(self) -> None:
        if self._state is State.RECEIVING:
            self._store.transferring = False
        self._state = State.IDLE

    def _ask(self) -> None:
        """For the next item."""
        self._sent_us = self._now
        self._messages.ask(self._partner, self._kind, self._expected, self._whole)

    def _tell_count(self) -> None:
        self._sent_us = self._now
        self._messages.count(self._partner, self._kind, self._count)

    def _acknowledge(self, to: Peer, answer: MavMissionResult, identity: int = 0) -> None:
        self._messages.acknowledge(to, self._kind, answer, identity)

    def _complain(self, text: str) -> None:
        self._say(Text(MavSeverity.CRITICAL, text))
