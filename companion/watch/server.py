"""The live page over HTTP: the page, a stream of words (server-sent events), the drawing of a companion.

Loopback unless told otherwise; beyond it every request needs the token. It only answers GET, and nothing that a viewer
sends reaches a companion. A viewer on a bad link gets fewer words and never holds up another: each has only the latest.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import ipaddress
import json
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from importlib.resources import files

from aiohttp import web
from aiohttp.http import HttpProcessingError
from aiohttp.typedefs import Middleware

from companion.watch.flights import Flights

RATE, IDLE_RATE = 20.0, 4.0
"""Hz at which companions are read: with viewers, and without any."""
VIEWERS_MAX = 32
PATIENCE = 10.0
"""s after which a viewer that takes nothing is let go: its page comes back by itself."""
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}
LOCAL_NAMES = frozenset({"localhost", "127.0.0.1", "[::1]"})

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]
"""What answers a request."""


def is_loopback(host: str) -> bool:
    """Whether only this computer reaches an address."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


class Board:
    """The latest word about every companion, for as many viewers as there are."""

    def __init__(self, flights: Flights) -> None:
        self.flights = flights
        self.latest = b"[]"
        self.viewers = 0
        self._changed = asyncio.Condition()
        self._awake = asyncio.Event()

    async def run(self) -> None:
        """Read and tell, for ever."""
        while True:
            found = await asyncio.to_thread(self.flights.look)
            self.latest = json.dumps(found, separators=(",", ":"), allow_nan=False).encode()
            async with self._changed:
                self._changed.notify_all()
            self._awake.clear()
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._awake.wait(), 1.0 / (RATE if self.viewers else IDLE_RATE))

    async def words(self) -> AsyncIterator[bytes]:
        """The latest, and the latest again each time there is a new one; what is missed is missed."""
        self.viewers += 1
        self._awake.set()
        try:
            while True:
                yield self.latest
                async with self._changed:
                    await self._changed.wait()
        finally:
            self.viewers -= 1


def _is_ours(record: logging.LogRecord) -> bool:
    """Whether a log record is about us. What is no HTTP at all is answered with 400; anybody who can reach the port
    could otherwise fill the terminal with tracebacks."""
    return not (record.exc_info and isinstance(record.exc_info[1], HttpProcessingError))


BOARD = web.AppKey("board", Board)


def application(flights: Flights, token: str | None) -> web.Application:
    """The server. ``token``: what every request must carry; None: only this computer reaches it."""
    logging.getLogger("aiohttp.server").addFilter(_is_ours)
    app = web.Application(middlewares=[_guard(token)], client_max_size=0)
    app[BOARD] = Board(flights)
    app.cleanup_ctx.append(_reading)
    app.router.add_get("/", _page)
    app.router.add_get("/words", _words)
    app.router.add_get("/drawing/{pid:[0-9]{1,7}}", _drawing)
    return app


async def _reading(app: web.Application) -> AsyncIterator[None]:
    task = asyncio.create_task(app[BOARD].run())
    yield
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task


def _guard(token: str | None) -> Middleware:
    @web.middleware
    async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
        if token is not None:
            if not hmac.compare_digest(request.query.get("token", "").encode(), token.encode()):
                return _refusal(403, "the token is missing or wrong; open the address that companion watch printed")
        elif request.host.rpartition(":")[0] not in LOCAL_NAMES and request.host not in LOCAL_NAMES:
            return _refusal(403, "this page is served to this computer only, as localhost")  # DNS rebinding
        try:
            return await handler(request)
        except web.HTTPException as error:
            return _refusal(error.status, f"{error.reason}; expected GET / , /words or /drawing/PID")

    return guard


def _refusal(status: int, words: str) -> web.Response:
    return web.Response(status=status, text=words + "\n", headers=HEADERS)


async def _page(request: web.Request) -> web.StreamResponse:
    text = files(__package__).joinpath("page.html").read_text(encoding="utf-8")
    return web.Response(text=text, content_type="text/html", headers=HEADERS)


async def _drawing(request: web.Request) -> web.StreamResponse:
    found = request.app[BOARD].flights.drawing(int(request.match_info["pid"]))
    if found is None:
        return _refusal(404, "no such companion")
    return web.json_response(found, headers=HEADERS)


async def _words(request: web.Request) -> web.StreamResponse:
    board = request.app[BOARD]
    if board.viewers >= VIEWERS_MAX:
        return _refusal(503, f"{VIEWERS_MAX} viewers are here already; close one")
    answer = web.StreamResponse(headers={**HEADERS, "Content-Type": "text/event-stream"})
    await answer.prepare(request)
    with contextlib.suppress(ConnectionError, TimeoutError):  # it has left, or takes nothing
        async with contextlib.aclosing(board.words()) as words:  # type: ignore[type-var]
            async for word in words:
                async with asyncio.timeout(PATIENCE):
                    await answer.write(b"data: " + word + b"\n\n")
    return answer


def serve(host: str, port: int, token: str | None, ready: Callable[[int], None]) -> None:
    """Serve until Ctrl-C or SIGTERM; ``ready`` is told the port. OSError: the address cannot be opened."""
    asyncio.run(_serve(host, port, token, ready))


async def _serve(host: str, port: int, token: str | None, ready: Callable[[int], None]) -> None:
    runner = web.AppRunner(application(Flights(), token), access_log=None, handle_signals=True, shutdown_timeout=0.5)
    await runner.setup()
    try:
        site = web.TCPSite(runner, host.strip("[]"), port)
        await site.start()
        ready(runner.addresses[0][1])
        await asyncio.Event().wait()
    except web.GracefulExit:
        pass
    finally:
        await runner.cleanup()
