"""A rudder over a whole log against the plant's, which was programmed apart from it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from companion.analysis.blade import blade_of
from companion.config.vessel import VesselConfig
from sitl.hidden_hull import hidden_hull
from sitl.rudder import Rudder

SEED = 32  # has a propeller and a rudder


def vessel() -> VesselConfig:
    return hidden_hull(SEED).real


@pytest.mark.parametrize(
    ("thrust_n", "angle_rad", "surge_mps", "sway_mps", "yaw_radps"),
    [
        (20.0, 0.3, 0.5, 0.0, 0.0),
        (20.0, 0.3, 0.5, 0.1, 0.1),
        (5.0, -0.5, 0.8, -0.1, 0.2),
        (-10.0, 0.3, 0.5, 0.1, 0.0),  # astern with way ahead: no race
        (0.0, 0.2, -0.4, 0.1, 0.1),  # the flow comes from the trailing edge
        (15.0, 0.6, 0.0, 0.1, 0.2),
        (30.0, 0.1, 0.0, 0.2, 0.3),
        (0.0, 0.75, 0.6, -0.3, 0.0),  # stalled
    ],
)
def test_the_force_is_the_plants(
    thrust_n: float, angle_rad: float, surge_mps: float, sway_mps: float, yaw_radps: float
) -> None:
    thruster = vessel().thrusters[0]
    thruster = replace(
        thruster,
        azimuth_min_rad=-1.0,
        azimuth_max_rad=1.0,
        azimuth_rate_radps=100.0,
        max_n=50.0,
        ahead_n=50.0,
        min_n=-50.0,
        astern_n=50.0,
        dead_band=0.0,
    )
    assert thruster.rudder is not None
    plant = Rudder(thruster, 1e-9, thruster.rudder)
    size = abs(thrust_n) / 50.0
    plant.demand(np.copysign(np.sqrt(size), thrust_n), angle_rad)
    for _ in range(200):
        plant.step(0.01, surge_mps, sway_mps, yaw_radps)
    assert plant.azimuth_rad == pytest.approx(angle_rad)
    surge_n, sway_n, _ = plant.wrench()
    blade = blade_of(thruster)
    assert blade is not None
    force = blade.force(
        np.array([plant.given_n]),
        np.array([angle_rad]),
        np.array([surge_mps]),
        np.array([sway_mps + thruster.rudder.x_m * yaw_radps]),
        thruster.rudder.race_gain,
    )
    assert float(force.surge_n[0]) == pytest.approx(surge_n - plant.given_n, rel=3e-3, abs=1e-3)
    assert float(force.sway_n[0]) == pytest.approx(sway_n, rel=3e-3, abs=1e-3)


def test_the_fin_is_the_slope_of_the_side_force() -> None:
    blade = blade_of(vessel().thrusters[0])
    assert blade is not None
    still, small = np.array([0.0]), np.array([1e-4])
    at = (np.array([10.0]), np.array([0.1]), np.array([0.5]))
    fall = blade.force(*at, still, 0.6).sway_n - blade.force(*at, small, 0.6).sway_n
    # the drag's part of the slope is left out
    assert float(blade.force(*at, still, 0.6).fin[0]) == pytest.approx(float(fall[0]) / 1e-4, rel=0.1)
