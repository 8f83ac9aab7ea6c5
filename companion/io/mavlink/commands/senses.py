"""MAV_CMD_USER_4 (31013): sensors that seem to lie, for ground stations' action buttons. param1 = 1: accept what they
say. param1 = 2: reject it."""

from __future__ import annotations

from companion.core.decision import Outcome
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied
from companion.supervisor.supervisor import Supervisor


def user_4(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Answer the boat's question whether sensors that seem to lie are right.

    param1: 1 accepts them: the estimate follows. 2 rejects them: they are used again when they agree with the others.
    """
    match request.whole(1):
        case 1:
            return supervisor.senses.request(True, request.now_s)
        case 2:
            return supervisor.senses.request(False, request.now_s)
    return denied("command 31013: give param 1, 1 accept or 2 reject")
