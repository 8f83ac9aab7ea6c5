"""A client of the mission protocol at a desk: its items, and an upload to the end."""

from __future__ import annotations

import math
from typing import Any

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Peer
from companion.mission.plan import PlanItem
from tests.unit.io.mavlink.conftest import Desk

LAT, LON = 634_400_000, 103_989_999


def waypoint(seq: int, **more: Any) -> PlanItem:
    values: dict[str, Any] = {
        "command": 16,
        "frame": 3,
        "param1": 0.0,
        "param2": 0.0,
        "param3": 0.0,
        "param4": math.nan,
        "x": LAT + seq,
        "y": LON,
        "z": 50.0,
    }
    return PlanItem(seq=seq, **{**values, **more})


def item_int(item: PlanItem, kind: int = 0, seq: int | None = None) -> Any:
    head = (1, 1, item.seq if seq is None else seq, item.frame, item.command, item.current, item.autocontinue)
    return mavlink.MAVLink_mission_item_int_message(
        *head, item.param1, item.param2, item.param3, item.param4, item.x, item.y, item.z, kind
    )


def upload(desk: Desk, items: list[PlanItem], kind: int = 0, peer: Peer | None = None) -> Any:
    """Plays the client to the end, and returns the final answer."""
    peer = peer or desk.peer("qgc")
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, len(items), kind), peer)
    while True:
        ((to, reply),) = desk.heard()
        assert to == peer and (reply.target_system, reply.target_component) == (peer.system, peer.component)
        assert reply.mission_type == kind
        if reply.id == mavlink.MAVLINK_MSG_ID_MISSION_ACK:
            return reply
        assert reply.id == mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT
        desk.tell(item_int(items[reply.seq], kind, reply.seq), peer)


def item_float(item: PlanItem, target: int = 1) -> Any:
    head = (target, target, item.seq, item.frame, item.command, item.current, item.autocontinue)
    place = (item.x * 1e-7, item.y * 1e-7, item.z)
    return mavlink.MAVLink_mission_item_message(*head, 0.0, 0.0, 0.0, 0.0, *place, 0)
