"""Turning ahead of a corner to which a stream carries the boat."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.core.angles import wrap_pi
from companion.core.frames import body_to_ned
from companion.guidance.carried_turn import carried_m
from companion.guidance.path_tracking import PathTracker
from companion.guidance.turning import Turning
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import nav_state

DT_S = 0.1
RATE_RADPS = math.radians(16.0)  # of the boat; PATH_YAW_RATE is what its file believes
VALUES = {
    "PATH_YAW_RATE": 25.0,
    "PATH_ACC": 0.7,
    "NAV_ACC_RAD": 1.5,
    "WP_SPEED": 1.5,
    "MPC_XY_VEL_MAX": 2.0,
    "PATH_LOOKAHEAD": 3.0,
}


@pytest.mark.parametrize(("begin_deg", "end_deg"), [(0.0, 90.0), (-170.0, -50.0), (170.0, -130.0), (30.0, -60.0)])
def test_the_way_carried_is_the_integral_of_the_streams_part_across_the_hull(begin_deg: float, end_deg: float) -> None:
    water, steps = (-0.5, 0.2), 20_000
    begin, turn = math.radians(begin_deg), wrap_pi(math.radians(end_deg - begin_deg))
    north = east = 0.0
    for i in range(steps):
        yaw = begin + turn * (i + 0.5) / steps
        across = water[1] * math.cos(yaw) - water[0] * math.sin(yaw)
        north -= across * math.sin(yaw) * abs(turn) / steps / 0.3
        east += across * math.cos(yaw) * abs(turn) / steps / 0.3
    assert carried_m(water, begin, math.radians(end_deg), 0.3) == pytest.approx((north, east), abs=1.0e-6)


def corner(water: tuple[float, float], seconds: float = 60.0) -> tuple[float, float]:
    """How far beyond and how far before the corner (metres, along the old leg) a boat gets off the new leg, which goes
    20 m north and then 20 m west. It turns and speeds up as bounds allow, and has no hold on the water sideways."""
    guide = PathTracker(Parameters(VALUES), can_sway=False, top_mps=3.0, turning=Turning(on_the_spot=True))
    nav = replace(nav_state(), current_north_mps=water[0], current_east_mps=water[1])
    guide.start([Waypoint(20.0, 0.0), Waypoint(20.0, -30.0)], nav)
    beyond = before = 0.0
    for _ in range(round(seconds / DT_S)):
        progress = guide.update(nav, 1.5, DT_S)
        if progress.finished or nav.east_m < -12.0:
            break
        ordered = progress.setpoint
        turn = min(RATE_RADPS * DT_S, max(-RATE_RADPS * DT_S, wrap_pi(ordered.yaw_rad - nav.yaw_rad)))
        yaw = wrap_pi(nav.yaw_rad + turn)
        surge = nav.surge_mps + min(0.6 * DT_S, max(-0.6 * DT_S, ordered.surge_mps - nav.surge_mps))
        sway = water[1] * math.cos(yaw) - water[0] * math.sin(yaw)
        north, east = body_to_ned(surge, sway, yaw)
        nav = replace(
            nav,
            north_m=nav.north_m + north * DT_S,
            east_m=nav.east_m + east * DT_S,
            north_mps=north,
            east_mps=east,
            yaw_rad=yaw,
            surge_mps=surge,
            sway_mps=sway,
            yaw_rate_radps=turn / DT_S,
        )
        beyond = max(beyond, nav.north_m - 20.0)
        before = max(before, 20.0 - nav.north_m) if nav.east_m < -3.0 else before
    assert nav.east_m < -11.0, "it goes on along the new leg"
    return beyond, before


@pytest.mark.parametrize("water", [(0.55, 0.0), (0.5, 0.25), (0.5, -0.25)])
def test_a_stream_along_the_leg_does_not_carry_it_past_the_corner(water: tuple[float, float]) -> None:
    """It began to turn at the corner, and was carried on for seconds."""
    beyond, before = corner(water)
    assert beyond < 0.6 and before < 0.8


def test_without_a_stream_nothing_changes() -> None:
    calm, weak = corner((0.0, 0.0)), corner((0.02, 0.0))
    assert calm[0] < 0.5 and calm == pytest.approx(weak, abs=0.15)


def test_against_a_stream_it_does_not_turn_so_early_that_it_is_carried_back() -> None:
    beyond, before = corner((-0.5, 0.0))
    assert beyond < 0.4 and before < 0.4
