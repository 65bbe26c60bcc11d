"""The live page in headless Chromium against a flight of the stand-in: screenshots to look at, and what it costs.

    python -m bench.watch_page OUT [SECONDS]

Flies a circle in real time, opens the page at a desktop's and a phone's size, ends and starts ``watch`` in between, and
prints what the page shows and the share of a core that ``watch`` takes with 4 viewers. Needs chromium on the path.
"""

from __future__ import annotations

import asyncio
import base64
import contextlib
import itertools
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from aiohttp import ClientSession

CHROMIUM = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--hide-scrollbars",
)  # fmt: skip
PORT, DEBUG_PORT = 8791, 9222
URL = f"http://127.0.0.1:{PORT}/"
SIZES = {"desktop": (1400, 900, False), "phone": (400, 1400, True)}
LOOK = """(() => ({ title: document.querySelector('h1')?.textContent,
  phase: document.querySelector('.phase')?.textContent,
  tiles: [...document.querySelectorAll('.tile')].map(t => t.innerText.replace(/\\n+/g, ' ')),
  banner: document.getElementById('banner').hidden ? null : document.getElementById('banner').textContent,
  wide: document.documentElement.scrollWidth > innerWidth,
  guards: document.querySelectorAll('.guard').length }))()"""


def watch() -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-m", "companion", "watch", "--listen", f"127.0.0.1:{PORT}"])


def cpu_seconds(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Page:
    """One tab, by Chromium's own protocol."""

    def __init__(self, socket: Any) -> None:
        self._socket = socket
        self._count = itertools.count(1)

    async def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        number = next(self._count)
        await self._socket.send_json({"id": number, "method": method, "params": parameters})
        while True:
            answer = await self._socket.receive_json()
            if answer.get("id") == number:
                return dict(answer.get("result", {}))

    async def looks(self) -> Any:
        answer = await self.call("Runtime.evaluate", expression=LOOK, returnByValue=True)
        return answer["result"].get("value")

    async def shoot(self, file: Path, width: int, height: int, mobile: bool) -> None:
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile}
        await self.call("Emulation.setDeviceMetricsOverride", **size)
        await asyncio.sleep(1.0)
        shot = await self.call("Page.captureScreenshot", format="png")
        file.write_bytes(base64.b64decode(shot["data"]))


@contextlib.asynccontextmanager
async def opened(session: ClientSession) -> AsyncIterator[Page]:
    for _ in range(300):
        with contextlib.suppress(OSError):
            async with session.put(f"http://127.0.0.1:{DEBUG_PORT}/json/new?{URL}") as answer:
                target = await answer.json()
            break
        await asyncio.sleep(0.2)
    async with session.ws_connect(target["webSocketDebuggerUrl"], max_msg_size=0) as socket:
        yield Page(socket)


async def view(session: ClientSession, seconds: float) -> int:
    """One more viewer: how many words it got."""
    words = 0
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(seconds), session.get(URL + "words", timeout=None) as answer:
            async for line in answer.content:
                words += line.startswith(b"data: ")
    return words


async def look(out: Path, seconds: float) -> None:
    server = watch()
    async with ClientSession() as session, opened(session) as page:
        await asyncio.sleep(seconds)
        print("page:", await page.looks())
        for name, size in SIZES.items():
            await page.shoot(out / f"{name}.png", *size)
            print(f"{name}:", await page.looks())
        before = cpu_seconds(server.pid)
        words = await asyncio.gather(*(view(session, 10.0) for _ in range(3)))
        print(f"4 viewers: {100.0 * (cpu_seconds(server.pid) - before) / 10.0:.1f} % of a core, words in 10 s: {words}")
        server.terminate()
        server.wait()
        await asyncio.sleep(5.0)
        print("without watch:", (await page.looks())["banner"])
        server = watch()
        await asyncio.sleep(8.0)
        print("with it again:", await page.looks())
    server.terminate()
    server.wait()


def main() -> None:
    out = Path(sys.argv[1] if len(sys.argv) > 1 else "watch_page")
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 15.0
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        os.environ["XDG_RUNTIME_DIR"] = place
        words = ["sim", "circle_r5", "--output", "rates", "--world", "outdoor", "--udp", "--no-report"]
        words += ["--duration", str(seconds + 60.0), "--record", f"{place}/flight"]
        flight = subprocess.Popen([sys.executable, "-m", "companion", *words], stderr=subprocess.DEVNULL)
        browser = subprocess.Popen(
            ["nice", "-n", "15", shutil.which("chromium") or "chromium", *CHROMIUM,
             f"--remote-debugging-port={DEBUG_PORT}", f"--user-data-dir={place}/chromium", "about:blank"],
            stderr=subprocess.DEVNULL,
        )  # fmt: skip
        try:
            asyncio.run(look(out, seconds))
        finally:
            for process in (browser, flight):
                process.terminate()
                process.wait()


if __name__ == "__main__":
    main()
