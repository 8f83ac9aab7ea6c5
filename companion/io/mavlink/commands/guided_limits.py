"""MAV_CMD_DO_GUIDED_LIMITS (222): limits of what another computer may do in Offboard."""

from __future__ import annotations

import math

from companion.core.decision import Outcome
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied
from companion.supervisor.supervisor import Supervisor


def do_guided_limits(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Limits of this stay in Offboard, or of the next one. At a limit the boat does what OFFB_LOSS_ACT says.

    param1: Longest time in seconds; 0 or NaN: no limit.
    param4: Largest distance from where the stay began, in metres; 0 or NaN: no limit. Params 2 and 3, heights, are
    ignored.
    """
    most_s, most_m = request.params[0], request.params[3]
    if not all(math.isnan(value) or 0.0 <= value < math.inf for value in (most_s, most_m)):
        return denied("limits (params 1 and 4) should be 0 or more")
    return supervisor.limit_offboard(most_s if most_s > 0.0 else None, most_m if most_m > 0.0 else None)
