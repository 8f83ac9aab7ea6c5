"""Surge step: constant force ahead or astern with the heading held, then coasting."""

from __future__ import annotations

from companion.core.setpoint import Setpoint
from companion.modes.trial.expectation import Expectation
from companion.modes.trial.manoeuvres.manoeuvre import Manoeuvre, Scene, straight

_STEADY = 2.5  # time constants until the speed is nearly steady
_COAST = 1.5  # time constants


class SurgeStep(Manoeuvre):
    """`share` of the largest force, negative astern, until the speed is nearly steady; then no surge force for a while
    (`coasts`)."""

    def __init__(self, share: float, coasts: bool, vital: bool = False) -> None:
        self.name = f"surge {share:+.0%}" + (" coast" if coasts else "")
        self._share, self._coasts, self.vital = share, coasts, vital
        self._yaw_rad = 0.0

    def _times_s(self, expectation: Expectation) -> tuple[float, float]:
        """(with force, coasting). At a share k the time constant of quadratic damping is 1/√k longer."""
        slow = expectation.speeding_s / abs(self._share) ** 0.5
        return min(30.0, max(6.0, _STEADY * slow)), min(20.0, max(5.0, _COAST * slow)) if self._coasts else 0.0

    def expected_s(self, expectation: Expectation) -> float:
        """Force, coasting, braking and turning."""
        return sum(self._times_s(expectation)) + expectation.turn_s + 2.0 * expectation.speeding_s

    def start(self, scene: Scene) -> None:
        """Keep this heading."""
        self._yaw_rad = scene.nav.yaw_rad

    def update(self, scene: Scene) -> Setpoint | None:
        """Force, then none."""
        force_s, coast_s = self._times_s(scene.expectation)
        if scene.t_s >= force_s + coast_s:
            return None
        e = scene.expectation
        full_n = e.surge_n if self._share > 0.0 else e.astern_n
        return straight(self._yaw_rad, self._share * full_n if scene.t_s < force_s else 0.0)
