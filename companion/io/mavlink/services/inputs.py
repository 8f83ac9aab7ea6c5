"""What ground stations send without waiting for an answer: sticks, clocks, stream requests, traffic."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from companion.core.decision import TextKind
from companion.core.readings import ManualInput
from companion.io.mavlink.telemetry.traffic import from_ais_vessel
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.loop import Vessel
from companion.supervisor.authority import AuthorityRequest, RequestedAction

_AXIS_ABSENT = 0x7FFF
_IGNORE = 0xFFFF
_RELEASE_LOW, _RELEASE_HIGH = 0, 0xFFFE  # channels 1 to 8, and 9 to 18
_SWAY, _PITCH, _THROTTLE, _YAW = 1, 2, 3, 4  # channels of PX4's sticks, as on the vessel's own transmitter
_MOST_OVERRIDERS = 8
_MOST_TOLD = 64

_Source = tuple[int, Endpoint]


class InputService:
    """In: MANUAL_CONTROL, RC_CHANNELS_OVERRIDE, TIMESYNC, PING, REQUEST_DATA_STREAM, AIS_VESSEL. Out: sticks and
    traffic to the supervisor, echoes.

    Remembers who was told why its sticks do not steer, and the channels that each source overrides, until it has been
    silent for COM_RC_LOSS_T. A source is a system on an endpoint: two ground stations may have the same system id.
    """

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self._told: set[tuple[_Source, str]] = set()  # why they do not steer
        self._overrides: dict[_Source, tuple[float, dict[int, float]]] = {}  # when heard, and channel → −1…1
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_MANUAL_CONTROL: self._on_manual_control,
            mavlink.MAVLINK_MSG_ID_RC_CHANNELS_OVERRIDE: self._on_override,
            mavlink.MAVLINK_MSG_ID_TIMESYNC: self._on_timesync,
            mavlink.MAVLINK_MSG_ID_PING: self._on_ping,
            mavlink.MAVLINK_MSG_ID_REQUEST_DATA_STREAM: self._on_request_data_stream,
            mavlink.MAVLINK_MSG_ID_AIS_VESSEL: self._on_ais_vessel,
        }

    def update(self, now_s: float) -> None:
        """Nothing: the supervisor watches for sticks that fall silent."""

    # --- sticks ----------------------------------------------------------------------------------------------------

    def _on_manual_control(self, message: Any, peer: Peer, now_s: float) -> None:
        """x ahead, y to starboard, r clockwise, z throttle, each −1000…1000."""
        if message.target != self._hub.system or not self._may_steer(peer, now_s):
            return
        surge = message.z if self._surge_is_throttle else message.x
        manual = ManualInput(
            now_s,
            _source(peer),
            _axis(surge),
            _axis(message.y),
            _axis(message.r),
            message.buttons | message.buttons2 << 16,
        )
        self._vessel.supervisor.manual_input(manual)

    def _on_override(self, message: Any, peer: Peer, now_s: float) -> None:
        """Channels as on a transmitter: 1 sway, 2 surge or 3 throttle, 4 yaw; for clients of ArduPilot those of Rover.
        Sticks come from what is overridden; none while nothing is."""
        if message.target_system != self._hub.system:
            return
        source = (peer.system, peer.endpoint)
        channels = self._overridden(source, now_s)
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
        self._overrides[source] = (now_s, channels)
        usual = _THROTTLE if self._surge_is_throttle else _PITCH, _SWAY, _YAW
        surge, sway, yaw = map(channels.get, peer.endpoint.persona.overrides or usual)
        self._vessel.supervisor.manual_input(ManualInput(now_s, _source(peer), surge, sway, yaw))

    def _overridden(self, source: _Source, now_s: float) -> dict[int, float]:
        """The channels that the source overrides already; none after a silence in which its sticks were lost."""
        heard_s, channels = self._overrides.pop(source, (now_s, {}))
        return channels if now_s - heard_s <= self._vessel.parameters["COM_RC_LOSS_T"] else {}

    @property
    def _surge_is_throttle(self) -> bool:
        return self._vessel.parameters["MAN_AXIS_SURGE"] != 0

    def _may_steer(self, peer: Peer, now_s: float) -> bool:
        supervisor, source = self._vessel.supervisor, (peer.system, peer.endpoint)
        request = AuthorityRequest(RequestedAction.GROUND_STICKS, system=peer.system, link=peer.endpoint)
        reason = supervisor.refusal(request, now_s)
        if reason:
            self._tell(peer, source, reason)
        if reason is not None:
            return False
        if supervisor.ground_stations.steer(peer.system, peer.endpoint, now_s):
            self._told.clear()
        return True

    def _tell(self, peer: Peer, source: _Source, why: str) -> None:
        if (source, why) not in self._told and len(self._told) < _MOST_TOLD:
            self._told.add((source, why))
            self._hub.say(peer, TextKind.REFUSAL, f"Sticks ignored: {why}")

    # --- clocks ----------------------------------------------------------------------------------------------------

    def _on_timesync(self, message: Any, peer: Peer, now_s: float) -> None:
        """A question has tc1 = 0. The answer has the boat's time there, and the sender's unchanged."""
        if message.tc1 == 0:
            ours_ns = max(1, round(now_s * 1e9))
            self._hub.send(peer, mavlink.MAVLink_timesync_message(ours_ns, message.ts1, peer.system, peer.component))

    def _on_ping(self, message: Any, peer: Peer, now_s: float) -> None:
        """A question has no target, the answer goes to its sender."""
        if message.target_system == 0 and message.target_component == 0:
            self._hub.send(
                peer, mavlink.MAVLink_ping_message(message.time_usec, message.seq, peer.system, peer.component)
            )

    # --- traffic ---------------------------------------------------------------------------------------------------

    def _on_ais_vessel(self, message: Any, peer: Peer, now_s: float) -> None:
        """A follower shows its leader as a vessel, with its system id as MMSI: that may be this boat."""
        mmsi: int = message.MMSI
        if mmsi != self._hub.system:
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
