"""Manoeuvres of hulls whose motion is known in closed form."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.hull import DampingConfig, HullConfig
from companion.config.vessel import PlantConfig, find, load
from sitl.manoeuvres import Bare, Thrust, stopping, turning_circle, zigzag

OTTER = load(find("otter"))
LINEAR = HullConfig(100.0, 100.0, 40.0, damping=DampingConfig(x_u=80.0, y_v=1e4, n_r=50.0))
PLANT = PlantConfig(hull=LINEAR, thruster_lag_s=0.0)


def test_half_speed_of_a_linear_drag_is_the_time_constant_times_ln_2() -> None:
    found = stopping(Bare(OTTER, PLANT), Thrust(40.0, 0.0))
    assert found["half_speed_s"] == pytest.approx(100.0 / 80.0 * math.log(2.0), abs=0.006)
    assert found["half_speed_m"] == pytest.approx(0.5 * 100.0 / 80.0, rel=0.01)


def test_the_circle_of_a_hull_that_does_not_drift() -> None:
    found = turning_circle(Bare(OTTER, PLANT), Thrust(40.0, 20.0))
    rate = 20.0 * 0.395 / 50.0
    assert found["speed_before_mps"] == pytest.approx(1.0, rel=1e-6)
    assert math.radians(found["yaw_rate_dps"]) == pytest.approx(rate, rel=1e-3)
    assert found["steady_diameter_m"] == pytest.approx(2.0 * found["speed_mps"] / rate, rel=1e-3)
    assert abs(found["drift_deg"]) < 0.1
    assert found["tactical_diameter_m"] == pytest.approx(found["steady_diameter_m"], rel=0.1)


def test_the_overshoot_of_a_linear_turn() -> None:
    """From the steady rate R with time constant T, the moment reversed: the heading goes on by R T (1 − ln 2)."""
    found = zigzag(Bare(OTTER, PLANT), Thrust(40.0, 20.0), 60.0)
    steady_deg = math.degrees(20.0 * 0.395 / 50.0)
    assert found["overshoot_2_deg"] == pytest.approx(steady_deg * 40.0 / 50.0 * (1.0 - math.log(2.0)), rel=0.02)


def test_a_force_beside_the_thrusters_counts_as_thrust() -> None:
    helped = turning_circle(Bare(OTTER, PLANT, 8.0), Thrust(36.0, 20.0))
    assert helped["speed_before_mps"] == pytest.approx(1.0, rel=1e-6)


def test_a_slow_propeller_makes_a_larger_overshoot() -> None:
    quick, slow = (
        zigzag(Bare(OTTER, replace(PLANT, thruster_lag_s=lag_s, lag_on="revolutions")), Thrust(40.0, 20.0))
        for lag_s in (0.1, 1.0)
    )
    assert slow["overshoot_1_deg"] > 1.5 * quick["overshoot_1_deg"]


def test_a_boat_that_does_not_turn_is_said() -> None:
    with pytest.raises(ValueError, match="0 changes of side"):
        zigzag(Bare(OTTER, PLANT), Thrust(40.0, 0.0))
