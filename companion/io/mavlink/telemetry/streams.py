"""Streaming: the messages that are sent without a request, made from the tick, at each endpoint's own rates.

In one tick a message is built and packed once, however many endpoints it goes to; only sequence number and checksum
differ. The default rates suit QGroundControl, MAVSDK and MAVProxy: 2.5 kB/s in all, slower on lines that carry less.
"""

from __future__ import annotations

import struct
import weakref
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from companion.core.decision import Status, TextKind
from companion.core.estimate import TrackedTarget
from companion.core.tick import Tick
from companion.io.mavlink.telemetry import following as follow
from companion.io.mavlink.telemetry import instruments as instruments
from companion.io.mavlink.telemetry import motion as motion
from companion.io.mavlink.telemetry import proximity as proximity
from companion.io.mavlink.telemetry import state as state
from companion.io.mavlink.telemetry import traffic as traffic
from companion.io.mavlink.telemetry import tuning as tuning
from companion.io.mavlink.telemetry.high_latency import high_latency2
from companion.io.mavlink.telemetry.view import View
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import FAST_BYTES_PER_S, Endpoint
from companion.io.mavlink.wire.framer import Packed, pack
from companion.io.mavlink.wire.hub import Hub
from companion.io.mavlink.wire.link_options import HIGH_LATENCY
from companion.io.mavlink.wire.personas import Persona
from companion.loop import Vessel

Builder = Callable[[View, Persona], Any]

NEVER = -1.0
_FASTEST_S = 0.02
_TOTAL_BYTES_PER_S = 2500.0  # of all messages at default rates
_TELEMETRY_SHARE = 0.6  # of a slow line; the rest is for answers
_HEARTBEAT_ON_RADIO_S = 0.4  # two may be lost in a row and the next wait in the queue: it comes within 1.5 s
_EARLY_S = 1e-3  # a tick may come so much before the time at which a message is due


@dataclass(frozen=True, slots=True)
class Stream:
    """A message that can be streamed or requested. `interval_s`: default period; NEVER: only on request. `by_persona`:
    whether it differs between personas."""

    build: Builder
    interval_s: float
    by_persona: bool = False


AIS_VESSEL: int = mavlink.MAVLINK_MSG_ID_AIS_VESSEL
ADSB_VEHICLE: int = mavlink.MAVLINK_MSG_ID_ADSB_VEHICLE
DEBUG_VECT: int = mavlink.MAVLINK_MSG_ID_DEBUG_VECT
HEARTBEAT: int = mavlink.MAVLINK_MSG_ID_HEARTBEAT
_MODE_MESSAGES = (HEARTBEAT, mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE, mavlink.MAVLINK_MSG_ID_CURRENT_MODE)

STREAMS: dict[int, Stream] = {
    HEARTBEAT: Stream(state.heartbeat, 1.0, True),
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: Stream(state.extended_sys_state, 1.0),
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: Stream(state.sys_status, 1.0),
    mavlink.MAVLINK_MSG_ID_CURRENT_MODE: Stream(state.current_mode, 2.0, True),
    mavlink.MAVLINK_MSG_ID_CONTROL_STATUS: Stream(state.control_status, 1.0),
    mavlink.MAVLINK_MSG_ID_CURRENT_EVENT_SEQUENCE: Stream(state.current_event_sequence, 1.0, True),
    mavlink.MAVLINK_MSG_ID_AVAILABLE_MODES_MONITOR: Stream(state.available_modes_monitor, 3.0),
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: Stream(state.home_position, 1.0),
    mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: Stream(state.mission_current, 1.0, True),
    mavlink.MAVLINK_MSG_ID_MISSION_ITEM_REACHED: Stream(state.mission_item_reached, NEVER, True),
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: Stream(state.battery_status, 1.0),
    mavlink.MAVLINK_MSG_ID_FENCE_STATUS: Stream(state.fence_status, 1.0),
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: Stream(state.system_time, 1.0),
    mavlink.MAVLINK_MSG_ID_RC_CHANNELS: Stream(state.rc_channels, 0.5),
    mavlink.MAVLINK_MSG_ID_ATTITUDE: Stream(motion.attitude, 0.1),
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: Stream(motion.global_position_int, 0.2),
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: Stream(motion.gps_raw_int, 0.5),
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: Stream(motion.local_position_ned, 0.5),
    mavlink.MAVLINK_MSG_ID_VFR_HUD: Stream(motion.vfr_hud, 0.25),
    mavlink.MAVLINK_MSG_ID_NAV_CONTROLLER_OUTPUT: Stream(motion.nav_controller_output, 0.5),
    mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT: Stream(motion.position_target_global_int, 1.0),
    mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: Stream(motion.position_target_local_ned, NEVER),
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: Stream(tuning.attitude_quaternion, NEVER),
    mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: Stream(tuning.attitude_target, NEVER),
    mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: Stream(motion.estimator_status, 1.0),
    mavlink.MAVLINK_MSG_ID_WIND_COV: Stream(motion.wind_cov, 1.0),
    mavlink.MAVLINK_MSG_ID_ACTUATOR_OUTPUT_STATUS: Stream(motion.actuator_output_status, 1.0),
    mavlink.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT: Stream(follow.named_values, 1.0),
    AIS_VESSEL: Stream(traffic.nearest, 0.2),  # the builder is for requests; streaming takes the vessels in turn
    ADSB_VEHICLE: Stream(traffic.nearest_adsb, 0.2),  # likewise
    mavlink.MAVLINK_MSG_ID_ORBIT_EXECUTION_STATUS: Stream(motion.orbit_execution_status, 1.0),
    mavlink.MAVLINK_MSG_ID_GPS_RTK: Stream(instruments.gps_rtk, 1.0),
    mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR: Stream(instruments.distance_sensor, 0.5),
    mavlink.MAVLINK_MSG_ID_OBSTACLE_DISTANCE: Stream(proximity.obstacle_distance, NEVER),
    DEBUG_VECT: Stream(follow.report, NEVER),
    mavlink.MAVLINK_MSG_ID_HIGH_LATENCY2: Stream(high_latency2, NEVER, True),
    mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: Stream(motion.gps_global_origin, NEVER),
    mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT: Stream(motion.ekf_status_report, 1.0),
}

_DATA_STREAMS: dict[int, tuple[int, ...]] = {
    mavlink.MAV_DATA_STREAM_EXTENDED_STATUS: (
        mavlink.MAVLINK_MSG_ID_SYS_STATUS,
        mavlink.MAVLINK_MSG_ID_GPS_RAW_INT,
        mavlink.MAVLINK_MSG_ID_NAV_CONTROLLER_OUTPUT,
        mavlink.MAVLINK_MSG_ID_MISSION_CURRENT,
        mavlink.MAVLINK_MSG_ID_FENCE_STATUS,
    ),
    mavlink.MAV_DATA_STREAM_RC_CHANNELS: (
        mavlink.MAVLINK_MSG_ID_RC_CHANNELS,
        mavlink.MAVLINK_MSG_ID_ACTUATOR_OUTPUT_STATUS,
    ),
    mavlink.MAV_DATA_STREAM_POSITION: (
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
    ),
    mavlink.MAV_DATA_STREAM_EXTRA1: (mavlink.MAVLINK_MSG_ID_ATTITUDE,),
    mavlink.MAV_DATA_STREAM_EXTRA2: (mavlink.MAVLINK_MSG_ID_VFR_HUD,),
    mavlink.MAV_DATA_STREAM_EXTRA3: (
        mavlink.MAVLINK_MSG_ID_BATTERY_STATUS,
        mavlink.MAVLINK_MSG_ID_SYSTEM_TIME,
        mavlink.MAVLINK_MSG_ID_WIND_COV,
        mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT,
    ),
}
_DATA_STREAMS[mavlink.MAV_DATA_STREAM_ALL] = tuple(number for group in _DATA_STREAMS.values() for number in group)


def _as_messages(built: Any) -> Sequence[Any]:
    """The messages that a builder returned: none, one or several."""
    if built is None:
        return ()
    return built if isinstance(built, tuple) else (built,)


def _slowing(bytes_per_s: float) -> float:
    """How many times longer the default intervals are on a line of that capacity."""
    return max(1.0, _TOTAL_BYTES_PER_S / (_TELEMETRY_SHARE * bytes_per_s))


def _stretch(outlet: Endpoint) -> float:
    """How many times longer all intervals are while a radio passes on less than its line carries."""
    if outlet.bytes_per_s == outlet.line_bytes_per_s or outlet.telemetry in follow.NARROW:
        return 1.0
    return _slowing(outlet.bytes_per_s) / _slowing(outlet.line_bytes_per_s)


class _Slot:
    """The schedule of one message on one endpoint."""

    __slots__ = ("due_s", "interval_s", "number")

    def __init__(self, number: int, interval_s: float, due_s: float) -> None:
        self.number, self.interval_s, self.due_s = number, interval_s, due_s


class Telemetry:
    """`publish(tick)` each tick. Remembers, for each endpoint, when each message is due; and the state that was last
    announced, to see what changed."""

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self._slots: weakref.WeakKeyDictionary[Endpoint, dict[int, _Slot]] = weakref.WeakKeyDictionary()
        self._rounds, self._adsb_rounds = traffic.Rounds(), traffic.Rounds()
        self._told_mode: Any = None
        self._told_home: Any = None
        self._told_mission: Any = None
        self._told_reached = 0
        self._told_fence: Any = None
        self._modes: Any = None
        self._modes_seq = 0
        self._event_sequence = (0, True)
        self._high_latency = True

    # --- streaming -------------------------------------------------------------------------------------------------

    def publish(self, tick: Tick) -> None:
        """Send all messages that are due on each endpoint, the messages of changed state, and the tick's events."""
        now_s = tick.t_s
        self.tell_changes(tick.status, now_s, tick)
        view = self._view(tick.status, now_s, tick)
        built: dict[Any, Sequence[Packed]] = {}
        for outlet in self._hub.outlets:
            if outlet.telemetry != HIGH_LATENCY or self._high_latency:
                self._publish_to(outlet, view, built)
        for event in tick.events:
            self._hub.say_to_all(event.kind, event.text)

    def _publish_to(self, outlet: Endpoint, view: View, built: dict[Any, Sequence[Packed]]) -> None:
        """All messages that are due on one endpoint; only the heartbeat while its line is busy."""
        now_s, busy, stretch = view.now_s, outlet.busy, _stretch(outlet)
        latest_s = now_s + _EARLY_S
        for slot in self._schedule(outlet, now_s).values():
            if slot.due_s > latest_s or slot.interval_s < 0.0 or (busy and slot.number != HEARTBEAT):
                continue
            interval_s = slot.interval_s * (1.0 if slot.number == HEARTBEAT else stretch)
            slot.due_s += interval_s
            if slot.due_s <= now_s:  # so late that a turn was missed
                slot.due_s = now_s + interval_s
            if slot.number == AIS_VESSEL:
                self._send_vessel(outlet, view.status, now_s, self._rounds, traffic.ais_vessel)
            elif slot.number == ADSB_VEHICLE:
                self._send_vessel(outlet, view.status, now_s, self._adsb_rounds, traffic.adsb_vehicle)
            else:
                self._send(outlet, slot.number, view, built)

    def tell_changes(self, status: Status, now_s: float, tick: Tick | None = None) -> None:
        """Send to all endpoints at once what has changed: mode or arming, home, mission item, fence."""
        numbers: list[int] = []
        mode = (status.mode, status.intended_mode, status.armed, bool(status.failsafes))
        if mode != self._told_mode:
            self._told_mode = mode
            numbers += _MODE_MESSAGES
        if status.home != self._told_home:
            self._told_home = status.home
            numbers.append(mavlink.MAVLINK_MSG_ID_HOME_POSITION)
        mission = (status.mission.state, status.mission.seq, status.mission.count)
        if mission != self._told_mission:
            self._told_mission = mission
            numbers.append(mavlink.MAVLINK_MSG_ID_MISSION_CURRENT)
        if status.fence != self._told_fence:
            self._told_fence = status.fence
            numbers.append(mavlink.MAVLINK_MSG_ID_FENCE_STATUS)
        if status.mission.reached > self._told_reached:
            numbers.append(mavlink.MAVLINK_MSG_ID_MISSION_ITEM_REACHED)
        self._told_reached = status.mission.reached
        if numbers:
            self.announce(status, now_s, numbers, tick)

    def announce(self, status: Status, now_s: float, numbers: Iterable[int], tick: Tick | None = None) -> None:
        """Send these messages to all endpoints now; they are due again one interval later."""
        view = self._view(status, now_s, tick)
        built: dict[Any, Sequence[Packed]] = {}
        for outlet in self._hub.outlets:
            schedule = self._schedule(outlet, now_s)
            for number in numbers:
                if not follow.streamed(outlet, number):
                    continue
                self._send(outlet, number, view, built)
                slot = schedule[number]
                if slot.interval_s > 0.0:
                    slot.due_s = now_s + slot.interval_s

    def message(self, number: int, persona: Persona, now_s: float) -> Any:
        """A message of STREAMS as it would be sent now, the first where there are several; None where it has no
        content."""
        view = self._view(self._vessel.supervisor.status(now_s), now_s)
        return next(iter(_as_messages(STREAMS[number].build(view, persona))), None)

    # --- rates -----------------------------------------------------------------------------------------------------

    def interval_s(self, endpoint: Endpoint, number: int, now_s: float) -> float | None:
        """Period of a message on an endpoint; NEVER where it is not streamed, None where it cannot be."""
        slot = self._schedule(endpoint, now_s).get(number)
        return None if slot is None else slot.interval_s

    def set_interval(self, endpoint: Endpoint, number: int, interval_s: float | None, now_s: float) -> bool:
        """Stream a message every `interval_s` (negative: never; None: by default). Returns False for a message that
        cannot be streamed."""
        if number not in STREAMS:
            return False
        if interval_s is None:
            endpoint.intervals_s.pop(number, None)
        else:
            endpoint.intervals_s[number] = interval_s
        self._reschedule(
            endpoint, number, self._default_s(endpoint, number) if interval_s is None else interval_s, now_s
        )
        return True

    def set_high_latency(self, on: bool) -> None:
        """Whether links with `?telemetry=high_latency` carry telemetry."""
        self._high_latency = on

    def set_event_sequence(self, latest: int) -> None:
        """The number of the newest event, for CURRENT_EVENT_SEQUENCE."""
        self._event_sequence = (latest, False)

    def set_data_stream(self, endpoint: Endpoint, group: int, rate_hz: float, start: bool, now_s: float) -> None:
        """REQUEST_DATA_STREAM: set the rate of a group, except for messages whose own interval was requested."""
        for number in _DATA_STREAMS.get(group, ()):
            if number not in endpoint.intervals_s:
                self._reschedule(endpoint, number, 1.0 / rate_hz if start and rate_hz > 0.0 else NEVER, now_s)

    def _reschedule(self, endpoint: Endpoint, number: int, interval_s: float, now_s: float) -> None:
        slot = self._schedule(endpoint, now_s)[number]
        slot.interval_s = NEVER if interval_s < 0.0 else max(_FASTEST_S, interval_s)
        slot.due_s = now_s

    def _schedule(self, endpoint: Endpoint, now_s: float) -> dict[int, _Slot]:
        """The schedule of an endpoint, made at its first use."""
        slots = self._slots.get(endpoint)
        if slots is None:
            slots = {}
            for i, number in enumerate(STREAMS):
                interval_s = self._default_s(endpoint, number)
                # spread over time, so that they are not all due in the same tick
                offset_s = 0.0 if number == HEARTBEAT else (0.37 * i) % 1.0 * min(1.0, abs(interval_s))
                slots[number] = _Slot(number, interval_s, now_s + offset_s)
            self._slots[endpoint] = slots
        return slots

    @staticmethod
    def _default_s(endpoint: Endpoint, number: int) -> float:
        """Default period of a message on an endpoint, by its telemetry option and the capacity of its line."""
        if endpoint.telemetry in follow.NARROW:
            return follow.NARROW[endpoint.telemetry].get(number, NEVER)
        interval_s = STREAMS[number].interval_s
        if number == HEARTBEAT:
            return interval_s if endpoint.bytes_per_s >= FAST_BYTES_PER_S else _HEARTBEAT_ON_RADIO_S
        if interval_s < 0.0 or number in endpoint.persona.unknown:
            return NEVER
        return interval_s * _slowing(endpoint.line_bytes_per_s)

    # --- making ----------------------------------------------------------------------------------------------------

    def _view(self, status: Status, now_s: float, tick: Tick | None = None) -> View:
        modes = tuple((mode.declaration.id, mode.declaration.selectable) for mode in self._vessel.supervisor.modes)
        if modes != self._modes:
            self._modes_seq = self._modes_seq + 1 & 0xFF
            self._modes = modes
        ground_stations = self._vessel.supervisor.ground_stations
        return View(
            self._vessel,
            self._vessel.last_tick if tick is None else tick,
            status,
            now_s,
            self._modes_seq,
            (ground_stations.in_control, ground_stations.takeover),
            event_sequence=self._event_sequence,
            modes_asked=self._hub.modes_asked,
        )

    def _send(self, outlet: Endpoint, number: int, view: View, built: dict[Any, Sequence[Packed]]) -> None:
        """Send a message to one endpoint. `built`: the messages that were packed in this tick already."""
        stream = STREAMS[number]
        key: Any = (number, outlet.persona.name) if stream.by_persona else number
        if number == DEBUG_VECT:
            received = outlet.leader.received if outlet.leader is not None else 0
            key, view = (number, outlet), replace(view, received=received)
        if key not in built:
            built[key] = self._packed(stream.build, view, outlet.persona)
        for packed in built[key]:
            self._hub.send_packed(outlet, packed)

    def _send_vessel(
        self,
        outlet: Endpoint,
        status: Status,
        now_s: float,
        rounds: traffic.Rounds,
        made: Callable[[TrackedTarget, float], Any],
    ) -> None:
        """Send the vessel whose turn it is; the leader is shown among them."""
        leader = follow.as_vessel(status.leader, self._vessel.frame, now_s) if status.leader is not None else None
        vessels: Sequence[TrackedTarget] = status.traffic if leader is None else (leader, *status.traffic)
        vessel = rounds.next(outlet, vessels, now_s) if vessels else None
        if vessel is not None:
            self._hub.send_packed(outlet, pack(made(vessel, now_s)))

    def _packed(self, build: Builder, view: View, persona: Persona) -> Sequence[Packed]:
        """Build and pack. Where a value does not fit its field, nothing is sent and an event says so."""
        try:
            return [pack(message) for message in _as_messages(build(view, persona))]
        except (struct.error, ValueError, OverflowError) as error:
            self._vessel.events.say(view.now_s, TextKind.FAULT, "telemetry_failed", f"{build.__name__}: {error}")
            return ()
