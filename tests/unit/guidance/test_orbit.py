"""A circle sailed by a boat that slides: its course follows its bow late."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.cli.new_file import file_text
from companion.config.hull import HullConfig
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import find, load, parse
from companion.core.angles import wrap_pi
from companion.core.estimate import NO_ESTIMATE, NavState
from companion.guidance.orbit import Circle, OrbitGuidance
from companion.guidance.sideslip import SteeredHull, steered_hull_of
from companion.guidance.turning import bends_of
from companion.params.store import Parameters
from sitl.hull import dynamics
from tests.unit.rudder_boat import ANSWERS

DT_S = 0.1
OTTER = load(find("otter")).hull
LAG_S = 10.0  # of a flat barge of two tonnes at 0.4 m/s
BARGE = replace(OTTER, m22_kg=2700.0, damping=replace(OTTER.damping, y_v=2700.0 / LAG_S, y_uv=0.0, y_vv=0.0))
SLOW = Parameters({"WP_SPEED": 0.45, "PATH_YAW_RATE": 5.0, "PATH_ACC": 0.03, "PATH_LOOKAHEAD": 10.0})
BOW_S, TURN_RADPS2 = 3.0, 0.008  # the heading loop, and the most that the thrusters turn the boat


def sailed(hull: HullConfig | None, seconds: float) -> tuple[list[float], float]:
    """(distances outside the circle, angle swept) from 10 m outside."""
    guidance = OrbitGuidance(SLOW, can_sway=False, steered=None if hull is None else SteeredHull(hull))
    nav = replace(NO_ESTIMATE, north_m=-30.0, current_north_mps=0.0, current_east_mps=0.0)
    guidance.start(Circle(0.0, 0.0, 20.0, True), nav)
    off_m, swept = [], 0.0
    for _ in range(int(seconds / DT_S)):
        progress = guidance.update(nav, 0.45, DT_S)
        setpoint = progress.setpoint
        assert setpoint.yaw_rad is not None
        wanted = setpoint.yaw_rate_radps + wrap_pi(setpoint.yaw_rad - nav.yaw_rad) / BOW_S
        turn = min(TURN_RADPS2, max(-TURN_RADPS2, (wanted - nav.yaw_rate_radps) / 1.5))
        nav = slid(nav, nav.yaw_rate_radps + turn * DT_S, setpoint.surge_mps)
        off_m.append(progress.error_m)
        swept = progress.swept_rad or 0.0
    return off_m, swept


def slid(nav: NavState, rate_radps: float, asked_mps: float) -> NavState:
    """One step of a hull that keeps its momentum in the turn, and loses its sideways speed within LAG_S."""
    surge = nav.surge_mps + (asked_mps - nav.surge_mps) * DT_S / 4.0
    sway = nav.sway_mps - (surge * rate_radps + nav.sway_mps / LAG_S) * DT_S
    return moved(nav, surge, sway, rate_radps)


def moved(nav: NavState, surge: float, sway: float, rate_radps: float) -> NavState:
    """Where it is a step later."""
    yaw = wrap_pi(nav.yaw_rad + rate_radps * DT_S)
    north, east = (surge * math.cos(yaw) - sway * math.sin(yaw), surge * math.sin(yaw) + sway * math.cos(yaw))
    return replace(
        nav,
        north_m=nav.north_m + north * DT_S,
        east_m=nav.east_m + east * DT_S,
        yaw_rad=yaw,
        yaw_rate_radps=rate_radps,
        surge_mps=surge,
        sway_mps=sway,
        north_mps=north,
        east_mps=east,
    )


def test_a_boat_that_slides_comes_round() -> None:
    """What it slides must not be learnt faster than its course follows its bow: the bow would swing to and fro."""
    off_m, swept = sailed(BARGE, 1200.0)
    assert swept > 2.0 * math.tau
    assert max(abs(off) for off in off_m[-3000:]) < 1.0
    swinging_m, _ = sailed(None, 1200.0)
    assert max(abs(off) for off in swinging_m[-3000:]) > 1.0


@pytest.mark.parametrize("radius_m", [25.0, 40.0])
def test_a_ship_that_slips_in_its_turn_settles_on_the_circle(radius_m: float) -> None:
    """Still water. What it slipped as it turned in was learnt as if it were there for good: it swung across the circle,
    7 m to either side."""
    ship = parse(
        file_text(
            replace(
                ANSWERS, layout="two-rudders", length_m=10.0, beam_m=3.0, mass_kg=9000.0, motor="4000", spread_m=1.4
            )
        ),
        "ship.toml",
    )
    steered, parameters = steered_hull_of(ship), Parameters(ship.parameters)
    assert steered is not None
    guidance = OrbitGuidance(parameters, False, top_speed_mps(ship), bends_of(ship, steady=True), steered)
    accelerations, inertia, most_nm = dynamics(ship.hull), ship.hull.m33_kgm2, 16000.0
    nav = replace(NO_ESTIMATE, north_m=-2.0 * radius_m)
    guidance.start(Circle(0.0, 0.0, radius_m, True), nav)
    off_m = []
    for _ in range(4000):
        progress = guidance.update(nav, 1.7, DT_S)
        setpoint = progress.setpoint
        turn = 0.49 * wrap_pi(setpoint.yaw_rad - nav.yaw_rad) + 1.1 * (setpoint.yaw_rate_radps - nav.yaw_rate_radps)
        moment = min(most_nm, max(-most_nm, inertia * turn))
        u, v, r = nav.surge_mps, nav.sway_mps, nav.yaw_rate_radps
        _, dv, dr = accelerations(u, v, r, 0.0, moment * steered.steers_1pm, moment)
        u += (setpoint.surge_mps - u) * DT_S / 4.0
        nav = moved(nav, u, v + dv * DT_S, r + dr * DT_S)
        off_m.append(progress.error_m)
    assert max(abs(off) for off in off_m[1500:]) < 0.7


def test_places_that_come_in_steps_do_not_make_the_speed_step() -> None:
    """At 5 Hz, of a receiver by itself: each fix changed the bend, and the propeller surged with it."""
    parameters = Parameters({"WP_SPEED": 1.0, "PATH_YAW_RATE": 8.0, "PATH_ACC": 0.2, "PATH_LOOKAHEAD": 3.0})
    guidance = OrbitGuidance(parameters, can_sway=False)
    nav = replace(NO_ESTIMATE, current_north_mps=0.0, current_east_mps=0.0, yaw_rad=math.pi, north_mps=-0.8)
    nav = replace(nav, surge_mps=0.8)
    guidance.start(Circle(0.0, 0.0, 20.0, True), replace(nav, east_m=19.5))
    asked = []
    for i in range(100):
        place = replace(nav, east_m=19.5 + (0.1 if i // 2 % 2 else -0.1))
        asked.append(guidance.update(place, 1.0, DT_S).setpoint.surge_mps2)
    assert max(map(abs, asked[50:])) < 0.15
