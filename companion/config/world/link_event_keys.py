"""What becomes of datagrams for a while, as a world file writes it."""

from __future__ import annotations

import difflib
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from companion.config.world.event_times import While
from companion.mavlink.dialect import BY_NAME
from companion.world import events
from companion.world.events import Event, When


class OnLink(While):
    """What every event on a link has."""

    way: Literal["both", "down", "up"] = "both"
    """which way: down (vehicle to companion), up (companion to vehicle), both"""
    link: Literal["companion", "ground_station", "both"] = "companion"
    """whose link: companion, ground_station, both"""
    messages: list[str] = Field(default_factory=list)
    """only these messages, by their MAVLink names, e.g. [HEARTBEAT, CURRENT_MODE]; all where absent"""

    @field_validator("messages")
    @classmethod
    def _are_known(cls, names: list[str]) -> list[str]:
        for name in names:
            if name not in BY_NAME:
                near = difflib.get_close_matches(name, BY_NAME, 1)
                meant = f"; did you mean {near[0]}?" if near else ""
                raise ValueError(f"{name!r} is no message of the common dialect{meant}")
        return names

    @property
    def traffic(self) -> tuple[When, bool, bool, bool, bool, frozenset[str]]:
        """The first fields of a LinkEvent."""
        return (
            self.when, self.way != "up", self.way != "down", self.link != "ground_station", self.link != "companion",
            frozenset(self.messages),
        )  # fmt: skip


class LinkCutModel(OnLink):
    """Nothing comes through."""

    kind: Literal["link_cut"]
    """the kind of event"""

    def event(self) -> Event:
        return events.LinkCut(*self.traffic)


class LinkDuplicateModel(OnLink):
    """Every datagram comes twice, as where a network has two routes."""

    kind: Literal["link_duplicate"]
    """the kind of event"""
    delay_s: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """how long after the first the second comes, in s"""

    def event(self) -> Event:
        return events.LinkDuplicate(*self.traffic, delay=self.delay_s)


class LinkRepeatModel(OnLink):
    """In the place of every datagram the first one of its message comes again, as from a relay that hangs."""

    kind: Literal["link_repeat"]
    """the kind of event"""

    def event(self) -> Event:
        return events.LinkRepeat(*self.traffic)


class LinkDelayModel(OnLink):
    """Everything comes later, in its order."""

    kind: Literal["link_delay"]
    """the kind of event"""
    delay_s: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """how much later, in s"""
    growth: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """how much later still for each second that it lasts, in s/s"""

    def event(self) -> Event:
        return events.LinkDelay(*self.traffic, delay=self.delay_s, growth=self.growth)


class LinkThinModel(OnLink):
    """A radio without room: of each message only so many a second come through."""

    kind: Literal["link_thin"]
    """the kind of event"""
    rate_hz: Annotated[float, Field(gt=0.0, le=1000.0)]
    """how many, in Hz"""

    def event(self) -> Event:
        return events.LinkThin(*self.traffic, rate=self.rate_hz)


class LinkRecutModel(OnLink):
    """The bytes come cut anew into datagrams, as from a serial-to-WiFi bridge that knows nothing of messages."""

    kind: Literal["link_recut"]
    """the kind of event"""
    size: Annotated[int, Field(ge=1, le=1400)] = 64
    """how many bytes the new datagrams have"""
    wait_s: Annotated[float, Field(ge=0.0, le=1.0)] = 0.005
    """after how long what does not fill one is sent all the same, in s"""

    @field_validator("messages")
    @classmethod
    def _has_no_messages(cls, names: Any) -> Any:
        if names:
            raise ValueError("cannot be given: bytes are cut anew whatever they say; expected no messages")
        return names

    def event(self) -> Event:
        return events.LinkRecut(*self.traffic, size=self.size, wait=self.wait_s)


LinkEventModel = LinkCutModel | LinkDuplicateModel | LinkRepeatModel | LinkDelayModel | LinkThinModel | LinkRecutModel
