"""The boat seen from its stern."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.core.frames import body_to_ned
from companion.core.setpoint import PathSetpoint, PlannedPose
from companion.guidance.stern_first import turned, turned_back
from tests.unit.estimates import AT_REST


def test_velocity_over_ground_and_turn_stay() -> None:
    north, east = body_to_ned(1.0, -0.2, 0.7)
    nav = replace(
        AT_REST, yaw_rad=0.7, surge_mps=1.0, sway_mps=-0.2, north_mps=north, east_mps=east, yaw_rate_radps=0.1
    )
    seen = turned(nav)
    assert seen.yaw_rad == pytest.approx(0.7 - math.pi)
    assert body_to_ned(seen.surge_mps, seen.sway_mps, seen.yaw_rad) == pytest.approx((north, east))
    assert (seen.north_mps, seen.east_mps, seen.yaw_rate_radps) == (north, east, 0.1)
    again = turned(seen)
    assert (again.yaw_rad, again.surge_mps, again.sway_mps) == pytest.approx((0.7, 1.0, -0.2))


def test_a_setpoint_asks_for_the_same_motion_over_ground() -> None:
    asked = PathSetpoint(2.0, 0.8, 0.1, 0.05, 0.2, sway_mps2=-0.1, yaw_radps2=0.01, exact=True)
    asked = replace(asked, ahead=(PlannedPose(1.0, 2.0, 2.5),))
    given = turned_back(asked)
    assert given.yaw_rad == pytest.approx(2.0 - math.pi) and given.surge_mps == -0.8
    for x, y, x_given, y_given in (
        (asked.surge_mps, asked.sway_mps, given.surge_mps, given.sway_mps),
        (asked.surge_mps2, asked.sway_mps2, given.surge_mps2, given.sway_mps2),
    ):
        assert body_to_ned(x, y, asked.yaw_rad) == pytest.approx(body_to_ned(x_given, y_given, given.yaw_rad))
    assert (given.yaw_rate_radps, given.yaw_radps2, given.exact) == (0.05, 0.01, True)
    (pose,) = given.ahead
    assert (pose.north_m, pose.east_m) == (1.0, 2.0) and pose.yaw_rad == pytest.approx(2.5 - math.pi)
