"""Which ground stations may command: those of a list, and of them the one that has taken control, as long as one has.

By the number of the message's sender, which anybody can claim where packets are not signed. Requests for control: MAVLink's development.xml,
MAV_CMD_REQUEST_OPERATOR_CONTROL and CONTROL_STATUS. Reading is everybody's; disarming and termination are those of everybody on the list, at any time: who sees
the danger first must not have to ask.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from companion.core.types import ACCEPTED, Outcome, Result
from companion.io.mavlink import messages as mavlink
from companion.mission.plan import PlanResult

REQUEST_OPERATOR_CONTROL = 32100  # MAV_CMD, which pymavlink's `common` lacks
_PERMISSION_DENIED = 3  # MAV_PARAM_ERROR
_NO_INDEX = -1
_COMMANDS = frozenset({mavlink.MAVLINK_MSG_ID_COMMAND_LONG, mavlink.MAVLINK_MSG_ID_COMMAND_INT})
_UPLOADS = frozenset(
    {
        mavlink.MAVLINK_MSG_ID_MISSION_COUNT,
        mavlink.MAVLINK_MSG_ID_MISSION_WRITE_PARTIAL_LIST,
        mavlink.MAVLINK_MSG_ID_MISSION_ITEM,
        mavlink.MAVLINK_MSG_ID_MISSION_ITEM_INT,
        mavlink.MAVLINK_MSG_ID_MISSION_CLEAR_ALL,
    }
)
_STICKS = frozenset({mavlink.MAVLINK_MSG_ID_MANUAL_CONTROL, mavlink.MAVLINK_MSG_ID_RC_CHANNELS_OVERRIDE})
_SETPOINTS = frozenset(
    {
        mavlink.MAVLINK_MSG_ID_SET_ATTITUDE_TARGET,
        mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED,
        mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT,
    }
)
_CONTROLLING = frozenset(
    {
        *_COMMANDS, *_UPLOADS, *_STICKS, *_SETPOINTS,
        mavlink.MAVLINK_MSG_ID_SET_MODE,
        mavlink.MAVLINK_MSG_ID_PARAM_SET,
        mavlink.MAVLINK_MSG_ID_MISSION_SET_CURRENT,
        mavlink.MAVLINK_MSG_ID_LOG_ERASE,
    }
)  # fmt: skip
_READING = frozenset(
    {
        mavlink.MAV_CMD_REQUEST_MESSAGE,
        mavlink.MAV_CMD_SET_MESSAGE_INTERVAL,
        mavlink.MAV_CMD_GET_MESSAGE_INTERVAL,
        mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES,
        mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION,
        mavlink.MAV_CMD_GET_HOME_POSITION,
        mavlink.MAV_CMD_RUN_PREARM_CHECKS,
    }
)


class Operators:
    """Remembers who has control, whether another may take it over, and whom it has told why they are not obeyed."""

    def __init__(self, listed: Collection[int] = ()) -> None:
        """`listed`: the only systems that may command; none: all may."""
        self._listed = frozenset(listed)
        self.in_control = 0  # 0: nobody, so that all who are listed may command
        self.takeover = True
        self._heard_s = 0.0
        self._told: set[tuple[int, str]] = set()

    def heard(self, system: int, now_s: float) -> None:
        if system == self.in_control:
            self._heard_s = now_s

    def refusal(self, message: Any, system: int, exempt: bool = False) -> str | None:
        """Why a message addressed to us is not obeyed; None where it is. `exempt`: its sender steers by another right, as the lead boat's crew does."""
        number = message.get_msgId()
        if number not in _CONTROLLING or (not self._listed and not self.in_control):
            return None
        if number in _COMMANDS and message.command in _READING:
            return None
        if exempt and number in _STICKS:
            return None
        if self._listed and system not in self._listed:
            return f"system {system} may not command here"
        if self.in_control in (0, system):
            return None
        if number in _COMMANDS and (message.command == REQUEST_OPERATOR_CONTROL or _ends_motion(message)):
            return None
        return f"system {self.in_control} has control"

    def tells(self, message: Any, system: int, reason: str) -> bool:
        """Whether that should be said: once of what comes in streams."""
        if message.get_msgId() not in _STICKS | _SETPOINTS:
            return True
        if (system, reason) in self._told:
            return False
        self._told.add((system, reason))
        return True

    def request(self, system: int, takeover: bool, now_s: float) -> Outcome:
        """Control for a system that may command. FAILED: who has it has to release it, or to allow a takeover."""
        if self.in_control not in (0, system) and not self.takeover:
            return Outcome(Result.FAILED, f"system {self.in_control} has control")
        self._told.clear()
        self.in_control, self.takeover, self._heard_s = system, takeover, now_s
        return ACCEPTED

    def release(self, system: int) -> Outcome:
        if self.in_control not in (0, system):
            return Outcome(Result.DENIED, f"system {self.in_control} has control")
        self._free()
        return ACCEPTED

    def lapsed(self, now_s: float, timeout_s: float) -> int:
        """The system that loses control by silence; 0 for none. A boat must not be left to one who has gone."""
        if not self.in_control or now_s - self._heard_s <= timeout_s:
            return 0
        silent = self.in_control
        self._free()
        return silent

    def _free(self) -> None:
        self._told.clear()
        self.in_control, self.takeover = 0, True


def _ends_motion(message: Any) -> bool:
    """Disarming and termination."""
    if message.command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
        return bool(message.param1 == 0.0)
    return bool(message.command == mavlink.MAV_CMD_DO_FLIGHTTERMINATION and message.param1 == 1.0)


def denials(message: Any, system: int, component: int) -> Sequence[Any]:
    """What the protocols answer to a message that is not obeyed; some have no answer."""
    number = message.get_msgId()
    if number in _COMMANDS:
        return (mavlink.MAVLink_command_ack_message(message.command, Result.DENIED.value, target_system=system, target_component=component),)
    if number in _UPLOADS:
        return (mavlink.MAVLink_mission_ack_message(system, component, PlanResult.DENIED, message.mission_type),)
    if number == mavlink.MAVLINK_MSG_ID_PARAM_SET:
        name = message.param_id.encode("ascii", "replace")[:16]
        return (mavlink.MAVLink_param_error_message(system, component, name, _NO_INDEX, _PERMISSION_DENIED),)
    return ()
