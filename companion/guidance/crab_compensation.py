"""The heading that keeps a course over ground in a current: the current triangle, within the boat's speed through the
water."""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState

_THROUGH_MPS = 0.15  # least speed through the water along the course: a slower boat drifts, whatever its heading
_DRIFT_TIME_S = 4.0


class CrabCompensation:
    """Call `update` every tick, then `heading_rad`.

    Uses the estimated current, or, while none is known, the drift that it learns itself: the sideways velocity over
    ground, remembered in NED so that it stays correct through a bend. `top_mps`: top speed through the water.
    """

    def __init__(self, top_mps: float) -> None:
        self._top_mps = top_mps
        self.reset()

    def reset(self) -> None:
        """Forget the drift."""
        self._north = self._east = 0.0

    def update(self, nav: NavState, speed_mps: float, straight: float, dt_s: float) -> None:
        """Learn the drift. `straight`: from 1 on a steady course to 0 in a bend, where the hull slips for other
        reasons."""
        across_north, across_east = -math.sin(nav.yaw_rad), math.cos(nav.yaw_rad)
        bound = max(speed_mps, abs(nav.surge_mps))
        drift = min(bound, max(-bound, nav.sway_mps))
        missing = drift - (self._north * across_north + self._east * across_east)
        learnt = missing * straight * min(1.0, dt_s / _DRIFT_TIME_S)
        self._north += learnt * across_north
        self._east += learnt * across_east

    def water(self, nav: NavState) -> tuple[float, float]:
        """(north_mps, east_mps) of the current, or of the drift while no current is known."""
        north, east = nav.current_north_mps, nav.current_east_mps
        return (self._north, self._east) if north is None or east is None else (north, east)

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
