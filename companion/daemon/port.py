"""An open link, whatever it runs over."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from companion.vehicle import CompanionError

if TYPE_CHECKING:  # an address is refused without all of MAVLink
    from companion.mavlink.peer import Received, Source


DATAGRAM_MAX = 65535
"""bytes: the most UDP carries."""


class AddressError(CompanionError):
    """An address that is not one, or that cannot be opened (exit code 2)."""


class Port(Protocol):
    """An open link. ``stream``: bytes come in pieces rather than datagrams. ``called``: whom it talks to from the
    start; None: it listens. ``exposed``: others than this computer and what is wired to it can send here."""

    stream: bool
    called: Source | None
    exposed: bool

    def fileno(self) -> int:
        """The descriptor to wait for with others; -1: there is none at the moment."""

    def receive(self, timeout: float) -> list[Received]:
        """What has arrived, and from whom: waits at most ``timeout`` s for the first, then takes all there is."""

    def send(self, data: bytes, to: Source) -> None:
        """Send one frame. A peer that is away is no error."""

    def close(self) -> None:
        """Close the link."""

    def describe(self) -> str:
        """What is listened to, for a person."""
