"""The operator commands that the supervisor answers by itself. A new command is one file and one row."""

from __future__ import annotations

from companion.io.mavlink.commands import (
    calibration,
    circle,
    conditions,
    fence,
    following,
    guided_limits,
    landing,
    motor_test,
    nudge,
    outputs,
    retraction,
    reverse,
    senses,
    trial,
)
from companion.io.mavlink.commands.request import CommandRow
from companion.io.mavlink.wire import messages as mavlink

ROWS: tuple[CommandRow, ...] = (
    CommandRow(mavlink.MAV_CMD_USER_1, nudge.user_1, once=True),
    CommandRow(mavlink.MAV_CMD_USER_2, retraction.user_2),
    CommandRow(mavlink.MAV_CMD_USER_3, following.user_3),
    CommandRow(mavlink.MAV_CMD_USER_4, senses.user_4, once=True),
    CommandRow(mavlink.MAV_CMD_USER_5, trial.user_5, once=True),
    CommandRow(mavlink.MAV_CMD_DO_FOLLOW, following.do_follow),
    CommandRow(mavlink.MAV_CMD_DO_FOLLOW_REPOSITION, following.reposition),
    CommandRow(mavlink.MAV_CMD_NAV_TAKEOFF, landing.take_off, once=True),
    CommandRow(mavlink.MAV_CMD_NAV_LAND, landing.land),
    CommandRow(mavlink.MAV_CMD_DO_GUIDED_LIMITS, guided_limits.do_guided_limits),
    CommandRow(mavlink.MAV_CMD_DO_FENCE_ENABLE, fence.do_fence_enable),
    CommandRow(mavlink.MAV_CMD_DO_SET_REVERSE, reverse.do_set_reverse),
    CommandRow(mavlink.MAV_CMD_CONDITION_YAW, conditions.yaw, once=True),
    CommandRow(mavlink.MAV_CMD_CONDITION_DELAY, conditions.delay),
    CommandRow(mavlink.MAV_CMD_CONDITION_DISTANCE, conditions.distance),
    CommandRow(mavlink.MAV_CMD_DO_ORBIT, circle.do_orbit, once=True),
    CommandRow(mavlink.MAV_CMD_PREFLIGHT_CALIBRATION, calibration.preflight, once=True),
    CommandRow(calibration.DO_START_MAG_CAL, calibration.start_compass, once=True),
    CommandRow(calibration.DO_ACCEPT_MAG_CAL, calibration.accept_compass),
    CommandRow(calibration.DO_CANCEL_MAG_CAL, calibration.cancel_compass),
    CommandRow(mavlink.MAV_CMD_ACTUATOR_TEST, motor_test.actuator_test),
    CommandRow(mavlink.MAV_CMD_DO_MOTOR_TEST, motor_test.do_motor_test, once=True),
    *(CommandRow(int(number), outputs.auxiliary, number in outputs.ONCE) for number in outputs.NUMBERS),
)
