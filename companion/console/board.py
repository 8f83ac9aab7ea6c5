"""The board: what the console knows of the boat now, and the pages that it passes it on to.

A page gets every event, and of all else the newest: a page that stalls misses ticks, and holds up nobody.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from companion.console.strips import History, series_of
from companion.record.feed_schema import finite

_MOST_EVENTS = 500

Message = dict[str, Any]


def text_of(message: Mapping[str, Any]) -> str:
    """A message as pages get it."""
    return json.dumps(finite(message), separators=(",", ":"), allow_nan=False, default=str)


class Page:
    """What waits for one page. Of kinds other than events, only the newest."""

    def __init__(self) -> None:
        self._newest: dict[str, str] = {}
        self._events: deque[str] = deque(maxlen=_MOST_EVENTS)
        self._something = asyncio.Event()

    def put(self, kind: str, text: str) -> None:
        """Let a message wait."""
        if kind == "event":
            self._events.append(text)
        else:
            self._newest[kind] = text
        self._something.set()

    async def take(self, longest_s: float | None = None) -> list[str]:
        """What waits, once there is something: in the order in which a page can use it. Empty after `longest_s`."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(longest_s):
                await self._something.wait()
        self._something.clear()
        newest, self._newest = self._newest, {}
        events, self._events = list(self._events), deque(maxlen=_MOST_EVENTS)
        first = [newest.pop(kind) for kind in ("hello", "boat", "history") if kind in newest]
        return [*first, *events, *newest.values()]


class Board:
    """Takes the messages of a source (`take`), and passes them on. Remembers the newest of each kind."""

    def __init__(self, mode: Mapping[str, Any]) -> None:
        """`mode`: what pages are told of the console itself: whether it replays a log, whether it may command."""
        self.mode = dict(mode)
        self.hello: Message | None = None
        self.boat: Message | None = None
        self.tick: Message | None = None
        self.on_boat: Callable[[], None] = lambda: None
        self._taken_s = 0.0  # when the tick came
        self._history: History | None = None
        self._events: deque[str] = deque(maxlen=_MOST_EVENTS)
        self._others: dict[str, str] = {}
        self.pages: set[Page] = set()

    @property
    def thrusters(self) -> tuple[str, ...]:
        """Names of the thrusters; empty before the boat is known."""
        if self.hello is None:
            return ()
        return tuple(row["name"] for row in self.hello["configuration"]["thrusters"])

    def take(self, message: Message) -> None:
        """A message of the feed."""
        match message.get("kind"):
            case "hello":
                self._meet(message)
            case "boat":
                self.boat = message
                self._tell("boat", text_of(message))
                self.on_boat()
            case "event":
                text = text_of(message)
                self._events.append(text)
                self._tell("event", text)
            case "tick":
                self._show(message)

    def _meet(self, hello: Message) -> None:
        self.hello = {**hello, "console": self.mode, "series": self._series(hello)}
        self.boat = self.tick = None
        self._history = History(self.thrusters)
        self._events.clear()
        self._others.clear()
        self._tell("hello", text_of(self.hello))

    @staticmethod
    def _series(hello: Message) -> list[dict[str, str]]:
        names = [row["name"] for row in hello["configuration"]["thrusters"]]
        return [{"name": one.name, "strip": one.strip, "unit": one.unit} for one in series_of(names)]

    def _show(self, message: Message) -> None:
        if self._history is None:
            return
        message["sample"] = self._history.take(message)
        self._taken_s = time.monotonic()
        self.tick = message
        if self.pages:
            self._tell("tick", text_of(message))

    def tell(self, kind: str, content: Mapping[str, Any]) -> None:
        """A message of the console itself, kept for pages that come later."""
        text = text_of({**content, "kind": kind})
        self._others[kind] = text
        self._tell(kind, text)

    def _tell(self, kind: str, text: str) -> None:
        for page in self.pages:
            page.put(kind, text)

    def welcome(self, page: Page) -> None:
        """A page has been opened: all that is known."""
        self.pages.add(page)
        if self.hello is None:
            page.put("waiting", text_of({"kind": "waiting", "console": self.mode}))
            return
        page.put("hello", text_of(self.hello))
        if self.boat is not None:
            page.put("boat", text_of(self.boat))
        if self._history is not None:
            page.put("history", text_of(self._history.message()))
        for text in self._events:
            page.put("event", text)
        if self.tick is not None:
            page.put("tick", text_of({**self.tick, "age_s": time.monotonic() - self._taken_s}))
        for kind, text in self._others.items():
            page.put(kind, text)
