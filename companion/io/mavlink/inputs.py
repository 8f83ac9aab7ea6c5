"""What ground stations send without waiting for an answer: sticks, clocks, stream requests, vessels they see."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from companion.core.types import ManualInput, Severity
from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.endpoint import Endpoint
from companion.io.mavlink.hub import Handler, Hub, Peer
from companion.io.mavlink.telemetry_traffic import from_ais_vessel
from companion.io.mavlink.vessel import VesselFace

_AXIS_ABSENT = 0x7FFF
_IGNORE = 0xFFFF
_RELEASE_LOW, _RELEASE_HIGH = 0, 0xFFFE  # channels 1 to 8, and 9 to 18
_SWAY, _PITCH, _THROTTLE, _YAW = 1, 2, 3, 4  # channels, as on the vessel's own transmitter
_MOST_OVERRIDERS = 8
_MOST_TOLD = 64

_Source = tuple[int, Endpoint]


class InputService:
    """In: MANUAL_CONTROL, RC_CHANNELS_OVERRIDE, TIMESYNC, PING, REQUEST_DATA_STREAM, AIS_VESSEL. Out: sticks and traffic to the
    supervisor, echoes.

    Remembers whose sticks steer, who was told so, and the channels that each source overrides. A source is a system on an endpoint: two
    stations may bear the same number.
    """

    def __init__(self, hub: Hub, vessel: VesselFace) -> None:
        self._hub = hub
        self._vessel = vessel
        self._steering: _Source | None = None
        self._steered_s = -math.inf
        self._told: set[tuple[_Source, str]] = set()  # why they do not steer
        self._overrides: dict[_Source, dict[int, float]] = {}  # channel → −1…1
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_MANUAL_CONTROL: self._on_manual_control,
            mavlink.MAVLINK_MSG_ID_RC_CHANNELS_OVERRIDE: self._on_override,
            mavlink.MAVLINK_MSG_ID_TIMESYNC: self._on_timesync,
            mavlink.MAVLINK_MSG_ID_PING: self._on_ping,
            mavlink.MAVLINK_MSG_ID_REQUEST_DATA_STREAM: self._on_request_data_stream,
            mavlink.MAVLINK_MSG_ID_AIS_VESSEL: self._on_ais_vessel,
        }

    def update(self, now_s: float) -> None:
        """Nothing happens by itself: sticks that fall silent are the supervisor's business."""

    # --- sticks ----------------------------------------------------------------------------------------------------

    def _on_manual_control(self, message: Any, peer: Peer, now_s: float) -> None:
        """x ahead, y to starboard, r clockwise, z throttle, each −1000…1000."""
        if message.target != self._hub.system or not self._may_steer(peer, now_s):
            return
        surge = message.z if self._surge_is_throttle else message.x
        manual = ManualInput(
            now_s, _source(peer), _axis(surge), _axis(message.y), _axis(message.r), message.buttons | message.buttons2 << 16
        )
        self._vessel.supervisor.manual_input(manual)

    def _on_override(self, message: Any, peer: Peer, now_s: float) -> None:
        """Channels as on a transmitter: 1 sway, 2 surge or 3 throttle, 4 yaw. Sticks come from what is overridden; none while nothing is."""
        if message.target_system != self._hub.system:
            return
        source = (peer.system, peer.endpoint)
        channels = dict(self._overrides.pop(source, ()))
        for channel in (_SWAY, _PITCH, _THROTTLE, _YAW):
            value = getattr(message, f"chan{channel}_raw")
            if value in (_RELEASE_LOW, _RELEASE_HIGH):
                channels.pop(channel, None)
            elif value != _IGNORE:
                channels[channel] = min(1.0, max(-1.0, (value - 1500) / 500.0))
        if not channels or not self._may_steer(peer, now_s):
            return
        if len(self._overrides) >= _MOST_OVERRIDERS:
            del self._overrides[next(iter(self._overrides))]
        self._overrides[source] = channels
        surge = channels.get(_THROTTLE if self._surge_is_throttle else _PITCH)
        self._vessel.supervisor.manual_input(ManualInput(now_s, _source(peer), surge, channels.get(_SWAY), channels.get(_YAW)))

    @property
    def _surge_is_throttle(self) -> bool:
        return self._vessel.parameters["MAN_AXIS_SURGE"] != 0

    def _may_steer(self, peer: Peer, now_s: float) -> bool:
        """A lead boat that steers by remote; else the station that was chosen; where none is, the first one, until its sticks have been silent for
        COM_RC_LOSS_T."""
        following, source, steering = self._vessel.supervisor.following, (peer.system, peer.endpoint), self._steering
        if (reason := following.stick_refusal(peer.system)) is not None:
            self._tell(peer, source, reason)
            return False
        chosen = following.remote_system or self._vessel.parameters["MAN_GCS_SYSID"]
        if chosen not in (0, peer.system):
            return False
        if steering is not None and steering != source:
            if chosen == 0 and now_s - self._steered_s <= self._vessel.parameters["COM_RC_LOSS_T"]:
                who = f"system {steering[0]}" if steering[0] != peer.system else f"system {steering[0]} on another link"
                self._tell(peer, source, f"{who} steers. MAN_GCS_SYSID chooses")
                return False
            self._told.clear()
        self._steering, self._steered_s = source, now_s
        return True

    def _tell(self, peer: Peer, source: _Source, why: str) -> None:
        if (source, why) not in self._told and len(self._told) < _MOST_TOLD:
            self._told.add((source, why))
            self._hub.say(peer, Severity.WARNING, f"Your sticks are not obeyed: {why}")

    # --- clocks ----------------------------------------------------------------------------------------------------

    def _on_timesync(self, message: Any, peer: Peer, now_s: float) -> None:
        """A question has tc1 = 0; the answer bears our time there and the asker's unchanged."""
        if message.tc1 == 0:
            ours_ns = max(1, round(now_s * 1e9))
            self._hub.send(peer, mavlink.MAVLink_timesync_message(ours_ns, message.ts1, peer.system, peer.component))

    def _on_ping(self, message: Any, peer: Peer, now_s: float) -> None:
        """A question is addressed to nobody, the answer to the asker."""
        if message.target_system == 0 and message.target_component == 0:
            self._hub.send(peer, mavlink.MAVLink_ping_message(message.time_usec, message.seq, peer.system, peer.component))

    # --- traffic ---------------------------------------------------------------------------------------------------

    def _on_ais_vessel(self, message: Any, peer: Peer, now_s: float) -> None:
        self._vessel.supervisor.traffic_heard(from_ais_vessel(message, peer.system, now_s), now_s)

    # --- streams ---------------------------------------------------------------------------------------------------

    def _on_request_data_stream(self, message: Any, peer: Peer, now_s: float) -> None:
        self._hub.telemetry.set_data_stream(
            peer.endpoint, message.req_stream_id, float(message.req_message_rate), bool(message.start_stop), now_s
        )


def _source(peer: Peer) -> str:
    return f"mavlink:{peer.system}"


def _axis(value: int) -> float | None:
    return None if value == _AXIS_ABSENT else min(1.0, max(-1.0, value / 1000.0))
