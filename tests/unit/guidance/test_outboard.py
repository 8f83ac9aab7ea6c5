"""Bends of a boat with one thruster that turns: it steers by pushing, and cannot brake meanwhile."""

from __future__ import annotations

import itertools
import math

import pytest

from companion.guidance.path_tracking import PathTracker
from companion.guidance.turning import Turning
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import nav_state

CORNER = [Waypoint(0.0, 0.0), Waypoint(50.0, 0.0), Waypoint(50.0, 50.0)]


def surge_mps(outboard: bool, north_m: float, off_deg: float, now_mps: float, turning_dps: float = 0.0) -> float:
    """The speed that is asked for at last of a boat that stays where it is, north on the way to a corner."""
    turning = Turning(on_the_spot=True, aside=outboard)
    guide = PathTracker(
        Parameters({"PATH_INTEGRAL": 0.0, "WP_SPEED": 2.0, "MPC_XY_VEL_MAX": 2.0}), can_sway=False, turning=turning
    )
    nav = nav_state(north_m, 0.0, math.radians(off_deg), now_mps, yaw_rate_radps=math.radians(turning_dps))
    guide.start(CORNER, nav, from_here=False)
    return [guide.update(nav, 2.0, 0.1).setpoint.surge_mps for _ in range(200)][-1]


@pytest.mark.parametrize("off_deg", [-25.0, 15.0, 25.0])
def test_while_it_turns_it_does_not_brake(off_deg: float) -> None:
    """A RIB of 5 m that turned and was too fast was told to brake: its outboard went from ahead to astern, gave no
    moment for two seconds, and the boat slid 5 m past the corner."""
    assert surge_mps(True, 20.0, off_deg, 1.5) == 1.5
    assert surge_mps(False, 20.0, off_deg, 1.5) < 1.3


def test_before_a_sharp_turn_it_brakes() -> None:
    assert surge_mps(True, 20.0, 60.0, 1.5) < 1.0
    assert surge_mps(True, 20.0, 60.0, 1.5, turning_dps=10.0) < 1.0, "it turns the wrong way"


def test_in_a_sharp_turn_it_goes_on() -> None:
    """A RIB that was 30 degrees behind in its turn went astern, turned no further for 3 s, and was 5 m off."""
    assert surge_mps(True, 20.0, 60.0, 1.5, turning_dps=-10.0) == 1.5


def test_the_speed_that_is_asked_for_does_not_jump_as_it_begins_to_turn() -> None:
    """At a mission that replaced another, it jumped by up to 0.9 m/s to what the boat had."""
    parameters = Parameters({"WP_SPEED": 2.0, "MPC_XY_VEL_MAX": 2.0})
    guide = PathTracker(parameters, can_sway=False, turning=Turning(on_the_spot=True, aside=True))
    guide.start(CORNER, nav_state(20.0, 0.0, 0.0, 1.5), from_here=False)
    asked = []
    for k in range(200):
        turning_dps = -10.0 if k >= 100 else 0.0
        nav = nav_state(20.0, 0.0, math.radians(60.0), 1.5, yaw_rate_radps=math.radians(turning_dps))
        asked.append(guide.update(nav, 2.0, 0.1).setpoint.surge_mps)
    assert asked[99] < 1.0 and asked[-1] == 1.5, "it brakes, and then goes on"
    steps = [abs(b - a) for a, b in itertools.pairwise(asked)]
    assert max(steps) <= 1.5 * parameters["PATH_ACC"] * 0.1 + 1.0e-9


def test_it_comes_to_rest_where_it_is_told_to() -> None:
    turning = Turning(on_the_spot=True, aside=True)
    guide = PathTracker(Parameters(), can_sway=False, turning=turning)
    nav = nav_state(20.0, 0.0, math.radians(20.0), 1.5)
    guide.start(CORNER, nav, from_here=False)
    assert [guide.update(nav, 0.0, 0.1).setpoint.surge_mps for _ in range(200)][-1] == 0.0


def test_it_brakes_before_it_turns() -> None:
    """By the time that a turn begins before its bend: 1.2 s, at half a metre a second in seven."""
    for north_m in (35.0, 40.0, 45.0):
        assert surge_mps(True, north_m, 0.0, 2.0) < surge_mps(False, north_m, 0.0, 2.0) - 0.08
    assert surge_mps(True, 5.0, 0.0, 2.0) == surge_mps(False, 5.0, 0.0, 2.0)
