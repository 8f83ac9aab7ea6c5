"""The lead boat as other systems report it: FOLLOW_TARGET of a leader module, a phone or a ground station,
GLOBAL_POSITION_INT of another vehicle.

What counts as known, by sender:

    leader module     custom_state has its mark; est_capabilities 0 means "as in the last whole message", one of which
                      comes each second
    QGroundControl    position and velocity, 4 Hz; no heading
    MAVSDK, phones    1 to 4 Hz, time stamps that stand still, attitude not a number. Only the capability of a position
                      is set though velocity may be filled in. A velocity that is finite and not exactly 0 counts: the
                      examples of MAVSDK fill in three zeros for "unknown"
    another vehicle   GLOBAL_POSITION_INT, when its system id is FOLL_SYSID
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from companion.core.readings import LEADER_MODULE, FixType, LeaderState, Wish
from companion.following.clock_alignment import ClockAlignment
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.io.mavlink.wire.reception import Reception
from companion.loop import Vessel
from companion.supervisor.authority import AuthorityRequest, RequestedAction, Right
from companion.supervisor.homing import is_on_earth

_POSITION, _VELOCITY, _ATTITUDE = 1, 2, 8  # est_capabilities
_MODULE_CAN = _POSITION | _VELOCITY | _ATTITUDE
_FASTEST_MPS = 100.0
_FASTEST_TURN_RADPS = math.tau
_LARGEST_SIGMA_M = 1000.0
_MOST_SOURCES = 16
_ASK_S, _ASK_FIRST_S = 10.0, 1.0  # how often a leader is asked for its time; until it has answered once
_ANSWER_S = 5.0
_ASK_MOST = 10  # questions to a system that never answers and is no leader module
_FOLLOW_TARGET, _GLOBAL_POSITION = mavlink.MAVLINK_MSG_ID_FOLLOW_TARGET, mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT
_WISHES = {int(wish): wish for wish in Wish}
_FIXES = {int(fix): fix for fix in FixType if fix is not FixType.NONE}
_SourceKey = tuple[str, int, int, int]  # name of the endpoint, system, component, id of the message


@dataclass(slots=True)
class _Source:
    """One kind of message of one sender: its clock, how many were lost, what its last whole message said, and the
    question that it was asked."""

    endpoint: Endpoint
    heard_s: float
    clock: ClockAlignment = field(default_factory=ClockAlignment)
    lost: int | None = None  # of its Reception, as last seen
    can: int = _MODULE_CAN
    accuracy_m: float | None = None
    module: bool = False
    asked_s: float = -math.inf
    asked_ns: int = 0
    unanswered: int = 0


@dataclass(frozen=True, slots=True)
class _Motion:
    """What one message says; None for what it does not say. `module_state`: the custom_state of a leader module."""

    stamp_s: float
    position: tuple[float, float] | None
    velocity: tuple[float, float] | None
    yaw_rad: float | None
    rate_radps: float | None = None
    module_state: int | None = None


class LeaderService:
    """In: FOLLOW_TARGET, GLOBAL_POSITION_INT, answers to TIMESYNC. Out: leader states to the supervisor, questions for
    the time.

    Messages with impossible values are ignored. Remembers each sender's clock, for at most 16 senders.
    """

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self._sources: dict[_SourceKey, _Source] = {}
        self.handles: Mapping[int, Handler] = {
            _FOLLOW_TARGET: self._on_follow_target,
            _GLOBAL_POSITION: self._on_global_position,
            mavlink.MAVLINK_MSG_ID_TIMESYNC: self._on_timesync,
        }

    def update(self, now_s: float) -> None:
        """Ask the leader for its time: seldom, since the link may be narrow."""
        for (_, system, component, _), source in self._sources.items():
            answers = source.module or source.unanswered < _ASK_MOST
            if source.endpoint.gone or now_s - source.heard_s > _ANSWER_S or not source.clock.aligned or not answers:
                continue
            soon_s = _ASK_FIRST_S * (1 + source.unanswered) if source.clock.latency_s is None else _ASK_S
            if now_s - source.asked_s >= min(_ASK_S, soon_s):
                source.asked_s, source.asked_ns = now_s, max(1, round(now_s * 1e9))
                source.unanswered += 1
                peer = Peer(source.endpoint, system, component)
                self._hub.send(peer, mavlink.MAVLink_timesync_message(0, source.asked_ns, system, component))

    # --- messages --------------------------------------------------------------------------------------------------

    def _on_follow_target(self, message: Any, peer: Peer, now_s: float) -> None:
        source = self._source(_FOLLOW_TARGET, peer, now_s)
        state = message.custom_state
        source.module = state & 0xFFFFFF00 == LEADER_MODULE
        if not source.module:
            source.can, source.accuracy_m = _capabilities(message), _sigma(message)
        else:
            peer.endpoint.leader = self._reception(peer)
            if message.est_capabilities:
                source.can, source.accuracy_m = message.est_capabilities, _sigma(message)
        can = source.can
        placed = can & _POSITION and (message.lat, message.lon) != (0, 0)
        position = _position(message) if placed else None
        if placed and position is None:
            return
        velocity = _velocity(message.vel) if can & _VELOCITY else None
        yaw_rad, rate_radps = _yaw(message.attitude_q, message.rates) if can & _ATTITUDE else (None, None)
        module_state = state if source.module else None
        motion = _Motion(message.timestamp * 1e-3, position, velocity, yaw_rad, rate_radps, module_state)
        self._report(source, peer, now_s, motion)

    def _on_global_position(self, message: Any, peer: Peer, now_s: float) -> None:
        """Of a vehicle that leads, unless it sends FOLLOW_TARGET too."""
        request = AuthorityRequest(RequestedAction.LEADER_POSITION, Right.VEHICLE, peer.system)
        if self._vessel.supervisor.refusal(request, now_s) is not None:
            return
        better = (
            s for (_, system, _, kind), s in self._sources.items() if system == peer.system and kind == _FOLLOW_TARGET
        )
        if any(now_s - other.heard_s <= _ANSWER_S for other in better):
            return
        source = self._source(_GLOBAL_POSITION, peer, now_s)
        placed = (message.lat, message.lon) != (0, 0)
        position = _position(message) if placed else None
        if placed and position is None:
            return
        velocity = _velocity((message.vx * 0.01, message.vy * 0.01)) if placed else None
        yaw_rad = (
            math.remainder(math.radians(message.hdg * 0.01), math.tau) if message.hdg <= 36000 else None
        )  # 65535: unknown
        self._report(source, peer, now_s, _Motion(message.time_boot_ms * 1e-3, position, velocity, yaw_rad))

    def _on_timesync(self, message: Any, peer: Peer, now_s: float) -> None:
        """An answer has the boat's time unchanged, and the sender's own."""
        if message.tc1 == 0:
            return
        for kind in (_FOLLOW_TARGET, _GLOBAL_POSITION):
            source = self._sources.get((peer.endpoint.name, peer.system, peer.component, kind))
            if source is not None and source.asked_ns and message.ts1 == source.asked_ns:
                if now_s - source.asked_s <= _ANSWER_S * self._hub.patience:
                    source.clock.exchanged(source.asked_s, message.tc1 * 1e-9, now_s)
                    source.unanswered = 0
                source.asked_ns = 0

    # --- parts -----------------------------------------------------------------------------------------------------

    def _report(self, source: _Source, peer: Peer, now_s: float, motion: _Motion) -> None:
        reception = self._reception(peer)
        lost_before = reception.lost if source.lost is None else source.lost
        source.lost = reception.lost
        position, velocity, state = motion.position, motion.velocity, motion.module_state
        self._vessel.supervisor.leader_heard(
            LeaderState(
                t_s=source.clock.arrived(motion.stamp_s, now_s, self._vessel.parameters["FOLL_LATENCY"]),
                heard_s=now_s,
                source=f"mavlink:{peer.system}",
                system_id=peer.system,
                lat_deg=None if position is None else position[0],
                lon_deg=None if position is None else position[1],
                north_mps=None if velocity is None else velocity[0],
                east_mps=None if velocity is None else velocity[1],
                yaw_rad=motion.yaw_rad,
                yaw_rate_radps=motion.rate_radps,
                accuracy_m=source.accuracy_m,
                wish=None if state is None else _WISHES.get(state & 0xFF, Wish.NONE),
                lost=max(0, reception.lost - lost_before),
                presses=0 if state is None else state >> 32 & 0xFF,
                fix=None if state is None else _FIXES.get(state >> 40 & 0x0F),
            )
        )

    def _source(self, kind: int, peer: Peer, now_s: float) -> _Source:
        key = (peer.endpoint.name, peer.system, peer.component, kind)
        source = self._sources.get(key)
        if source is None:
            if len(self._sources) >= _MOST_SOURCES:
                del self._sources[min(self._sources, key=lambda other: self._sources[other].heard_s)]
            source = self._sources[key] = _Source(peer.endpoint, now_s)
        source.endpoint, source.heard_s = peer.endpoint, now_s
        return source

    @staticmethod
    def _reception(peer: Peer) -> Reception:
        return peer.endpoint.receptions.of(peer.system, peer.component) or Reception()


def _capabilities(message: Any) -> int:
    """What a sender other than a module knows: what it claims, and a velocity that it fills in without a claim."""
    claimed: int = message.est_capabilities
    filled_in = all(map(math.isfinite, message.vel[:2])) and any(message.vel[:2])
    return claimed | _VELOCITY if filled_in else claimed


def _position(message: Any) -> tuple[float, float] | None:
    lat_deg, lon_deg = message.lat * 1e-7, message.lon * 1e-7
    return (lat_deg, lon_deg) if is_on_earth(lat_deg, lon_deg) else None


def _velocity(vel: Sequence[float]) -> tuple[float, float] | None:
    north_mps, east_mps = vel[0], vel[1]
    plausible = math.isfinite(north_mps) and math.isfinite(east_mps) and math.hypot(north_mps, east_mps) <= _FASTEST_MPS
    return (north_mps, east_mps) if plausible else None


def _yaw(q: Sequence[float], rates: Sequence[float]) -> tuple[float | None, float | None]:
    """(heading, its rate) of an attitude w, x, y, z; None for what is no attitude."""
    if not all(map(math.isfinite, q)) or not 0.9 <= math.sqrt(sum(part * part for part in q)) <= 1.1:
        return None, None
    w, x, y, z = q
    yaw_rad = math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    turning = math.isfinite(rates[2]) and abs(rates[2]) <= _FASTEST_TURN_RADPS
    return yaw_rad, rates[2] if turning else None


def _sigma(message: Any) -> float | None:
    sigma_m: float = message.position_cov[0]
    return sigma_m if 0.0 < sigma_m <= _LARGEST_SIGMA_M else None
