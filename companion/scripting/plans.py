"""Missions of a script: MAVLink's mission protocol from the client's side (MAVLink guide, "Mission Protocol")."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.scripting.client import BOAT_COMPONENT, Client, ScriptError
from companion.scripting.values import Item, item_of

_TRANSFER_S = 60.0


def download(client: Client) -> list[Item]:
    """The mission that is aboard. Raises ScriptError."""
    system = client.boat_system
    request = mavlink.MAVLink_mission_request_list_message(system, BOAT_COMPONENT, 0)
    count = client.ask(request, lambda m: m.get_type() == "MISSION_COUNT" and m.mission_type == 0, "mission").count
    items = []
    for seq in range(count):
        one = mavlink.MAVLink_mission_request_int_message(system, BOAT_COMPONENT, seq, 0)
        message = client.ask(one, partial(_is_item, seq), f"mission item {seq}")
        items.append(item_of(message))
    client.send(mavlink.MAVLink_mission_ack_message(system, BOAT_COMPONENT, 0, 0))
    return items


def _is_item(seq: int, message: Any) -> bool:
    return bool(message.get_type() == "MISSION_ITEM_INT" and message.mission_type == 0 and message.seq == seq)


def upload(client: Client, items: Sequence[Item]) -> None:
    """Replace the mission. Raises ScriptError with the boat's words."""
    system, end_s = client.boat_system, client.door.now_s() + _TRANSFER_S
    message: Any = mavlink.MAVLink_mission_count_message(system, BOAT_COMPONENT, len(items), 0)
    while client.door.now_s() < end_s:
        answer = client.ask(message, _is_step, "mission upload")
        if answer.get_type() == "MISSION_ACK":
            if answer.type != mavlink.MAV_MISSION_ACCEPTED:
                raise ScriptError(f"mission refused: {client.reason(f'result {answer.type}')}")
            return
        if not 0 <= answer.seq < len(items):
            raise ScriptError(f"mission upload: the boat asks for item {answer.seq} of {len(items)}")
        message = _message(items[answer.seq], answer.seq, system)
    raise ScriptError(f"mission upload: not done within {_TRANSFER_S:g} s")


def _is_step(message: Any) -> bool:
    steps = ("MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK")
    return message.get_type() in steps and message.mission_type == 0


def _message(one: Item, seq: int, system: int) -> Any:
    params = (one.param1, one.param2, one.param3, one.param4)
    return mavlink.MAVLink_mission_item_int_message(
        system, BOAT_COMPONENT, seq, one.frame, one.command, int(seq == 0), 1, *params, one.x, one.y, one.z, 0
    )
