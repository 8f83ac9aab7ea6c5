"""Commands that ask for messages, and for how often they should come."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from typing import Any

from companion.io.mavlink.commands.request import (
    DONE,
    UNSUPPORTED,
    Answer,
    CommandHandler,
    CommandRequest,
    denied,
    not_now,
    unread,
)
from companion.io.mavlink.telemetry.state import available_mode
from companion.io.mavlink.telemetry.streams import NEVER, STREAMS
from companion.io.mavlink.transfer.component_metadata import Descriptions
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Hub, Peer
from companion.io.mavlink.wire.personas import Persona
from companion.loop import Vessel

_CAPABILITIES: int = (
    mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_FTP
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION
    | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
    | mavlink.MAV_PROTOCOL_CAPABILITY_COMPONENT_ACCEPTS_GCS_CONTROL
)
_PARAM_BYTEWISE, _PARAM_C_CAST = 16, 131072  # MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_…
_LONGEST_US = 0x7FFFFFFF  # the most that MESSAGE_INTERVAL holds: 36 min
_NUMBERING = 2  # as major version: QGroundControl finds anything below 1.4.1 too old for the px4 identity


def autopilot_version(version: str, vessel_name: str, persona: Persona) -> Any:
    """AUTOPILOT_VERSION. The firmware type is "development": an official one is not ours to claim."""
    parts = [int(part) if part.isdigit() else 0 for part in (*version.split("."), "0", "0")[:3]]
    major, minor, patch = (min(255, part) for part in parts)
    flight = _NUMBERING << 24 | minor << 16 | patch << 8
    unique = hashlib.blake2b(vessel_name.encode(), digest_size=8).digest()
    encoding = _PARAM_BYTEWISE if persona.bytewise_parameters else _PARAM_C_CAST
    custom = (patch, minor, major, 0, 0, 0, 0, 0)
    nothing = (0,) * 8
    return mavlink.MAVLink_autopilot_version_message(
        _CAPABILITIES | encoding,
        flight,
        0,
        0,
        0,
        custom,
        nothing,
        nothing,
        0,
        0,
        int.from_bytes(unique, "little"),
        (*unique, *(0,) * 10),
    )


def _with(*messages: Any) -> Answer:
    """Done, and here they are."""
    return Answer(DONE.outcome, messages)


class MessageCommands:
    """`commands`: REQUEST_MESSAGE and its relatives, SET_MESSAGE_INTERVAL, GET_MESSAGE_INTERVAL."""

    def __init__(self, hub: Hub, vessel: Vessel, described: Descriptions) -> None:
        self._described = described
        self._hub = hub
        self._vessel = vessel
        self.commands: Mapping[int, CommandHandler] = {
            mavlink.MAV_CMD_REQUEST_MESSAGE: self._request_message,
            mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: self._capabilities,
            mavlink.MAV_CMD_GET_HOME_POSITION: self._get_home,
            mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: self._set_interval,
            mavlink.MAV_CMD_GET_MESSAGE_INTERVAL: self._get_interval,
            mavlink.MAV_CMD_CONTROL_HIGH_LATENCY: self._control_high_latency,
        }

    def _request_message(self, request: CommandRequest) -> Answer:
        """One message, sent once.

        param1: Id of the message.
        param2: AVAILABLE_MODES: index of the mode from 1, or 0 for all. MESSAGE_INTERVAL: id of the message meant.
        """
        number = request.whole(1)
        if number is None or number < 0:
            return unread("no such message")
        if number == mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION:
            return _with(self._version(request.peer))
        if number == mavlink.MAVLINK_MSG_ID_AVAILABLE_MODES:
            return self._available_modes(request)
        if number == mavlink.MAVLINK_MSG_ID_COMPONENT_METADATA:
            boot_ms = int(request.now_s * 1000.0) & 0xFFFFFFFF
            described = self._described.of(request.peer.endpoint.persona)
            return _with(mavlink.MAVLink_component_metadata_message(boot_ms, described.crc, described.uri))
        if number == mavlink.MAVLINK_MSG_ID_MESSAGE_INTERVAL:
            return self._interval_of(request, request.whole(2))
        return self._streamed(request, number)

    def _streamed(self, request: CommandRequest, number: int) -> Answer:
        if number not in STREAMS:
            return UNSUPPORTED
        message = self._hub.telemetry.message(number, request.peer.endpoint.persona, request.now_s)
        return not_now() if message is None else _with(message)

    def _capabilities(self, request: CommandRequest) -> Answer:
        """AUTOPILOT_VERSION.

        param1: 1.
        """
        return _with(self._version(request.peer)) if request.whole(1) == 1 else unread("param 1 should be 1")

    def _get_home(self, request: CommandRequest) -> Answer:
        """HOME_POSITION."""
        return self._streamed(request, mavlink.MAVLINK_MSG_ID_HOME_POSITION)

    def _version(self, peer: Peer) -> Any:
        return autopilot_version(self._hub.version, self._vessel.config.name, peer.endpoint.persona)

    def _available_modes(self, request: CommandRequest) -> Answer:
        """Param 2: the index from 1, or 0 for all, the last one last."""
        modes, index = self._vessel.supervisor.modes, request.whole_or(2, 0)
        if index is None or not 0 <= index <= len(modes):
            return unread(f"modes are numbered 1 to {len(modes)}")
        wanted = range(1, len(modes) + 1) if index == 0 else (index,)
        return _with(*(available_mode(modes, i, request.peer.endpoint.persona) for i in wanted))

    def _set_interval(self, request: CommandRequest) -> Answer:
        """Rate of a message on this link.

        param1: Id of the message.
        param2: Microseconds between two; 0: the default; −1: never.
        """
        number, interval_us = request.whole(1), request.params[1]
        if number is None or not math.isfinite(interval_us) or interval_us < -1.0:
            return unread("no such message or interval")
        interval_s = None if interval_us == 0.0 else NEVER if interval_us < 0.0 else interval_us * 1e-6
        taken = self._hub.telemetry.set_interval(request.peer.endpoint, number, interval_s, request.now_s)
        return DONE if taken else unread(f"message {number} is not streamed")

    def _control_high_latency(self, request: CommandRequest) -> Answer:
        """HIGH_LATENCY2 on links with `?telemetry=high_latency`.

        param1: 1 starts it, 0 stops it.
        """
        wanted = request.whole(1)
        if wanted not in (0, 1):
            return denied("param 1 of high latency should be 0 or 1")
        self._hub.telemetry.set_high_latency(bool(wanted))
        return DONE

    def _get_interval(self, request: CommandRequest) -> Answer:
        """MESSAGE_INTERVAL of a message: −1 for one that is not streamed, 0 for one that cannot be.

        param1: Id of the message.
        """
        return self._interval_of(request, request.whole(1))

    def _interval_of(self, request: CommandRequest, number: int | None) -> Answer:
        """MESSAGE_INTERVAL: −1 for a message that could be streamed but is not, 0 for one that cannot."""
        if number is None or not 0 <= number <= 0xFFFF:
            return unread("no such message")
        interval_s = self._hub.telemetry.interval_s(request.peer.endpoint, number, request.now_s)
        interval_us = 0 if interval_s is None else -1 if interval_s < 0.0 else round(min(interval_s * 1e6, _LONGEST_US))
        return _with(mavlink.MAVLink_message_interval_message(number, interval_us))
