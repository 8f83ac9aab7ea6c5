"""Keeps a boat without sideways thrust on a velocity over ground, beside the current triangle.

The triangle knows the current only as well as the estimate does, which takes part of the wind for a stream and knows no
gusts. What still carries the boat off its course is measured as velocity across the course, and asked for the other
way. What goes as the turn under way ends is not learnt: the bow of a long hull follows its setpoint late, and its
course the bow, and a loop that integrated that would swing it to and fro.
"""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.guidance.motion_request import Pair

_LEARNS_1PS = 0.2
_AGAINST = 0.6  # share of the present velocity across the course that is asked for the other way at once
_SEEN_S = 0.7  # low-pass of that velocity: the bow should not answer the noise of the estimate
_MOST_SHARE = 0.6  # of the speed asked for: more would turn the bow by over 31 degrees
_TURN_RAD = math.radians(30.0)  # off the course: a turn, of which nothing is learnt


class CourseKeeping:
    """Call `update` every tick while a velocity over ground is asked for. Remembers the velocity (NED) that it has
    learnt to steer against, and the low-pass filtered velocity across the course."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget it."""
        self._north = self._east = self._across = 0.0

    def update(self, nav: NavState, wanted: Pair, straight: float, dt_s: float, passing_mps: float = 0.0) -> Pair:
        """The velocity (north, east) to steer for, so that the boat makes `wanted` over ground. `straight`: from 1 on a
        steady course to 0 in a bend. `passing_mps`: of the velocity across `wanted`, to starboard, what goes as the
        turn under way ends."""
        speed = math.hypot(*wanted)
        if speed <= 0.0:
            return wanted
        side_n, side_e = -wanted[1] / speed, wanted[0] / speed
        off_rad = abs(wrap_pi(math.atan2(nav.east_mps, nav.north_mps) - math.atan2(wanted[1], wanted[0])))
        learns = straight * max(0.0, 1.0 - off_rad / _TURN_RAD)
        across = nav.north_mps * side_n + nav.east_mps * side_e
        self._across += min(1.0, dt_s / _SEEN_S) * (learns * across - self._across)
        learnt = _LEARNS_1PS * dt_s * learns * (across - passing_mps)
        self._north += learnt * side_n
        self._east += learnt * side_e
        most = _MOST_SHARE * speed
        share = most / max(most, math.hypot(self._north, self._east))
        self._north, self._east = share * self._north, share * self._east
        against = self._north * side_n + self._east * side_e + _AGAINST * self._across
        against = min(most, max(-most, against))
        return wanted[0] - against * side_n, wanted[1] - against * side_e
