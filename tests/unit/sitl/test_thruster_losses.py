"""What water and battery take of the thrust, against the published formulae written out."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.devices import ThrusterConfig
from companion.config.losses import LossConfig
from companion.config.vessel import find, load
from sitl.battery import FULL_V
from sitl.thruster_losses import ThrusterLosses, Water, raced, ventilated
from sitl.thrusters import ThrusterModel, build
from sitl.world import World, WorldConditions

REVOLT = load(find("revolt"))
NONE = LossConfig(propeller_m=0.2, inflow=False, cross_flow=False, ventilation=False, interaction=False, sag=False)
STILL = (0.0, 0.0, 0.0)
DEEP = (0.0, 0.0, 1.0)


def pushing(*thrusters: ThrusterConfig, throttle: float = 1.0) -> list[ThrusterModel]:
    made = build(thrusters, 0.0, None)
    for thruster in made:
        thruster.demand(throttle, thruster.config.azimuth_rad)
        thruster.step(0.01)
    return list(made)


def left(
    config: LossConfig,
    thrusters: list[ThrusterModel],
    velocity: tuple[float, float, float] = STILL,
    water: list[Water] | None = None,
    battery_v: float = FULL_V,
) -> tuple[float, float, float]:
    places = [(t.config.x_m, t.config.y_m) for t in thrusters]
    return ThrusterLosses(config, [t.config for t in thrusters], places).wrench(thrusters, velocity, water, battery_v)


ONE = replace(REVOLT.thrusters[0], x_m=-1.0, y_m=0.0)


def test_without_losses_it_is_what_the_thrusters_give() -> None:
    thrusters = pushing(*REVOLT.thrusters)
    wrenches = [thruster.wrench() for thruster in thrusters]
    assert left(NONE, thrusters, (1.0, 0.3, 0.1)) == pytest.approx([sum(axis) for axis in zip(*wrenches, strict=True)])


def test_thrust_falls_with_the_inflow_along_a_straight_line() -> None:
    """1 − V/(J₀ n D) with n of T₀ = K_T ρ n² D⁴: at half that speed, half; at it none; not negative beyond."""
    config, thrusters = replace(NONE, inflow=True), pushing(ONE)
    full_n = thrusters[0].force_n
    turns_hz = math.sqrt(full_n / (0.35 * 1025.0 * 0.2**4))
    free_mps = 0.88 * turns_hz * 0.2
    for share in (0.0, 0.5, 1.0):
        assert left(config, thrusters, (share * free_mps, 0.0, 0.0))[0] == pytest.approx((1.0 - share) * full_n)
    assert left(config, thrusters, (2.0 * free_mps, 0.0, 0.0))[0] == 0.0
    assert full_n < left(config, thrusters, (-0.2 * free_mps, 0.0, 0.0))[0] <= 1.3 * full_n
    waves = left(config, thrusters, STILL, [(-0.5 * free_mps, 0.0, 1.0)])
    assert waves[0] == pytest.approx(0.5 * full_n)  # the same water, moved by waves


def test_astern_it_falls_with_the_way_astern() -> None:
    config, thrusters = replace(NONE, inflow=True), pushing(ONE, throttle=-1.0)
    still = left(config, thrusters)[0]
    assert still < 0.0 and still < left(config, thrusters, (-0.3, 0.0, 0.0))[0] < 0.0


def test_water_across_the_shaft_drags_as_momentum_says() -> None:
    config, thrusters = replace(NONE, cross_flow=True), pushing(ONE)
    surge_n, sway_n, yaw_nm = left(config, thrusters, (0.0, 0.4, 0.0))
    area, full_n = 0.25 * math.pi * 0.04, thrusters[0].force_n
    mass_flow = 1025.0 * area * math.sqrt(full_n / (2.0 * 1025.0 * area))
    assert surge_n == pytest.approx(full_n) and sway_n == pytest.approx(-0.4 * mass_flow)
    assert yaw_nm == pytest.approx(-1.0 * sway_n)


def test_near_the_surface_it_ventilates() -> None:
    assert ventilated(2.0) == 1.0 and ventilated(1.3) == 1.0
    assert ventilated(0.0) == pytest.approx(1.0 - 0.675)
    assert ventilated(-0.48) == pytest.approx(0.0, abs=0.01) and ventilated(-2.0) == 0.0
    config, thrusters = replace(NONE, ventilation=True), pushing(ONE)
    assert left(config, thrusters, STILL, [DEEP])[0] == pytest.approx(thrusters[0].force_n)
    assert left(config, thrusters, STILL, [(0.0, 0.0, 0.0)])[0] == pytest.approx(0.325 * thrusters[0].force_n)


def test_in_the_race_of_another_it_gives_less() -> None:
    """Dang and Laheij: right behind at 6 diameters 1 − 0.8^(6^⅔) = 0.52; at right angles nearly all."""
    assert raced(6.0, 0.0) == pytest.approx(1.0 - 0.8 ** (6.0 ** (2.0 / 3.0)))
    assert raced(6.0, 90.0) > 0.99 and raced(6.0, 10.0) < raced(6.0, 20.0) < 1.0
    config = replace(NONE, interaction=True)
    behind, ahead = replace(ONE, x_m=-1.2, name="behind"), replace(ONE, x_m=0.0, name="ahead")
    thrusters = pushing(behind, ahead)
    full_n = thrusters[0].force_n
    assert left(config, thrusters)[0] == pytest.approx((1.0 + raced(6.0, 0.0)) * full_n, rel=1e-3)
    beside = pushing(replace(behind, x_m=-1.0, y_m=-0.15), replace(ahead, x_m=-1.0, y_m=0.15))
    assert left(config, beside)[0] > 1.95 * full_n


def test_hull_and_battery_take_their_share() -> None:
    thrusters = pushing(ONE)
    full_n = thrusters[0].force_n
    assert left(replace(NONE, deduction=0.1), thrusters)[0] == pytest.approx(0.9 * full_n)
    assert left(replace(NONE, sag=True), thrusters, battery_v=0.9 * FULL_V)[0] == pytest.approx(0.81 * full_n)


def test_an_azimuth_lags_and_its_gear_has_play() -> None:
    turning = replace(ONE, kind="azimuth", azimuth_rate_radps=math.radians(90.0))
    thruster = ThrusterModel(turning, 0.0)
    thruster.backlash_rad = math.radians(4.0)
    thruster.demand(0.5, math.radians(30.0))
    for _ in range(200):
        thruster.step(0.01)
    assert math.degrees(thruster.azimuth_rad) == pytest.approx(28.0)
    thruster.demand(0.5, math.radians(27.0))  # within the play
    for _ in range(200):
        thruster.step(0.01)
    assert math.degrees(thruster.azimuth_rad) == pytest.approx(28.0)
    slow = ThrusterModel(turning, 0.0)
    slow.azimuth_lag_s = 0.5
    slow.demand(0.5, math.radians(10.0))
    for _ in range(50):
        slow.step(0.01)
    assert math.degrees(slow.azimuth_rad) == pytest.approx(10.0 * (1.0 - math.exp(-1.0)), rel=0.01)


def test_a_plant_with_losses_is_slower_in_waves() -> None:
    sitl = REVOLT.sitl
    assert sitl is not None
    plant = sitl.plants[sitl.plant]
    lossy = replace(plant, losses=LossConfig(propeller_m=0.15))
    vessel = replace(REVOLT, sitl=replace(sitl, plants={**sitl.plants, sitl.plant: lossy}))
    ways = []
    for boat in (REVOLT, vessel):
        world = World(boat, WorldConditions(waves="0.1@180"))
        for thruster in world.thrusters[:2]:
            thruster.demand(0.6, 0.0)
            thruster.dead = False
        for k in range(1, 201):
            for thruster in world.thrusters[:2]:
                thruster.demand(0.6, 0.0)
            world.advance(0.1 * k)
        ways.append(world.truth.north_m)
    assert 0.5 * ways[0] < ways[1] < 0.98 * ways[0]


def test_an_empty_battery_takes_nothing_of_a_sail_its_keel_and_its_rudder() -> None:
    world = World(load(find("sailbot")), WorldConditions(seed=1, wind="6@90", water="rough", waves="0"))
    world.advance(20.0)
    losses = ThrusterLosses(LossConfig(deduction=0.05), (world.thrusters[0].config,), ((0.0, 0.0),))
    whole = world.thrusters[0].wrench()
    assert abs(whole[1]) > 0.5
    assert losses.wrench(world.thrusters, (0.9, 0.1, 0.0), None, 11.2) == pytest.approx(whole)
