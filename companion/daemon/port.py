"""An open link, whatever it runs over."""

from __future__ import annotations

from typing import Protocol

from companion.vehicle import CompanionError


class AddressError(CompanionError):
    """An address that is not one, or that cannot be opened (exit code 2)."""


class Port(Protocol):
    """An open link. ``stream``: bytes come in pieces rather than datagrams."""

    stream: bool

    def receive(self, timeout: float) -> list[bytes]:
        """What has arrived: waits at most ``timeout`` s for the first piece, then takes all there is."""

    def send(self, data: bytes) -> None:
        """Send one frame. A peer that is away is no error."""

    def close(self) -> None:
        """Close the link."""

    def describe(self) -> str:
        """What is listened to, for a person."""
