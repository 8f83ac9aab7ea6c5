"""MAV_CMD_DO_SET_REVERSE (194): the mission's legs stern first."""

from __future__ import annotations

from companion.core.decision import Outcome
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied
from companion.supervisor.supervisor import Supervisor


def do_set_reverse(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Sail the rest of the mission stern first, or bow first, until an item or another mode changes that.

    param1: 1 stern first, while a mission is under way; 0 bow first.
    """
    match request.whole(1):
        case 0 | 1 as astern:
            return supervisor.sail_astern(bool(astern), request.now_s)
    return denied("param 1 of reverse should be 0 or 1")
