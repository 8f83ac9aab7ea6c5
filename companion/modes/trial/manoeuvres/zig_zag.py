"""Zig-zag (IMO MSC.137(76)): a constant moment to one side until the heading is off by an angle, then to the other
side. The moment stands for the rudder angle: in proportion, with the largest moment for 35°."""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.setpoint import Setpoint
from companion.modes.trial.expectation import Expectation
from companion.modes.trial.manoeuvres.manoeuvre import Manoeuvre, Scene, pushed, straight

_AHEAD = 1.0  # time constants before the first moment
_FULL_RUDDER_DEG = 35.0
_EXECUTES = 4
_LONGEST_S = 40.0
SURGE_SHARE = 0.4


class ZigZag(Manoeuvre):
    """`angle_deg`: 10 or 20. Remembers the mean heading, the side of the moment, and how often it has changed."""

    def __init__(self, angle_deg: float) -> None:
        self.name = f"zig-zag {angle_deg:.0f}/{angle_deg:.0f}"
        self._angle_rad = math.radians(angle_deg)
        self._share = angle_deg / _FULL_RUDDER_DEG

    def expected_s(self, expectation: Expectation) -> float:
        """Ahead, the changes, and turning to the centre."""
        return _AHEAD * expectation.speeding_s + 0.6 * _LONGEST_S + expectation.turn_s

    def start(self, scene: Scene) -> None:
        """Keep this heading first."""
        self._yaw_rad, self._side, self._executes = scene.nav.yaw_rad, 1.0, 0

    def update(self, scene: Scene) -> Setpoint | None:
        """Straight, then to and fro."""
        e = scene.expectation
        ahead_s = _AHEAD * e.speeding_s
        surge_n = SURGE_SHARE * e.surge_n
        if scene.t_s < ahead_s:
            return straight(self._yaw_rad, surge_n)
        if self._side * wrap_pi(scene.nav.yaw_rad - self._yaw_rad) >= self._angle_rad:
            self._side, self._executes = -self._side, self._executes + 1
        if self._executes > _EXECUTES or scene.t_s - ahead_s > _LONGEST_S:
            return None
        return pushed(surge_n, 0.0, self._side * self._share * e.yaw_nm)
