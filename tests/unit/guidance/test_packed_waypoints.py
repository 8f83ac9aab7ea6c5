"""Waypoints closer together than the boat is long, with a boat that follows its setpoints exactly."""

from __future__ import annotations

import math

import pytest

from companion.config.reversing import turns_on_the_spot
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import find, load
from companion.guidance.agility import agility_of
from companion.guidance.path import PathKind
from companion.guidance.path_tracking import PathTracker
from companion.guidance.turning import turning_of
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import nav_state

DT_S = 0.2
# (north_m, east_m, radius_m, speed_mps)
FIVE = [
    (0.2541, 0.1447, 8.0, 0.4),
    (0.3956, -0.4847, 0.3, None),
    (0.3925, -0.4304, 8.0, None),
    (0.3925, -0.4304, 8.0, None),
    (-0.1943, 0.1970, 0.3, 5.0),
]
SEVEN = [
    *[(0.0637, 0.4487, 8.0, 5.0)] * 4,
    (0.1541, 0.3158, None, None),
    (-0.0304, -0.2627, 0.3, 0.4),
    (0.4105, -0.3366, 8.0, None),
]


@pytest.mark.parametrize(
    ("name", "kind", "points", "begin"),
    [
        ("cybership2", PathKind.PCHIP, FIVE, (0.305, 0.951, 2.73)),
        ("heron", PathKind.LINEAR, SEVEN, (0.896, 0.112, -2.38)),
    ],
)
def test_a_boat_beyond_a_tip_that_it_did_not_see_comes_back(
    name: str,
    kind: PathKind,
    points: list[tuple[float, float, float | None, float | None]],
    begin: tuple[float, float, float],
) -> None:
    """Its place on the track stayed at the tip, and the course there led it away in a straight line."""
    config = load(find(name))
    parameters = Parameters(config.parameters)
    parameters.set("PATH_KIND", float(kind))
    turning = turning_of(config, turns_on_the_spot(config.thrusters))
    tracker = PathTracker(
        parameters, config.limits.sway_n > 0.0, top_speed_mps(config), agility_of(config), turning=turning
    )
    north_m, east_m, yaw_rad = begin
    tracker.start([Waypoint(*point) for point in points], nav_state(*begin))
    surge_mps = sway_mps = 0.0
    for _ in range(600):
        nav = nav_state(north_m, east_m, yaw_rad, surge_mps, sway_mps)
        progress = tracker.update(nav, parameters["WP_SPEED"], DT_S)
        if progress.finished:
            break
        yaw_rad, surge_mps, sway_mps = (
            progress.setpoint.yaw_rad,
            progress.setpoint.surge_mps,
            progress.setpoint.sway_mps,
        )
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        north_m += (surge_mps * c - sway_mps * s) * DT_S
        east_m += (surge_mps * s + sway_mps * c) * DT_S
        assert math.hypot(north_m, east_m) < 4.0
    assert progress.finished and progress.passed == len(points)
