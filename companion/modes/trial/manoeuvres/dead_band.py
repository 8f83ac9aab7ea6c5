"""Dead band: the throttle of each thruster pair rises slowly from zero, so that the log shows where thrust begins."""

from __future__ import annotations

import math

from companion.core.actuation import ThrusterCommand
from companion.core.setpoint import Setpoint, ThrusterSetpoint
from companion.modes.trial.expectation import Expectation
from companion.modes.trial.manoeuvres.manoeuvre import Begin, Manoeuvre, Scene

_RAMP_S, _TO = 10.0, 0.35


class DeadBand(Manoeuvre):
    """All thrusters that push along the hull, together: throttle from 0 to `_TO` within `_RAMP_S`."""

    name = "dead band"
    begins = Begin.FACING

    def expected_s(self, expectation: Expectation) -> float:
        """The ramp, and turning to the centre."""
        return _RAMP_S + expectation.turn_s

    def update(self, scene: Scene) -> Setpoint | None:
        """The ramp."""
        if scene.t_s >= _RAMP_S:
            return None
        throttle = _TO * scene.t_s / _RAMP_S
        commands = []
        for i, thruster in enumerate(scene.config.thrusters):
            along = math.cos(thruster.azimuth_rad)
            working = i not in scene.inputs.failed and i not in scene.inputs.up
            share = math.copysign(1.0, along) if working and abs(along) > 0.5 else 0.0
            commands.append(ThrusterCommand(0.0, share * throttle, thruster.azimuth_rad if thruster.turns else None))
        return ThrusterSetpoint(tuple(commands))
