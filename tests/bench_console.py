"""`make bench`, its rows of the feed and the console."""

from __future__ import annotations

import asyncio
import json
import os
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

from aiohttp import ClientSession, ClientWebSocketResponse

from companion.feed_view import look, open_feed
from companion.record.feed import SOCKET
from tests.afloat_beside import BoatBeside
from tests.protocol.process import Companion
from tests.waiting import wait_until

Line = Callable[[str, str, str], None]
_TICKS = 80
_ROUNDS = 4
_PAGES = 20


def feed_cost(folder: Path, line: Line) -> None:
    """What the feed costs the control thread, with one reader."""
    boat = BoatBeside(folder / "feed", logs=False)
    for _ in range(100):
        boat.step()
    feed = open_feed(boat.vessel, (), boat.state.directory)
    with socket.socket(socket.AF_UNIX) as reader:
        reader.connect(str(boat.state.directory / SOCKET))
        wait_until(lambda: feed.readers == 1, "the reader")
        offers, looks = [], []
        for _ in range(60):
            boat.step()
            tick = boat.vessel.last_tick
            assert tick is not None
            started_s = time.thread_time()
            look(boat.vessel, tick.t_s)
            looks.append(1e3 * (time.thread_time() - started_s))
            started_s = time.thread_time()
            feed.record(tick)
            offers.append(1e6 * (time.thread_time() - started_s))
    line("feed: a tick offered, on the control thread", f"{statistics.median(offers):.0f} us", "50 us")
    line("feed: a look at what changes seldom, once a second", f"{statistics.median(looks):.2f} ms", "2 ms")
    feed.close()
    boat.close()


def lateness(path: Path, ticks: int = _TICKS) -> tuple[list[float], int]:
    """Reads the feed. (Milliseconds by which each tick was made behind the earliest, by a clock that goes evenly; frames
    that this reader lost.)"""
    made, numbers = [], []
    with socket.socket(socket.AF_UNIX) as reader:
        reader.connect(str(path))
        with reader.makefile("rb") as file:
            while len(made) < ticks:
                message = json.loads(file.readline())
                if message["kind"] == "tick":
                    made.append(message["made_unix_ns"] / 1e6 - 1e3 * message["row"]["t_s"])
                    numbers.append(message["sequence"])
    earliest = min(made)
    return [one - earliest for one in made], numbers[-1] - numbers[0] + 1 - ticks


def console(folder: Path, line: Line) -> None:
    """Lateness of ticks alone, and with 20 pages, one of them stalled, and a stalled reader; the console's own needs."""
    with Companion(folder / "console"):
        state = folder / "console" / "state"
        feed = state / SOCKET
        command = [sys.executable, "-m", "companion", "console", "--port=0", f"--state={state}"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        url = process.stdout.readline().split()[1].rstrip("/")
        alone, one, many = _Late(), _Late(), _Late()
        used_s = passed_s = 0.0
        for _ in range(_ROUNDS):  # in turn, so that what else this machine does falls on all alike
            alone.take(feed)
            with socket.socket(socket.AF_UNIX) as stalled:
                stalled.connect(str(feed))
                with Pages(url, 1):
                    before_s, started_s = cpu_s(process.pid), time.monotonic()
                    one.take(feed)
                    used_s += cpu_s(process.pid) - before_s
                    passed_s += time.monotonic() - started_s
                with Pages(url, _PAGES):
                    many.take(feed)
        line("tick lateness: nobody but the measuring reader", alone.text, "-")
        line("tick lateness: a page, and a stalled reader", one.text, "the same")
        line(f"tick lateness: {_PAGES} pages, one stalled, a stalled reader", many.text, "the same")
        share = used_s / passed_s
        memory_mb = int(Path(f"/proc/{process.pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
        line("console: CPU with one page at 10 Hz", f"{100.0 * share:.1f} % of a core", "10 %")
        line(f"console: memory after {_PAGES} pages", f"{memory_mb:.0f} MB", "150 MB")
        _to_pixel(url, line)
        process.terminate()
        process.wait()


class _Late:
    """Milliseconds by which ticks were late, in all rounds."""

    def __init__(self) -> None:
        self._late_ms: list[float] = []
        self._lost = 0

    def take(self, feed: Path) -> None:
        late_ms, lost = lateness(feed)
        self._late_ms += late_ms
        self._lost += lost

    @property
    def text(self) -> str:
        ordered = sorted(self._late_ms)
        middle, most = statistics.median(ordered), ordered[int(0.95 * len(ordered))]
        return f"{middle:.1f} ms, 95 % {most:.1f} ms, {self._lost} lost"


def cpu_s(pid: int) -> float:
    """Processor time of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Pages:
    """So many pages on the console's stream; the first of several reads nothing."""

    def __init__(self, url: str, count: int) -> None:
        self._url, self._count = url, count
        self._ended = threading.Event()
        self._open = threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._all()))

    async def _all(self) -> None:
        async with ClientSession() as session:
            origin = {"Origin": self._url}
            pages = [await session.ws_connect(f"{self._url}/api/stream", headers=origin) for _ in range(self._count)]
            reading = pages[1:] if len(pages) > 1 else pages
            tasks = [asyncio.create_task(_read(page)) for page in reading]
            self._open.set()
            while not self._ended.is_set():
                await asyncio.sleep(0.1)
            for task in tasks:
                task.cancel()

    def __enter__(self) -> None:
        self._thread.start()
        self._open.wait()

    def __exit__(self, *reason: object) -> None:
        self._ended.set()
        self._thread.join()


async def _read(page: ClientWebSocketResponse) -> None:
    async for message in page:
        if (told := message.json())["kind"] == "beat":
            await page.send_json({"beat": told["number"]})


def _to_pixel(url: str, line: Line) -> None:
    """From the control thread to the drawn page, in a real browser, where there is one."""
    from tests.browser import Browser, has_browser

    if not has_browser:
        line("feed to pixel", "no browser here", "150 ms")
        return
    with tempfile.TemporaryDirectory() as place:
        browser = Browser(Path(place))
        browser.open(url)
        browser.wait("window.usvConsole?.model.delays_ms.length > 200", "200 frames")
        delays = sorted(browser.run("return usvConsole.model.delays_ms"))
        browser.close()
    text = f"{statistics.median(delays):.0f} ms, 95 % {delays[int(0.95 * len(delays))]:.0f} ms"
    line("feed to pixel, Chromium on this machine", text, "150 ms")
