"""Watches whether a follower keeps up with its leader. Announces when it falls behind, and when it catches up again."""

from __future__ import annotations

import math
from collections import deque

from companion.core.decision import TextKind
from companion.core.events import EventLog

_WINDOW_S = 30
_FURTHER_M = 1.5  # growth of the way to the follow position over the window: more than receivers make of it
_FAR_M = 5.0
_SLOWER = 0.9  # of the wanted speed: less is made where the thrust is at its end
_GAP_S = 1.0


class KeepingUp:
    """Call `update(off_m, wanted_mps, made_mps, now_s)` every tick under way. `off_m`: way left to the follow position.

    A boat falls behind where that way grows for half a minute although it wants to sail faster than it does: the leader
    is too fast for this wind, this current and these waves, or for the speed that the boat may sail. Remembers that way
    over the last 30 s, and whether it has been announced. The watch starts again after more than a second without
    `update`.
    """

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self._off_m: deque[float] = deque(maxlen=_WINDOW_S + 1)  # one a second
        self._next_s = 0.0
        self._last_s = -_GAP_S
        self._slow_s = 0
        self._behind = False

    def update(
        self, off_m: float, wanted_mps: float, made_mps: float, now_s: float, most_mps: float = math.inf
    ) -> None:
        """Record where the boat is and judge it once a second. Speeds over ground along the course to sail. `most_mps`:
        what `wanted_mps` is limited to."""
        if now_s - self._last_s > _GAP_S:
            self._off_m.clear()
            self._slow_s, self._behind, self._next_s = 0, False, now_s
        self._last_s = now_s
        if now_s < self._next_s:
            return
        self._next_s += 1.0
        self._off_m.append(off_m)
        wants_more = made_mps < _SLOWER * wanted_mps or wanted_mps >= most_mps
        self._slow_s = self._slow_s + 1 if wants_more else 0
        grown_m = off_m - self._off_m[0] if len(self._off_m) > _WINDOW_S else 0.0
        if not self._behind and self._slow_s >= _WINDOW_S and grown_m > _FURTHER_M and off_m > _FAR_M:
            self._behind = True
            text = f"Follow: cannot keep up, {off_m:.0f} m behind"
            self._events.say(now_s, TextKind.ATTENTION, "follow_behind", text)
        elif self._behind and (off_m < _FAR_M or grown_m < -_FURTHER_M):
            self._behind = False
            self._events.say(now_s, TextKind.ROUTINE, "follow_catches_up", "Follow: catching up")
