"""What a MAVLink message asks for, and the answers of the protocols where it is refused. Whether it is refused is
decided in `companion/supervisor/authority.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from companion.core.decision import Result
from companion.io.mavlink.wire import messages as mavlink
from companion.mission.plan import PlanResult
from companion.supervisor.authority import RequestedAction

REQUEST_OPERATOR_CONTROL = 32100  # MAV_CMD, which pymavlink's `common` lacks
DO_SEND_BANNER = 42428  # MAV_CMD of ArduPilot's dialect
HASH_CHECK = "_HASH_CHECK"  # PX4's name for the hash of all parameters; whoever sets it wants no list any more
_PERMISSION_DENIED = 3  # MAV_PARAM_ERROR
_NO_INDEX = -1

CONTROLLING: Mapping[int, RequestedAction] = {  # message ids; all others change nothing aboard
    mavlink.MAVLINK_MSG_ID_COMMAND_LONG: RequestedAction.COMMAND,
    mavlink.MAVLINK_MSG_ID_COMMAND_INT: RequestedAction.COMMAND,
    mavlink.MAVLINK_MSG_ID_SET_MODE: RequestedAction.COMMAND,
    mavlink.MAVLINK_MSG_ID_MISSION_SET_CURRENT: RequestedAction.COMMAND,
    mavlink.MAVLINK_MSG_ID_LOG_ERASE: RequestedAction.COMMAND,
    mavlink.MAVLINK_MSG_ID_MISSION_COUNT: RequestedAction.UPLOAD,
    mavlink.MAVLINK_MSG_ID_MISSION_WRITE_PARTIAL_LIST: RequestedAction.UPLOAD,
    mavlink.MAVLINK_MSG_ID_MISSION_ITEM: RequestedAction.UPLOAD,
    mavlink.MAVLINK_MSG_ID_MISSION_ITEM_INT: RequestedAction.UPLOAD,
    mavlink.MAVLINK_MSG_ID_MISSION_CLEAR_ALL: RequestedAction.UPLOAD,
    mavlink.MAVLINK_MSG_ID_MANUAL_CONTROL: RequestedAction.STICKS,
    mavlink.MAVLINK_MSG_ID_RC_CHANNELS_OVERRIDE: RequestedAction.STICKS,
    mavlink.MAVLINK_MSG_ID_SET_ATTITUDE_TARGET: RequestedAction.SETPOINT,
    mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: RequestedAction.SETPOINT,
    mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT: RequestedAction.SETPOINT,
    mavlink.MAVLINK_MSG_ID_PARAM_SET: RequestedAction.PARAMETER,
}
STREAMS = frozenset({RequestedAction.STICKS, RequestedAction.SETPOINT})  # many messages a second: one refusal is told
_COMMANDS = frozenset({mavlink.MAVLINK_MSG_ID_COMMAND_LONG, mavlink.MAVLINK_MSG_ID_COMMAND_INT})
_ITEMS = frozenset({mavlink.MAVLINK_MSG_ID_MISSION_ITEM, mavlink.MAVLINK_MSG_ID_MISSION_ITEM_INT})
GO_THERE = 2  # `current` of a mission item that ArduPilot takes for Guided, not for the mission
READING = frozenset(  # commands that change nothing aboard, so that nobody refuses them
    {
        mavlink.MAV_CMD_RUN_PREARM_CHECKS,
        mavlink.MAV_CMD_GET_HOME_POSITION,
        mavlink.MAV_CMD_GET_MESSAGE_INTERVAL,
        mavlink.MAV_CMD_SET_MESSAGE_INTERVAL,
        mavlink.MAV_CMD_REQUEST_MESSAGE,
        mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION,
        mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES,
        # QGroundControl and MAVSDK ask every component for these until one answers that it has no camera
        mavlink.MAV_CMD_REQUEST_CAMERA_INFORMATION,
        mavlink.MAV_CMD_REQUEST_CAMERA_SETTINGS,
        mavlink.MAV_CMD_REQUEST_STORAGE_INFORMATION,
        mavlink.MAV_CMD_REQUEST_CAMERA_CAPTURE_STATUS,
        mavlink.MAV_CMD_REQUEST_VIDEO_STREAM_INFORMATION,
        mavlink.MAV_CMD_REQUEST_VIDEO_STREAM_STATUS,
        mavlink.MAV_CMD_REQUEST_FLIGHT_INFORMATION,
        DO_SEND_BANNER,
    }
)


def action_of(message: Any) -> RequestedAction:
    """What a message asks for."""
    number = message.get_msgId()
    if number in _ITEMS and message.current == GO_THERE:
        return RequestedAction.COMMAND
    if number == mavlink.MAVLINK_MSG_ID_PARAM_SET and message.param_id == HASH_CHECK:
        return RequestedAction.READ
    if number not in _COMMANDS:
        return CONTROLLING.get(number, RequestedAction.READ)
    if message.command in READING:
        return RequestedAction.READ
    if message.command == REQUEST_OPERATOR_CONTROL:
        return RequestedAction.OPERATOR_CONTROL
    return RequestedAction.DISARM if _ends_motion(message) else RequestedAction.COMMAND


def _ends_motion(message: Any) -> bool:
    """Disarming and termination."""
    if message.command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
        return bool(message.param1 == 0.0)
    return bool(message.command == mavlink.MAV_CMD_DO_FLIGHTTERMINATION and message.param1 == 1.0)


def denials(message: Any, system: int, component: int) -> Sequence[Any]:
    """The negative acknowledgement of a message that is refused; empty where its protocol has none."""
    number = message.get_msgId()
    if number in _COMMANDS:
        return (
            mavlink.MAVLink_command_ack_message(
                message.command, Result.DENIED.value, target_system=system, target_component=component
            ),
        )
    if CONTROLLING.get(number) is RequestedAction.UPLOAD:
        return (mavlink.MAVLink_mission_ack_message(system, component, PlanResult.DENIED, message.mission_type),)
    if number == mavlink.MAVLINK_MSG_ID_PARAM_SET:
        name = message.param_id.encode("ascii", "replace")[:16]
        return (mavlink.MAVLink_param_error_message(system, component, name, _NO_INDEX, _PERMISSION_DENIED),)
    return ()
