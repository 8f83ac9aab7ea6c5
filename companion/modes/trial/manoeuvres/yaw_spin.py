"""Yaw spin: a constant moment on the spot, to starboard and to port, each followed by turning free."""

from __future__ import annotations

import math

from companion.core.setpoint import Setpoint
from companion.modes.trial.expectation import Expectation
from companion.modes.trial.manoeuvres.manoeuvre import Begin, Manoeuvre, Scene, pushed

_TURN_RAD = 1.5 * math.pi
_LONGEST_S = 25.0
_FREE_S = 5.0


class YawSpin(Manoeuvre):
    """`share` of the largest moment until the boat has turned by three quarters of a turn, then none. Remembers the
    angle turned, the side, and when the moment ended."""

    begins = Begin.CENTRE

    def __init__(self, share: float) -> None:
        self.name = f"spin {share:.0%}"
        self._share = share

    def expected_s(self, expectation: Expectation) -> float:
        """Both sides, and the way to the centre."""
        return 2.0 * (min(_LONGEST_S, 1.5 * expectation.turn_s) + _FREE_S) + expectation.turn_s

    def start(self, scene: Scene) -> None:
        """To starboard first."""
        self._side, self._turned_rad, self._begun_s = 1.0, 0.0, scene.t_s
        self._free_s: float | None = None

    def update(self, scene: Scene) -> Setpoint | None:
        """Moment, free, moment to the other side, free."""
        self._turned_rad += scene.nav.yaw_rate_radps * scene.inputs.dt_s
        if self._free_s is None:
            if abs(self._turned_rad) < _TURN_RAD and scene.t_s - self._begun_s < _LONGEST_S:
                return pushed(0.0, 0.0, self._side * self._share * scene.expectation.yaw_nm)
            self._free_s = scene.t_s
        if scene.t_s - self._free_s < _FREE_S:
            return pushed(0.0, 0.0, 0.0)
        if self._side < 0.0:
            return None
        self._side, self._turned_rad, self._begun_s, self._free_s = -1.0, 0.0, scene.t_s, None
        return pushed(0.0, 0.0, 0.0)
