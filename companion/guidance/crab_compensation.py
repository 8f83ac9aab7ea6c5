"""The heading that keeps a course over ground in a current: the current triangle, within the boat's speed through the
water."""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.guidance.sideslip import Sideslip, SteeredHull

_THROUGH_MPS = 0.15  # least speed through the water along the course: a slower boat drifts, whatever its heading
_DRIFT_TIME_S = 4.0
_KNOWN_TIME_S = 3.0  # in which a current that becomes known under way is used: the bow would jump to it
_SUPPOSED_TIME_S = 20.0  # a drift that was supposed at the beginning, and that no current bears out, is forgotten
_SLOWER_TIME_S = 20.0  # a slower command counts as that of the leg after so long: braking ends sooner
_OPPOSITE_RAD = 0.5 * math.pi  # headings further apart are two ways to sail, not one with more or less of a turn


class CrabCompensation:
    """Call `update` every tick (and `sail_at`, for `bow_rad`), then `heading_rad`.

    Uses the estimated current, or, while none is known, the drift that it learns itself: the sideways velocity over
    ground beyond the hull's own sideslip, remembered in NED so that it stays correct through a bend. `top_mps`: top
    speed through the water. `steered`: the hull of a boat without sideways thrust. Remembers current or drift, the
    sideslip, and the leg's speed. `slip_mps`: the sideslip that the boat's own turns give it, after each `update`.
    """

    def __init__(self, top_mps: float, steered: SteeredHull | None = None) -> None:
        self._top_mps = top_mps
        self._sideslip = Sideslip(steered)
        self.reset()

    def reset(self) -> None:
        """Forget the drift and the leg's speed."""
        self._north = self._east = 0.0
        self._fresh = True
        self._supposed = False
        self._leg_mps = self.slip_mps = 0.0
        self._sideslip.reset()

    def begin(self, nav: NavState) -> None:
        """Forget drift and speed, and take for the drift what carries the boat aside, while no current is known: a boat
        that begins from rest turns into a stream at once."""
        self.reset()
        if _current(nav) is None:
            self._learn_drift(nav, self._top_mps, 1.0)
            self._supposed = True

    def sail_at(self, leg_mps: float, dt_s: float) -> None:
        """Remember the speed commanded for the leg. A guard that slows the boat down for a while hardly counts."""
        slower = self._leg_mps + (leg_mps - self._leg_mps) * min(1.0, dt_s / _SLOWER_TIME_S)
        self._leg_mps = max(leg_mps, slower)

    def update(self, nav: NavState, speed_mps: float, straight: float, dt_s: float) -> None:
        """Learn the drift, while no current is known. `straight`: from 1 on a steady course to 0 in a bend, where the
        hull slips for other reasons."""
        known, slip_mps = _current(nav), self._sideslip.update(nav, dt_s)
        self.slip_mps = slip_mps
        if known is None:
            bound_mps, part = max(speed_mps, abs(nav.surge_mps)), straight * min(1.0, dt_s / _DRIFT_TIME_S)
            self._learn_drift(nav, bound_mps, part, slip_mps)
            if self._supposed:
                kept = 1.0 - min(1.0, dt_s / _SUPPOSED_TIME_S)
                self._north, self._east = kept * self._north, kept * self._east
        else:
            self._supposed = False
            part = 1.0 if self._fresh else min(1.0, dt_s / _KNOWN_TIME_S)
            self._north += part * (known[0] - self._north)
            self._east += part * (known[1] - self._east)
        self._fresh = False

    def _learn_drift(self, nav: NavState, bound_mps: float, part: float, slip_mps: float = 0.0) -> None:
        across_north, across_east = -math.sin(nav.yaw_rad), math.cos(nav.yaw_rad)
        drift = min(bound_mps, max(-bound_mps, nav.sway_mps - slip_mps))
        learnt = part * (drift - (self._north * across_north + self._east * across_east))
        self._north += learnt * across_north
        self._east += learnt * across_east

    def water(self, nav: NavState) -> tuple[float, float]:
        """(north_mps, east_mps) of the current, or of the drift while no current is known."""
        return (_current(nav) if self._fresh else None) or (self._north, self._east)

    def sway_mps(self, nav: NavState, wanted_mps: float, bound_mps: float) -> float:
        """The sideways speed over ground to ask for: as the water carries the boat, and at most `bound_mps` more or
        less by the thrusters."""
        north, east = self.water(nav)
        carried = east * math.cos(nav.yaw_rad) - north * math.sin(nav.yaw_rad)
        return carried + min(bound_mps, max(-bound_mps, wanted_mps - carried))

    def heading_rad(self, nav: NavState, course_rad: float, speed_mps: float, last_rad: float) -> float:
        """The heading for that course over ground at `speed_mps`, or at the highest speed that the current leaves.
        Where it leaves none, the heading is into the current: the boat loses least ground there.

        With a current along the course that is faster than `speed_mps` there are two solutions: bow along the course
        with the thrusters braking, or bow against the current. The one nearer to `last_rad`, the last setpoint, is
        used.
        """
        c, s = math.cos(course_rad), math.sin(course_rad)
        north, east = self.water(nav)
        along, across = north * c + east * s, east * c - north * s
        most = along + math.sqrt(max(0.0, self._top_mps**2 - across * across))
        if abs(across) >= self._top_mps or most <= 0.0:
            return math.atan2(-east, -north)
        through = min(speed_mps, most) - along
        bow_first = course_rad - math.atan2(across, max(_THROUGH_MPS, through))
        if through >= _THROUGH_MPS or math.hypot(through, across) < _THROUGH_MPS:
            return bow_first
        against = course_rad - math.atan2(across, through)
        return min(bow_first, against, key=lambda heading: abs(wrap_pi(heading - last_rad)))

    def bow_rad(self, nav: NavState, course_rad: float, speed_mps: float, aside_mps: float, last_rad: float) -> float:
        """The heading of a boat that can push itself sideways, with up to `aside_mps` through the water.

        While it slows down it keeps the heading for the speed of its leg, told by `sail_at`. It turns further into the
        current only as far as its sideways speed does not suffice: beside wind that is taken for a current a slow boat
        would come to lie across it.
        """
        slow = self.heading_rad(nav, course_rad, speed_mps, last_rad)
        if speed_mps >= self._leg_mps:
            return slow
        steady = self.heading_rad(nav, course_rad, self._leg_mps, last_rad)
        less = wrap_pi(steady - slow)
        north, east = self.water(nav)
        through = math.hypot(speed_mps * math.cos(course_rad) - north, speed_mps * math.sin(course_rad) - east)
        if through <= aside_mps:
            return steady
        if abs(less) > _OPPOSITE_RAD:
            return slow
        free = math.asin(aside_mps / through)
        return slow + min(free, max(-free, less))


def _current(nav: NavState) -> tuple[float, float] | None:
    north, east = nav.current_north_mps, nav.current_east_mps
    return None if north is None or east is None else (north, east)
