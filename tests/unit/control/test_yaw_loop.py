"""The heading loop under way: no faster than a jet's nozzle can follow."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import VesselConfig, bundled, find, load
from companion.control.bias import BiasForce
from companion.control.heading import YawLoop
from companion.control.model import damping
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.estimate import NO_ESTIMATE
from companion.core.setpoint import HeadingSetpoint, PathSetpoint
from companion.params.store import Parameters
from companion.params.table import table_of
from tests.unit.control.simple_boat import REVOLT, SimpleBoat

JET_BOAT = load(find("rescuerunner"))
ERROR_RAD = 0.05


def moment_nm(config: VesselConfig, bandwidth_radps: float) -> float:
    """Against a small error of heading, at rest: Kp = m33 ω² of it."""
    parameters = Parameters({**config.parameters, "PATH_BW_YAW": bandwidth_radps})
    setpoint = HeadingSetpoint(ERROR_RAD, ZERO_WRENCH)
    return YawLoop(config, parameters).moment_nm(setpoint, SimpleBoat().nav(), BiasForce(config.limits), 0.0)


def at_rate(rate_dps: float) -> VesselConfig:
    return replace(JET_BOAT, thrusters=(replace(JET_BOAT.thrusters[0], azimuth_rate_radps=math.radians(rate_dps)),))


@pytest.mark.parametrize("rate_dps", [10.0, 14.0, 20.0])
def test_a_slow_nozzle_limits_the_bandwidth(rate_dps: float) -> None:
    """In 1/bandwidth it gets 0.6 of its way to the stop at 24 degrees."""
    bounded = rate_dps / (0.6 * 24.0)
    assert moment_nm(at_rate(rate_dps), 1.8) == pytest.approx(moment_nm(JET_BOAT, bounded))
    assert moment_nm(at_rate(rate_dps), 1.8) < 0.8 * moment_nm(JET_BOAT, 1.8)
    assert moment_nm(at_rate(rate_dps), 0.5 * bounded) == pytest.approx(moment_nm(JET_BOAT, 0.5 * bounded)), (
        "a slower loop stays as it is"
    )


def test_a_fast_nozzle_and_azimuths_do_not_limit_it() -> None:
    assert moment_nm(at_rate(700.0), 1.8) == pytest.approx(moment_nm(JET_BOAT, 1.8))
    slow = replace(REVOLT, thrusters=tuple(replace(thruster, azimuth_rate_radps=0.01) for thruster in REVOLT.thrusters))
    assert moment_nm(slow, 0.8) == moment_nm(REVOLT, 0.8)


@pytest.mark.parametrize("name", sorted(bundled()))
def test_a_large_error_turns_the_boat_at_the_rate_of_its_parameter(name: str) -> None:
    """Or as fast as its limit allows, while the heading is as far off as before. A hull that resists its turn more than the loop damps it did not turn at all."""
    boat = load(find(name))
    parameters = Parameters(boat.parameters, table_of(boat))
    fastest = math.radians(parameters["PATH_YAW_RATE"])
    loop, bias = YawLoop(boat, parameters), BiasForce(boat.limits)
    surge_mps, rate_radps = 0.5 * parameters["WP_SPEED"], 0.0

    def resisted_nm(radps: float) -> float:
        return damping(boat.hull, surge_mps, 0.0, radps)[2]

    for _ in range(400):
        nav = replace(NO_ESTIMATE, yaw_rad=2.5, yaw_rate_radps=rate_radps, surge_mps=surge_mps)
        asked_nm = loop.moment_nm(PathSetpoint(0.0, surge_mps), nav, bias, 0.1)
        given_nm = min(boat.limits.yaw_nm, max(-boat.limits.yaw_nm, asked_nm))
        rate_radps += 0.1 * (given_nm - resisted_nm(rate_radps)) / boat.hull.m33_kgm2
    reachable = min(fastest, next(r / 1000 for r in range(1, 4000) if resisted_nm(r / 1000) >= boat.limits.yaw_nm))
    assert 0.9 * reachable <= -rate_radps <= 1.05 * fastest


def learnt_after_nm(learned_nm: float, error_rad: float) -> float:
    """What is left of a learned moment after 8 s so far off the heading."""
    loop, bias = YawLoop(JET_BOAT, Parameters(JET_BOAT.parameters)), BiasForce(JET_BOAT.limits)
    bias.grow(0.0, 0.0, learned_nm, 0.0, 1.0)
    nav = replace(NO_ESTIMATE, yaw_rad=error_rad, surge_mps=1.0)
    for _ in range(160):
        loop.moment_nm(PathSetpoint(0.0, 1.0), nav, bias, 0.05)
    return bias.in_body(error_rad)[2]


def test_a_moment_learned_on_another_course_does_not_hold_the_bow_off_in_a_turn() -> None:
    """A small jet that had come to rest from full speed circled its point for a minute, out of its alarm circle."""
    assert 0.0 < learnt_after_nm(100.0, 1.5) < 20.0
    assert learnt_after_nm(100.0, -1.5) == pytest.approx(100.0), "one that turns the bow the right way may stay"


def slowed(rate_dps: float = 14.0) -> YawLoop:
    """A loop whose nozzle is found to turn at that rate instead of 70 degrees a second."""
    loop = YawLoop(JET_BOAT, Parameters(JET_BOAT.parameters))
    loop.steers_at(math.radians(rate_dps))
    return loop


def asked_nm(loop: YawLoop, pushed_nm: float, off_deg: float, turning_dps: float) -> float:
    """With `off_deg` left of a turn, at that rate, while the nozzle still gives `pushed_nm`."""
    nav = replace(NO_ESTIMATE, yaw_rad=-math.radians(off_deg), yaw_rate_radps=math.radians(turning_dps), surge_mps=5.0)
    loop.pushes(Wrench(1300.0, 0.0, pushed_nm))
    return loop.moment_nm(PathSetpoint(0.0, 5.0), nav, BiasForce(JET_BOAT.limits), 0.0)


def test_a_slow_nozzle_turns_back_before_the_boat_is_there() -> None:
    """30 degrees before the end of a turn, with a nozzle that takes a second to come back: RescueRunner swung 30
    degrees past its course, and 5 m past its track. What the nozzle no longer does is not waited for."""
    assert asked_nm(slowed(), 500.0, 30.0, 30.0) < asked_nm(slowed(), 0.0, 30.0, 30.0) < 0.0
    assert asked_nm(slowed(70.0), 500.0, 30.0, 30.0) == asked_nm(slowed(70.0), 0.0, 30.0, 30.0)
    assert abs(asked_nm(slowed(), 0.0, 0.0, 0.0)) < 1.0e-9


def learned_nm(loop: YawLoop, turning_radps: float, for_s: float, begin_nm: float = 0.0) -> float:
    """The moment that the loop learns from a steady error of 0.1 rad, in a turn at that rate."""
    bias = BiasForce(JET_BOAT.limits)
    bias.grow(0.0, 0.0, begin_nm, 0.0, 1.0)
    nav = replace(NO_ESTIMATE, yaw_rad=0.1, yaw_rate_radps=turning_radps, surge_mps=8.0)
    for _ in range(round(for_s / 0.1)):
        loop.moment_nm(PathSetpoint(0.0, 8.0, yaw_rate_radps=turning_radps), nav, bias, 0.1)
    return bias.in_body(0.0)[2]


def test_a_loop_with_slow_steering_tells_by_how_much_it_is_later() -> None:
    """At 14 degrees a second in place of 70 its bandwidth is 14/14.4 1/s in place of the parameter's 1.8."""
    assert slowed().late_s == pytest.approx(14.4 / 14.0 - 1.0 / 1.8)
    assert slowed(70.0).late_s == 0.0


def test_slow_steering_learns_an_offset_sooner_on_straights() -> None:
    kp = JET_BOAT.hull.m33_kgm2 * (14.0 / 24.0) ** 2
    assert learned_nm(slowed(), 0.0, 10.0) < -1.5 * kp * 0.1


def test_slow_steering_forgets_in_bends() -> None:
    """What wind and waves turn it by is other after a bend, and its lag in one is no offset: so it left every bend with
    the bow off by 28 degrees for half a minute."""
    bend_radps = math.radians(16.0)
    assert learned_nm(slowed(), bend_radps, 10.0) == 0.0
    assert 0.0 < learned_nm(slowed(), bend_radps, 6.0, 45.0) < 0.3 * 45.0
    assert learned_nm(slowed(70.0), bend_radps, 1.0) < 0.0, "with the steering as configured it learns there"
    assert learned_nm(slowed(60.0), bend_radps, 1.0) < 0.0, "and with one that is slower but fast enough"


@pytest.mark.parametrize("n_ur", [0.0, 400.0, 4000.0])
def test_a_hull_that_way_holds_straight_still_comes_to_its_heading(n_ur: float) -> None:
    """With gains by inertia alone, damping of twenty times the critical leaves a fifth of the error after a minute."""
    hull = replace(REVOLT.hull, damping=replace(REVOLT.hull.damping, n_ur=n_ur))
    boat = replace(REVOLT, hull=hull)
    parameters = Parameters(boat.parameters, table_of(boat))
    loop, bias = YawLoop(boat, parameters), BiasForce(boat.limits)
    yaw_rad, rate_radps = 0.1, 0.0
    for _ in range(round(10.0 / (0.1 * parameters["PATH_BW_YAW"]))):
        nav = replace(NO_ESTIMATE, yaw_rad=yaw_rad, yaw_rate_radps=rate_radps, surge_mps=1.0)
        asked_nm = loop.moment_nm(PathSetpoint(0.0, 1.0), nav, bias, 0.0)
        for _ in range(100):
            rate_radps += 0.001 * (asked_nm - damping(hull, 1.0, 0.0, rate_radps)[2]) / hull.m33_kgm2
            yaw_rad += 0.001 * rate_radps
    assert abs(yaw_rad) < 0.01
