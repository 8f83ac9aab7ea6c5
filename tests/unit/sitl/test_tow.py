"""A hull on a tow: where it goes, and that its accelerations are those of where it goes."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import ConfigError, find, load
from sitl.magnetometer import with_magnetometer
from sitl.tow import TowedHull, TowLeg
from sitl.world import World, WorldConditions

VESSEL = load(find("revolt"))
assert VESSEL.sitl is not None
PLANT = VESSEL.sitl.plants["as_sailed"]


def towed(seconds: float, *legs: TowLeg, current: tuple[float, float] = (0.0, 0.0)) -> TowedHull:
    hull = TowedHull(PLANT.hull, legs)
    hull.set_current(*current)
    for _ in range(round(seconds * 100)):
        hull.step(1e6, -1e6, 1e6, 0.01)
    return hull


def test_a_circle_of_three_tenths_g() -> None:
    hull = towed(60.0, TowLeg(60.0, 8.0, 0.3))
    rate = 0.3 * 9.81 / 8.0
    assert hull.yaw_rate_radps == pytest.approx(rate, rel=1e-3)
    assert math.hypot(hull.surge_mps2, hull.sway_mps2) == pytest.approx(0.3 * 9.81, rel=5e-3)
    assert math.hypot(hull.north_mps, hull.east_mps) == pytest.approx(8.0, rel=1e-3)
    assert math.degrees(math.atan2(-hull.sway_mps, hull.surge_mps)) == pytest.approx(
        math.degrees(0.2 * rate), abs=0.05
    )  # bow into the turn


def test_accelerations_integrate_to_velocity_and_velocity_to_position() -> None:
    hull = TowedHull(PLANT.hull, (TowLeg(5.0, 0.0), TowLeg(10.0, 6.0, 0.2), TowLeg(5.0, 2.0, -0.3)))
    north = east = vn = ve = 0.0
    yaw = 0.0
    for _ in range(2000):
        before = hull.yaw_rad
        hull.step(0.0, 0.0, 0.0, 0.01)
        middle = before + 0.5 * math.remainder(hull.yaw_rad - before, 2 * math.pi)
        c, s = math.cos(middle), math.sin(middle)
        dn, de = 0.01 * (c * hull.surge_mps2 - s * hull.sway_mps2), 0.01 * (s * hull.surge_mps2 + c * hull.sway_mps2)
        north, east = north + 0.01 * (vn + 0.5 * dn), east + 0.01 * (ve + 0.5 * de)
        vn, ve, yaw = vn + dn, ve + de, yaw + 0.01 * hull.turn_radps
    assert (vn, ve, north, east) == pytest.approx((hull.north_mps, hull.east_mps, hull.north_m, hull.east_m), abs=1e-6)
    assert math.remainder(yaw - hull.yaw_rad, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_a_current_carries_it_along() -> None:
    hull = towed(30.0, TowLeg(30.0, 3.0), current=(0.0, 1.0))
    assert (hull.north_mps, hull.east_mps) == pytest.approx((3.0, 1.0), abs=1e-3)
    assert (hull.water_surge_mps, hull.water_sway_mps) == pytest.approx((3.0, 0.0), abs=1e-3)
    assert hull.yaw_rad == 0.0


def test_the_world_tows_whatever_the_thrusters_do() -> None:
    world = World(VESSEL, WorldConditions(tow=(TowLeg(10.0, 4.0),)))
    world.advance(10.0)
    assert world.truth.surge_mps == pytest.approx(4.0, abs=0.1)


def test_a_vessel_without_an_inertial_sensor_cannot_have_a_magnetometer() -> None:
    with pytest.raises(ConfigError, match="no sensor with a magnetometer"):
        with_magnetometer(replace(VESSEL, sensors=VESSEL.sensors[:1]))
