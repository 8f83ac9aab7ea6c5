"""Turning circle: steady ahead, then a constant moment until the boat has turned by a full circle and a half (IMO
MSC.137(76): advance, transfer, tactical diameter)."""

from __future__ import annotations

import math

from companion.core.setpoint import Setpoint
from companion.modes.trial.expectation import Expectation
from companion.modes.trial.manoeuvres.manoeuvre import Manoeuvre, Scene, pushed, straight

_AHEAD = 1.5  # time constants before the turn, at least
_NEAR, _LATEST = 0.4, 6.0  # the turn begins this near to the centre, or that much later
_TURN_RAD = math.radians(400.0)
_LONGEST_S = 45.0
SURGE_SHARE, YAW_SHARE = 0.5, 0.6


class TurningCircle(Manoeuvre):
    """To starboard or port. Remembers the heading before the turn, the angle turned, and when the turn began."""

    vital = True

    def __init__(self, to_starboard: bool) -> None:
        self.name = "turning circle " + ("starboard" if to_starboard else "port")
        self._side = 1.0 if to_starboard else -1.0

    def expected_s(self, expectation: Expectation) -> float:
        """Ahead, the circle, and turning to the centre."""
        return _AHEAD * expectation.speeding_s + min(_LONGEST_S, 2.5 * expectation.turn_s) + expectation.turn_s

    def start(self, scene: Scene) -> None:
        """Keep this heading first."""
        self._yaw_rad, self._turned_rad = scene.nav.yaw_rad, 0.0
        self._turn_s: float | None = None

    def update(self, scene: Scene) -> Setpoint | None:
        """Straight, then round."""
        e = scene.expectation
        surge_n = SURGE_SHARE * e.surge_n
        if self._turn_s is None:
            ahead_s = _AHEAD * e.speeding_s
            if scene.t_s < ahead_s or (scene.out_share > _NEAR and scene.t_s < _LATEST * ahead_s):
                return straight(self._yaw_rad, surge_n)
            self._turn_s = scene.t_s
        self._turned_rad += scene.nav.yaw_rate_radps * scene.inputs.dt_s
        if abs(self._turned_rad) >= _TURN_RAD or scene.t_s - self._turn_s > _LONGEST_S:
            return None
        return pushed(surge_n, 0.0, self._side * YAW_SHARE * e.yaw_nm)
