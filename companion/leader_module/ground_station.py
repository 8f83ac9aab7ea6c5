"""A ground station on the lead boat, on a link of its own to the leader module.

To it the module is a surface boat with the modes Manual, Remote and Follow, with PX4's numbers of Manual, Offboard and
Follow. A mode that it sets by SET_MODE or MAV_CMD_DO_SET_MODE is what the crew asks of the follower. Its MANUAL_CONTROL
to the module's system id are the crew's sticks. Other commands are refused; nothing is forwarded between the two links.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from companion.core.decision import ModeId, TextKind
from companion.core.estimate import NavState
from companion.core.readings import ManualInput, Wish
from companion.core.tick import DeviceHealth
from companion.io.mavlink.telemetry.statustext import statustexts
from companion.io.mavlink.telemetry.view import INT16_MAX, centidegrees, degrees_e7, fitted, millimetres
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.framer import UnknownMessage, pack
from companion.io.mavlink.wire.links import Link
from companion.io.mavlink.wire.personas import PX4
from companion.leader_module.catalogue import Catalogue
from companion.leader_module.crew_wish import CrewWish

_COMPONENT = mavlink.MAV_COMP_ID_AUTOPILOT1  # ground stations show no other component as a vehicle
_WISHES = {ModeId.MANUAL: Wish.MANUAL, ModeId.OFFBOARD: Wish.REMOTE, ModeId.FOLLOW: Wish.AUTONOMOUS}
_MODES = {wish: mode for mode, wish in _WISHES.items()} | {Wish.NONE: ModeId.MANUAL}
_HEARTBEAT_S, _POSITION_S = 1.0, 0.5
_STICKS_S = 0.5  # silence after which sticks count as released
_EARLY_S = 1e-3
_AXIS_ABSENT = 0x7FFF
_SET_MODE, _REQUEST_MESSAGE = mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_CMD_REQUEST_MESSAGE
_ACCEPTED, _DENIED, _UNSUPPORTED = (
    int(n) for n in (mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_DENIED, mavlink.MAV_RESULT_UNSUPPORTED)
)


class LeadGroundStation:
    """The ground stations on one link: `serve` answers them, `publish` sends what is due each tick."""

    def __init__(self, link: Link, system: int, crew: CrewWish, say: Callable[[float, str], None]) -> None:
        self._link, self._system, self._crew, self._say = link, system, crew, say
        self._catalogue = Catalogue(system)
        self._sticks: ManualInput | None = None
        self._heartbeat_s = self._position_s = -math.inf
        self._announced: tuple[Wish, int] | None = None
        self._text_id = 0

    def serve(self, now_s: float) -> None:
        """Handle and answer what has come in."""
        for endpoint, message in self._link.receive(now_s):
            if not isinstance(message, UnknownMessage):
                self._take(endpoint, message, now_s)
        for text in self._link.news():
            self._say(now_s, text)
        self._flush(now_s)

    def publish(self, nav: NavState, placed: bool) -> None:
        """Send heartbeat and position where they are due."""
        now_s, asked = nav.t_s, (self._crew.wish, self._crew.presses)
        if now_s - self._heartbeat_s >= _HEARTBEAT_S - _EARLY_S or asked != self._announced:
            self._heartbeat_s, self._announced = now_s, asked
            self._send(self._heartbeat())
        if placed and now_s - self._position_s >= _POSITION_S - _EARLY_S:
            self._position_s = now_s
            self._send(_position(nav))
        self._flush(now_s)

    def tell(self, kind: TextKind, text: str) -> None:
        """Send a STATUSTEXT to all that are connected."""
        self._text_id = self._text_id % 0xFFFF + 1
        for message in statustexts(kind, text, self._text_id):
            self._send(message)

    def sticks(self, now_s: float) -> ManualInput | None:
        """The crew's sticks; None after half a second of silence."""
        return self._sticks if self._sticks is not None and now_s - self._sticks.t_s <= _STICKS_S else None

    def filenos(self) -> Sequence[int]:
        """Descriptors of the link."""
        return self._link.filenos()

    def health(self, now_s: float) -> DeviceHealth:
        """Health of the link."""
        return self._link.health(now_s)

    def close(self) -> None:
        """Close the link."""
        self._link.close()

    # --- parts -----------------------------------------------------------------------------------------------------

    def _take(self, endpoint: Endpoint, message: Any, now_s: float) -> None:
        kind = message.get_type()
        if kind == "SET_MODE" and message.target_system == self._system:
            self._choose(message.custom_mode, now_s)
        elif kind in ("COMMAND_LONG", "COMMAND_INT") and message.target_system == self._system:
            source = message.get_srcSystem(), message.get_srcComponent()
            result, answers = self._command(message, now_s)
            for answer in (mavlink.MAVLink_command_ack_message(message.command, result, 0, 0, *source), *answers):
                self._answer(endpoint, answer)
        elif kind == "MANUAL_CONTROL" and message.target == self._system:
            self._sticks = ManualInput(
                now_s, f"mavlink:{message.get_srcSystem()}", _axis(message.x), _axis(message.y), _axis(message.r)
            )
        else:
            for answer in self._catalogue.answers(message):
                self._answer(endpoint, answer)

    def _command(self, message: Any, now_s: float) -> tuple[int, Sequence[Any]]:
        """(MAV_RESULT, further answers). Param 2 of DO_SET_MODE is PX4's main mode, param 3 its sub mode."""
        whole = [
            int(p) if math.isfinite(p) and p == int(p) and 0 <= p <= 255 else None
            for p in (message.param2, message.param3)
        ]
        if message.command == _REQUEST_MESSAGE and message.param1 == mavlink.MAVLINK_MSG_ID_AVAILABLE_MODES:
            modes = () if whole[0] is None else self._catalogue.modes(whole[0])
            return (_ACCEPTED, modes) if modes else (_DENIED, ())
        if message.command != _SET_MODE:
            return _UNSUPPORTED, ()
        main, sub = whole
        if main is None or sub is None or not self._choose(main << 16 | sub << 24, now_s):
            return _DENIED, ()
        return _ACCEPTED, ()

    def _choose(self, custom_mode: int, now_s: float) -> bool:
        mode = PX4.mode(custom_mode, frozenset(_WISHES))
        if mode is None:
            self._say(now_s, f"mode {custom_mode} refused: not Manual, Remote or Follow")
            return False
        self._crew.press(_WISHES[mode])
        return True

    def _heartbeat(self) -> Any:
        mode = _MODES[self._crew.wish]
        kind, autopilot = mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_PX4
        return mavlink.MAVLink_heartbeat_message(
            kind, autopilot, PX4.base_mode(mode, False), PX4.custom_mode(mode), mavlink.MAV_STATE_ACTIVE, 3
        )

    def _send(self, message: Any) -> None:
        packed = pack(message)
        for endpoint in self._link.endpoints:
            endpoint.send(packed, self._system, _COMPONENT)

    def _answer(self, endpoint: Endpoint, message: Any) -> None:
        endpoint.send(pack(message), self._system, _COMPONENT)

    def _flush(self, now_s: float) -> None:
        for endpoint in self._link.endpoints:
            endpoint.flush(now_s)


def _axis(value: int) -> float | None:
    return None if value == _AXIS_ABSENT else min(1.0, max(-1.0, value / 1000.0))


def _position(nav: NavState) -> Any:
    boot_ms = int(nav.t_s * 1000.0) & 0xFFFFFFFF
    velocity = (fitted(part, 100.0, -INT16_MAX, INT16_MAX, 0) for part in (nav.north_mps, nav.east_mps))
    return mavlink.MAVLink_global_position_int_message(
        boot_ms,
        degrees_e7(nav.lat_deg),
        degrees_e7(nav.lon_deg),
        millimetres(nav.altitude_m),
        0,
        *velocity,
        0,
        centidegrees(nav.yaw_rad if nav.heading_valid else None),
    )
