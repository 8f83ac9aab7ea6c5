"""Steps of dynamic positioning: ahead, aside and in heading, with the controller as it is; then keeping the point."""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.frames import body_to_ned
from companion.core.setpoint import Setpoint
from companion.modes.trial.expectation import Expectation
from companion.modes.trial.manoeuvres.manoeuvre import Begin, Manoeuvre, Scene
from companion.positioning.hold_point import HoldPoint

_STEPS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, 45.0))  # lengths ahead and aside, degrees
_KEEP_S, _STEP_S = 45.0, 22.0


class PositioningSteps(Manoeuvre):
    """Keeps the point for `_KEEP_S`, then goes to each step for `_STEP_S`. Remembers the first pose and the step."""

    name = "positioning"
    begins = Begin.CENTRE
    brakes = False
    vital = True

    def __init__(self, hold_point: HoldPoint) -> None:
        self._hold_point = hold_point

    def expected_s(self, expectation: Expectation) -> float:
        """All steps, and the way to the centre."""
        return _KEEP_S + (len(_STEPS) - 1) * _STEP_S + expectation.turn_s

    def start(self, scene: Scene) -> None:
        """Keep this point."""
        nav = scene.nav
        self._pose, self._step = (nav.north_m, nav.east_m, nav.yaw_rad), 0
        self._hold_point.stop_here(nav)

    def update(self, scene: Scene) -> Setpoint | None:
        """The setpoint of dynamic positioning."""
        step = 0 if scene.t_s < _KEEP_S else 1 + int((scene.t_s - _KEEP_S) / _STEP_S)
        if step >= len(_STEPS):
            return None
        if step != self._step:
            self._step = step
            ahead, aside, degrees = _STEPS[step]
            length_m, (north_m, east_m, yaw_rad) = scene.expectation.length_m, self._pose
            dn, de = body_to_ned(ahead * length_m, aside * length_m, yaw_rad)
            self._hold_point.shift(north_m + dn, east_m + de, wrap_pi(yaw_rad + math.radians(degrees)))
        return self._hold_point.update(scene.nav, None, scene.inputs.speed_mps, scene.inputs.dt_s)
