"""The moment that thrusters give beside a force ahead."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.allocation.rudder_curve import RudderCurve
from companion.cli.new_file import file_text
from companion.config.dimensions.limits import rudder_share
from companion.config.vessel import VesselConfig, find, load, parse
from companion.config.yaw_limit import YawLimit
from tests.unit.rudder_boat import ANSWERS, SKIFF

WAMV = load(find("wamv16"))  # two motors of 250 N ahead and 100 N astern, 1.03 m off the middle


def test_at_rest_and_astern_it_is_the_limit_of_the_file() -> None:
    limit = YawLimit(WAMV)
    assert limit.nm(0.0) == limit.nm(-50.0) == WAMV.limits.yaw_nm


def test_ahead_the_stronger_thrust_of_one_motor_turns_the_boat() -> None:
    """0.9 of (2 · 100 N + force) · 1.03 m, as long as the other motor still pushes with less than 250 N."""
    limit = YawLimit(WAMV)
    for surge_n in (45.0, 90.0, 120.0):
        assert limit.nm(surge_n) == pytest.approx(0.9 * (200.0 + surge_n / 0.9) * 1.03, rel=0.01)


def test_it_is_never_less_than_at_rest() -> None:
    limit = YawLimit(WAMV)
    assert min(limit.nm(0.01 * i * WAMV.limits.surge_n) for i in range(120)) == WAMV.limits.yaw_nm


def test_for_its_heading_the_boat_slows_down() -> None:
    limit = YawLimit(WAMV)
    strongest_n = max(range(450), key=lambda n: limit.nm(float(n)))
    assert limit.within(400.0, 240.0) == (pytest.approx(210.0, abs=20.0), 240.0)  # as little as needed
    surge_n, yaw_nm = limit.within(400.0, -900.0)
    assert surge_n == pytest.approx(strongest_n, abs=30.0) and yaw_nm == -limit.nm(surge_n)
    assert abs(yaw_nm) == pytest.approx(limit.most_nm, rel=0.02)


def test_a_moment_that_fits_costs_no_way() -> None:
    limit = YawLimit(WAMV)
    assert limit.within(100.0, 200.0) == (100.0, 200.0) and limit.within(-100.0, 400.0) == (-100.0, 185.4)
    assert limit.within(300.0, -180.0) == (300.0, -180.0)


def flat(config: VesselConfig) -> bool:
    return YawLimit(config).nm(0.3 * config.limits.surge_n) == config.limits.yaw_nm


def test_a_limit_that_somebody_chose_stays() -> None:
    assert flat(replace(WAMV, limits=replace(WAMV.limits, yaw_nm=150.0)))


@pytest.mark.parametrize("name", ["revolt", "rescuerunner", "aboat", "sailbot"])
def test_other_boats_have_one_limit(name: str) -> None:
    assert flat(load(find(name)))


@pytest.mark.parametrize("layout", ["two-rudders", "rudder-bow"])
def test_rudders_beside_other_thrusters_push_with_the_race_of_the_force_ahead(layout: str) -> None:
    boat = parse(file_text(replace(ANSWERS, layout=layout, spread_m=0.3, bow_motor="10")), "boat.toml")
    limit, rudder = YawLimit(boat), boat.thrusters[0].rudder
    assert rudder is not None
    surge_n = 0.8 * boat.limits.surge_n
    by_blades_nm = abs(rudder.x_m) * rudder_share(boat.thrusters[0]) * surge_n
    assert limit.nm(0.0) == boat.limits.yaw_nm
    assert limit.nm(surge_n) > by_blades_nm
    assert limit.nm(surge_n) < 1.3 * by_blades_nm + boat.limits.yaw_nm


def test_a_rudder_alone_keeps_the_limit_of_the_file() -> None:
    assert YawLimit(SKIFF).nm(0.8 * SKIFF.limits.surge_n) == SKIFF.limits.yaw_nm


@pytest.mark.parametrize(("layout", "least"), [("two-rudders", 3.0), ("rudder-bow", 3.0)])
def test_rudders_beside_other_thrusters_push_with_the_speed_too(layout: str, least: float) -> None:
    """As `RudderCurve` has it, which the allocation uses: 0.9 of what the blades give there more than at rest."""
    boat = parse(file_text(replace(ANSWERS, layout=layout, spread_m=0.3, bow_motor="10")), "boat.toml")
    limit, surge_n, surge_mps = YawLimit(boat), 0.4 * boat.limits.surge_n, 2.0
    rudders = [RudderCurve(thruster) for thruster in boat.thrusters if thruster.rudder is not None]
    each_n = surge_n / len(rudders)
    more_nm = sum(
        abs(curve.lever_m) * (curve.most_n(curve.inflow(each_n, surge_mps)) - curve.most_n(curve.inflow(each_n, 0.0)))
        for curve in rudders
    )
    assert limit.by_speed
    assert limit.nm(surge_n, surge_mps) - limit.nm(surge_n) == pytest.approx(0.9 * more_nm)
    assert limit.nm(surge_n, surge_mps) > least * boat.limits.yaw_nm
    assert limit.nm(surge_n, -surge_mps) == limit.nm(surge_n)
    wanted_nm = 2.0 * boat.limits.yaw_nm
    assert limit.within(surge_n, wanted_nm, surge_mps) == (surge_n, wanted_nm)


def test_speed_gives_a_boat_without_rudders_nothing() -> None:
    for boat in (WAMV, SKIFF, load(find("revolt")), load(find("sailbot"))):
        limit = YawLimit(boat)
        assert not limit.by_speed and limit.nm(50.0, 3.0) == limit.nm(50.0)


def test_a_thruster_in_the_bow_turns_the_boat_too_where_a_push_aside_does_not_count() -> None:
    boat = parse(file_text(replace(ANSWERS, layout="twin-bow", spread_m=0.3, bow_motor="10")), "boat.toml")
    limit, bow = YawLimit(boat), boat.thrusters[-1]
    assert bow.azimuth_rad == pytest.approx(math.pi / 2.0)
    assert limit.aside_nm == pytest.approx(0.9 * abs(bow.min_n) * bow.x_m, rel=0.01)
    assert limit.within(5.0, 1.0e3, aside=True) == (5.0, boat.limits.yaw_nm + limit.aside_nm)
    assert limit.within(5.0, 1.0e3) == (5.0, boat.limits.yaw_nm)


def test_no_other_boat_has_more_by_a_push_aside() -> None:
    """Without sideways thrust what pushes aside counts already; a limit that somebody chose stays."""
    by_hand = replace(load(find("cybership2")), limits=replace(load(find("cybership2")).limits, yaw_nm=1.0))
    for boat in (WAMV, SKIFF, load(find("rescuerunner")), by_hand):
        assert YawLimit(boat).aside_nm == 0.0
