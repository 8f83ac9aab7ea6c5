"""MAV_CMD_USER_2 (31011): retractable thrusters, for ground stations' action buttons. param1 = 1: lower them. param1 = 2: retract them."""

from __future__ import annotations

from companion.core.types import Outcome
from companion.io.mavlink.command_request import Answer, Request, denied
from companion.io.mavlink.vessel import SupervisorFace


def user_2(supervisor: SupervisorFace, request: Request) -> Outcome | Answer:
    """What param1 asks for; 0, as clients fill what they do not mean, is refused."""
    match request.whole(1):
        case 1:
            return supervisor.lower_thrusters(True, request.now_s)
        case 2:
            return supervisor.lower_thrusters(False, request.now_s)
    return denied("param 1 of command 31011 should be 1 (lower) or 2 (retract)")
