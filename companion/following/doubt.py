"""Whether a leader's positions can be true: against the velocity that it reports, and against each other."""

from __future__ import annotations

import math

from companion.core.geodesy import rough_distance_and_bearing
from companion.core.readings import LeaderState

_JUMP_M, _JUMP_SIGMAS = 10.0, 6.0  # a difference between expected and reported position that no receiver explains
_SPEED_SHARE = 0.5  # of the way since the last position, by which a velocity may be wrong
_IN_A_ROW = 4  # positions that agree with each other at another place; fewer are outliers
_LONGEST_GAP_S = 2.0  # after it the leader may be anywhere
_JUMP_LASTS_S = 10.0
_SIGMA_M = 3.0  # of a leader that does not say how good its position is
_WAY_M, _LEAST_S = 3.0, 1.5  # way by its velocity, and time, after which it is asked whether it has moved
_MOVED_SHARE = 0.3
_REST_MPS = 0.3  # below it a leader may lie still: what its velocity adds up to is noise

_Place = tuple[float, float, float]
"""t_s, lat_deg, lon_deg."""


class LeaderDoubt:
    """`see(state)` each position in order of time; `text(now_s)` says why it cannot be true, for people, or None.

    A jump is a position off the expected one by more than 10 m and 6 sigmas, confirmed by the next three: it counts for
    10 s, and `jump_m` stays until `forget_jump`. A leader repeats its position where none of a stretch is further from
    its beginning than 0.3 of the way that its own velocity makes, in at least 3 m and 1.5 s. One that lies still, or
    sends no velocity, is not judged.
    """

    def __init__(self) -> None:
        self._last: LeaderState | None = None  # believed
        self._other: LeaderState | None = None  # at another place
        self._others = 0
        self._anchor: _Place | None = None
        self._way_m = self._moved_m = 0.0
        self._repeats = False
        self._jumped_s = -math.inf
        self.jump_m: float | None = None

    def forget_jump(self) -> None:
        """A person has decided to follow it all the same."""
        self.jump_m = None
        self._jumped_s = -math.inf

    def text(self, now_s: float) -> str | None:
        """Why its positions cannot be true now, or None."""
        if self.jump_m is not None and now_s - self._jumped_s <= _JUMP_LASTS_S:
            return f"leader jumped {self.jump_m:.0f} m"
        return "leader repeats its position" if self._repeats else None

    def see(self, state: LeaderState) -> None:
        """A position. One that is older than the last, or without a velocity, is ignored."""
        if state.lat_deg is None or state.north_mps is None or state.east_mps is None:
            return
        if self._last is not None and state.t_s <= self._last.t_s:
            return
        self._see_way(state)
        last = self._last
        if last is None or state.t_s - last.t_s > _LONGEST_GAP_S or _apart_m(last, state) <= _tolerated_m(last, state):
            self._last, self._other, self._others = state, None, 0
            return
        other = self._other
        agrees = other is not None and _apart_m(other, state) <= _tolerated_m(other, state)
        self._others = self._others + 1 if agrees else 1
        self._other = state
        if self._others >= _IN_A_ROW:
            self.jump_m, self._jumped_s = _apart_m(last, state), state.heard_s
            self._last, self._other, self._others = state, None, 0

    def _see_way(self, state: LeaderState) -> None:
        lat_deg, lon_deg = state.lat_deg or 0.0, state.lon_deg or 0.0
        speed_mps = math.hypot(state.north_mps or 0.0, state.east_mps or 0.0)
        anchor, last = self._anchor, self._last
        unjudged = speed_mps < _REST_MPS or last is None or state.t_s - last.t_s > _LONGEST_GAP_S
        if unjudged or anchor is None or last is None:
            self._anchor, self._way_m, self._moved_m = (state.t_s, lat_deg, lon_deg), 0.0, 0.0
            return
        self._way_m += speed_mps * (state.t_s - last.t_s)
        moved_m = rough_distance_and_bearing(anchor[1], anchor[2], lat_deg, lon_deg)[0]
        self._moved_m = max(self._moved_m, moved_m)
        if self._way_m >= _WAY_M and state.t_s - anchor[0] >= _LEAST_S:
            self._repeats = self._moved_m < _MOVED_SHARE * self._way_m
            self._anchor, self._way_m, self._moved_m = (state.t_s, lat_deg, lon_deg), 0.0, 0.0


def _apart_m(before: LeaderState, state: LeaderState) -> float:
    """How far a position is from where the leader should be since the one before."""
    dt_s = state.t_s - before.t_s
    distance_m, bearing_rad = rough_distance_and_bearing(
        before.lat_deg or 0.0, before.lon_deg or 0.0, state.lat_deg or 0.0, state.lon_deg or 0.0
    )
    north_m = distance_m * math.cos(bearing_rad) - dt_s * (before.north_mps or 0.0)
    east_m = distance_m * math.sin(bearing_rad) - dt_s * (before.east_mps or 0.0)
    return math.hypot(north_m, east_m)


def _tolerated_m(before: LeaderState, state: LeaderState) -> float:
    sigma_m = max(before.accuracy_m or _SIGMA_M, state.accuracy_m or _SIGMA_M)
    way_m = (state.t_s - before.t_s) * math.hypot(before.north_mps or 0.0, before.east_mps or 0.0)
    return max(_JUMP_M, _JUMP_SIGMAS * sigma_m) + _SPEED_SHARE * way_m
