"""The bias force as the boat turns."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from companion.control.bias import BiasForce
from companion.control.dynamic_positioning import DynamicPositioning
from companion.core.setpoint import PoseSetpoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import REVOLT, nav_state

TURN = [math.radians(degrees) for degrees in range(91)]


def learnt() -> BiasForce:
    """20 N to starboard, with the bow to the north."""
    bias = BiasForce(REVOLT.limits)
    bias.grow(0.0, 20.0, 0.0, 0.0, 1.0)
    return bias


def test_what_pushed_the_side_does_not_push_the_bow_as_hard() -> None:
    """ÅBOAT was driven 4 m past its point, against the wind, by what it had learnt beam on."""
    bias = learnt()
    for before, now in pairwise(TURN):
        bias.turn(before, now)
    x, y, _ = bias.in_body(TURN[-1])
    assert (x, y) == pytest.approx((5.0, 0.0), abs=0.3)


@pytest.mark.parametrize(("bow_on", "ahead_n"), [(True, 5.0), (False, 20.0)])
def test_only_a_bow_that_turns_to_the_weather_is_told_of(bow_on: bool, ahead_n: float) -> None:
    law, bias = DynamicPositioning(REVOLT, Parameters({**REVOLT.parameters, "DP_INTEGRAL": 0.0})), learnt()
    for yaw_rad in TURN:
        law.update(
            PoseSetpoint(0.0, 0.0, yaw_rad).within(0.0, bow_on), replace(nav_state(), yaw_rad=yaw_rad), bias, 0.1
        )
    assert bias.in_body(TURN[-1])[0] == pytest.approx(ahead_n, abs=0.3)
