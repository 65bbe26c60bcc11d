"""``watch``: the live page of the companions on this computer."""

from __future__ import annotations

import re
import secrets
from pathlib import Path

from companion.cli.terminal import say
from companion.config.syntax.faults import ConfigError, Fault
from companion.vehicle import CompanionError

TOKEN_LEAST = 16
"""Characters of a token that is given."""


def watch(listen: str, token_file: Path | None) -> None:
    """Serve it until Ctrl-C. ConfigError: where, or with what token, makes no sense."""
    try:
        from companion.watch.server import is_loopback, serve
    except ImportError:
        raise CompanionError(
            "no live page: the library aiohttp is missing; pip install 'px4-path-companion[watch]'"
        ) from None
    host, port = _address(listen)
    token = None if token_file is None else _token(token_file)
    if token is None and not is_loopback(host):
        token = secrets.token_urlsafe(18)

    def ready(bound: int) -> None:
        name = host if host not in ("0.0.0.0", "[::]") else "THIS-COMPUTER"
        say(f"http://{name}:{bound}/" + ("" if token is None else f"?token={token}"))
        if not is_loopback(host):
            say(
                "warning: others on the network can reach this page; it is not encrypted, and who has the token sees it"
            )

    try:
        serve(host, port, token, ready)
    except OSError as error:
        raise ConfigError([Fault("--listen", 0, "", f"{listen} cannot be opened: {error.strerror}")]) from None
    except UnicodeError:  # a label of the name is empty or too long
        raise ConfigError([Fault("--listen", 0, "", f"{listen} cannot be opened: no host has this name")]) from None


def _address(listen: str) -> tuple[str, int]:
    found = re.fullmatch(r"(\[[0-9A-Fa-f:.]+\]|[\w.-]+):([0-9]{1,5})", listen)
    if found is None or int(found[2]) > 65535:
        raise ConfigError([Fault("--listen", 0, "", f"{listen!r} is no address; expected HOST:PORT")])
    return found[1], int(found[2])


def _token(file: Path) -> str:
    try:
        token = file.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError([Fault("--token-file", 0, "", f"{file} cannot be read: {error}")]) from None
    if not re.fullmatch(rf"[\w.~-]{{{TOKEN_LEAST},200}}", token):
        message = f"{file} holds no token; expected one line of {TOKEN_LEAST} or more letters, digits, - _ . ~"
        raise ConfigError([Fault("--token-file", 0, "", message)])
    return token
