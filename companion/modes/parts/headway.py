"""Watches whether a boat under way makes headway. Announces when it makes none, and when it makes headway again."""

from __future__ import annotations

from collections import deque

from companion.core.decision import TextKind
from companion.core.events import EventLog

_WINDOW_S = 40
_AGAIN_S = 15
_LEAST_MPS = 0.02  # mean speed made good below which the boat makes no headway
_LEAST_SHARE = 0.25  # share of the wanted speed that limits _LEAST_MPS at low speeds
_SMOOTHING_S = 3.0
_GAP_S = 1.0


class Headway:
    """Call `update(way_m, speed_mps, now_s)` every tick under way. `way_m` grows as the boat nears its destination.

    Remembers the way made in the last 40 s, and since when the boat is stuck. The watch starts again after `reset`, or
    after more than a second without `update`. `rebase` continues the watch with a new origin of `way_m`.
    """

    def __init__(self, name: str, events: EventLog) -> None:
        """`name` is the mode's name in the texts."""
        self._name = name
        self._events = events
        self.reset()

    def reset(self) -> None:
        """Forget all way made and start the watch again."""
        self._last_s = -_GAP_S
        self._made: deque[float] = deque(maxlen=_WINDOW_S + 1)  # one a second
        self._next_s = self._smooth_m = self._way_m = 0.0
        self._last_way_m: float | None = None
        self._stuck_s: float | None = None

    def rebase(self) -> None:
        """Continue on another route: the next `way_m` counts from a new origin."""
        self._last_way_m = None

    def stuck_s(self, now_s: float) -> float | None:
        """Seconds without headway, 0 while there is some. None while not under way, or before 40 s under way."""
        if now_s - self._last_s > _GAP_S or len(self._made) <= _WINDOW_S:
            return None
        return 0.0 if self._stuck_s is None else now_s - self._stuck_s

    def is_stuck(self, now_s: float) -> bool:
        """Whether the boat has made no headway for 40 s."""
        return (self.stuck_s(now_s) or 0.0) > 0.0

    def update(self, way_m: float, speed_mps: float, now_s: float) -> None:
        """Record the way made so far and judge it once a second. `speed_mps` is the wanted speed."""
        if now_s - self._last_s > _GAP_S:
            self.reset()
        elif self._last_way_m is not None:
            self._way_m += way_m - self._last_way_m
            self._smooth_m += (self._way_m - self._smooth_m) * min(1.0, (now_s - self._last_s) / _SMOOTHING_S)
        self._last_s, self._last_way_m = now_s, way_m
        if now_s < self._next_s:
            return
        self._next_s = now_s + 1.0 if not self._made else self._next_s + 1.0
        self._made.append(self._smooth_m)
        self._judge(min(_LEAST_MPS, _LEAST_SHARE * speed_mps), now_s)

    def _judge(self, least_mps: float, now_s: float) -> None:
        made = self._made
        lately = len(made) > _AGAIN_S and made[-1] - made[-1 - _AGAIN_S] > 2.0 * least_mps * _AGAIN_S
        if (
            self._stuck_s is None
            and len(made) > _WINDOW_S
            and not lately
            and made[-1] - made[0] < least_mps * _WINDOW_S
        ):
            self._stuck_s = now_s - _WINDOW_S
            self._events.say(
                now_s, TextKind.ATTENTION, "no_headway", f"{self._name}: no headway: wind, current or obstacle"
            )
        elif self._stuck_s is not None and lately:
            self._stuck_s = None
            self._made = deque([made[-1]], _WINDOW_S + 1)  # the way made while stuck no longer counts
            self._events.say(now_s, TextKind.ROUTINE, "headway_again", f"{self._name}: making headway again")
