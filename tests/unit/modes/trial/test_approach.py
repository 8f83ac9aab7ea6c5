"""Between two manoeuvres of a trial: the boat brakes as long as that slows it down, and then comes in."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.vessel import find, load
from companion.core.estimate import NavState
from companion.core.setpoint import HeadingSetpoint
from companion.modes.trial.approach import Approach
from companion.modes.trial.circle import TrialCircle
from companion.modes.trial.expectation import expected
from companion.modes.trial.manoeuvres.manoeuvre import Begin
from tests.unit.conftest import AT_REST

REVOLT = load(find("revolt"))
EXPECTED = expected(REVOLT)
PERIOD_S = 0.1


def carried(east_m: float, east_mps: float) -> NavState:
    """Heading north, carried east."""
    return replace(AT_REST, east_m=east_m, sway_mps=east_mps, east_mps=east_mps)


def braked_for_s(slowing_mps2: float) -> float:
    """Until the bow is turned to the centre. The boat is carried out at a fifth of its top speed, and slows down."""
    radius_m = EXPECTED.radius_m
    approach = Approach(TrialCircle((0.0, 0.0), radius_m, EXPECTED), EXPECTED)
    speed_mps, east_m, t_s = 0.2 * EXPECTED.top_mps, 0.8 * radius_m, 0.0
    approach.begin(carried(east_m, speed_mps), Begin.CENTRE, True, t_s)
    while t_s < 60.0:
        asked = approach.update(carried(east_m, max(0.0, speed_mps)), t_s)
        if asked is None or (isinstance(asked, HeadingSetpoint) and abs(asked.yaw_rad) > math.radians(45.0)):
            return t_s
        speed_mps -= slowing_mps2 * PERIOD_S
        east_m, t_s = east_m + max(0.0, speed_mps) * PERIOD_S, t_s + PERIOD_S
    return math.inf


def test_a_boat_that_a_stream_holds_up_does_not_brake_for_ever() -> None:
    assert braked_for_s(0.0) < 3.0


def test_a_boat_that_slows_down_brakes_until_it_is_slow() -> None:
    needed_s = 6.0 * EXPECTED.speeding_s
    slowing_mps2 = 0.12 * EXPECTED.top_mps / (0.5 * needed_s)  # from a fifth of the top speed to 0.08 of it
    assert 0.4 * needed_s < braked_for_s(slowing_mps2) < 0.6 * needed_s
