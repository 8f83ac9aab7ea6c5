"""The lead boat: where it is now, from its messages."""

from __future__ import annotations

import math
import statistics
from collections import deque

from companion.core.angles import wrap_pi
from companion.core.estimate import Leader
from companion.core.geodesy import LocalFrame
from companion.core.readings import FixType, LeaderState
from companion.following.filter import LeaderFilter
from companion.following.link_counter import LinkCounter

_SLOW_MPS = 0.5  # below this the course gives no heading
_ASTERN_MPS = 0.3  # against its heading, from which on it goes astern
FORGET_S = 30.0  # of silence, after which another may lead
_SIGMA_M = 3.0  # of a leader that does not say how good its position is
_LEAST_SIGMA_M, _MOST_SIGMA_M = 0.3, 10.0
_SIGMA_MPS = 0.12
_ANEW_S = 8.0  # without a position, after which the filter begins anew
_REFUSED_S, _REFUSED = 2.0, 3  # for how long, and how many in a row, positions are rejected as outliers
_FAR_M = 20_000.0  # from the origin of its own plane, which is then laid anew
_YAW_SHARE = 0.4  # of the difference between measured and expected heading that is applied
_RATE_TAU_S, _COURSE_RATE_TAU_S, _PUSH_TAU_S = 0.2, 0.6, 0.6
_BARE_RATE_TAU_S = 3.0  # of the turn by positions alone: one found sooner feeds on itself
_LATELY = 9  # intervals
# Its heading lies where it points further off its course than this for so long at speed, or over such a way at any
# speed: no boat goes astern so fast or so far.
_OFF_COURSE_RAD, _OFF_COURSE_S, _AT_SPEED_MPS, _OFF_COURSE_M = math.radians(60.0), 2.0, 3.0, 60.0


class LeaderTracker:
    """`take(state)` each message, `leader(frame, now_s)` → Leader, or None while none has been heard.

    It is given the leader's messages only; those of another system begin anew. Who leads is decided in
    `supervisor/authority.py`. Remembers its filter in a plane of its own, heading, the last intervals, and since when
    positions are rejected. Fixes count by the time at which they were valid; one older than the last is ignored.
    """

    def __init__(self) -> None:
        self._state: LeaderState | None = None
        self._forget()

    def _forget(self) -> None:
        self._fixed: LeaderState | None = None  # the last one with a position
        self._filter: LeaderFilter | None = None
        self._plane: LocalFrame | None = None
        self._intervals: deque[float] = deque(maxlen=_LATELY)
        self._yaw_rad: float | None = None
        self._told_yaw = False
        self._off_course_s = self._off_course_m = 0.0  # for how long, fast, and how far its heading was off its course
        self._heading_lies = False
        self._refused = 0
        self._refused_s = 0.0
        self._link = LinkCounter()
        self._known: tuple[float, LocalFrame, Leader] | None = None

    @property
    def fix(self) -> FixType | None:
        """Kind of fix of the last position; None where it is not said."""
        return None if self._fixed is None else self._fixed.fix

    @property
    def system_id(self) -> int | None:
        """The system that leads; None before any was heard."""
        return None if self._state is None else self._state.system_id

    def silent_s(self, now_s: float) -> float:
        """Since its last message; infinite before any."""
        return math.inf if self._state is None else now_s - self._state.heard_s

    def take(self, state: LeaderState) -> None:
        """One message of the leader."""
        if state.system_id != self.system_id:
            self._forget()
        self._state = state
        self._known = None
        self._link.heard(state.heard_s, state.lost)
        if state.lat_deg is None or state.lon_deg is None or (self._fixed is not None and state.t_s <= self._fixed.t_s):
            return
        if self._fixed is not None:
            self._intervals.append(state.t_s - self._fixed.t_s)
        self._fixed = state
        self._fuse(state, state.lat_deg, state.lon_deg)

    # --- the filter ------------------------------------------------------------------------------------------------

    def _fuse(self, state: LeaderState, lat_deg: float, lon_deg: float) -> None:
        filter_, plane = self._filter, self._plane
        if filter_ is None or plane is None or state.t_s - filter_.t_s > _ANEW_S:
            self._begin(state, lat_deg, lon_deg)
            return
        if math.hypot(filter_.north_m, filter_.east_m) > _FAR_M:
            plane = self._plane = LocalFrame(*plane.to_geodetic(filter_.north_m, filter_.east_m))
            filter_.north_m = filter_.east_m = 0.0
        north_m, east_m = plane.to_ned(lat_deg, lon_deg)
        dt_s = state.t_s - filter_.t_s
        was = math.hypot(filter_.north_mps, filter_.east_mps), math.atan2(filter_.east_mps, filter_.north_mps)
        filter_.advance(state.t_s)
        taken = filter_.take_position(north_m, east_m, _sigma_m(state))
        if not taken and self._still_outlier(state.t_s):
            return
        if not taken:
            self._begin(state, lat_deg, lon_deg)
            return
        self._refused = 0
        if state.north_mps is not None and state.east_mps is not None:
            filter_.take_velocity(state.north_mps, state.east_mps, _SIGMA_MPS)
        self._see_motion(filter_, state, *was, dt_s)
        self._see_heading(filter_, state, dt_s)

    def _begin(self, state: LeaderState, lat_deg: float, lon_deg: float) -> None:
        """Begin at that position, with the velocity of the message or none."""
        self._plane = LocalFrame(lat_deg, lon_deg)
        filter_ = self._filter = LeaderFilter(state.t_s, 0.0, 0.0, _sigma_m(state))
        self._refused = 0
        if state.north_mps is not None and state.east_mps is not None:
            filter_.take_velocity(state.north_mps, state.east_mps, _SIGMA_MPS)
        filter_.turn_radps = state.yaw_rate_radps or 0.0
        self._yaw_rad = self._yaw_rad if state.yaw_rad is None else state.yaw_rad
        self._see_heading(filter_, state, 0.0)

    def _still_outlier(self, t_s: float) -> bool:
        """Whether a position far from the expected one is still rejected as an outlier."""
        if self._refused == 0:
            self._refused_s = t_s
        self._refused += 1
        return self._refused <= _REFUSED or t_s - self._refused_s < _REFUSED_S

    @staticmethod
    def _see_motion(filter_: LeaderFilter, state: LeaderState, was_mps: float, was_rad: float, dt_s: float) -> None:
        """Turn and acceleration, from the gyro where there is one. Without velocities, what the filter makes of an
        acceleration would be the next one: there is none then."""
        speed, bare = math.hypot(filter_.north_mps, filter_.east_mps), state.north_mps is None
        push = 0.0 if bare else (speed - was_mps) / dt_s
        filter_.acceleration_mps2 += (push - filter_.acceleration_mps2) * (1.0 if bare else dt_s / (dt_s + _PUSH_TAU_S))
        if state.yaw_rate_radps is not None:
            filter_.turn_radps += (state.yaw_rate_radps - filter_.turn_radps) * dt_s / (dt_s + _RATE_TAU_S)
        elif min(speed, was_mps) > _SLOW_MPS:
            turn = wrap_pi(math.atan2(filter_.east_mps, filter_.north_mps) - was_rad) / dt_s
            tau_s = _BARE_RATE_TAU_S if bare else _COURSE_RATE_TAU_S
            filter_.turn_radps += (turn - filter_.turn_radps) * dt_s / (dt_s + tau_s)
        else:
            filter_.turn_radps = 0.0

    def _see_heading(self, filter_: LeaderFilter, state: LeaderState, dt_s: float) -> None:
        """The heading of the message; without one, or where it lies, the course; the last heading while the leader is
        too slow for one."""
        self._doubt_heading(filter_, state.yaw_rad, dt_s)
        told = None if self._heading_lies else state.yaw_rad
        self._told_yaw = told is not None
        if told is not None:
            expected = told if self._yaw_rad is None or dt_s <= 0.0 else self._yaw_rad + filter_.turn_radps * dt_s
            self._yaw_rad = wrap_pi(expected + _YAW_SHARE * wrap_pi(told - expected))
        elif math.hypot(filter_.north_mps, filter_.east_mps) > _SLOW_MPS:
            self._yaw_rad = math.atan2(filter_.east_mps, filter_.north_mps)

    def _doubt_heading(self, filter_: LeaderFilter, yaw_rad: float | None, dt_s: float) -> None:
        """Judge its heading by its course, while it is fast enough to have one."""
        speed_mps = math.hypot(filter_.north_mps, filter_.east_mps)
        if yaw_rad is None or speed_mps < _SLOW_MPS:
            return
        off = abs(wrap_pi(yaw_rad - math.atan2(filter_.east_mps, filter_.north_mps)))
        if off < _OFF_COURSE_RAD:
            self._off_course_s = self._off_course_m = 0.0
            self._heading_lies = False
            return
        self._off_course_m += speed_mps * dt_s
        self._off_course_s += dt_s if speed_mps > _AT_SPEED_MPS else 0.0
        self._heading_lies |= self._off_course_s >= _OFF_COURSE_S or self._off_course_m >= _OFF_COURSE_M

    # --- what is known ---------------------------------------------------------------------------------------------

    def leader(self, frame: LocalFrame, now_s: float) -> Leader | None:
        """The leader at `now_s` in the plane of `frame`; None while no position is known."""
        state, fixed, filter_, plane = self._state, self._fixed, self._filter, self._plane
        if state is None or fixed is None or filter_ is None or plane is None:
            return None
        known = self._known
        if known is not None and known[0] == now_s and known[1] == frame:
            return known[2]
        ahead_s = max(0.0, now_s - filter_.t_s)
        north_m, east_m, north_mps, east_mps = filter_.at(filter_.t_s + ahead_s)
        north_m, east_m = frame.to_ned(*plane.to_geodetic(north_m, east_m))
        rate = filter_.turn_radps
        yaw = None if self._yaw_rad is None else wrap_pi(self._yaw_rad + rate * min(ahead_s, 1.0))
        astern = (
            self._told_yaw and yaw is not None and north_mps * math.cos(yaw) + east_mps * math.sin(yaw) < -_ASTERN_MPS
        )
        sigma_m, age_s = max(_sigma_m(fixed), filter_.sigma_m), max(0.0, now_s - fixed.t_s)
        interval_s = statistics.median(self._intervals) if self._intervals else 0.0
        leader = Leader(
            state.system_id, north_m, east_m, north_mps, east_mps, yaw, rate, sigma_m, age_s, interval_s, state.wish,
            self._link.value(now_s), filter_.acceleration_mps2, astern, heading_lies=self._heading_lies,
        )  # fmt: skip
        self._known = (now_s, frame, leader)
        return leader


def _sigma_m(state: LeaderState) -> float:
    """Standard deviation of its position, m, within limits."""
    accuracy_m = _SIGMA_M if state.accuracy_m is None or not state.accuracy_m > 0.0 else state.accuracy_m
    return min(_MOST_SIGMA_M, max(_LEAST_SIGMA_M, accuracy_m))
