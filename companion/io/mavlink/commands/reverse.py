"""MAV_CMD_DO_SET_REVERSE (194): this boat follows its path bow first."""

from __future__ import annotations

from companion.core.decision import Outcome, Result
from companion.io.mavlink.commands.request import DONE, Answer, CommandRequest, denied
from companion.supervisor.supervisor import Supervisor


def do_set_reverse(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Sail ahead, as always; astern is not supported.

    param1: 0 ahead. 1, astern, is answered with UNSUPPORTED: path tracking and the hull model know motion ahead only.
    """
    match request.whole(1):
        case 0:
            return DONE
        case 1:
            return Answer(Outcome(Result.UNSUPPORTED, "no path is sailed astern here"))
    return denied("param 1 of reverse should be 0 or 1")
