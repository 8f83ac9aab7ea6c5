"""Drift: no thrust, so that wind and current show themselves."""

from __future__ import annotations

from companion.core.setpoint import NEUTRAL_SETPOINT, Setpoint
from companion.modes.trial.expectation import Expectation
from companion.modes.trial.manoeuvres.manoeuvre import Begin, Manoeuvre, Scene

_DRIFT_S = 40.0


class Drift(Manoeuvre):
    """From the centre for `_DRIFT_S`, or until the circle ends it."""

    name = "drift"
    begins = Begin.CENTRE
    vital = True

    def expected_s(self, expectation: Expectation) -> float:
        """Drifting, and the way to the centre."""
        return _DRIFT_S + expectation.turn_s

    def update(self, scene: Scene) -> Setpoint | None:
        """Neutral."""
        return NEUTRAL_SETPOINT if scene.t_s < _DRIFT_S else None
