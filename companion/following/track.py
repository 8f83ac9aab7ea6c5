"""The track of the lead boat: crumbs of its filtered way with their courses, addressed by arc length.

A crumb is laid every few metres of way, when a fix has just come in. Its course is that of the velocity, which a
receiver measures far better than two positions give it. The leader itself is the live end of the track. Where the
leader goes back over its track, the track is shortened with it.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from typing import NamedTuple

from companion.core.angles import wrap_pi
from companion.core.estimate import Leader

_COURSE_MPS = 0.5  # a slower velocity has no course
_CURVE_SPACINGS = 2.0  # to either side, over which the curvature is taken
_BESIDE_SPACINGS = 4.0  # further beside its track, the leader is not going back along it
_KEPT_M = 40.0  # kept astern of the place up to which the track is needed
_MOST_CRUMBS = 2000


class _Crumb(NamedTuple):
    """Arc length along the track, place and course there."""

    s_m: float
    north_m: float
    east_m: float
    course_rad: float


@dataclass(frozen=True, slots=True)
class TrackPoint:
    """Place on the track, its direction there and how it bends (positive to starboard)."""

    north_m: float
    east_m: float
    course_rad: float
    curvature_1pm: float


class LeaderTrack:
    """`start`, then `update(leader, now_s)` each tick. Queries are by arc length, which grows as the leader goes on.

    Remembers the crumbs (arc length, north, east, course), the live end and the time of the last fix.
    """

    def __init__(self, spacing_m: float = 2.0) -> None:
        self._spacing_m = spacing_m
        self._s: list[float] = []
        self._north: list[float] = []
        self._east: list[float] = []
        self._course: list[float] = []
        self._end = _Crumb(0.0, 0.0, 0.0, 0.0)  # the leader itself
        self._fixed_s = -math.inf

    @property
    def begin_s_m(self) -> float:
        """Arc length at which the track begins."""
        return self._s[0]

    @property
    def end_s_m(self) -> float:
        """Arc length of the leader."""
        return self._end.s_m

    def start(self, leader: Leader, behind_m: float, course_rad: float, now_s: float) -> None:
        """Begin with a straight line of that length and direction, which ends at the leader."""
        count = max(2, math.ceil(behind_m / self._spacing_m) + 1)
        back = [behind_m * (1.0 - i / (count - 1)) for i in range(count)]
        self._s = [behind_m - b for b in back]
        self._north = [leader.north_m - b * math.cos(course_rad) for b in back]
        self._east = [leader.east_m - b * math.sin(course_rad) for b in back]
        self._course = [course_rad] * count
        self._end = _Crumb(behind_m, leader.north_m, leader.east_m, course_rad)
        self._fixed_s = now_s - leader.age_s

    def update(self, leader: Leader, now_s: float) -> None:
        """Move the end to the leader: lay a crumb, or take crumbs back where the leader goes astern over them."""
        fresh = now_s - leader.age_s > self._fixed_s + 1e-6
        north_m, east_m = leader.north_m, leader.east_m
        along, across = self._from_last(north_m, east_m)
        if along < -0.5 * self._spacing_m and abs(across) < _BESIDE_SPACINGS * self._spacing_m:
            self._take_back(north_m, east_m)
            along, across = self._from_last(north_m, east_m)
        course = self._course_of(leader, along, across)
        if fresh:
            self._fixed_s = now_s - leader.age_s
            away = math.hypot(along, across)
            if away >= self._spacing_m and (along > 0.0 or away > _BESIDE_SPACINGS * self._spacing_m):
                self._lay(north_m, east_m, course)
                along = 0.0
        self._end = _Crumb(self._s[-1] + along, north_m, east_m, course)

    def _from_last(self, north_m: float, east_m: float) -> tuple[float, float]:
        """(along, across) in m from the last crumb, in its direction."""
        c, s = math.cos(self._course[-1]), math.sin(self._course[-1])
        dn, de = north_m - self._north[-1], east_m - self._east[-1]
        return dn * c + de * s, de * c - dn * s

    def _take_back(self, north_m: float, east_m: float) -> None:
        while len(self._s) > 2 and self._from_last(north_m, east_m)[0] < 0.0:
            for column in (self._s, self._north, self._east, self._course):
                column.pop()

    def _course_of(self, leader: Leader, along: float, across: float) -> float:
        """Direction in which the track goes on at the leader."""
        last = self._course[-1]
        if leader.speed_mps > _COURSE_MPS:
            course = math.atan2(leader.east_mps, leader.north_mps)
            return course if abs(wrap_pi(course - last)) < 0.5 * math.pi or along > self._spacing_m else last
        return wrap_pi(last + math.atan2(across, along)) if along > 0.5 * self._spacing_m else last

    def _lay(self, north_m: float, east_m: float, course_rad: float) -> None:
        """Lay a crumb there. Where fixes are rare, fill the gap with crumbs on a cubic Hermite curve."""
        n0, e0, c0, s0 = self._north[-1], self._east[-1], self._course[-1], self._s[-1]
        chord = math.hypot(north_m - n0, east_m - e0)
        turn = wrap_pi(course_rad - c0)
        parts = min(_MOST_CRUMBS, max(1, round(chord / self._spacing_m))) if abs(turn) < 0.5 * math.pi else 1
        mn, me = chord * math.cos(c0), chord * math.sin(c0)
        kn, ke = chord * math.cos(course_rad), chord * math.sin(course_rad)
        last_n, last_e, s = n0, e0, s0
        for i in range(1, parts + 1):
            x = i / parts
            h00, h10, h01, h11 = (1 + 2 * x) * (1 - x) ** 2, x * (1 - x) ** 2, x * x * (3 - 2 * x), x * x * (x - 1)
            n = h00 * n0 + h10 * mn + h01 * north_m + h11 * kn
            e = h00 * e0 + h10 * me + h01 * east_m + h11 * ke
            s += math.hypot(n - last_n, e - last_e)
            self._s.append(s)
            self._north.append(n)
            self._east.append(e)
            self._course.append(wrap_pi(c0 + x * turn))
            last_n, last_e = n, e
        if len(self._s) > _MOST_CRUMBS:
            self.trim(self._s[len(self._s) - _MOST_CRUMBS] + _KEPT_M)

    def trim(self, s_m: float) -> None:
        """Forget what lies far astern of `s_m`."""
        first = bisect_left(self._s, s_m - _KEPT_M)
        first = min(first, len(self._s) - 2)
        if first > 16:
            for column in (self._s, self._north, self._east, self._course):
                del column[:first]

    def at(self, s_m: float) -> TrackPoint:
        """The point at that arc length; straight on beyond either end."""
        north, east, course = self._place(s_m)
        h = _CURVE_SPACINGS * self._spacing_m
        ahead, behind = min(self._end.s_m, s_m + h), max(self._s[0], s_m - h)
        turn = wrap_pi(self._place(ahead)[2] - self._place(behind)[2])
        return TrackPoint(north, east, course, turn / (ahead - behind) if ahead - behind > 0.5 * h else 0.0)

    def _place(self, s_m: float) -> tuple[float, float, float]:
        i = bisect_right(self._s, s_m) - 1
        if i < 0:
            return self._straight(0, s_m)
        if i + 1 < len(self._s):
            return self._between(s_m, i, self._crumb(i + 1))
        end = self._end
        if end.s_m <= self._s[-1] + 0.05 * self._spacing_m:
            return self._straight(-1, s_m)
        if s_m >= end.s_m:
            away, course = s_m - end.s_m, end.course_rad
            return end.north_m + away * math.cos(course), end.east_m + away * math.sin(course), course
        return self._between(s_m, i, end)

    def _crumb(self, i: int) -> _Crumb:
        return _Crumb(self._s[i], self._north[i], self._east[i], self._course[i])

    def _straight(self, i: int, s_m: float) -> tuple[float, float, float]:
        away, course = s_m - self._s[i], self._course[i]
        return self._north[i] + away * math.cos(course), self._east[i] + away * math.sin(course), course

    def _between(self, s_m: float, i: int, end: _Crumb) -> tuple[float, float, float]:
        x = (s_m - self._s[i]) / max(1e-9, end.s_m - self._s[i])
        course = wrap_pi(self._course[i] + x * wrap_pi(end.course_rad - self._course[i]))
        north, east = self._north[i], self._east[i]
        return north + x * (end.north_m - north), east + x * (end.east_m - east), course

    def project(self, north_m: float, east_m: float, near_s_m: float | None, reach_m: float = math.inf) -> float:
        """Arc length of the nearest point of the track, within `reach_m` of `near_s_m` where that is given. The limit
        keeps the boat on its own part of a track that crosses itself. Beyond either end the track goes straight on."""
        low, high = -math.inf, math.inf
        if near_s_m is not None:
            low, high = near_s_m - reach_m, near_s_m + reach_m
        begin = max(0, bisect_right(self._s, low) - 1)
        stop = min(len(self._s), bisect_left(self._s, high) + 1)
        best, found = math.inf, self._end.s_m if near_s_m is None else near_s_m
        for i in range(begin, max(begin + 1, stop)):
            last = i + 1 >= len(self._s)
            s1, n1, e1, _ = self._end if last else self._crumb(i + 1)
            n0, e0, s0 = self._north[i], self._east[i], self._s[i]
            dn, de = n1 - n0, e1 - e0
            length2 = dn * dn + de * de
            x = ((north_m - n0) * dn + (east_m - e0) * de) / length2 if length2 > 1e-6 else 0.0
            lowest, highest = (-math.inf if i == 0 else 0.0), (math.inf if last and s1 > s0 else 1.0)
            x = min(highest, max(lowest, x))
            off = (n0 + x * dn - north_m) ** 2 + (e0 + x * de - east_m) ** 2
            if off < best:
                best, found = off, s0 + x * (s1 - s0)
        return min(high, max(low, found))
