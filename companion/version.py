"""The version of this software, where every room may name it."""

from __future__ import annotations

__version__ = "0.1.0"
