"""MAV_CMD_USER_1 (31010): small corrections of what Hold holds, for ground stations' action buttons.

param1 = 1: nudge by param2 metres ahead, param3 metres to starboard, param4 degrees to starboard. param1 = 2: heading
param2, 0 to 360 degrees.
"""

from __future__ import annotations

import math

from companion.core.decision import Outcome
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied
from companion.supervisor.supervisor import Supervisor


def user_1(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Small corrections in Hold: a nudge, or another heading at the same point.

    param1: 1 nudges, 2 sets the heading.
    param2: Nudge: metres ahead, as the held heading has it. Heading: 0 to 360 degrees.
    param3: Nudge: metres to starboard. NaN: no change.
    param4: Nudge: degrees to starboard. NaN: no change.
    """
    match request.whole(1):
        case 1:
            forward_m, starboard_m, turn_deg = (0.0 if math.isnan(value) else value for value in request.params[1:4])
            return supervisor.nudge(forward_m, starboard_m, math.radians(turn_deg), request.now_s)
        case 2:
            if not 0.0 <= request.params[1] <= 360.0:
                return denied("param 2 of the heading should be 0 to 360 degrees")
            return supervisor.set_heading(math.radians(request.params[1]), request.now_s)
    return denied("command 31010: give param 1, 1 nudge or 2 heading")
