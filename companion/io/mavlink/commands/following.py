"""Commands about following a lead boat, for action buttons, scripts and clients that know them.

DO_FOLLOW (32): Follow mode. param1: system id of the leader; −1 or NaN: as FOLL_SYSID has it; 0: follow no more, hold.
MAV_CMD_USER_3 (31012): the station. param1: bearing in the leader's frame, degrees, 180 astern, 90 to starboard;
param2: distance, m. NaN keeps. DO_FOLLOW_REPOSITION (33): the station by params 6 and 7, offset from the leader, m;
MAVLink does not say in which frame: here the leader's, ahead and to starboard. Camera (params 1 to 4) and altitude
(param 5) mean nothing on a boat. In COMMAND_INT these offsets would be whole numbers: refused.
"""

from __future__ import annotations

import math

from companion.core.decision import ModeId, Outcome
from companion.io.mavlink.commands.request import DONE, Answer, CommandRequest, denied
from companion.supervisor.supervisor import Supervisor


def do_follow(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Follow mode, or the end of it.

    param1: System id of the leader, which becomes FOLL_SYSID; −1 or NaN: as FOLL_SYSID has it; 0: end Follow and hold.
    """
    match request.whole_or(1, -1):
        case -1:
            return supervisor.following.follow(None, request.now_s)
        case 0:
            following = supervisor.status(request.now_s).intended_mode is ModeId.FOLLOW
            return supervisor.hold_here(request.now_s) if following else DONE
        case int(system_id) if 1 <= system_id <= 255:
            return supervisor.following.follow(system_id, request.now_s)
    return denied("param 1 of follow should be a system id, -1 or 0")


def user_3(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """The follow position by bearing and distance.

    param1: Bearing in the leader's frame, degrees: 180 astern, 90 to starboard. NaN keeps it.
    param2: Distance, m, not less than FOLL_MIN_DIST. NaN keeps it.
    """
    bearing_deg, distance_m = request.params[0], request.params[1]
    if math.isnan(bearing_deg) and math.isnan(distance_m):
        return denied("command 31012: give a bearing, a distance or both")
    bearing_rad = None if math.isnan(bearing_deg) else math.radians(bearing_deg)
    return supervisor.following.set_follow_position(
        bearing_rad, None if math.isnan(distance_m) else distance_m, request.now_s
    )


def reposition(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """The follow position by an offset, as COMMAND_LONG only.

    param6: Metres ahead of the leader.
    param7: Metres to its starboard.
    """
    ahead_m, starboard_m = request.params[5], request.params[6]
    if request.frame is not None:
        return denied("send command 33 as COMMAND_LONG: it has offsets")
    if not math.isfinite(ahead_m) or not math.isfinite(starboard_m):
        return denied("params 6 and 7 of command 33 should be metres")
    return supervisor.following.set_follow_position(
        math.atan2(starboard_m, ahead_m), math.hypot(ahead_m, starboard_m), request.now_s
    )
