"""Items of a mission that are done as soon as they are taken up, and that a jump leads back to: once a second each."""

from __future__ import annotations

import math

_AT_ONCE_S, _AGAIN_S = 0.2, 1.0


class Repeats:
    """Call `take_up` with each task and `reached` with each item that is done. Remembers when the present task was
    taken up, when each item may be taken up again, and when each was last said."""

    def __init__(self) -> None:
        self._taken_up_s = -math.inf
        self._again_s: dict[int, float] = {}
        self._said_s: dict[int, float] = {}

    def take_up(self, now_s: float) -> None:
        """A task is taken up."""
        self._taken_up_s = now_s

    def reached(self, seq: int, now_s: float) -> bool:
        """An item of the present task is done. Returns whether that is to be said."""
        at_once = now_s - self._taken_up_s < _AT_ONCE_S
        self._again_s[seq] = self._taken_up_s + _AGAIN_S if at_once else now_s
        if now_s - self._said_s.get(seq, -math.inf) < _AGAIN_S:
            return False
        self._said_s[seq] = now_s
        return True

    def too_soon(self, seq: int, now_s: float) -> bool:
        """Whether a task that begins with this item has to wait, as the item was done at once."""
        return now_s < self._again_s.get(seq, -math.inf)
