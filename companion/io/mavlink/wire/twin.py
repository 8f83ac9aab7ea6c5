"""Another vehicle with this boat's own system id: a command for one of them moves both, and ground stations draw one
vehicle that jumps between two places.

Our own packets may come back too, through a router or another radio. They carry a time since boot that we had a moment
ago; another vehicle was switched on at another time.
"""

from __future__ import annotations

from typing import Any

from companion.io.mavlink.wire import messages as mavlink

_OF_VEHICLES = frozenset({mavlink.MAVLINK_MSG_ID_ATTITUDE, mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT})
_LATE_S, _EARLY_S = 60.0, 1.0  # an echo is younger, and never from the future
_COUNT, _SPAN_S, _GAP_S = 5, 5.0, 10.0
_AGAIN_S = 300.0
_WRAP_MS = 1 << 32


class Twin:
    """`take(message, now_s)` each packet with the boat's own address → whether to warn now.

    Remembers since when and how many packets came that are not ours, and when it warned. `patience`: factor on the
    delay of echoes, where vessel time runs fast.
    """

    def __init__(self, patience: float = 1.0) -> None:
        self._late_s = _LATE_S * patience
        self._since_s = self._last_s = 0.0
        self._count = 0
        self._warned_s: float | None = None

    def take(self, message: Any, now_s: float) -> bool:
        """ATTITUDE and GLOBAL_POSITION_INT count, any other packet does not."""
        if message.get_msgId() not in _OF_VEHICLES:
            return False
        behind_s = ((int(now_s * 1000.0) - message.time_boot_ms + _WRAP_MS // 2) % _WRAP_MS - _WRAP_MS // 2) / 1000.0
        if -_EARLY_S <= behind_s <= self._late_s:
            return False
        if not self._count or now_s - self._last_s > _GAP_S:
            self._since_s, self._count = now_s, 0
        self._count, self._last_s = self._count + 1, now_s
        certain = self._count >= _COUNT and now_s - self._since_s >= _SPAN_S
        if not certain or (self._warned_s is not None and now_s - self._warned_s < _AGAIN_S):
            return False
        self._warned_s = now_s
        return True
