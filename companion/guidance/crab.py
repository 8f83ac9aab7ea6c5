"""Which heading keeps a course over ground in a current: the wind triangle, solved within what the boat can do through the water."""

from __future__ import annotations

import math

from companion.config import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.types import NavState

_THROUGH_MPS = 0.15  # through the water along the course, at least: slower boats do not crab, they drift
_DRIFT_TIME_S = 4.0
_SEARCH_STEPS = 40


def top_speed_mps(config: VesselConfig) -> float:
    """Through calm water at full surge thrust, from the vessel's own model; infinite where that has no damping. Of a hull with a hump of
    resistance, on the far side of it."""
    drag = config.hull.drag_n
    high = 1.0
    while drag(high) < config.limits.surge_n:
        high *= 2.0
        if high > 100.0:
            return math.inf
    low = 0.0
    for _ in range(_SEARCH_STEPS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if drag(middle) < config.limits.surge_n else (low, middle)
    return low


class Crab:
    """`update(nav, speed, straight, dt_s)` every tick, then `heading_rad(course_rad, …)`.

    Remembers the boat's drift over ground across its bow, as a velocity in NED, so that it turns out of the way with the boat in a bend. It
    serves where no current is known. `top_mps`: the most that the boat makes through the water.
    """

    def __init__(self, top_mps: float) -> None:
        self._top_mps = top_mps
        self.reset()

    def reset(self) -> None:
        self._north = self._east = 0.0

    def update(self, nav: NavState, speed_mps: float, straight: float, dt_s: float) -> None:
        """`straight`: 1 on a steady course to 0 in a bend, where the hull slips for other reasons and nothing is learnt."""
        across_north, across_east = -math.sin(nav.yaw_rad), math.cos(nav.yaw_rad)
        bound = max(speed_mps, abs(nav.surge_mps))
        drift = min(bound, max(-bound, nav.sway_mps))
        missing = drift - (self._north * across_north + self._east * across_east)
        learnt = missing * straight * min(1.0, dt_s / _DRIFT_TIME_S)
        self._north += learnt * across_north
        self._east += learnt * across_east

    def water(self, nav: NavState) -> tuple[float, float]:
        """(north, east) m/s of the water, or of what carries the boat off where that is all that is known."""
        north, east = nav.current_north_mps, nav.current_east_mps
        return (self._north, self._east) if north is None or east is None else (north, east)

    def heading_rad(self, nav: NavState, course_rad: float, speed_mps: float, last_rad: float) -> float:
        """The bow's direction for that course over ground at `speed_mps`, or at the most that is left of it against the current. Where
        nothing is left, bow into the current: there the boat is carried off least.

        A current that sets the boat along faster than it should go can be met in two ways, bow first with the thrusters braking, or bow
        against it: the one nearer to the heading asked for last.
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
