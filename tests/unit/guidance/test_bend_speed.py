"""Speeds in bends that the moment of the thrusters can turn a hull under way at."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from companion.cli.new_file import file_text
from companion.config.hull import DampingConfig, HullConfig
from companion.config.vessel import find, load, parse
from companion.config.yaw_limit import YawLimit
from companion.control.model import coriolis, damping
from companion.guidance.bend_speed import BendSpeeds, steady_turn_radps
from companion.guidance.orbit import Circle, OrbitGuidance
from companion.guidance.sideslip import SteeredHull
from companion.guidance.speed_profile import BendLimits
from companion.guidance.turning import bends_of, turning_of
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST
from tests.unit.rudder_boat import ANSWERS

TOP_MPS = 2.4
# An inflatable of 3.95 m, whose bow way holds straight: by its dimensions.
HULL = HullConfig(
    m11_kg=643.0,
    m22_kg=1647.0,
    m33_kgm2=1397.0,
    damping=DampingConfig(x_u=182.7, x_uu=32.3, y_v=46.9, y_vv=937.5, n_r=275.2, n_rr=1705.0, n_ur=1421.0),
)
BOAT = replace(load(find("otter")), hull=HULL, limits=replace(load(find("otter")).limits, yaw_nm=139.6))
BENDS = BendSpeeds(SteeredHull(HULL), YawLimit(BOAT), TOP_MPS)


def taken_nm(speed_mps: float, curvature_1pm: float) -> float:
    rate = speed_mps * curvature_1pm
    return (275.2 + 1421.0 * speed_mps) * rate + 1705.0 * rate * rate


@pytest.mark.parametrize("radius_m", [3.0, 6.0, 12.0, 20.0])
def test_the_turn_takes_seven_tenths_of_the_moment(radius_m: float) -> None:
    assert taken_nm(BENDS.at(1.0 / radius_m), 1.0 / radius_m) == pytest.approx(0.7 * 139.6, rel=0.05)


def test_a_wide_bend_is_sailed_at_any_speed() -> None:
    assert math.isinf(BENDS.at(1.0 / 500.0)) and np.isinf(BENDS.of(np.array([1.0e-6]))[0])


def test_both_forms_agree() -> None:
    bends = np.array([0.01, 0.05, 0.2, 3.0])
    assert BENDS.of(bends).tolist() == [BENDS.at(float(bend)) for bend in bends]


def test_a_steady_turn_without_square_damping() -> None:
    linear = replace(HULL, damping=replace(HULL.damping, n_rr=0.0))
    assert steady_turn_radps(linear, -1.0, 100.0) == pytest.approx(100.0 / (275.2 + 1421.0))
    assert math.isinf(steady_turn_radps(replace(linear, damping=DampingConfig(x_u=1.0)), 0.0, 1.0))


@pytest.mark.parametrize("steers_1pm", [0.0, -0.19])
@pytest.mark.parametrize("surge_mps", [0.5, 1.0, 1.8])
def test_a_hull_with_fins_at_its_stern_turns_as_the_equations_of_motion_say(
    surge_mps: float, steers_1pm: float
) -> None:
    """A launch of 10 m with two rudders, integrated to its steady turn. A moment alone turns it, so it drifts; the
    rudders' force, which was left out, pushes it outwards besides: planned at 1.6 m/s, a circle of 25 m took all."""
    damping_of = DampingConfig(
        x_u=2123.0, y_v=84.0, y_vv=1688.0, n_r=9076.0, n_rr=49800.0, y_uv=2292.0, n_uv=-9018.0, n_ur=50270.0
    )
    hull = HullConfig(m11_kg=10030.0, m22_kg=12410.0, m33_kgm2=73310.0, damping=damping_of)
    v = r = 0.0
    for _ in range(4000):
        drag, turning = damping(hull, surge_mps, v, r), coriolis(hull, surge_mps, v, r)
        v += 0.02 * (9000.0 * steers_1pm - drag[1] - turning[1]) / hull.m22_kg
        r += 0.02 * (9000.0 - drag[2] - turning[2]) / hull.m33_kgm2
    assert v < -0.05
    assert steady_turn_radps(hull, surge_mps, 9000.0, steers_1pm) == pytest.approx(r, rel=0.02)
    adrift = replace(hull, damping=replace(damping_of, n_uv=0.0))
    assert steady_turn_radps(adrift, surge_mps, 9000.0, steers_1pm) > 1.05 * r


def test_the_least_of_the_limits_counts() -> None:
    bend = np.array([1.0 / 12.0])
    free, bounded = BendLimits(0.289, 0.0955), BendLimits(0.289, 0.0955, BENDS)
    assert free.speeds(bend)[0] == pytest.approx(1.146)
    assert bounded.speeds(bend)[0] == BENDS.at(1.0 / 12.0) < 0.9
    assert BendLimits(0.01, 1.0, BENDS).speeds(bend)[0] == pytest.approx(math.sqrt(0.12))


@pytest.mark.parametrize("name", ["revolt", "rescuerunner", "sailbot"])
def test_side_thrust_jets_and_sails_have_other_laws(name: str) -> None:
    assert turning_of(load(find(name)), on_the_spot=False).bends is None


@pytest.mark.parametrize("outside_m", [0.0, 0.5, 1.5, 2.5])
def test_a_boat_that_runs_wide_of_its_circle_does_not_speed_up(outside_m: float) -> None:
    """It is not on its way to the circle: a faster boat would run wider still."""
    guidance = OrbitGuidance(Parameters({"WP_SPEED": 1.43, "PATH_ACC": 0.289}), False, TOP_MPS, BENDS)
    nav = replace(AT_REST, north_m=0.0, east_m=12.0 + outside_m, yaw_rad=math.pi, surge_mps=0.8, north_mps=-0.8)
    guidance.start(Circle(0.0, 0.0, 12.0, True), nav)
    for _ in range(50):
        asked = guidance.update(nav, 1.43, 0.1).setpoint.surge_mps
    assert asked <= BENDS.at(1.0 / 12.0) + 1e-6


def test_bends_count_what_the_speed_gives_rudders_beside_other_thrusters() -> None:
    """A ship of 12 m planned its bends by the moment at rest, with the race of its screws. Its corners were 5 m off."""
    ship = parse(file_text(replace(ANSWERS, length_m=6.0, beam_m=1.8, mass_kg=1200.0, layout="two-rudders", motor="600",
                                   spread_m=1.0)), "ship.toml")  # fmt: skip
    bends, limit, speed_mps = bends_of(ship), YawLimit(ship), 2.0
    assert bends is not None
    still_nm, moment_nm = limit.nm(ship.hull.drag_n(speed_mps)), limit.nm(ship.hull.drag_n(speed_mps), speed_mps)
    assert moment_nm > 1.5 * still_nm
    assert bends.rate_radps(speed_mps) == pytest.approx(steady_turn_radps(ship.hull, speed_mps, moment_nm))
    assert bends.rate_radps(speed_mps) > 1.2 * steady_turn_radps(ship.hull, speed_mps, still_nm)
