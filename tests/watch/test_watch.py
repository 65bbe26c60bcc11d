"""The live page: what a flight publishes, what a viewer is sent, and who is let in. No browser: see bench/watch_page."""

from __future__ import annotations

import asyncio
import json
import os
import socket
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from aiohttp.test_utils import TestClient, TestServer
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.daemon import live
from companion.daemon.live import Publisher, live_document
from companion.daemon.status_file import StatusFile
from companion.vehicle import OutputLevel
from companion.watch import server
from companion.watch.flights import Flights
from companion.watch.server import application, is_loopback
from tests.support.flights import Flown, flight

ABOUT = {"mission": "circle", "vehicle": "x500", "output": "rates", "link": "UDP 127.0.0.1:14540", "record": "/f"}
TOKEN = "a-token-of-this-test"


@pytest.fixture
def own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A computer of its own."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("RUNTIME_DIRECTORY", raising=False)
    monkeypatch.setattr("companion.daemon.status_file.SHARED", ())
    return tmp_path / "companion"


@pytest.fixture(scope="module")
def flown() -> Flown:
    return flight(level=OutputLevel.RATES, duration=2.0)


def publish(flown: Flown) -> tuple[StatusFile, Publisher]:
    notice = StatusFile(ABOUT)
    notice.write({"phase": "follow", "notes": ["join -> follow: on the path"]})
    said: deque[str] = deque()
    publisher = Publisher(flown.conductor, said, lambda: 0.0)
    publisher.work(flown.conductor.last.now)  # type: ignore[union-attr]
    assert not said
    return notice, publisher


def served(token: str | None, visit: Callable[[TestClient[Any, Any]], Awaitable[None]]) -> None:
    async def run() -> None:
        async with TestClient(TestServer(application(Flights(), token))) as client:
            await visit(client)

    asyncio.run(run())


async def words(client: TestClient[Any, Any], path: str = "/words") -> AsyncIterator[list[dict[str, Any]]]:
    async with client.get(path) as answer:
        assert answer.status == 200 and answer.content_type == "text/event-stream"
        async for line in answer.content:
            if line.startswith(b"data: "):
                yield json.loads(line[6:])


def test_a_flight_says_where_it_is_and_how_well_it_holds(flown: Flown) -> None:
    tick = flown.conductor.last
    assert tick is not None and tick.memory.state is not None and tick.memory.path.progress is not None
    said = live_document(flown.conductor, tick.now + 0.5)
    assert said is not None
    json.dumps(said, allow_nan=False)
    assert said["p_n"] == pytest.approx(tick.memory.state.p_n, abs=1e-4)
    assert said["path_error_m"] == pytest.approx(tick.memory.path.progress.path_error, abs=1e-4)
    assert said["phase"] == tick.memory.phase.value
    assert said["link"]["age_s"] == pytest.approx(tick.now + 0.5 - (tick.memory.state_at or 0.0), abs=1e-3)
    tilt = next(guard for guard in said["guards"] if guard["name"] == "tilt")
    assert tilt["used"] == pytest.approx(tilt["value"] / tilt["limit"], abs=1e-3)


def test_it_is_published_beside_the_status_and_gone_with_the_flight(own: Path, flown: Flown) -> None:
    notice, publisher = publish(flown)
    pid = os.getpid()
    assert {file.name for file in own.iterdir()} == {f"{pid}.json", f"{pid}.live", f"{pid}.path"}
    path = json.loads((own / f"{pid}.path").read_text())
    assert len(path["points"]) == live.PATH_POINTS and path["closed"]
    assert all(abs((n**2 + e**2) ** 0.5 - 5.0) < 0.01 for n, e, _ in path["points"])
    publisher.remove()
    notice.remove()
    assert list(own.iterdir()) == []


def test_viewers_see_the_flight_its_path_and_its_trail(own: Path, flown: Flown) -> None:
    publish(flown)

    async def visit(client: TestClient[Any, Any]) -> None:
        async for received in words(client):
            if received:
                break
        (one,) = received
        assert one["about"]["mission"] == "circle" and one["running"] and one["state"] == "" and one["has_path"]
        assert one["notes"] == ["join -> follow: on the path"]
        assert one["live"]["p_n"] == live_document(flown.conductor, 0.0)["p_n"]  # type: ignore[index]
        async with client.get(f"/drawing/{one['pid']}") as answer:
            drawing = await answer.json()
        assert len(drawing["path"]["points"]) == live.PATH_POINTS and drawing["trail"] == [one["live"]["p_n"]]
        async with client.get("/") as answer:
            page = await answer.text()
            policy = answer.headers["Content-Security-Policy"]
        assert (
            "default-src 'none'" in policy
            and "http" not in page.replace("<!doctype html>", "").lower().split("<script>")[0]
        )
        for path in ("/drawing/7", "/nothing", "/drawing/../x"):
            async with client.get(path) as answer:
                assert answer.status == 404 and (await answer.text()).count("\n") == 1
        async with client.post("/words") as answer:
            assert answer.status == 405

    served(None, visit)


def test_a_flight_that_ends_and_one_that_begins_are_seen(
    own: Path, flown: Flown, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("companion.watch.flights.STATUS_PERIOD", 0.0)
    flights = Flights()
    assert flights.look() == []
    notice, publisher = publish(flown)
    assert len(flights.look()) == 1
    publisher.remove()
    assert flights.look()[0]["live"] is None
    notice.remove()
    assert flights.look() == [] and flights.drawing(os.getpid()) is None
    publish(flown)
    assert flights.look()[0]["live"] is not None


def test_only_who_has_the_token_is_let_in(own: Path) -> None:
    async def visit(client: TestClient[Any, Any]) -> None:
        for path in ("/", "/words", "/drawing/1"):
            for query in ("", "?token=", "?token=wrong", "?token=%ff"):
                async with client.get(path + query) as answer:
                    assert answer.status == 403 and "companion watch printed" in await answer.text()
        async with client.get(f"/?token={TOKEN}") as answer:
            assert answer.status == 200
        async for received in words(client, f"/words?token={TOKEN}"):
            assert received == []
            break

    served(TOKEN, visit)


def test_a_page_of_somebody_elses_name_reads_nothing(own: Path) -> None:
    async def visit(client: TestClient[Any, Any]) -> None:
        for host, status in (("evil.example:8765", 403), ("localhost:8765", 200), ("127.0.0.1", 200)):
            async with client.get("/", headers={"Host": host}) as answer:
                assert answer.status == status, host

    served(None, visit)


def test_a_viewer_that_takes_nothing_is_let_go_and_holds_up_nobody(
    own: Path, flown: Flown, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server, "PATIENCE", 0.3)
    monkeypatch.setattr(server, "RATE", 400.0)
    notice, _ = publish(flown)
    notice.write({"notes": ["x" * 250] * 20})  # 5 kB a word fill a stalled viewer's socket soon

    async def visit(client: TestClient[Any, Any]) -> None:
        board = client.app[server.BOARD]  # type: ignore[union-attr]
        reader, writer = await asyncio.open_connection(client.host, client.port, limit=1)
        writer.write(b"GET /words HTTP/1.1\r\nHost: localhost\r\n\r\n")
        count = 0
        async for _ in words(client):
            count += 1
            if count > 50 and board.viewers == 1:
                break
        writer.close()
        del reader

    async def in_time(client: TestClient[Any, Any]) -> None:
        await asyncio.wait_for(visit(client), 60.0)

    served(None, in_time)


def test_not_more_viewers_than_fit(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "VIEWERS_MAX", 1)

    async def visit(client: TestClient[Any, Any]) -> None:
        async for _ in words(client):
            async with client.get("/words") as answer:
                assert answer.status == 503 and "close one" in await answer.text()
            break

    served(None, visit)


def test_rubbish_beside_a_status_is_no_flight(own: Path, flown: Flown) -> None:
    publish(flown)
    for text in ("", "{", "[1]", '{"p_n": NaN}', '{"p_n": ["<b>", 1, 2]}', "[" * 5000):
        (own / f"{os.getpid()}.live").write_text(text)
        (received,) = Flights().look()
        json.dumps(received, allow_nan=False)
        assert received["live"] is None or received["live"]["p_n"] == ["<b>", 1, 2]


@pytest.mark.parametrize(
    "sent", [b"\x16\x03\x01\xff\x00\n\n", b"GET / HTTP/1.1\r\n\r\n", b"GET /" + b"a" * 20_000 + b" HTTP/1.1\r\nHost: x\r\n\r\n",
             b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 500 + b"\r\n", b"GET / HTTP/7.7\r\nHost: localhost\r\n\r\n"],
)  # fmt: skip
def test_what_is_no_http_is_refused_without_a_traceback(sent: bytes, caplog: pytest.LogCaptureFixture) -> None:
    async def visit(client: TestClient[Any, Any]) -> None:
        reader, writer = await asyncio.open_connection(client.host, client.port)
        writer.write(sent)
        assert b" 400 " in await reader.readline()
        writer.close()
        async with client.get("/") as answer:  # and the next one is served
            assert answer.status == 200

    served(None, visit)
    assert not caplog.records


def test_where_it_listens() -> None:
    assert all(map(is_loopback, ("localhost", "127.0.0.1", "127.1.2.3", "[::1]")))
    assert not any(map(is_loopback, ("0.0.0.0", "[::]", "192.168.1.4", "drone.local")))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--listen", "8765"], "expected HOST:PORT"),
        (["--listen", "127.0.0.1:99999"], "expected HOST:PORT"),
        (["--listen", "a..b:8765"], "no host has this name"),
        (["--token-file", "none"], "cannot be read"),
        (["--token-file", "short"], "holds no token"),
    ],
)
def test_bad_input_is_answered_in_one_line(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short").write_text("abc\n")
    received = CliRunner().invoke(app, ["watch", *words])
    assert said in str(received.exception) and "\n" not in str(received.exception)


def test_an_address_that_is_taken_is_named() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        received = CliRunner().invoke(app, ["watch", "--listen", f"127.0.0.1:{taken.getsockname()[1]}"])
    assert "cannot be opened" in str(received.exception)
