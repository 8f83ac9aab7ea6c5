"""Water too shallow for the boat, by its echo sounders: where it was found, and how soon it comes by the slope of the
bottom.

CP_DEPTH_MIN is the least depth below the transducer and, by the slope, below the bow half a length ahead of it. A shoal
found becomes a circle ahead of the boat, larger each time that it is met again: so the boat turns back, and gropes its
way round.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from companion.core.estimate import NavState
from companion.core.readings import Depth, DepthAhead
from companion.obstacles.clear_way import stop_m
from companion.obstacles.occupancy import Floats
from companion.params.store import Parameters

_STALE_S = 5.0
_TRACK_M, _STEP_M = 12.0, 0.5  # length of track over which the slope counts, and between its samples
_LEAST_SAMPLES = 6
_LEAST_SQUARE_M2 = 1.0
_RISES = 0.02  # slope of a bottom that surely rises
_LEVEL_SHARE = 0.02  # of the track's spread, that speaks for a level bottom across it
_SHALLOW_S = 0.4  # for that long, and by two readings, before it counts: fish and bubbles
_ALONE_S = 2.0  # a shallow reading after which none came for that long counts, too: there the sounder finds no bottom
_GROWTH = 1.5
_AGAIN_S, _AGAIN_M = 120.0, 40.0  # a shoal met again within these grows
_TURNS_S = 5.0  # sooner than that it is the same meeting: a boat that turns at the edge
_MOST_RADIUS_M = 25.0
_SAME_M = 2.0
_MOST = 200
_MOVES_MPS = 0.1  # below it, the boat's course is noise
_MET_M = 0.2  # before it: the boat that stops there comes no nearer


@dataclass(frozen=True, slots=True)
class _Shoal:
    north_m: float
    east_m: float
    radius_m: float
    t_s: float


@dataclass(frozen=True, slots=True)
class _Echoes:
    """Shallow readings ahead, one after another. `places`: where those are that no shoal stands for yet."""

    since_s: float
    last_s: float
    places: tuple[tuple[float, float], ...]


class Shoals:
    """`update(depth, nav, now_s)` each tick and `take_ahead` each reading of a sounder that looks ahead. `circles`:
    shoals found. `way_m`: way left on the course until the water is too shallow for the bow, by the slope; infinite
    where it does not become so.

    Remembers the depths of the last 12 m of track, the last course, what each sounder saw shallow ahead last, and at
    most 200 shoals.
    """

    def __init__(self, length_m: float, parameters: Parameters, coasts: bool = False) -> None:
        """`coasts`: the boat has no thrust astern, and has to turn away in time."""
        self._length_m = length_m
        self._coasts = coasts
        self._ahead_m = 0.5 * length_m  # of the transducer, to the bow
        self._parameters = parameters
        self._track: deque[tuple[float, float, float]] = deque(maxlen=round(_TRACK_M / _STEP_M))
        self._shoals: list[_Shoal] = []
        self._shallow_s: float | None = None
        self._echoes: dict[str, _Echoes] = {}  # ahead, by sounder: since its last deep reading
        self._read_s = self._first_s = -math.inf  # of the last reading, and of the first shallow one
        self._course: tuple[float, float] | None = None
        self._left_m = math.inf  # for the transducer
        self.way_m = math.inf
        self.shallow_m: float | None = None  # depth, while it is too little
        self.found: float | None = None  # depth of a shoal found in this tick

    @property
    def circles(self) -> list[tuple[float, float, float]]:
        """north_m, east_m, radius_m of all shoals found."""
        return [(one.north_m, one.east_m, one.radius_m) for one in self._shoals]

    def update(self, depth: Depth | None, nav: NavState, now_s: float) -> None:
        """The newest depth, and where the boat is."""
        least_m = self._parameters["CP_DEPTH_MIN"]
        self.way_m, self.found = math.inf, None
        if least_m <= 0.0 or depth is None or now_s - depth.t_s > _STALE_S or not nav.position_valid:
            self._shallow_s = self.shallow_m = None
            return
        if depth.t_s > self._read_s:
            self._read_s = depth.t_s
            last = self._track[-1] if self._track else None
            if last is None or math.dist(last[:2], (nav.north_m, nav.east_m)) >= _STEP_M:
                self._track.append((nav.north_m, nav.east_m, depth.below_transducer_m))
        self._mind_course(nav)
        self._left_m = self._way_left_m(depth.below_transducer_m - least_m)
        self.way_m = max(0.0, self._left_m - self._ahead_m)
        if depth.below_transducer_m >= least_m and self.way_m > self._met_m:
            self._shallow_s = self.shallow_m = None
            return
        if self._shallow_s is None:
            self._shallow_s, self._first_s = now_s, depth.t_s
        again = depth.t_s > self._first_s or now_s - self._shallow_s >= _ALONE_S
        if again and now_s - self._shallow_s >= _SHALLOW_S and self.shallow_m is None:
            self.shallow_m = self.found = self._under_bow_m(depth.below_transducer_m, least_m)
            self._meet(nav, now_s)

    @property
    def _met_m(self) -> float:
        """Way left at which a shoal is met. One that has to turn away needs its length for that, and has the distance
        at which it stops left then."""
        return stop_m(self._parameters) + self._length_m if self._coasts else _MET_M

    def take_ahead(self, reading: DepthAhead, nav: NavState, now_s: float) -> None:
        """The depth at a place ahead: too little of it is a shoal there, once a second reading says so too."""
        least_m = self._parameters["CP_DEPTH_MIN"]
        if least_m <= 0.0 or reading.below_m >= least_m or not nav.position_valid:
            self._echoes.pop(reading.source, None)
            return
        c, s = math.cos(nav.yaw_rad), math.sin(nav.yaw_rad)
        place = nav.north_m + c * reading.ahead_m, nav.east_m + s * reading.ahead_m
        before = self._echoes.get(reading.source)
        if before is None or reading.t_s - before.last_s > _STALE_S:
            self._echoes[reading.source] = _Echoes(reading.t_s, reading.t_s, (place,))
        elif reading.t_s - before.since_s < _SHALLOW_S:
            self._echoes[reading.source] = _Echoes(before.since_s, reading.t_s, (*before.places, place))
        else:
            self._echoes[reading.source] = _Echoes(before.since_s, reading.t_s, ())
            for north_m, east_m in (*before.places, place):
                self._add(north_m, east_m, self._length_m, now_s)

    def clear(self) -> None:
        """Forget all shoals, and the track on which the slope counts."""
        self._shoals.clear()
        self._echoes.clear()
        self._track.clear()
        self._left_m = self.way_m = math.inf

    def way_along_m(self, along: tuple[float, float]) -> float:
        """As `way_m` in the direction of the unit vector `along` (north, east). Across the track the bottom counts as
        level."""
        if self._course is None or math.isinf(self.way_m):
            return math.inf
        share = self._course[0] * along[0] + self._course[1] * along[1]
        return max(0.0, self._left_m / share - self._ahead_m) if share > 0.0 else math.inf

    def _under_bow_m(self, depth_m: float, least_m: float) -> float:
        """Depth below the bow by the slope; below the transducer where that is too little already; the least that is
        enough, where a shoal is met before."""
        if depth_m < least_m or math.isinf(self._left_m):
            return depth_m
        if self.way_m > _MET_M:
            return least_m
        return depth_m - (depth_m - least_m) * self._ahead_m / self._left_m

    def _mind_course(self, nav: NavState) -> None:
        speed = math.hypot(nav.north_mps, nav.east_mps)
        if speed >= _MOVES_MPS:
            self._course = nav.north_mps / speed, nav.east_mps / speed

    def _way_left_m(self, water_m: float) -> float:
        """By the slope of the bottom along the boat's course, the last one of a boat that has stopped. Where the water
        is too shallow already, what counts is the bottom near by: the boat has to leave."""
        if len(self._track) < _LEAST_SAMPLES or self._course is None:
            return math.inf
        samples = np.asarray(self._track)
        slope = _slope(samples[-_LEAST_SAMPLES:], self._course)
        if water_m > 0.0:
            slope = min(slope, _slope(samples, self._course))
        return water_m / -slope if slope < (-1e-3 if water_m > 0.0 else -_RISES) else math.inf

    def _meet(self, nav: NavState, now_s: float) -> None:
        """A shoal before the bow: the boat lies at the edge of its circle, or what way is left from it."""
        speed = math.hypot(nav.north_mps, nav.east_mps)
        course = math.atan2(nav.east_mps, nav.north_mps) if speed > 0.2 else nav.yaw_rad
        again = [
            one
            for one in self._shoals
            if now_s - one.t_s < _AGAIN_S and math.dist((one.north_m, one.east_m), (nav.north_m, nav.east_m)) < _AGAIN_M
        ]
        grown = [(1.0 if now_s - one.t_s < _TURNS_S else _GROWTH) * one.radius_m for one in again]
        radius_m = min(_MOST_RADIUS_M, max([_GROWTH * self._length_m, *grown]))
        off_m = radius_m + (self.way_m if _MET_M < self.way_m < math.inf else 0.0)
        self._add(nav.north_m + off_m * math.cos(course), nav.east_m + off_m * math.sin(course), radius_m, now_s)

    def _add(self, north_m: float, east_m: float, radius_m: float, now_s: float) -> None:
        for i, one in enumerate(self._shoals):
            if math.dist((one.north_m, one.east_m), (north_m, east_m)) < _SAME_M and one.radius_m >= radius_m:
                self._shoals[i] = _Shoal(one.north_m, one.east_m, one.radius_m, now_s)
                return
        self._shoals = [*self._shoals, _Shoal(north_m, east_m, radius_m, now_s)][-_MOST:]


def _slope(samples: Floats, course: tuple[float, float]) -> float:
    """Change of depth for each metre along the course, by the plane that fits the samples best; across a straight track
    that is level. 0 for a track too short to tell."""
    north, east, depth = (samples - samples.mean(axis=0)).T
    nn, ee, ne = float(north @ north), float(east @ east), float(north @ east)
    if nn + ee < _LEAST_SQUARE_M2:
        return 0.0
    nn, ee = nn + _LEVEL_SHARE * (nn + ee), ee + _LEVEL_SHARE * (nn + ee)
    nd, ed = float(north @ depth), float(east @ depth)
    return ((ee * nd - ne * ed) * course[0] + (nn * ed - ne * nd) * course[1]) / (nn * ee - ne * ne)
