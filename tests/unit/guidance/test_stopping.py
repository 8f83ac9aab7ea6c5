"""Where the boat comes to rest."""

from __future__ import annotations

import math

import pytest

from companion.guidance.stopping import BRAKE_SHARE, SMOOTHING_S, stopping_point, stopping_time_s
from companion.params.store import Parameters
from tests.unit.control.simple_boat import nav_state


def test_at_rest_it_is_here() -> None:
    assert stopping_point(nav_state(3.0, -4.0, 1.0), Parameters()) == (3.0, -4.0)


def test_the_slowest_axis_sets_the_time() -> None:
    parameters = Parameters()
    assert stopping_time_s(0.5, 0.0, 0.0, parameters) == pytest.approx(0.5 / (BRAKE_SHARE * 0.1))
    assert stopping_time_s(0.1, 0.1, 0.0, parameters) == pytest.approx(0.1 / (BRAKE_SHARE * 0.04))
    assert stopping_time_s(0.0, 0.0, math.radians(-3.0), parameters) == pytest.approx(3.0 / (BRAKE_SHARE * 1.5))


def test_the_stopping_point_lies_along_the_velocity() -> None:
    north, east = stopping_point(nav_state(yaw_rad=math.pi / 2.0, surge_mps=0.5), Parameters())
    assert north == pytest.approx(0.0, abs=1e-12)
    assert east == pytest.approx(0.5 * (SMOOTHING_S / 2.0 + 0.5 / (2.0 * BRAKE_SHARE * 0.1)), rel=1e-6)
