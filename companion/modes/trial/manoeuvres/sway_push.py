"""Sway push: a constant force sideways with the heading held, both ways."""

from __future__ import annotations

from companion.core.setpoint import Setpoint
from companion.modes.trial.expectation import Expectation
from companion.modes.trial.manoeuvres.manoeuvre import Begin, Manoeuvre, Scene, straight

_PUSH_S, _COAST_S = 14.0, 6.0


class SwayPush(Manoeuvre):
    """`share` of the largest force to starboard and, from the same start, to port; each followed by coasting."""

    begins = Begin.CENTRE

    def __init__(self, share: float) -> None:
        self.name = f"sway {share:.0%}"
        self._share = share
        self._yaw_rad = 0.0

    def expected_s(self, expectation: Expectation) -> float:
        """Both pushes, and the way to the centre."""
        return 2.0 * (_PUSH_S + _COAST_S) + expectation.turn_s

    def start(self, scene: Scene) -> None:
        """Keep this heading."""
        self._yaw_rad = scene.nav.yaw_rad

    def update(self, scene: Scene) -> Setpoint | None:
        """Starboard, coast, port, coast."""
        leg, within_s = divmod(scene.t_s, _PUSH_S + _COAST_S)
        if leg >= 2.0:
            return None
        sway_n = self._share * scene.expectation.sway_n * (1.0 if leg == 0.0 else -1.0)
        return straight(self._yaw_rad, 0.0, sway_n if within_s < _PUSH_S else 0.0)
