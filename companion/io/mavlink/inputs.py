"""What ground stations send without waiting for an answer: sticks, clocks, stream requests."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from companion.core.types import ManualInput
from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.hub import Handler, Hub, Peer
from companion.io.mavlink.vessel import VesselFace

_AXIS_ABSENT = 0x7FFF
_IGNORE = 0xFFFF
_RELEASE_LOW, _RELEASE_HIGH = 0, 0xFFFE  # channels 1 to 8, and 9 to 18
_SWAY, _PITCH, _THROTTLE, _YAW = 1, 2, 3, 4  # channels, as on the vessel's own transmitter
_MOST_OVERRIDERS = 8


class InputService:
    """In: MANUAL_CONTROL, RC_CHANNELS_OVERRIDE, TIMESYNC, PING, REQUEST_DATA_STREAM. Out: sticks to the supervisor, echoes.

    Remembers the channels that each peer overrides.
    """

    def __init__(self, hub: Hub, vessel: VesselFace) -> None:
        self._hub = hub
        self._vessel = vessel
        self._overrides: dict[int, dict[int, float]] = {}  # system → channel → −1…1
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_MANUAL_CONTROL: self._on_manual_control,
            mavlink.MAVLINK_MSG_ID_RC_CHANNELS_OVERRIDE: self._on_override,
            mavlink.MAVLINK_MSG_ID_TIMESYNC: self._on_timesync,
            mavlink.MAVLINK_MSG_ID_PING: self._on_ping,
            mavlink.MAVLINK_MSG_ID_REQUEST_DATA_STREAM: self._on_request_data_stream,
        }

    def update(self, now_s: float) -> None:
        """Nothing happens by itself: sticks that fall silent are the supervisor's business."""

    # --- sticks ----------------------------------------------------------------------------------------------------

    def _on_manual_control(self, message: Any, peer: Peer, now_s: float) -> None:
        """x ahead, y to starboard, r clockwise, z throttle, each −1000…1000."""
        if message.target != self._hub.system or not self._may_steer(peer):
            return
        surge = message.z if self._surge_is_throttle else message.x
        manual = ManualInput(
            now_s, _source(peer), _axis(surge), _axis(message.y), _axis(message.r), message.buttons | message.buttons2 << 16
        )
        self._vessel.supervisor.manual_input(manual)

    def _on_override(self, message: Any, peer: Peer, now_s: float) -> None:
        """Channels as on a transmitter: 1 sway, 2 surge or 3 throttle, 4 yaw. Sticks come from what is overridden; none while nothing is."""
        if message.target_system != self._hub.system or not self._may_steer(peer):
            return
        if peer.system not in self._overrides and len(self._overrides) >= _MOST_OVERRIDERS:
            return
        channels = self._overrides.setdefault(peer.system, {})
        for channel in (_SWAY, _PITCH, _THROTTLE, _YAW):
            value = getattr(message, f"chan{channel}_raw")
            if value in (_RELEASE_LOW, _RELEASE_HIGH):
                channels.pop(channel, None)
            elif value != _IGNORE:
                channels[channel] = min(1.0, max(-1.0, (value - 1500) / 500.0))
        if not channels:
            del self._overrides[peer.system]
            return
        surge = channels.get(_THROTTLE if self._surge_is_throttle else _PITCH)
        self._vessel.supervisor.manual_input(ManualInput(now_s, _source(peer), surge, channels.get(_SWAY), channels.get(_YAW)))

    @property
    def _surge_is_throttle(self) -> bool:
        return self._vessel.parameters["MAN_AXIS_SURGE"] != 0

    def _may_steer(self, peer: Peer) -> bool:
        chosen = self._vessel.parameters["MAN_GCS_SYSID"]
        return chosen in (0, peer.system)

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

    # --- streams ---------------------------------------------------------------------------------------------------

    def _on_request_data_stream(self, message: Any, peer: Peer, now_s: float) -> None:
        self._hub.telemetry.set_data_stream(
            peer.endpoint, message.req_stream_id, float(message.req_message_rate), bool(message.start_stop), now_s
        )


def _source(peer: Peer) -> str:
    return f"mavlink:{peer.system}"


def _axis(value: int) -> float | None:
    return None if value == _AXIS_ABSENT else min(1.0, max(-1.0, value / 1000.0))
