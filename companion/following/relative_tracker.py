"""Where the lead boat is relative to this boat: by a moving base, else by the difference of two receivers of one kind,
else by two positions.

What two receivers near each other have in common drops out of the difference of their own positions: errors of orbits,
clocks, ionosphere and troposphere, where both use the same satellites and the same corrections. It does not drop out of
a leader's position beside an estimate that rests on another kind of fix. FOLL_COMMON says how much that is. The
difference is used where it is clearly less uncertain than two positions: so where that share is known, and for a while
after a moving base.

A moving base is believed while it agrees with what is known without it: with the two positions when it comes, with the
filter from then on. One that jumps, repeats itself or drifts away from the positions is ignored, and what the filter
had learned of it is forgotten.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from dataclasses import replace

from companion.config.vessel import VesselConfig
from companion.core.decision import TextKind
from companion.core.estimate import Leader, NavState, RelativeBy
from companion.core.geodesy import LocalFrame
from companion.core.readings import FixType, GnssFix, RelativeFix
from companion.following.relative_filter import RelativeFilter
from companion.params.store import Parameters

_DIFFERENCE, _BASE = 1, 2  # FOLL_REL: the best that may be used
_SIGMA_M = 1.5  # of a fix that does not say how good it is
_NOISE_SHARE = 0.12  # of the accuracies: what is not slow
_MOST_AGE_S, _INTERVALS = 1.0, 3.0  # of the leader's position
_FRESH_S = 2.0  # since the last difference
_TAKE_SHARE, _KEEP_SHARE = 0.7, 0.85  # of the uncertainty of positions, below which the difference is used
_BASE_S = 3.0  # since the last vector of a base: it comes once a second, and one may be lost
_OLDEST_S = 2.0  # of a measurement on arrival
_GATE = 5.0  # sigmas of the innovation, on each axis
_NEW_GATE, _NEW_M = 4.0, 0.5  # sigmas of both positions, and metres, by which a base may differ when it comes
_AGAIN_GATE = 3.0  # sigmas of the difference, by which one may differ that was doubted before
_DRIFT_GATE = 5.0  # sigmas of the slow error
_OTHER_S = 3.0  # of differences that are all outliers, after which the filter begins anew
_LEAST_BASE_M = 0.05  # an antenna swings with the boat
_FLOAT_TIMES = 5.0  # the accuracy of a float solution, which errs slowly: its variance is that of 25
_JUMP_MPS = 0.5  # by which the velocities may be wrong in a sharp turn, before a vector counts as a jump
_SAME = 3  # equal vectors in a row: a receiver at sea does not repeat itself
_STEADY_M, _STEADY_S = 0.5, 30.0  # how steady a base must be, and for how long, to be believed again
_JOIN_MPS = 0.5  # with which the leader's place moves to a better one
_KEPT_S = 3.0  # of the way that is kept

_Place = tuple[float, float]
_Say = Callable[[float, TextKind, str, str], None]


class RelativeTracker:
    """`take(reading)` each fix and each vector of a base; `update` once a tick; `placed(leader)` → the leader, moved to
    where it is relative to this boat, with the uncertainty of that.

    Remembers the filter, the way by the velocities over the last seconds, since when differences are outliers, when
    each measurement was last used, why the base is not believed, and how far the leader is moved.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, say: _Say) -> None:
        self._parameters, self._say = parameters, say
        self._arms = {sensor.name: (sensor.x_m, sensor.y_m) for sensor in config.sensors}
        self._filter = RelativeFilter()
        self._arrived: list[GnssFix | RelativeFix] = []
        self._system: int | None = None
        self._forget()

    def _forget(self) -> None:
        self._filter.forget()
        self._t_s: float | None = None
        self._velocity = (0.0, 0.0)
        self._way: deque[tuple[float, float, float]] = deque()  # (t_s, north, east), summed up
        self._own = ""  # the receiver whose positions are used
        self._difference_s = self._base_s = -math.inf
        self._outlier_s: float | None = None
        self._slow_m = self._total_m = 0.0
        self._doubt = ""
        self._doubted_s = -math.inf
        self._last_base: RelativeFix | None = None
        self._same = 0
        self._steady: tuple[float, float, float] | None = None  # (way's t_s, north, east) of the last vector
        self._by = RelativeBy.POSITIONS
        self._moved = (0.0, 0.0)
        self._sigma_m = math.inf

    @property
    def doubt(self) -> str:
        """Why the moving base is not believed, for people; empty while it is."""
        return self._doubt

    def take(self, reading: GnssFix | RelativeFix) -> None:
        """A fix of a receiver aboard, or its vector from a moving base. It is used with the next `update`."""
        self._arrived.append(reading)

    # --- once a tick -----------------------------------------------------------------------------------------------

    def update(
        self, leader: Leader | None, fix: FixType | None, nav: NavState, frame: LocalFrame, now_s: float
    ) -> None:
        """`leader`: as its messages place it; `fix`: of its receiver. `nav` and `frame`: this boat at `now_s`."""
        arrived, self._arrived = self._arrived, []
        if not self._keeps(leader, nav, now_s) or leader is None:
            return
        self._advance(leader, nav, now_s)
        best = int(self._parameters["FOLL_REL"])
        for reading in arrived:
            age_s = now_s - reading.t_s
            if not -_OLDEST_S < age_s < _OLDEST_S or reading.fix is FixType.NONE:
                continue
            if isinstance(reading, RelativeFix):
                if best >= _BASE:
                    self._take_base(reading, leader, nav, now_s)
            elif best >= _DIFFERENCE and reading.fix is fix:
                self._take_difference(reading, leader, nav, frame, now_s)
        self._decide(leader, nav, now_s)

    def placed(self, leader: Leader) -> Leader:
        """The leader where it is relative to this boat."""
        north_m, east_m = self._moved
        return replace(
            leader,
            north_m=leader.north_m + north_m,
            east_m=leader.east_m + east_m,
            relative_m=self._sigma_m,
            relative_by=self._by,
        )

    def _keeps(self, leader: Leader | None, nav: NavState, now_s: float) -> bool:
        """Whether the leader can be placed. What is known of another one, or before it could be, is forgotten."""
        if leader is None and self._system is None:
            return False
        usable = leader is not None and self._usable(leader, nav, now_s)
        if leader is None or leader.system_id != self._system or not usable:
            self._forget()
            self._system = None if leader is None else leader.system_id
        return usable

    @staticmethod
    def _usable(leader: Leader, nav: NavState, now_s: float) -> bool:
        most_s = max(_MOST_AGE_S, _INTERVALS * leader.interval_s)
        return nav.position_valid and leader.age_s <= most_s and now_s - nav.t_s + nav.position_age_s < _FRESH_S

    def _advance(self, leader: Leader, nav: NavState, now_s: float) -> None:
        north_mps, east_mps = leader.north_mps - nav.north_mps, leader.east_mps - nav.east_mps
        last_s, (was_north, was_east) = self._t_s, self._velocity
        self._t_s, self._velocity = now_s, (north_mps, east_mps)
        if last_s is None:
            self._way.append((now_s, 0.0, 0.0))
            return
        dt_s = now_s - last_s
        if dt_s <= 0.0:
            return
        moved = 0.5 * dt_s * (was_north + north_mps), 0.5 * dt_s * (was_east + east_mps)
        self._filter.advance(moved, dt_s)
        _, north_m, east_m = self._way[-1]
        self._way.append((now_s, north_m + moved[0], east_m + moved[1]))
        while now_s - self._way[0][0] > _KEPT_S:
            self._way.popleft()

    def _moved_since(self, t_s: float) -> _Place:
        """By how much the velocities have moved the leader from this boat since then."""
        way = self._way
        i = min(len(way) - 1, max(1, bisect_right(way, (t_s, math.inf, math.inf))))
        if len(way) < 2:
            return 0.0, 0.0
        (t0, n0, e0), (t1, n1, e1) = way[i - 1], way[i]
        share = (t_s - t0) / (t1 - t0)
        return way[-1][1] - n0 - share * (n1 - n0), way[-1][2] - e0 - share * (e1 - e0)

    def _arm(self, source: str, nav: NavState) -> _Place:
        """(north, east) of that antenna from the middle of the boat."""
        x, y = self._arms.get(source, (0.0, 0.0)) if nav.heading_valid else (0.0, 0.0)
        c, s = math.cos(nav.yaw_rad), math.sin(nav.yaw_rad)
        return c * x - s * y, s * x + c * y

    # --- the difference of two receivers ---------------------------------------------------------------------------

    def _take_difference(self, fix: GnssFix, leader: Leader, nav: NavState, frame: LocalFrame, now_s: float) -> None:
        if fix.source != self._own and now_s - self._difference_s <= _FRESH_S:
            return
        own, theirs = fix.position_accuracy_m or _SIGMA_M, leader.accuracy_m
        self._total_m = math.hypot(own, theirs)
        self._slow_m = math.sqrt(1.0 - self._parameters["FOLL_COMMON"]) * self._total_m
        self._filter.suppose(self._slow_m)
        (arm_north, arm_east), (since_north, since_east) = self._arm(fix.source, nav), self._moved_since(fix.t_s)
        ahead_s = now_s - fix.t_s
        own_north, own_east = frame.to_ned(fix.lat_deg, fix.lon_deg)
        north_m = leader.north_m - ahead_s * leader.north_mps - own_north + arm_north + since_north
        east_m = leader.east_m - ahead_s * leader.east_mps - own_east + arm_east + since_east
        noise_m = _NOISE_SHARE * self._total_m
        expected_north, expected_east, sigma_m = self._filter.difference_m
        off_m = math.hypot(north_m - expected_north, east_m - expected_east)
        if off_m > _GATE * math.hypot(sigma_m, noise_m) + _NEW_M:
            self._outlier_s = now_s if self._outlier_s is None else self._outlier_s
            if now_s - self._outlier_s < _OTHER_S:
                return
            self._filter.forget()
            self._base_s = -math.inf
        self._outlier_s = None
        self._own, self._difference_s = fix.source, now_s
        self._filter.take_difference(north_m, east_m, noise_m)

    # --- the moving base -------------------------------------------------------------------------------------------

    def _take_base(self, fix: RelativeFix, leader: Leader, nav: NavState, now_s: float) -> None:
        (arm_north, arm_east), (since_north, since_east) = self._arm(fix.source, nav), self._moved_since(fix.t_s)
        north_m, east_m = arm_north + since_north - fix.north_m, arm_east + since_east - fix.east_m
        sigma_m = max(_LEAST_BASE_M, fix.accuracy_m or _LEAST_BASE_M)
        sigma_m *= 1.0 if fix.fix is FixType.RTK_FIXED else _FLOAT_TIMES
        lie = self._lie(fix, (north_m, east_m), sigma_m, leader, nav, now_s)
        steady = self._is_steady(north_m, east_m, now_s)
        if lie:
            self._doubted_s = now_s
            if not self._doubt:
                self._say(now_s, TextKind.ATTENTION, "relative_doubted", f"Relative position ignored: {lie}")
                self._filter.forget()
                self._difference_s = self._base_s = -math.inf
            self._doubt = lie
        elif self._doubt and not steady:
            self._doubted_s = now_s
        if self._doubt and now_s - self._doubted_s < _STEADY_S:
            return
        if self._doubt:
            self._doubt = ""
            self._say(now_s, TextKind.ROUTINE, "relative_believed", "Relative position is used again")
        self._base_s = now_s
        self._filter.take_base(north_m, east_m, sigma_m)

    def _lie(self, fix: RelativeFix, place: _Place, sigma_m: float, leader: Leader, nav: NavState, now_s: float) -> str:
        """Why the vector cannot be true, for people; empty where it may be."""
        last, self._last_base = self._last_base, fix
        vector = fix.north_m, fix.east_m, fix.down_m
        repeats = last is not None and vector == (last.north_m, last.east_m, last.down_m)
        self._same = self._same + 1 if repeats else 0
        if self._same >= _SAME - 1:
            return "it repeats itself"
        apart_m = math.hypot(place[0] - leader.north_m + nav.north_m, place[1] - leader.east_m + nav.east_m)
        if apart_m > _NEW_GATE * math.hypot(leader.accuracy_m, nav.position_accuracy_m) + _NEW_M:
            return f"{apart_m:.1f} m off positions"
        return self._against_filter(place, sigma_m, now_s)

    def _against_filter(self, place: _Place, sigma_m: float, now_s: float) -> str:
        """Why the vector cannot be true beside what is known without it; empty where it may be."""
        compared = now_s - self._difference_s <= _FRESH_S
        here, known_m = self._filter.position_m, math.hypot(self._filter.sigma_m, sigma_m)
        off_m, silent_s = math.dist(place, here), now_s - self._base_s
        if silent_s > _BASE_S:
            strange = self._doubt and compared and off_m > _AGAIN_GATE * known_m
            return f"{off_m:.1f} m off positions" if strange else ""
        if off_m > _GATE * known_m + _JUMP_MPS * silent_s:
            return f"jumped {off_m:.1f} m"
        north_m, east_m, _ = self._filter.difference_m
        drift_m = math.dist((north_m, east_m), here)
        return f"{drift_m:.1f} m off positions" if compared and drift_m > _DRIFT_GATE * self._slow_m else ""

    def _is_steady(self, north_m: float, east_m: float, now_s: float) -> bool:
        """Whether the vector has moved as the velocities say since the one before."""
        last, self._steady = self._steady, (now_s, north_m, east_m)
        if last is None or now_s - last[0] > _KEPT_S:
            return False
        since_north, since_east = self._moved_since(last[0])
        return math.hypot(north_m - last[1] - since_north, east_m - last[2] - since_east) < _STEADY_M

    # --- what it rests on ------------------------------------------------------------------------------------------

    def _decide(self, leader: Leader, nav: NavState, now_s: float) -> None:
        """What the leader's place rests on from now on, and how far it is moved."""
        self._sigma_m = math.hypot(leader.accuracy_m, nav.position_accuracy_m)
        share = _KEEP_SHARE if self._by is RelativeBy.DIFFERENCE else _TAKE_SHARE
        better = now_s - self._difference_s <= _FRESH_S and self._filter.sigma_m < share * self._sigma_m
        by_base = now_s - self._base_s <= _BASE_S
        self._by = RelativeBy.MOVING_BASE if by_base else RelativeBy.DIFFERENCE if better else RelativeBy.POSITIONS
        wanted = 0.0, 0.0
        if self._by is not RelativeBy.POSITIONS:
            self._sigma_m = self._filter.sigma_m
            north_m, east_m = self._filter.position_m
            wanted = nav.north_m + north_m - leader.north_m, nav.east_m + east_m - leader.east_m
        off_north, off_east = wanted[0] - self._moved[0], wanted[1] - self._moved[1]
        off_m = math.hypot(off_north, off_east)
        step_s = self._way[-1][0] - self._way[-2][0] if len(self._way) > 1 else 0.0
        share = min(1.0, _JOIN_MPS * step_s / off_m) if off_m > 0.0 else 1.0
        self._moved = self._moved[0] + share * off_north, self._moved[1] + share * off_east
        self._sigma_m = math.hypot(self._sigma_m, (1.0 - share) * off_m)
