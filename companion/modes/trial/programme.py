"""The manoeuvres of a trial, in their order."""

from __future__ import annotations

from companion.modes.trial.expectation import Expectation
from companion.modes.trial.manoeuvres.dead_band import DeadBand
from companion.modes.trial.manoeuvres.drift import Drift
from companion.modes.trial.manoeuvres.manoeuvre import Manoeuvre
from companion.modes.trial.manoeuvres.motor_check import MotorCheck
from companion.modes.trial.manoeuvres.positioning_steps import PositioningSteps
from companion.modes.trial.manoeuvres.stopping import Stopping
from companion.modes.trial.manoeuvres.surge_step import SurgeStep
from companion.modes.trial.manoeuvres.sway_push import SwayPush
from companion.modes.trial.manoeuvres.turning_circle import TurningCircle
from companion.modes.trial.manoeuvres.yaw_spin import YawSpin
from companion.modes.trial.manoeuvres.zig_zag import ZigZag
from companion.positioning.hold_point import HoldPoint


def programme(expectation: Expectation, hold_point: HoldPoint) -> tuple[Manoeuvre, ...]:
    """What this boat does; sideways pushes only with sideways thrust."""
    return (
        MotorCheck(),
        DeadBand(),
        SurgeStep(0.3, coasts=True, vital=True),
        SurgeStep(0.6, coasts=True),
        SurgeStep(-0.5, coasts=True),
        Stopping(),
        *((SwayPush(0.5), SwayPush(0.9)) if expectation.sways else ()),
        YawSpin(0.35),
        YawSpin(0.8),
        TurningCircle(to_starboard=True),
        ZigZag(10.0),
        ZigZag(20.0),
        TurningCircle(to_starboard=False),
        Drift(),
        PositioningSteps(hold_point),
    )
