"""MAV_CMD_CONDITION_YAW (115), CONDITION_DELAY (112) and CONDITION_DISTANCE (114), sent as commands."""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.decision import Outcome, Result
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied
from companion.supervisor.supervisor import Supervisor

_IN_MISSIONS = Answer(Outcome(Result.UNSUPPORTED, "conditions belong into a mission"))


def yaw(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """In Hold: another heading at the same point. The boat turns the shorter way, as fast as it does by itself.

    param1: Degrees: heading 0 to 360, or the angle to turn by.
    param2: Angular speed; ignored.
    param3: −1 to port, 1 to starboard. Of a heading: 0, or the shorter way, else it is refused.
    param4: 1: param1 is an angle to turn by, at most 180 degrees.
    """
    angle_deg, side, relative = request.params[0], request.whole_or(3, 0), request.whole_or(4, 0)
    if side not in (-1, 0, 1) or relative not in (0, 1):
        return denied("params 3 and 4 should be -1 to 1, and 0 or 1")
    if not 0.0 <= angle_deg <= (180.0 if relative else 360.0):
        return denied("param 1 should be 0 to 360, relative 0 to 180")
    now_rad = supervisor.parts.nav.yaw_rad
    if relative:
        return supervisor.set_heading(wrap_pi(now_rad + (side or 1) * math.radians(angle_deg)), request.now_s)
    turn_rad = wrap_pi(math.radians(angle_deg) - now_rad)
    if side * turn_rad < 0.0:
        return denied("the boat turns the shorter way only")
    return supervisor.set_heading(wrap_pi(now_rad + turn_rad), request.now_s)


def delay(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Unsupported as a command: there is nothing that it could hold back. In a mission it is."""
    return _IN_MISSIONS


def distance(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Unsupported as a command, as CONDITION_DELAY."""
    return _IN_MISSIONS
