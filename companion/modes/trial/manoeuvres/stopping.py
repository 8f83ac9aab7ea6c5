"""Stopping distance: full ahead until the speed is nearly steady, then full astern until the boat is at rest."""

from __future__ import annotations

from companion.core.setpoint import Setpoint
from companion.modes.trial.expectation import Expectation
from companion.modes.trial.manoeuvres.manoeuvre import Manoeuvre, Scene, straight

_AHEAD = 2.0  # time constants
_LONGEST_S = 40.0


class Stopping(Manoeuvre):
    """Remembers the heading, and when it went astern. The way from full astern to rest is the stopping distance."""

    name = "stopping"
    vital = True

    def expected_s(self, expectation: Expectation) -> float:
        """Ahead, astern and turning."""
        return (_AHEAD + 2.0) * expectation.speeding_s + expectation.turn_s

    def start(self, scene: Scene) -> None:
        """Keep this heading."""
        self._yaw_rad = scene.nav.yaw_rad
        self._astern_s: float | None = None

    def cut(self, scene: Scene) -> None:
        """The circle asks to brake: that is the manoeuvre itself."""
        if self._astern_s is None:
            self._astern_s = scene.t_s

    def update(self, scene: Scene) -> Setpoint | None:
        """Full ahead, then full astern."""
        e = scene.expectation
        if self._astern_s is None and scene.t_s >= _AHEAD * e.speeding_s:
            self._astern_s = scene.t_s
        if self._astern_s is None:
            return straight(self._yaw_rad, e.surge_n)
        if scene.nav.surge_mps <= 0.0 or scene.t_s - self._astern_s > _LONGEST_S:
            return None
        return straight(self._yaw_rad, -e.astern_n)
