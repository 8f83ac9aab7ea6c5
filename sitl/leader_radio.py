"""The radio link between a lead boat and its followers: the MAVLink bytes that the leader sends, which arrive, and
when."""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.config.vessel import ConfigError
from companion.core.geodesy import LocalFrame
from sitl.lead_boat import LeadBoat, LeaderFix
from sitl.moving_base import MovingBase
from sitl.noise import stream
from sitl.sensors import Grade, grade

WISH_NONE, WISH_MANUAL, WISH_REMOTE, WISH_AUTONOMOUS = range(4)
# in custom_state: marks a leader module; the low byte is the crew's wish, bits 40 to 43 the kind of fix
_MODULE_STATE = 0x55535600
_FIX_TYPES = {1: 3, 2: 4, 4: 6}  # GGA's quality → GPS_FIX_TYPE
_POSITION, _VELOCITY, _ATTITUDE = 1, 2, 8  # est_capabilities
_NAN = math.nan
_WHOLE_S = 1.0  # how often a radio module sends a whole message, not a short one
_STICKS_HZ = 20.0


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of leader: how often it sends its position, its system and component, and what its heartbeat says."""

    rate_hz: float
    system: int
    component: int
    vehicle: int
    autopilot: int


KINDS = {
    "module": Kind(20.0, 100, 191, mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID),
    "radio": Kind(
        20.0, 100, 191, mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID
    ),  # the module on 16 kbit/s
    "phone": Kind(4.0, 250, 190, mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID),  # QGroundControl's Follow Me
    "mavsdk": Kind(1.0, 245, 190, mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID),
    "vehicle": Kind(5.0, 100, 1, mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA),
}


class EmulatedLeaderModule:
    """What a leader sends: `speak()` at `due_s` returns its packets. Remembers its clock, its counters and what it last
    sent.

    A module dead-reckons from the boat's last fix to the moment of sending, and so does a vehicle, with
    GLOBAL_POSITION_INT. A module's inertial sensor keeps its velocity that of the moment. A phone and MAVSDK send the
    fix as it is. Set `wish`, what the crew asks for, and `sticks` (x, y, z, r; −1000 to 1000), what it steers.
    """

    def __init__(
        self,
        boat: LeadBoat,
        *,
        kind: str = "module",
        gnss: str = "standalone",
        heading: bool = True,
        rate_hz: float = 0.0,
        moving_base: bool = False,
        seed: int = 0,
    ) -> None:
        """`gnss`: grade of the boat's receiver, for the accuracy it reports. `heading` False: it has no inertial
        sensor. `rate_hz` 0: the usual rate of its kind. `moving_base`: its receiver sends RTCM once a
        second. Raises ConfigError for an unknown kind or grade."""
        if kind not in KINDS:
            raise ConfigError([f"leader kind '{kind}': one of {', '.join(KINDS)}"])
        self.kind = kind
        self.wish = WISH_AUTONOMOUS
        self.sticks: tuple[int, int, int, int] | None = None
        self._boat, self._heading = boat, heading
        self._sigma_m = _sigma_m(grade(gnss))
        self._who = KINDS[kind]
        self._period_s = 1.0 / (rate_hz or self._who.rate_hz)
        draws = stream(seed, f"{boat.name} module")
        self.due_s = boat.t_s + draws.uniform(0.0, self._period_s)
        self._heartbeat_s, self._sticks_s, self._whole_s = self.due_s, self.due_s, -math.inf
        self._clock_s, self._clock_rate = draws.uniform(5.0, 5000.0), 1.0 + draws.uniform(-50e-6, 50e-6)
        self._said = 0
        self._rtcm = 0
        self._base = MovingBase() if moving_base else None
        self._codec = mavlink.MAVLink(None, srcSystem=self._who.system, srcComponent=self._who.component)

    @property
    def system(self) -> int:
        """Its MAVLink system id."""
        return self._who.system

    def clock_ms(self, t_s: float) -> int:
        """Time of its own clock, which has an offset and a drift."""
        return round(1000.0 * (self._clock_s + self._clock_rate * t_s))

    def speak(self) -> list[bytes]:
        """The MAVLink packets that it sends at `due_s`. Step the boat to that time first. Sets the next `due_s`."""
        now_s, self.due_s = self.due_s, self.due_s + self._period_s
        packets = []
        if now_s >= self._heartbeat_s - 1e-9:
            self._heartbeat_s += 1.0
            packets.append(
                self._pack(mavlink.MAVLink_heartbeat_message(self._who.vehicle, self._who.autopilot, 0, 0, 4, 3))
            )
        fix = self._boat.fix
        if fix is not None:
            packets.append(self._pack(self._position(fix, now_s)))
            packets += [self._pack(message) for message in self._corrections(fix)]
        if self.sticks is not None and now_s >= self._sticks_s - 1e-9:
            self._sticks_s = now_s + 1.0 / _STICKS_HZ
            packets.append(self._pack(mavlink.MAVLink_manual_control_message(1, *self.sticks, 0)))
        return packets

    def answer(self, message: Any, at_s: float) -> bytes | None:
        """Its answer to a message: the time of its clock to a TIMESYNC request, else None. A phone and MAVSDK do not
        answer."""
        if self.kind in ("phone", "mavsdk") or message.get_type() != "TIMESYNC" or message.tc1 != 0:
            return None
        clock_ns = round(1e9 * (self._clock_s + self._clock_rate * at_s))
        return self._pack(mavlink.MAVLink_timesync_message(clock_ns, message.ts1))

    def _corrections(self, fix: LeaderFix) -> list[Any]:
        """What its moving base sends of that fix, as GPS_RTCM_DATA: pieces of 180 bytes, numbered from 0 to 3."""
        frames = [] if self._base is None or fix.lat_deg is None else self._base.frames(fix.t_s, fix.true_m)
        messages = []
        for frame in frames:
            self._rtcm = (self._rtcm + 1) % 32
            for n in range(0, len(frame), 180):
                piece, flags = frame[n : n + 180], self._rtcm << 3 | n // 180 % 4 << 1 | (len(frame) > 180)
                messages.append(mavlink.MAVLink_gps_rtcm_data_message(flags, len(piece), list(piece.ljust(180, b"\0"))))
        return messages

    def _pack(self, message: Any) -> bytes:
        data: bytes = message.pack(self._codec)
        self._codec.seq = (self._codec.seq + 1) % 256
        return data

    def _position(self, fix: LeaderFix, now_s: float) -> Any:
        if self.kind == "vehicle":
            return self._global_position(fix, now_s)
        if self.kind == "phone":
            return self._bare(fix, self.clock_ms(now_s), _POSITION | _VELOCITY, (0.0,) * 4, (0.0,) * 3)
        if self.kind == "mavsdk":
            return self._bare(fix, 0, _POSITION, (1.0, _NAN, _NAN, _NAN), (_NAN,) * 3)
        return self._follow_target(fix, now_s)

    def _follow_target(self, fix: LeaderFix, now_s: float) -> Any:
        lat, lon = _reckoned(fix, now_s)
        can = (_POSITION | _VELOCITY if lat or lon else 0) | (_ATTITUDE if self._heading else 0)
        whole = self.kind != "radio" or can != self._said or now_s >= self._whole_s - 1e-9
        if whole:
            self._said, self._whole_s = can, now_s + _WHOLE_S
        half = 0.5 * (fix.yaw_rad + fix.yaw_rate_radps * (now_s - fix.t_s))
        attitude = [math.cos(half), 0.0, 0.0, math.sin(half)] if self._heading else [_NAN] * 4
        rates = [0.0, 0.0, fix.yaw_rate_radps if self._heading else 0.0]
        gained_mps = self._boat.velocity_gained_mps if self._heading else (0.0, 0.0)
        velocity = [fix.north_mps + gained_mps[0], fix.east_mps + gained_mps[1], 0.0] if lat or lon else [0.0] * 3
        covariance = [self._sigma_m, 0.0, 0.0] if whole else [0.0] * 3
        return mavlink.MAVLink_follow_target_message(
            self.clock_ms(now_s),
            can if whole else 0,
            lat,
            lon,
            0.0,
            velocity,
            [0.0] * 3,
            attitude,
            rates,
            covariance,
            _MODULE_STATE | self.wish | (_FIX_TYPES[fix.quality] if lat or lon else 1) << 40,
        )

    def _bare(
        self, fix: LeaderFix, clock_ms: int, can: int, attitude: Sequence[float], acceleration: Sequence[float]
    ) -> Any:
        """The fix as it is, without dead reckoning; without a fix a phone sends no position."""
        lat, lon = _scaled(fix.lat_deg, fix.lon_deg)
        velocity = [fix.north_mps, fix.east_mps, 0.0]
        covariance = [self._sigma_m, 0.0, 0.0] if self.kind == "phone" else [0.0] * 3
        return mavlink.MAVLink_follow_target_message(
            clock_ms,
            can if lat or lon else 0,
            lat,
            lon,
            0.0,
            velocity,
            list(acceleration),
            list(attitude),
            [0.0] * 3,
            covariance,
            0,
        )

    def _global_position(self, fix: LeaderFix, now_s: float) -> Any:
        lat, lon = _reckoned(fix, now_s)
        yaw_deg = math.degrees(fix.yaw_rad + fix.yaw_rate_radps * (now_s - fix.t_s)) % 360.0
        heading = min(35999, round(100.0 * yaw_deg)) if self._heading else 65535
        speeds = (round(100.0 * fix.north_mps), round(100.0 * fix.east_mps), 0)
        return mavlink.MAVLink_global_position_int_message(
            self.clock_ms(now_s) % (1 << 32), lat, lon, 0, 0, *speeds, heading
        )


class LeaderPort:
    """The module's side of a link to a follower in another process: a `companion.core.ports.ByteStream`."""

    def __init__(self, name: str, module: EmulatedLeaderModule) -> None:
        self.name = name
        self._module = module
        self._codec = mavlink.MAVLink(None)
        self._codec.robust_parsing = True
        self._answers: list[tuple[float, bytes]] = []

    def read(self, now_s: float) -> Sequence[tuple[float, bytes]]:
        """(time, packet) of all that it has sent by `now_s`."""
        said, self._answers = self._answers, []
        while self._module.due_s <= now_s:
            at_s = self._module.due_s
            said += [(at_s, packet) for packet in self._module.speak()]
        return said

    def write(self, data: bytes, now_s: float) -> None:
        """Packets from the follower; TIMESYNC requests are answered."""
        for message in self._codec.parse_buffer(data) or ():
            if (answer := self._module.answer(message, now_s)) is not None:
                self._answers.append((now_s, answer))

    def fault(self) -> str | None:
        """Always None."""
        return None

    def fileno(self) -> int | None:
        """None: it is in memory."""
        return None

    def close(self) -> None:
        """Nothing to close."""


class RadioPath:
    """Packets on their way from a module to one follower: `take` what is sent, `arrived(until_s)` what has come in."""

    def __init__(
        self,
        name: str,
        *,
        latency_s: float = 0.03,
        jitter_s: float = 0.01,
        loss: float = 0.0,
        cuts: Sequence[tuple[float, float]] = (),
        seed: int = 0,
    ) -> None:
        """`latency_s`: mean, of which at least half always passes; `jitter_s`: one sigma; `loss`: share of packets
        lost; `cuts`: (begin, duration) in s. Raises ConfigError where `loss` is not 0 to 1."""
        if not 0.0 <= loss <= 1.0:
            raise ConfigError([f"loss {loss:g}: must be a share from 0 to 1"])
        self.cuts = list(cuts)
        self._latency_s, self._jitter_s, self._loss = latency_s, jitter_s, loss
        self._draws = stream(seed, f"{name} air")
        self._flying: list[tuple[float, int, bytes]] = []
        self._count = 0

    def take(self, sent_s: float, data: bytes) -> None:
        """A packet sent at `sent_s`."""
        if (at_s := self.arrival_s(sent_s)) is not None:
            self._count += 1
            heapq.heappush(self._flying, (at_s, self._count, data))

    def arrival_s(self, sent_s: float) -> float | None:
        """When a packet sent at `sent_s` arrives, in either direction; None if it is lost."""
        lost = self._draws.random() < self._loss
        delay_s = max(0.5 * self._latency_s, self._draws.gauss(self._latency_s, self._jitter_s))
        cut = any(begin_s <= sent_s < begin_s + duration_s for begin_s, duration_s in self.cuts)
        return None if lost or cut else sent_s + delay_s

    def arrived(self, until_s: float) -> list[tuple[float, bytes]]:
        """(time of arrival, packet) of all that have arrived by `until_s`, in that order."""
        flying, arrived = self._flying, []
        while flying and flying[0][0] <= until_s:
            at_s, _, data = heapq.heappop(flying)
            arrived.append((at_s, data))
        return arrived


def _reckoned(fix: LeaderFix, now_s: float) -> tuple[int, int]:
    """Latitude and longitude in 1e-7 degrees, moved from the fix to `now_s`; 0, 0 without a fix."""
    if fix.lat_deg is None or fix.lon_deg is None:
        return 0, 0
    age_s = now_s - fix.t_s
    return _scaled(*LocalFrame(fix.lat_deg, fix.lon_deg).to_geodetic(fix.north_mps * age_s, fix.east_mps * age_s))


def _scaled(lat_deg: float | None, lon_deg: float | None) -> tuple[int, int]:
    return (0, 0) if lat_deg is None or lon_deg is None else (round(lat_deg * 1e7), round(lon_deg * 1e7))


def _sigma_m(receiver: Grade) -> float:
    return math.hypot(receiver.white_m, receiver.slow_m)
