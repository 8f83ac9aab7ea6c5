"""Others with this boat's own address.

Another vehicle: a command for one of them moves both, and ground stations draw one vehicle that jumps between two
places. A client whose ids were set to the boat's: nothing that it sends is heard, since our own packets may come back
too, through a router or another radio.

Those carry a time since boot that we had a moment ago; another vehicle was switched on at another time. A client sends
what a vehicle never does.
"""

from __future__ import annotations

from typing import Any

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.actions import CONTROLLING

_OF_CLIENTS = (
    frozenset(CONTROLLING)
    | {
        mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_LIST,
        mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_READ,
        mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_LIST,
    }
) - {  # a vehicle sends these too, as the answers to a download
    mavlink.MAVLINK_MSG_ID_MISSION_COUNT,
    mavlink.MAVLINK_MSG_ID_MISSION_ITEM,
    mavlink.MAVLINK_MSG_ID_MISSION_ITEM_INT,
}
_OF_VEHICLES = frozenset({mavlink.MAVLINK_MSG_ID_ATTITUDE, mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT})
_LATE_S, _EARLY_S = 60.0, 1.0  # an echo is younger, and never from the future
_COUNT, _SPAN_S, _GAP_S = 5, 5.0, 10.0
_AGAIN_S = 300.0
_WRAP_MS = 1 << 32


class Twin:
    """`take(message, now_s)` each packet with the boat's own address → whether to warn of another vehicle now, and
    `take_client` each that is addressed to the boat → whether to warn of a client.

    Remembers since when and how many packets came that are not ours, and when it warned. `patience`: factor on the
    delay of echoes, where vessel time runs fast.
    """

    def __init__(self, patience: float = 1.0) -> None:
        self._late_s = _LATE_S * patience
        self._since_s = self._last_s = 0.0
        self._count = 0
        self._warned_s: float | None = None
        self._warned_client_s: float | None = None

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

    def take_client(self, message: Any, now_s: float) -> bool:
        """What only clients send counts, at once."""
        if message.get_msgId() not in _OF_CLIENTS:
            return False
        if self._warned_client_s is not None and now_s - self._warned_client_s < _AGAIN_S:
            return False
        self._warned_client_s = now_s
        return True
