"""MAV_CMD_USER_2 (31011): retractable thrusters, for ground stations' action buttons. param1 = 1: lower them. param1 =
2: retract them."""

from __future__ import annotations

from companion.core.decision import Outcome
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied
from companion.supervisor.supervisor import Supervisor


def user_2(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Lower or retract the retractable thrusters. 0, with which clients fill what they leave out, is refused.

    param1: 1 lowers them, 2 retracts them.
    """
    match request.whole(1):
        case 1:
            return supervisor.lower_thrusters(True, request.now_s)
        case 2:
            return supervisor.lower_thrusters(False, request.now_s)
    return denied("command 31011: give param 1, 1 lower or 2 retract")
