"""Ranges that another computer sends over a link: OBSTACLE_DISTANCE, DISTANCE_SENSOR."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from companion.core.readings import Ranges
from companion.io.mavlink import ranges
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.loop import Vessel


class RangeService:
    """In: OBSTACLE_DISTANCE, DISTANCE_SENSOR of the boat's own system, such as a computer aboard. Out: ranges to the
    supervisor. Those of other systems tell of water around other boats, those of an autopilot are our own that come
    back; a depth below is not taken from a link."""

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_OBSTACLE_DISTANCE: self._on_obstacle_distance,
            mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR: self._on_distance_sensor,
        }

    def update(self, now_s: float) -> None:
        """Nothing: the supervisor watches for ranges that fall silent."""

    def _on_obstacle_distance(self, message: Any, peer: Peer, now_s: float) -> None:
        if self._is_sensor(peer):
            self._take(ranges.ranges_of(message, _source(peer), now_s), now_s)

    def _on_distance_sensor(self, message: Any, peer: Peer, now_s: float) -> None:
        if self._is_sensor(peer):
            self._take(ranges.reading_of(message, _source(peer), now_s), now_s)

    def _is_sensor(self, peer: Peer) -> bool:
        return peer.system == self._hub.system and peer.component != mavlink.MAV_COMP_ID_AUTOPILOT1

    def _take(self, reading: object, now_s: float) -> None:
        if isinstance(reading, Ranges):
            self._vessel.supervisor.obstacle_heard(reading, now_s)


def _source(peer: Peer) -> str:
    return f"mavlink:{peer.system}.{peer.component}"
