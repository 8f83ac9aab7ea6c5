"""How fast a page is sent what waits for it: no faster than it says that it has it.

A slow network keeps what it cannot carry yet, for minutes, and a page would show that as the present. So a beat follows
each batch of messages, the page answers it, and of three batches that are on their way the first must arrive before a
fourth goes. What waits meanwhile is replaced by what is newer. The answers also tell how old data are when a page gets
them, and whether it still lives: a tab that its browser has frozen answers nothing.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

_MOST_UNDER_WAY = 3
_SILENT_S = 10.0  # of a page that no longer counts as open


class Pace:
    """The beats of one page. Remembers when those that are not answered yet were sent. `now_s`: of the clock of the
    event loop, in all calls."""

    def __init__(self, now_s: float) -> None:
        self._number = 0
        self._under_way: OrderedDict[int, float] = OrderedDict()
        self._heard_s = now_s
        self._room = asyncio.Event()
        self._room.set()
        self.round_s = 0.0
        """From a beat to its answer, of the last one that was answered."""

    def beat(self, now_s: float) -> dict[str, Any]:
        """The message that goes after a batch."""
        self._number += 1
        self._under_way[self._number] = now_s
        self._mind_room()
        return {"kind": "beat", "number": self._number, "at_s": now_s, "round_s": self.round_s}

    def take(self, message: Mapping[str, Any], now_s: float) -> None:
        """What a page has sent: its answer to a beat, or something else."""
        number = message.get("beat")
        sent_s = self._under_way.pop(number, None) if isinstance(number, int) else None
        if sent_s is not None:
            self._heard_s, self.round_s = now_s, now_s - sent_s
            self._mind_room()

    async def room(self) -> None:
        """Wait until another batch may go."""
        await self._room.wait()

    def lives(self, now_s: float) -> bool:
        """Whether the page has answered lately."""
        return now_s - self._heard_s < _SILENT_S

    def _mind_room(self) -> None:
        if len(self._under_way) < _MOST_UNDER_WAY:
            self._room.set()
        else:
            self._room.clear()
