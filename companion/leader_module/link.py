"""A leader module's link towards the follower: what it sends and when, what the follower reports, and link quality.

At 20 Hz on a narrow (`thrifty`) line of 2,000 bytes a second, both directions together:

    FOLLOW_TARGET      one whole message of 105 bytes a second, the others 92 bytes: 1,853 bytes/s
    HEARTBEAT          1 Hz, 21 bytes/s
    MANUAL_CONTROL     only while the crew steers by stick, 10 Hz of 23 bytes: 230 bytes/s;
                       every second FOLLOW_TARGET is then omitted
    from the follower  HEARTBEAT, GLOBAL_POSITION_INT, DEBUG_VECT at 1 Hz: 103 bytes/s
    TIMESYNC           a question and an answer every 10 s: 6 bytes/s

A receiver that is a moving base adds what it prints: GPS_RTCM_DATA, 16 bytes more for each 180. Four constellations of
MSM4 and 4072.0 once a second are about 800 bytes/s, which the line of 2,000 bytes/s does not carry.
"""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from companion.core.estimate import NavState
from companion.core.readings import ManualInput, Wish
from companion.core.tick import DeviceHealth
from companion.following.link_counter import AcknowledgedCounter
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.framer import Packed, UnknownMessage, pack
from companion.io.mavlink.wire.links import Link
from companion.io.mavlink.wire.personas import ARDUPILOT, PX4
from companion.leader_module.messages import COMPONENT, follow_target, heartbeat, manual_control
from companion.leader_module.moving_base import fragments

_AUTOPILOT = mavlink.MAV_COMP_ID_AUTOPILOT1
_WHOLE_S = _HEARTBEAT_S = 1.0
_STICKS_S = 0.1
_REPORT_S = 1.0  # period of the follower's reports
_EARLY_S = 1e-3
_COUNT = 65536


@dataclass(slots=True)
class Follower:
    """What the follower has reported; None for what it has not. `heard_s`: time of its last message."""

    heard_s: float | None = None
    mode: str | None = None
    armed: bool = False
    position_s: float = -math.inf
    lat_deg: float | None = None
    lon_deg: float | None = None
    north_mps: float = 0.0
    east_mps: float = 0.0
    throttle: float | None = None
    nozzle_deg: float | None = None


@dataclass(frozen=True, slots=True)
class Broadcast:
    """What is sent in one tick. `placed`: the lead boat has a fix; `sticks`: the crew's, None where there are none."""

    nav: NavState
    placed: bool
    wish: Wish
    presses: int
    sticks: ManualInput | None


class LeadLink:
    """One link: `serve` handles what has come in, `publish` sends what is due each tick.

    A position is sent only when none waits for the line. Remembers when each message was sent, what each remote has
    acknowledged, and what the follower reported.
    """

    def __init__(
        self,
        link: Link,
        system: int,
        follower: int,
        rate_hz: float,
        thrifty: bool,
        follower_says: Callable[[float, str], None],
    ) -> None:
        """`system`: our id. `follower`: id of the vessel that is shown and that the sticks steer. `rate_hz`: of
        `publish`. `follower_says(now_s, text)`: called for its STATUSTEXT."""
        self.name = link.name
        self.follower = Follower()
        self._link = link
        self._system, self._follower_id = system, follower
        self._thrifty = thrifty
        self._usual = round(rate_hz * _REPORT_S) + 1  # messages between two reports
        self._says = follower_says
        self._counters: weakref.WeakKeyDictionary[Endpoint, AcknowledgedCounter] = weakref.WeakKeyDictionary()
        self._reporting: Endpoint | None = None  # the remote of the follower's last report
        self._whole_s = self._heartbeat_s = self._sticks_s = -math.inf
        self._gave_way = False
        self._frames_sent = 0
        self._chunks: dict[int, str] = {}

    @property
    def counter(self) -> int | None:
        """Link quality, 0 (good) to 40; None before the follower's first report."""
        return None if self._reporting is None else self._counters[self._reporting].value

    def serve(self, now_s: float) -> None:
        """Handle and answer what has come in."""
        for endpoint, message in self._link.receive(now_s):
            if not isinstance(message, UnknownMessage):
                self._take(endpoint, message, now_s)
        for text in self._link.news():
            self._says(now_s, text)
        self._flush(now_s)

    def publish(self, broadcast: Broadcast) -> None:
        """Send what is due."""
        now_s = broadcast.nav.t_s
        self._flush(now_s)
        free = [
            endpoint for endpoint in self._link.endpoints if not endpoint.backlog
        ]  # an old position is worse than none
        if now_s - self._heartbeat_s >= _HEARTBEAT_S - _EARLY_S:
            self._heartbeat_s = now_s
            self._send(pack(heartbeat()))
        steering = broadcast.wish is Wish.REMOTE and broadcast.sticks is not None
        if steering and broadcast.sticks is not None and now_s - self._sticks_s >= _STICKS_S - _EARLY_S:
            self._sticks_s = now_s
            self._send(pack(manual_control(broadcast.sticks, self._follower_id)))
        self._gave_way = self._thrifty and steering and not self._gave_way
        if free and not self._gave_way:
            whole = not self._thrifty or now_s - self._whole_s >= _WHOLE_S - _EARLY_S
            if whole:
                self._whole_s = now_s
            packed = pack(follow_target(broadcast.nav, broadcast.placed, broadcast.wish, broadcast.presses, whole))
            for endpoint in free:
                self._send(packed, endpoint)
        self._flush(now_s)

    def send_corrections(self, frames: Sequence[bytes], now_s: float) -> None:
        """Send RTCM frames of the boat's moving base to followers whose line is free: what is late is of no use."""
        free = [endpoint for endpoint in self._link.endpoints if not endpoint.backlog]
        for frame in frames:
            self._frames_sent += 1
            for message in fragments(frame, self._frames_sent):
                packed = pack(message)
                for endpoint in free:
                    self._send(packed, endpoint)
        self._flush(now_s)

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

    def _send(self, packed: Packed, only: Endpoint | None = None) -> None:
        for endpoint in self._link.endpoints if only is None else (only,):
            endpoint.send(packed, self._system, COMPONENT)
            self._counter(endpoint).sent()

    def _counter(self, endpoint: Endpoint) -> AcknowledgedCounter:
        counter = self._counters.get(endpoint)
        if counter is None:
            counter = self._counters[endpoint] = AcknowledgedCounter(self._usual)
        return counter

    def _flush(self, now_s: float) -> None:
        for endpoint in self._link.endpoints:
            endpoint.flush(now_s)

    def _take(self, endpoint: Endpoint, message: Any, now_s: float) -> None:
        kind, system = message.get_type(), message.get_srcSystem()
        if kind == "TIMESYNC" and message.tc1 == 0 and getattr(message, "target_system", 0) in (0, self._system):
            ours_ns = max(1, round(now_s * 1e9))
            self._send(
                pack(mavlink.MAVLink_timesync_message(ours_ns, message.ts1, system, message.get_srcComponent())),
                endpoint,
            )
        if system != self._follower_id or message.get_srcComponent() != _AUTOPILOT:
            return
        follower = self.follower
        follower.heard_s = now_s
        if kind == "HEARTBEAT":
            persona = ARDUPILOT if message.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA else PX4
            mode = persona.mode(message.custom_mode)
            follower.mode = f"mode {message.custom_mode}" if mode is None else mode.value
            follower.armed = bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
        elif kind == "GLOBAL_POSITION_INT":
            known = (message.lat, message.lon) != (0, 0)
            follower.lat_deg, follower.lon_deg = (message.lat * 1e-7, message.lon * 1e-7) if known else (None, None)
            follower.north_mps, follower.east_mps, follower.position_s = message.vx * 0.01, message.vy * 0.01, now_s
        elif kind == "DEBUG_VECT" and message.name == "follow":
            self._take_report(endpoint, message)
        elif kind == "STATUSTEXT":
            self._take_text(message, now_s)

    def _take_report(self, endpoint: Endpoint, message: Any) -> None:
        if all(map(math.isfinite, (message.x, message.y, message.z))):
            self.follower.throttle, self.follower.nozzle_deg = message.x, message.y
            self._counter(endpoint).reported(int(message.z) % _COUNT)
            self._reporting = endpoint

    def _take_text(self, message: Any, now_s: float) -> None:
        """Collect a text, which may come in chunks; the last one is shorter than 50 characters. Control characters are
        removed, for a terminal would obey them."""
        part = "".join(character for character in message.text if character.isprintable())
        begun = self._chunks.pop(message.id, "") if message.id and message.chunk_seq else ""
        text = begun + part
        if not message.id or len(message.text) < 50:
            self._says(now_s, text)
        elif len(text) < 400:
            self._chunks = {message.id: text}
