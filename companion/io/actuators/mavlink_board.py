"""The MAVLink side of a bridge to an autopilot board: its address, its heartbeat, the messages that it is asked for,
and its relays."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from companion.config.actuators.mavlink_servo import MavlinkBoardConfig
from companion.core.actuation import Beacon, Light
from companion.core.ports import ByteStream
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer, UnknownMessage, frame, pack

COMPONENT = mavlink.MAV_COMP_ID_ONBOARD_COMPUTER
BEAT_LOST_S = 3.5  # boards beat once a second
_BEAT_S = 1.0
_ASK_S = 1.0
_ASK_AGAIN_S = 10.0  # for parameters, which somebody may set meanwhile
_STALE_S = 2.0
_MICROSECONDS = 1e6
_RELAYS_AGAIN_S = 1.0
_BLINK_HZ = 1.0


class MavlinkBoard:
    """`read(now_s)` → messages of the board with their time of arrival; `attend(now_s)` once a step: heartbeat, and
    requests that are due.

    The board is the first autopilot whose heartbeat comes in; other systems on the line are ignored. Remembers its
    address and kind (`autopilot`, a MAV_AUTOPILOT), the times of its last message and heartbeat and of each message,
    the parameters asked for, and counts.
    """

    def __init__(
        self, stream: ByteStream, system: int, intervals_s: Mapping[int, float], parameters: Sequence[str]
    ) -> None:
        """`system`: our own id; `intervals_s`: how often each message is wanted; `parameters`: names of those
        wanted."""
        self.stream = stream
        self.address: tuple[int, int] | None = None
        self.autopilot: int | None = None
        self.heard_s: float | None = None
        self.beat_s: float | None = None
        self.parameters: dict[str, float] = {}
        self._system = system
        self._intervals_s = dict(intervals_s)
        self._wanted = tuple(parameters)
        self._came_s: dict[int, float] = {}
        self._framer = Framer()
        self._garbage_before = 0
        self._sequence = 0
        self._sent_beat_s: float | None = None
        self._asked_s: float | None = None
        self._asked_parameters_s: float | None = None

    @property
    def frames(self) -> int:
        """How many valid frames have come in."""
        return self._framer.received

    @property
    def garbage(self) -> int:
        """Bytes of no frame since the last frame that was one."""
        return self._framer.garbage - self._garbage_before

    def read(self, now_s: float) -> list[tuple[float, Any]]:
        """Messages of the board since the last call, each with its time of arrival in vessel time."""
        messages: list[tuple[float, Any]] = []
        for arrival_s, data in self.stream.read(now_s):
            for message in self._framer.feed(data):
                if isinstance(message, UnknownMessage):
                    continue  # its checksum cannot be judged: it may be noise
                self._garbage_before = self._framer.garbage
                if self._is_from_the_board(message, arrival_s):
                    self.heard_s = self._came_s[message.get_msgId()] = arrival_s
                    messages.append((arrival_s, message))
        return messages

    def came_s(self, number: int) -> float | None:
        """When that message last came in; None before the first."""
        return self._came_s.get(number)

    def attend(self, now_s: float) -> None:
        """Send the heartbeat and the requests that are due."""
        if self._sent_beat_s is None or now_s - self._sent_beat_s >= _BEAT_S:
            self._sent_beat_s = now_s
            kind, none = mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID
            self.send(now_s, mavlink.MAVLink_heartbeat_message(kind, none, 0, 0, mavlink.MAV_STATE_ACTIVE, 3))
        if self.address is not None and (self._asked_s is None or now_s - self._asked_s >= _ASK_S):
            self._asked_s = now_s
            self._ask(now_s)

    def send(self, now_s: float, *messages: Any) -> None:
        """Send all messages in one write, so that a busy line drops all or none."""
        frames = []
        for message in messages:
            frames.append(frame(pack(message), self._sequence, self._system, COMPONENT))
            self._sequence = (self._sequence + 1) & 0xFF
        if frames:
            self.stream.write(b"".join(frames), now_s)

    def command(self, number: int, *parameters: float) -> Any:
        """COMMAND_LONG to the board. Its address must be known."""
        assert self.address is not None
        values = (*parameters, *(0.0,) * (7 - len(parameters)))
        return mavlink.MAVLink_command_long_message(*self.address, number, 0, *values)

    def _ask(self, now_s: float) -> None:
        """For messages that do not come, and for parameters."""
        assert self.address is not None
        requests = []
        for number, interval_s in self._intervals_s.items():
            came_s = self._came_s.get(number)
            if came_s is None or now_s - came_s > _STALE_S:
                requests.append(self.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, number, interval_s * _MICROSECONDS))
        asked_s = self._asked_parameters_s
        missing = any(name not in self.parameters for name in self._wanted)
        if self._wanted and (missing or asked_s is None or now_s - asked_s >= _ASK_AGAIN_S):
            self._asked_parameters_s = now_s
            requests += [
                mavlink.MAVLink_param_request_read_message(*self.address, name.encode("ascii"), -1)
                for name in self._wanted
            ]
        self.send(now_s, *requests)

    def _is_from_the_board(self, message: Any, arrival_s: float) -> bool:
        sender = message.get_srcSystem(), message.get_srcComponent()
        number = message.get_msgId()
        if (
            number == mavlink.MAVLINK_MSG_ID_HEARTBEAT
            and message.autopilot != mavlink.MAV_AUTOPILOT_INVALID
            and self.address in (None, sender)
        ):
            self.address, self.autopilot, self.beat_s = sender, message.autopilot, arrival_s
        if sender != self.address:
            return False
        if number == mavlink.MAVLINK_MSG_ID_PARAM_VALUE:
            self._note_parameter(message.param_id, message.param_value)
        return True

    def _note_parameter(self, name: str | bytes, value: float) -> None:
        text = name.decode("ascii", "replace") if isinstance(name, bytes) else name
        if text in self._wanted and math.isfinite(value):
            self.parameters[text] = value


class MavlinkRelays:
    """`orders(on, beacon, now_s)` → DO_SET_RELAY messages: changes at once, all others once a second.

    The board leaves its relays as they are in silence. Remembers what was sent and when.
    """

    def __init__(self, config: MavlinkBoardConfig, board: MavlinkBoard) -> None:
        self._numbers, self._lamps = config.relays, config.lamps
        self._board = board
        self._sent: dict[int, tuple[bool, float]] = {}

    def orders(self, on: Sequence[bool], beacon: Beacon, now_s: float) -> list[Any]:
        """Messages that are due. `on`: of the bridge's relays, in order. The board's address must be known."""
        wanted = dict(zip(self._numbers, on, strict=True))
        for number, light in zip(self._lamps, (beacon.red, beacon.yellow, beacon.green), strict=False):
            wanted[number] = light is Light.STEADY or (light is Light.BLINK and now_s * _BLINK_HZ % 1.0 < 0.5)
        due = []
        for number, state in wanted.items():
            sent = self._sent.get(number)
            if sent is None or sent[0] is not state or now_s - sent[1] >= _RELAYS_AGAIN_S:
                self._sent[number] = state, now_s
                due.append(self._board.command(mavlink.MAV_CMD_DO_SET_RELAY, number, float(state)))
        return due
