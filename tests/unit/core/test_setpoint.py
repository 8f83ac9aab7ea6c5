"""Setpoints that a guard slows down."""

from __future__ import annotations

import math

import pytest

from companion.core.frames import body_to_ned
from companion.core.setpoint import PathSetpoint, PlannedPose, braked


@pytest.mark.parametrize("gain_mps2", [0.3, 0.0, -0.1, -2.0])
def test_braking_is_against_the_way_ahead_and_astern(gain_mps2: float) -> None:
    ahead = braked(PathSetpoint(0.4, 1.0, 0.2, surge_mps2=gain_mps2), 0.5, 0.2)
    assert (ahead.surge_mps, ahead.sway_mps, ahead.surge_mps2) == pytest.approx((0.5, 0.1, min(0.25 * gain_mps2, -0.2)))
    astern = braked(PathSetpoint(0.4 + math.pi, -1.0, -0.2, surge_mps2=-gain_mps2), 0.5, 0.2)
    for one, other in ((astern.surge_mps, ahead.surge_mps), (astern.surge_mps2, ahead.surge_mps2)):
        assert body_to_ned(one, 0.0, astern.yaw_rad) == pytest.approx(body_to_ned(other, 0.0, ahead.yaw_rad))


def test_without_braking_no_way_is_gained() -> None:
    assert braked(PathSetpoint(0.0, 1.0, surge_mps2=0.3), 0.5).surge_mps2 == 0.0
    assert braked(PathSetpoint(0.0, -1.0, surge_mps2=-0.3), 0.5).surge_mps2 == 0.0


def test_a_plans_own_accelerations_are_those_of_the_slower_way() -> None:
    """With all of its braking ÅBOAT stood ahead of a fence, learned 100 N against that, and was 3 m over it at last."""
    slow = braked(PathSetpoint(0.0, 1.5, surge_mps2=-0.4, sway_mps2=0.2), 0.5)
    assert slow.surge_mps2 == pytest.approx(-0.1) and slow.sway_mps2 == pytest.approx(0.05)
    assert braked(PathSetpoint(0.0, 1.5, surge_mps2=-0.4), 0.5, 0.2).surge_mps2 == -0.2


def test_poses_ahead_are_dropped() -> None:
    """They lead on at full speed: thrusters would turn for a corner that the boat does not reach."""
    assert braked(PathSetpoint(0.0, 1.5, exact=True, ahead=(PlannedPose(0.0, 0.0, 0.0),)), 0.5).ahead == ()
