"""The operator commands that the supervisor answers by itself. A new command is one file and one row."""

from __future__ import annotations

from companion.io.mavlink.commands import circle, following, nudge, outputs, retraction
from companion.io.mavlink.commands.request import CommandRow
from companion.io.mavlink.wire import messages as mavlink

ROWS: tuple[CommandRow, ...] = (
    CommandRow(mavlink.MAV_CMD_USER_1, nudge.user_1, once=True),
    CommandRow(mavlink.MAV_CMD_USER_2, retraction.user_2),
    CommandRow(mavlink.MAV_CMD_USER_3, following.user_3),
    CommandRow(mavlink.MAV_CMD_DO_FOLLOW, following.do_follow),
    CommandRow(mavlink.MAV_CMD_DO_FOLLOW_REPOSITION, following.reposition),
    CommandRow(mavlink.MAV_CMD_DO_ORBIT, circle.do_orbit, once=True),
    *(CommandRow(int(number), outputs.auxiliary, number in outputs.ONCE) for number in outputs.NUMBERS),
)
