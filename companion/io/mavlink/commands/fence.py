"""MAV_CMD_DO_FENCE_ENABLE (207): the fence off for a while, and on again."""

from __future__ import annotations

from companion.core.decision import Outcome
from companion.io.mavlink.commands.request import DONE, Answer, CommandRequest, denied
from companion.supervisor.supervisor import Supervisor


def do_fence_enable(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Switch the fence off or on. Off, it is on again after disarming, a restart, or another fence.

    param1: 0 off, 1 on; 2 (the floor off) does nothing, because a boat's fence has no floor.
    """
    match request.whole(1):
        case 0 | 1 as on:
            return supervisor.switch_fence(bool(on), request.now_s)
        case 2:
            return DONE
    return denied("param 1 of the fence should be 0, 1 or 2")
