"""A ground station in lockstep: it sends and reads MAVLink over a rig's link, with pymavlink, and waits by ticking the
rig."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.angles import wrap_pi
from companion.core.geodesy import LocalFrame
from sitl.scenarios.rig import Rig

BACK_S = 60.0
"""What a boat may take, beside the usual time to settle, to come back from where weather drove it before it was armed.
Then it is judged wherever it is."""

_HEARTBEAT_PERIOD_S = 1.0
_LOOK_S = 1.0
_THERE_LENGTHS, _THERE_M, _THERE_RAD = 0.1, 0.2, math.radians(3.0)  # off by no more, a boat is at its point
_MARKS = {0xFD: 12, 0xFE: 8}  # what MAVLink 2 and 1 packets begin with, and their length without the payload
_SIGNED, _SIGNATURE_BYTES = 1, 13
_IDS = {kind.msgname: number for number, kind in mavlink.mavlink_map.items()}
_TAKEN = frozenset(
    _IDS[kind] for kind in ("STATUSTEXT", "COMMAND_ACK", "MISSION_ITEM_REACHED", "MISSION_REQUEST_INT", "MISSION_ACK")
)  # the others are read when a scenario asks for them, or where `hears` names them


class GroundStationTimeout(Exception):
    """The vessel did not do in time what the scenario waited for."""


@dataclass(frozen=True, slots=True)
class Item:
    """A mission item, with its place in degrees."""

    command: int
    lat_deg: float = 0.0
    lon_deg: float = 0.0
    params: tuple[float, float, float, float] = (0.0, 0.0, 0.0, math.nan)
    frame: int = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT


class Newest:
    """The newest message of each type. Packets are decoded when they are asked for: of the hundreds in a second a
    scenario looks at few."""

    def __init__(self, decode: Callable[[bytearray], Any]) -> None:
        self._decode = decode
        self._packets: dict[int, bytes] = {}

    def take(self, number: int, packet: bytes) -> None:
        """The newest packet of that message id."""
        self._packets[number] = packet

    def get(self, kind: str) -> Any:
        """The message, None where none of that type has come."""
        packet = self._packets.get(_IDS[kind])
        return None if packet is None else self._decode(bytearray(packet))

    def __getitem__(self, kind: str) -> Any:
        """The message. Raises KeyError where none of that type has come."""
        return self._decode(bytearray(self._packets[_IDS[kind]]))

    def drop(self, kind: str) -> None:
        """Forget the message, to wait for the next."""
        self._packets.pop(_IDS[kind], None)


class GroundStation:
    """`last`: newest message of each type; `texts`: all STATUSTEXTs, `heard_s` when each came; `acks`, `reached`:
    results and items so far. `fences`: (when, corners as north and east of home in m) of the areas to stay in that it
    uploaded. `ordered_s`: when it last ordered something. `streamed`: what it sends in every tick. `heartbeats` False:
    it has fallen silent. `hears`: ids of messages that `_take` gets besides, for classes made of this one."""

    hears: frozenset[int] = frozenset()

    def __init__(self, rig: Rig, system: int = 255, vessel: int = 1) -> None:
        """`system`: its own id; `vessel`: the boat's id."""
        self.rig = rig
        self.vessel = vessel
        self.texts: list[str] = []
        self.heard_s: list[float] = []
        self.acks: list[Any] = []
        self.reached: list[int] = []
        self.fences: list[tuple[float, tuple[tuple[float, float], ...]]] = []
        self.streamed: Callable[[], Sequence[Any]] = tuple
        self.ordered_s = -math.inf
        self.heartbeats = True
        self._heartbeat_due_s = 0.0
        self._requests: list[Any] = []
        self._mission_ack: Any = None
        self._codec = mavlink.MAVLink(None, srcSystem=system, srcComponent=190)
        self.last = Newest(self._codec.decode)
        self._rest = b""  # a packet of which the end has not come

    def send(self, message: Any) -> None:
        """Send a message."""
        self.rig.send(message.pack(self._codec))
        self._codec.seq = (self._codec.seq + 1) % 256

    def step(self) -> None:
        """One tick of the vessel; handle everything that it sent."""
        if self.heartbeats and self.rig.now_s >= self._heartbeat_due_s:
            self._heartbeat_due_s = self.rig.now_s + _HEARTBEAT_PERIOD_S
            self.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
        for message in self.streamed():
            self.send(message)
        self.rig.step()
        for number, packet in self._packets(self._rest + self.rig.receive()):
            self.last.take(number, packet)
            if number in _TAKEN or number in self.hears:
                self._take(self._codec.decode(bytearray(packet)))

    def _packets(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """The packets that are whole, with their message ids; bytes that begin none are skipped."""
        at, size = 0, len(data)
        while at + 2 < size:
            if (around := _MARKS.get(data[at])) is None:
                at += 1
                continue
            second = data[at] == 0xFD
            end = at + around + data[at + 1] + (_SIGNATURE_BYTES if second and data[at + 2] & _SIGNED else 0)
            if end > size:
                break
            yield int.from_bytes(data[at + 7 : at + 10], "little") if second else data[at + 5], data[at:end]
            at = end
        self._rest = data[at:]

    def _take(self, message: Any) -> None:
        kind = message.get_type()
        if kind == "STATUSTEXT":
            self.texts.append(message.text)
            self.heard_s.append(self.rig.now_s)
        elif kind == "COMMAND_ACK":
            self.acks.append(message)
        elif kind == "MISSION_ITEM_REACHED":
            self.reached.append(message.seq)
        elif kind == "MISSION_REQUEST_INT":
            self._requests.append(message)
        elif kind == "MISSION_ACK":
            self._mission_ack = message

    def wait(self, what: str, condition: Callable[[], bool], timeout_s: float) -> None:
        """Step until `condition()`. Raises GroundStationTimeout with `what` and the vessel's last texts."""
        end_s = self.rig.now_s + timeout_s
        while not condition():
            if self.rig.now_s >= end_s:
                raise GroundStationTimeout(f"{what}: not within {timeout_s:g} s; last texts: {self.texts[-3:]}")
            self.step()

    def sail(self, duration_s: float) -> None:
        """Step for `duration_s`."""
        end_s = self.rig.now_s + duration_s
        while self.rig.now_s < end_s - 1e-9:
            self.step()

    def command(self, number: int, *params: float, expect: int = mavlink.MAV_RESULT_ACCEPTED) -> None:
        """Send COMMAND_LONG and wait for its result. Raises GroundStationTimeout for another result than `expect`."""
        self._send_command(number, params)
        self._acknowledged(number, expect)

    def ask(self, number: int, *params: float) -> int:
        """Send COMMAND_LONG. Returns its result, whatever it is."""
        self._send_command(number, params)
        return self._acknowledged(number, *mavlink.enums["MAV_RESULT"])

    def ask_int(self, number: int, lat_deg: float, lon_deg: float, *params: float) -> int:
        """Send COMMAND_INT with a place and four parameters. Returns its result, whatever it is."""
        self._send_command_int(number, lat_deg, lon_deg, *params)
        return self._acknowledged(number, *mavlink.enums["MAV_RESULT"])

    def _send_command(self, number: int, params: Sequence[float]) -> None:
        self._begins_order()
        padded = (*params, *(0.0 for _ in range(7 - len(params))))
        self.send(mavlink.MAVLink_command_long_message(self.vessel, 1, number, 0, *padded))

    def _begins_order(self) -> None:
        self.ordered_s = self.rig.now_s
        self.acks.clear()

    def _acknowledged(self, number: int, *expect: int) -> int:
        self.wait(f"ack of command {number}", lambda: any(a.command == number for a in self.acks), 3.0)
        result: int = next(a.result for a in self.acks if a.command == number)
        if result not in expect:
            raise GroundStationTimeout(
                f"command {number}: result {result}, expected {expect[0]}; last texts: {self.texts[-3:]}"
            )
        return result

    def set_parameter(self, name: str, value: float) -> None:
        """Send PARAM_SET and wait for its echo. Raises GroundStationTimeout where none comes."""
        self.last.drop("PARAM_VALUE")
        self.send(
            mavlink.MAVLink_param_set_message(self.vessel, 1, name.encode(), value, mavlink.MAV_PARAM_TYPE_REAL32)
        )
        self.wait(f"{name} = {value:g}", lambda: getattr(self.last.get("PARAM_VALUE"), "param_id", "") == name, 3.0)

    def parameter(self, name: str) -> float:
        """The value of a parameter, asked for by PARAM_REQUEST_READ. Raises GroundStationTimeout where none comes."""
        self.last.drop("PARAM_VALUE")
        self.send(mavlink.MAVLink_param_request_read_message(self.vessel, 1, name.encode(), -1))
        self.wait(name, lambda: getattr(self.last.get("PARAM_VALUE"), "param_id", "") == name, 3.0)
        return float(self.last["PARAM_VALUE"].param_value)

    def hold_at_home(self, settle_s: float, back_s: float = 0.0) -> None:
        """Arm in Hold, go to home with the heading of the start, and settle: weather has driven the boat off while it
        was not armed yet, so it has up to `back_s` more until it says that it is there."""
        home = self.rig.config.home
        self.ready()
        self.set_mode(0x03040000)
        self.arm()
        self.reposition(home.lat_deg, home.lon_deg, home.yaw_rad)
        self.sail(settle_s)
        latest_s = self.rig.now_s + back_s
        while self.rig.now_s < latest_s and not self._is_home():
            self.sail(_LOOK_S)

    def _is_home(self) -> bool:
        """Whether the boat says that it lies at home with the heading of the start."""
        home, there = self.rig.config.home, self.last["GLOBAL_POSITION_INT"]
        off_m = math.hypot(*LocalFrame(home.lat_deg, home.lon_deg).to_ned(there.lat * 1.0e-7, there.lon * 1.0e-7))
        turned_rad = abs(wrap_pi(math.radians(0.01 * there.hdg) - home.yaw_rad))
        return off_m <= max(_THERE_M, _THERE_LENGTHS * self.rig.config.length_m) and turned_rad <= _THERE_RAD

    def reposition(self, lat_deg: float, lon_deg: float, yaw_rad: float) -> None:
        """Go to a point and hold it with that heading. COMMAND_INT, so that the point is exact to a centimetre."""
        self._acknowledged(self._reposition(lat_deg, lon_deg, yaw_rad), mavlink.MAV_RESULT_ACCEPTED)

    def offer_reposition(self, lat_deg: float, lon_deg: float, yaw_rad: float) -> bool:
        """As `reposition`, but the vessel may refuse for the moment. Returns whether it goes."""
        taken: int = mavlink.MAV_RESULT_ACCEPTED
        result = self._acknowledged(
            self._reposition(lat_deg, lon_deg, yaw_rad), taken, mavlink.MAV_RESULT_TEMPORARILY_REJECTED
        )
        return result == taken

    def _reposition(self, lat_deg: float, lon_deg: float, yaw_rad: float) -> int:
        number: int = mavlink.MAV_CMD_DO_REPOSITION
        self._send_command_int(number, lat_deg, lon_deg, -1.0, 1.0, 0.0, yaw_rad)
        return number

    def _send_command_int(self, number: int, lat_deg: float, lon_deg: float, *params: float) -> None:
        self._begins_order()
        place = round(lat_deg * 1e7), round(lon_deg * 1e7)
        frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
        self.send(mavlink.MAVLink_command_int_message(self.vessel, 1, frame, number, 0, 0, *params, *place, math.nan))

    def set_mode(self, custom_mode: int) -> None:
        """Set a mode and wait for it."""
        self._begins_order()
        self.send(mavlink.MAVLink_set_mode_message(self.vessel, 1, custom_mode))
        self.wait(f"mode {custom_mode:#x}", lambda: self._heartbeat("custom_mode") == custom_mode, 3.0)

    def arm(self) -> None:
        """Arm, and wait until the vessel is armed."""
        self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
        self.wait("armed", lambda: self.is_armed, 3.0)

    @property
    def is_armed(self) -> bool:
        """Whether the vessel said so last."""
        return bool(self._heartbeat("base_mode") & 128)

    def ready(self, timeout_s: float = 60.0) -> None:
        """Wait until the vessel reports that it can be armed."""
        bit = mavlink.MAV_SYS_STATUS_PREARM_CHECK
        self.wait(
            "ready to arm",
            lambda: bool(getattr(self.last.get("SYS_STATUS"), "onboard_control_sensors_health", 0) & bit),
            timeout_s,
        )

    def _heartbeat(self, name: str) -> int:
        return int(getattr(self.last.get("HEARTBEAT"), name, 0))

    def upload(self, items: Sequence[Item], kind: int = mavlink.MAV_MISSION_TYPE_MISSION) -> None:
        """Upload mission, fence or rally points. Raises GroundStationTimeout when the vessel refuses."""
        result = self.offer(items, kind)
        if result != mavlink.MAV_MISSION_ACCEPTED:
            raise GroundStationTimeout(f"mission refused with {result}; last texts: {self.texts[-3:]}")
        if kind == mavlink.MAV_MISSION_TYPE_FENCE:
            self._note_fence(items)

    def offer(self, items: Sequence[Item], kind: int = mavlink.MAV_MISSION_TYPE_MISSION) -> int:
        """As `upload`. Returns the vessel's MAV_MISSION_RESULT, whatever it is."""
        self._requests.clear()
        self._mission_ack = None
        self.send(mavlink.MAVLink_mission_count_message(self.vessel, 1, len(items), kind))
        end_s = self.rig.now_s + 30.0
        while self._mission_ack is None:
            if self.rig.now_s >= end_s:
                raise GroundStationTimeout("mission upload: not within 30 s")
            self.step()
            requests, self._requests = self._requests, []
            for request in requests:
                self.send(self._item_message(items[request.seq], request.seq, kind))
        return int(self._mission_ack.type)

    def _note_fence(self, items: Sequence[Item]) -> None:
        home = LocalFrame(self.rig.config.home.lat_deg, self.rig.config.home.lon_deg)
        vertices = [item for item in items if item.command == mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION]
        corners = tuple(home.to_ned(item.lat_deg, item.lon_deg) for item in vertices)
        if len(corners) > 2:
            self.fences.append((self.rig.now_s, corners))

    def _item_message(self, item: Item, seq: int, kind: int) -> Any:
        x, y = round(item.lat_deg * 1e7), round(item.lon_deg * 1e7)
        return mavlink.MAVLink_mission_item_int_message(
            self.vessel, 1, seq, item.frame, item.command, int(seq == 0), 1, *item.params, x, y, 0.0, kind
        )
