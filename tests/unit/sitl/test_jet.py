"""The jet and the planing hull against closed forms and the figures of the RescueRunner thesis."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from companion.config.devices import NozzleConfig
from companion.config.vessel import find, load
from sitl.hull import Hull, resistance_of
from sitl.jet import Jet

VESSEL = load(find("rescuerunner"))
assert VESSEL.sitl is not None
PLANT = VESSEL.sitl.plants["as_estimated"]
WORN = VESSEL.sitl.plants["worn"]
CONFIG = VESSEL.thrusters[0]
SPEEDS, FORCES = zip(*PLANT.hull.resistance, strict=True)
DT_S = 0.01


def jet(lag_s: float = 0.5) -> Jet:
    assert CONFIG.jet is not None
    return Jet(CONFIG, lag_s, CONFIG.jet)


def sail(hull: Hull, thruster: Jet, duration_s: float, each: Callable[[], bool] | None = None) -> None:
    for _ in range(round(duration_s / DT_S)):
        thruster.step(DT_S, hull.water_surge_mps)
        hull.step(*thruster.wrench(), DT_S)
        if each is not None and each():
            return


def steady_mps(throttle: float) -> float:
    hull, thruster = Hull(PLANT.hull), jet()
    thruster.demand(throttle, 0.0)
    sail(hull, thruster, 60.0)
    return hull.water_surge_mps


@pytest.mark.parametrize("throttle", [0.1, 0.3, 0.5, 0.7, 1.0])
def test_it_settles_where_thrust_and_resistance_balance(throttle: float) -> None:
    speed = steady_mps(throttle)
    exit_mps = 6.0 + 27.0 * throttle**1.32
    assert 5.125 * exit_mps * (exit_mps - 0.9 * speed) == pytest.approx(np.interp(speed, SPEEDS, FORCES), rel=0.002)


def test_the_speeds_of_the_thesis() -> None:
    """8.2 m/s at about half throttle, 40 kn at full."""
    assert steady_mps(0.5) == pytest.approx(8.2, abs=0.3)
    assert steady_mps(1.0) == pytest.approx(40.0 / 1.94384, rel=0.04)


def test_the_turning_circle_at_full_nozzle() -> None:
    """A radius of 9 m or so: half the distance across after half a turn."""
    hull, thruster = Hull(PLANT.hull), jet()
    thruster.demand(0.505, 0.0)
    sail(hull, thruster, 60.0)
    began_m, turned = hull.east_m, 0.0

    def half_round() -> bool:
        nonlocal turned
        turned += hull.turn_radps * DT_S
        return turned >= math.pi

    thruster.demand(0.505, math.radians(-24.0))
    sail(hull, thruster, 30.0, half_round)
    assert turned >= math.pi and 0.5 * (hull.east_m - began_m) == pytest.approx(9.0, abs=1.5)
    assert hull.water_sway_mps < -0.5, "it slides outwards"


def test_without_thrust_the_nozzle_does_nothing() -> None:
    hull, thruster = Hull(PLANT.hull), jet()
    hull.place(0.0, 0.0, 0.0, 6.0)
    thruster.demand(0.0, math.radians(24.0))
    sail(hull, thruster, 3.0)
    assert thruster.azimuth_rad == pytest.approx(math.radians(24.0)) and abs(hull.yaw_rad) < 1e-12


def test_the_impeller_lags_and_the_nozzle_turns_at_its_rate() -> None:
    thruster = jet()
    thruster.demand(1.0, math.radians(40.0))
    for _ in range(20):
        thruster.step(DT_S)
    exit_mps = 33.0 * -math.expm1(-0.2 / 0.5)
    assert thruster.force_n == pytest.approx(5.125 * exit_mps**2, rel=1e-4)
    assert thruster.azimuth_rad == pytest.approx(math.radians(14.0))
    for _ in range(300):
        thruster.step(DT_S)
    assert thruster.azimuth_rad == pytest.approx(math.radians(24.0)) and thruster.throttle() == pytest.approx(
        1.0, abs=0.01
    )
    assert thruster.force_n == pytest.approx(CONFIG.ahead_n, rel=0.01)


@pytest.mark.parametrize("lag_s", [0.0, 0.3])
def test_a_linear_actuator_turns_the_nozzle(lag_s: float) -> None:
    """At its rate while it is further off than rate times lag, then with its time constant, whatever the vessel's file
    promises."""
    thruster = Jet(CONFIG, 0.5, CONFIG.jet, None, NozzleConfig(math.radians(14.0), lag_s))  # type: ignore[arg-type]
    thruster.demand(0.5, math.radians(20.0))
    far_s = (20.0 - 14.0 * lag_s) / 14.0
    for step in range(1, 301):
        thruster.step(DT_S)
        t_s = step * DT_S
        left_deg = (
            20.0 - 14.0 * t_s if t_s <= far_s else 14.0 * lag_s * math.exp(-(t_s - far_s) / lag_s) if lag_s else 0.0
        )
        assert math.degrees(thruster.azimuth_rad) == pytest.approx(20.0 - left_deg, abs=0.08)


def test_at_rest_below_the_dead_band_and_astern_nothing_is_given() -> None:
    thruster = jet(lag_s=0.0)
    for throttle in (0.0, 0.019, -0.5):
        thruster.demand(throttle, None)
        thruster.step(DT_S, 3.0)
        assert thruster.force_n == 0.0 and thruster.throttle() == 0.0
    thruster.demand(0.02, None)
    thruster.step(DT_S, 0.0)
    assert thruster.force_n == pytest.approx(5.125 * (6.0 + 27.0 * 0.02**1.32) ** 2)
    thruster.step(DT_S, 10.0)
    assert thruster.force_n < 0.0, "a boat that outruns its jet is braked by it"


def test_faults() -> None:
    thruster = jet(lag_s=0.0)
    thruster.demand(0.5, 0.3)
    thruster.stalled = True
    thruster.step(DT_S)
    assert thruster.force_n == 0.0 and thruster.azimuth_rad > 0.0
    thruster.stalled, thruster.runaway = False, True
    thruster.demand(0.0, 0.0)
    thruster.step(DT_S)
    assert thruster.throttle() == pytest.approx(0.5)
    thruster.runaway, thruster.dead = False, True
    before_rad = thruster.azimuth_rad
    thruster.step(DT_S)
    assert thruster.force_n == 0.0 and thruster.azimuth_rad == before_rad


def test_a_worn_jet_on_a_foul_hull_is_slower() -> None:
    hull = Hull(WORN.hull)
    assert WORN.jet is not None
    thruster = Jet(CONFIG, WORN.thruster_lag_s, WORN.jet)
    thruster.demand(0.7, 0.0)
    sail(hull, thruster, 60.0)
    assert hull.water_surge_mps < 0.8 * steady_mps(0.7)


def test_both_sides_read_the_same_resistance() -> None:
    """The plant's and the controller's own reading of the table, against numpy's."""
    plant = resistance_of(PLANT.hull.resistance)
    for speed in (0.0, 0.7, 2.0, 3.3, 5.5, 7.9, 12.0, 20.6):
        expected = float(np.interp(speed, SPEEDS, FORCES))
        assert plant(speed) == pytest.approx(expected) and PLANT.hull.drag_n(speed) == pytest.approx(expected)
        assert PLANT.hull.drag_n(-speed) == pytest.approx(-expected)
    assert plant(24.0) == pytest.approx(2500.0 + 850.0 / 4.6 * 3.4) and PLANT.hull.drag_n(24.0) == pytest.approx(
        plant(24.0)
    )
    slope = (PLANT.hull.drag_n(3.001) - PLANT.hull.drag_n(2.999)) / 0.002
    assert PLANT.hull.drag_slope(3.0) == pytest.approx(slope)
    assert replace(PLANT.hull, resistance=()).drag_n(5.0) == 0.0
