"""The plant's propeller with a rudder: forces by flow alone, against the controller's curve, in drift and astern."""

from __future__ import annotations

import math

import pytest

from companion.allocation.rudder_curve import RudderCurve
from companion.config.devices import NozzleConfig
from sitl.hull import Hull
from sitl.rudder import Rudder
from tests.unit.rudder_boat import SKIFF

(THRUSTER,) = SKIFF.thrusters
ANGLE_RAD = math.radians(20.0)


def rudder(throttle: float, angle_rad: float, surge_mps: float = 0.0, sway_mps: float = 0.0) -> Rudder:
    assert THRUSTER.rudder is not None
    found = Rudder(THRUSTER, 0.0, THRUSTER.rudder)
    found.demand(throttle, angle_rad)
    for _ in range(200):
        found.step(0.01, surge_mps, sway_mps)
    return found


def test_no_force_without_flow() -> None:
    assert rudder(0.0, ANGLE_RAD).wrench() == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(("throttle", "surge_mps"), [(1.0, 0.0), (0.5, 0.0), (0.0, 1.5), (0.7, 1.0)])
def test_in_straight_flow_it_is_what_the_controller_believes(throttle: float, surge_mps: float) -> None:
    thrust_n = THRUSTER.ahead_n * throttle**2
    x, y, n = rudder(throttle, ANGLE_RAD, surge_mps).wrench()
    assert THRUSTER.rudder is not None
    believed = RudderCurve(THRUSTER).force_n(thrust_n, ANGLE_RAD, surge_mps)
    # the race of both parts of the blade, mixed as speeds squared or as forces: the same without drift
    assert (x, y) == pytest.approx(believed, rel=1e-6)
    assert n == pytest.approx(THRUSTER.rudder.x_m * y)


def test_it_pushes_the_stern_to_the_side_of_its_angle_and_the_other_way_astern() -> None:
    assert rudder(0.5, ANGLE_RAD).wrench()[1] > 0.0 > rudder(0.5, -ANGLE_RAD).wrench()[1]
    ahead, astern = rudder(0.0, ANGLE_RAD, 1.0).wrench(), rudder(0.0, ANGLE_RAD, -1.0).wrench()
    assert astern[1] < 0.0 < ahead[1] and abs(astern[1]) < ahead[1], "astern it is weaker, and turns the other way"
    assert ahead[0] < 0.0 < astern[0], "it resists both ways"


def test_a_propeller_astern_leaves_it_in_dead_water() -> None:
    coasting, braking = rudder(0.0, ANGLE_RAD, 1.0).wrench()[1], rudder(-1.0, ANGLE_RAD, 1.0).wrench()[1]
    assert braking < 0.2 * coasting


def test_amidships_it_is_a_fin() -> None:
    _, y, n = rudder(0.0, 0.0, 1.0, 0.3).wrench()
    assert y < 0.0 < n, "a boat that slides to starboard is pushed back, bow towards its way"


def test_it_stalls() -> None:
    slides = [abs(rudder(0.0, 0.0, 1.0, sway).wrench()[1]) / (1.0 + sway**2) for sway in (0.8, 3.0)]
    assert slides[1] < 4.0 * slides[0]


def test_the_blade_turns_at_the_rate_and_lag_of_its_drive() -> None:
    assert THRUSTER.rudder is not None
    found = Rudder(THRUSTER, 0.0, THRUSTER.rudder, None, NozzleConfig(math.radians(10.0), 0.2))
    found.demand(0.0, ANGLE_RAD)
    found.step(1.0)
    assert found.azimuth_rad == pytest.approx(math.radians(10.0))


def test_the_boat_turns_to_the_side_of_the_wheel() -> None:
    assert SKIFF.sitl is not None and THRUSTER.rudder is not None
    hull = Hull(SKIFF.sitl.plants["as_modelled"].hull)
    found = Rudder(THRUSTER, 0.3, THRUSTER.rudder)
    found.demand(0.6, -ANGLE_RAD)  # pushes the stern to port
    for _ in range(600):
        found.step(0.02, hull.water_surge_mps, hull.water_sway_mps, hull.yaw_rate_radps)
        hull.step(*found.wrench(), 0.02)
    assert hull.yaw_rate_radps > 0.1 and hull.water_surge_mps > 0.5
