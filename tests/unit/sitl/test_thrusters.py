"""Thrusters: curve, limits, lag, turn."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from pydantic import TypeAdapter

from companion.config.devices import ThrusterConfig
from companion.config.vessel import find, load
from companion.core.actuation import Deployment
from sitl.thrusters import ThrusterModel, build

VESSEL = load(find("revolt"))
STERN, _, BOW = VESSEL.thrusters
DT_S = 0.01


def run(thruster: ThrusterModel, seconds: float) -> None:
    for _ in range(round(seconds / DT_S)):
        thruster.step(DT_S)


def settled(config: ThrusterConfig, throttle: float) -> float:
    thruster = ThrusterModel(config, 0.1)
    thruster.demand(throttle, None)
    run(thruster, 3.0)
    return thruster.force_n


def test_force_is_quadratic_in_throttle_within_limits() -> None:
    assert settled(STERN, 0.5) == pytest.approx(27.0 * 0.25, rel=1e-6)
    assert settled(STERN, -0.5) == pytest.approx(-27.0 * 0.25, rel=1e-6)
    assert settled(STERN, 1.0) == pytest.approx(25.0, rel=1e-6)
    assert settled(STERN, 7.0) == pytest.approx(25.0, rel=1e-6)


def test_bow_is_weaker_astern() -> None:
    assert settled(BOW, 0.8) == pytest.approx(15.18 * 0.64, rel=1e-6)
    assert settled(BOW, -0.8) == pytest.approx(-6.172 * 0.64, rel=1e-6)
    assert settled(BOW, -1.0) == pytest.approx(-6.1, rel=1e-6)


def test_nothing_turns_in_the_dead_band() -> None:
    banded = replace(STERN, dead_band=0.1)
    assert settled(banded, 0.09) == 0.0
    assert settled(banded, -0.09) == 0.0
    assert settled(banded, 0.11) == pytest.approx(27.0 * 0.11**2, rel=1e-6)


def test_thrust_goes_with_the_square_of_revolutions_that_lag() -> None:
    thruster = ThrusterModel(STERN, 0.3)
    thruster.lag_on_revolutions = True
    thruster.demand(0.5, None)
    run(thruster, 0.3)
    assert thruster.force_n == pytest.approx(6.75 * (1.0 - math.exp(-1.0)) ** 2, rel=1e-9)
    thruster.demand(-0.5, None)
    run(thruster, 3.0)
    assert thruster.force_n == pytest.approx(-6.75, rel=1e-3)


def test_force_follows_with_a_first_order_lag() -> None:
    thruster = ThrusterModel(STERN, 0.3)
    thruster.demand(0.5, None)
    run(thruster, 0.3)
    assert thruster.force_n == pytest.approx(6.75 * (1.0 - math.exp(-1.0)), rel=1e-9)
    assert thruster.throttle() == pytest.approx(math.sqrt(thruster.force_n / 27.0))


def test_without_lag_force_is_there_at_once() -> None:
    thruster = ThrusterModel(STERN, 0.0)
    thruster.demand(-0.5, None)
    thruster.step(DT_S)
    assert thruster.force_n == -6.75


def test_azimuth_turns_at_its_rate_and_stops_on_target() -> None:
    thruster = ThrusterModel(STERN, 0.3)
    thruster.demand(0.0, math.radians(90.0))
    run(thruster, 0.3)
    assert math.degrees(thruster.azimuth_rad) == pytest.approx(45.0)
    run(thruster, 0.4)
    assert math.degrees(thruster.azimuth_rad) == pytest.approx(90.0)


def test_endless_azimuth_takes_the_shorter_way_round() -> None:
    thruster = ThrusterModel(replace(STERN, azimuth_rad=math.radians(170.0)), 0.3)
    thruster.demand(0.0, math.radians(-170.0))
    thruster.step(DT_S)
    assert math.degrees(thruster.azimuth_rad) == pytest.approx(171.5)
    run(thruster, 0.5)
    assert math.degrees(thruster.azimuth_rad) == pytest.approx(-170.0)


def limited(low_deg: float, high_deg: float, at_deg: float) -> ThrusterModel:
    thruster = TypeAdapter(ThrusterConfig).validate_python(
        {
            "name": "drive",
            "kind": "azimuth",
            "x_m": 0.0,
            "y_m": 0.0,
            "max_n": 25.0,
            "min_n": -25.0,
            "ahead_n": 27.0,
            "astern_n": 27.0,
            "force_rate_nps": 50.0,
            "azimuth_deg": at_deg,
            "azimuth_rate_dps": 150.0,
            "azimuth_min_deg": low_deg,
            "azimuth_max_deg": high_deg,
        }
    )
    return ThrusterModel(thruster, 0.3)


def test_an_azimuth_with_stops_goes_round_the_long_way() -> None:
    thruster = limited(-175.0, 175.0, 170.0)
    thruster.demand(0.0, math.radians(-170.0))
    thruster.step(DT_S)
    assert math.degrees(thruster.azimuth_rad) == pytest.approx(168.5)
    run(thruster, 3.0)
    assert math.degrees(thruster.azimuth_rad) == pytest.approx(-170.0)


def test_an_azimuth_of_a_turn_and_a_half_uses_it() -> None:
    thruster = limited(-270.0, 270.0, 170.0)
    thruster.demand(0.0, math.radians(-170.0))
    run(thruster, 1.0)
    assert math.degrees(thruster.azimuth_rad) == pytest.approx(190.0)
    thruster.demand(0.0, math.radians(-80.0))
    run(thruster, 3.0)
    assert math.degrees(thruster.azimuth_rad) == pytest.approx(-80.0)  # 280° lies beyond the stop


def test_a_direction_beyond_the_stops_gives_the_nearer_stop() -> None:
    nozzle = limited(-24.0, 24.0, 0.0)
    nozzle.demand(0.0, math.radians(100.0))
    run(nozzle, 2.0)
    assert math.degrees(nozzle.azimuth_rad) == pytest.approx(24.0)
    nozzle.demand(0.0, math.radians(-100.0))
    run(nozzle, 2.0)
    assert math.degrees(nozzle.azimuth_rad) == pytest.approx(-24.0)


def test_a_fixed_thruster_does_not_turn() -> None:
    thruster = ThrusterModel(BOW, 0.3)
    thruster.demand(0.5, 0.0)
    run(thruster, 2.0)
    assert thruster.azimuth_rad == pytest.approx(math.pi / 2)


def test_a_dead_thruster_gives_nothing_and_stays_where_it_points() -> None:
    thruster = ThrusterModel(STERN, 0.3)
    thruster.demand(1.0, 1.0)
    thruster.dead = True
    run(thruster, 3.0)
    assert (thruster.force_n, thruster.azimuth_rad) == (0.0, 0.0)


def test_wrench_of_each_place_and_direction() -> None:
    port, starboard, bow = build(VESSEL.thrusters, 0.0, (-1.12, -1.12, 1.12))
    port.demand(0.5, None)
    starboard.demand(0.5, None)
    bow.demand(0.5, None)
    for thruster in (port, starboard, bow):
        thruster.step(DT_S)
    assert port.wrench() == pytest.approx((6.75, 0.0, 0.15 * 6.75))  # pushes ahead on the port side: bow to starboard
    assert starboard.wrench() == pytest.approx((6.75, 0.0, -0.15 * 6.75))
    assert bow.wrench() == pytest.approx((0.0, 3.795, 1.12 * 3.795))
    placed = build(VESSEL.thrusters, 0.0, None)[2]
    placed.demand(0.5, None)
    placed.step(DT_S)
    assert placed.wrench() == pytest.approx((0.0, 3.795, 1.15 * 3.795))


def test_a_retractable_thruster_gives_nothing_unless_it_is_down() -> None:
    bow = ThrusterModel(BOW, 0.0)
    bow.demand(0.5, None)
    bow.lower = False
    run(bow, 0.01)
    assert (bow.force_n, bow.deployment) == (0.0, Deployment.MOVING)
    run(bow, BOW.travel_s)
    assert (bow.force_n, bow.down, bow.deployment) == (0.0, 0.0, Deployment.RETRACTED)
    bow.lower = True
    run(bow, BOW.travel_s - 0.02)
    assert bow.force_n == 0.0 and bow.deployment is Deployment.MOVING
    run(bow, 0.03)
    assert bow.force_n == pytest.approx(3.795) and bow.deployment is Deployment.LOWERED
    bow.jammed, bow.lower = True, False
    run(bow, 10.0)
    assert bow.down == 1.0 and ThrusterModel(STERN, 0.0).deployment is None


def test_faults_that_the_board_does_not_see() -> None:
    thruster = ThrusterModel(STERN, 0.1)
    thruster.demand(0.5, 1.0)
    thruster.stuck = thruster.stalled = True
    run(thruster, 2.0)
    assert (thruster.azimuth_rad, thruster.force_n) == (0.0, 0.0) and not thruster.dead
    thruster.stalled, thruster.runaway = False, True
    thruster.demand(0.0, None)
    run(thruster, 2.0)
    assert thruster.force_n == pytest.approx(12.5, rel=1e-3)


def test_a_reversed_propeller_pushes_the_other_way_and_a_fouled_one_hardly() -> None:
    thruster = ThrusterModel(STERN, 0.1)
    thruster.demand(0.5, 0.0)
    run(thruster, 2.0)
    asked_n = thruster.force_n
    thruster.reversed = True
    run(thruster, 2.0)
    assert thruster.force_n == pytest.approx(-asked_n, rel=1e-3) and thruster.throttle() < 0.0
    thruster.reversed, thruster.fouled = False, True
    run(thruster, 2.0)
    assert thruster.wrench()[0] == pytest.approx(0.1 * asked_n, rel=1e-3)
    assert thruster.throttle() == pytest.approx(0.5, rel=1e-3), "its board sees nothing"
