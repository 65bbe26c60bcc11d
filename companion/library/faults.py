"""What is wrong with several inputs, said all at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from companion.config.syntax.faults import ConfigError, Fault
from companion.daemon.port import AddressError

T = TypeVar("T")


class Faults:
    """Collects what is wrong with several inputs, to show it all at once."""

    def __init__(self) -> None:
        self._faults: list[Fault] = []

    def collect(self, read_one: Callable[[], T], option: str = "--connect") -> T | None:
        """The value of ``read_one``, or None where it has faults. ``option``: whose address it opens."""
        try:
            return read_one()
        except ConfigError as error:
            self._faults += error.faults
        except AddressError as error:
            self._faults.append(Fault(option, 0, "", str(error)))
        return None

    def add(self, fault: Fault) -> None:
        """One more."""
        self._faults.append(fault)

    def raise_any(self) -> None:
        """ConfigError, if anything was wrong."""
        if self._faults:
            raise ConfigError(self._faults)
