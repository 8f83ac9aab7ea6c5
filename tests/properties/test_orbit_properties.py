"""The orbit law on a boat that is only kinematics: it turns and speeds up within limits, and the water carries it."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.guidance.orbit import (
    Circle,
    OrbitGuidance,
    approach,
    least_radius_m,
    orbit_speed_mps,
    radius_refusal,
    round_line,
)
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST

DT_S = 0.1
LAG_S = 0.6  # of heading and speed behind what is asked for

BEARINGS = st.floats(-math.pi, math.pi)


class Boat:
    """Heading and speed through the water follow the setpoint with a lag; the current carries it."""

    def __init__(self, nav: NavState, current: tuple[float, float]) -> None:
        self.nav = replace(nav, current_north_mps=current[0], current_east_mps=current[1])
        self.current = current

    def step(self, yaw_rad: float, rate_radps: float, surge_mps: float) -> None:
        nav = self.nav
        rate = rate_radps + wrap_pi(yaw_rad - nav.yaw_rad) / LAG_S
        surge = nav.surge_mps + (surge_mps - nav.surge_mps) * DT_S / LAG_S
        yaw = wrap_pi(nav.yaw_rad + rate * DT_S)
        c, s = math.cos(yaw), math.sin(yaw)
        through = surge - (self.current[0] * c + self.current[1] * s)
        north, east = through * c + self.current[0], through * s + self.current[1]
        self.nav = replace(
            nav,
            north_m=nav.north_m + north * DT_S,
            east_m=nav.east_m + east * DT_S,
            north_mps=north,
            east_mps=east,
            surge_mps=surge,
            sway_mps=east * c - north * s,
            yaw_rad=yaw,
            yaw_rate_radps=rate,
        )


def sail(boat: Boat, guidance: OrbitGuidance, speed_mps: float, seconds: float) -> list[float]:
    """Errors of the radius, a tick each."""
    errors = []
    for _ in range(int(seconds / DT_S)):
        progress = guidance.update(boat.nav, speed_mps, DT_S)
        setpoint = progress.setpoint
        assert setpoint.yaw_rad is not None
        boat.step(setpoint.yaw_rad, setpoint.yaw_rate_radps, setpoint.surge_mps)
        errors.append(progress.error_m)
    return errors


@settings(deadline=None, max_examples=40)
@given(
    radius_m=st.floats(6.0, 40.0),
    clockwise=st.booleans(),
    away=st.floats(0.0, 4.0),
    bearing=BEARINGS,
    yaw=BEARINGS,
    current=st.tuples(st.floats(0.0, 0.2), BEARINGS),
    can_sway=st.booleans(),
)
def test_from_anywhere_it_comes_to_the_circle_and_stays(
    radius_m: float,
    clockwise: bool,
    away: float,
    bearing: float,
    yaw: float,
    current: tuple[float, float],
    can_sway: bool,
) -> None:
    circle = Circle(30.0, -20.0, radius_m, clockwise)
    north_m, east_m = 30.0 + away * radius_m * math.cos(bearing), -20.0 + away * radius_m * math.sin(bearing)
    drift = (current[0] * math.cos(current[1]), current[0] * math.sin(current[1]))
    boat = Boat(replace(AT_REST, north_m=north_m, east_m=east_m, yaw_rad=yaw), drift)
    guidance = OrbitGuidance(Parameters({}), can_sway, top_mps=2.0)
    guidance.start(circle, boat.nav)
    sail(boat, guidance, 0.6, (away + 2.0) * radius_m / 0.5 + 40.0)
    lap = sail(boat, guidance, 0.6, 2.0 * math.pi * radius_m / 0.6)
    assert max(abs(error) for error in lap) < 0.35


@pytest.mark.parametrize("clockwise", [True, False])
def test_turns_are_counted_on_the_circle_in_its_direction(clockwise: bool) -> None:
    circle = Circle(0.0, 0.0, 10.0, clockwise)
    boat = Boat(replace(AT_REST, north_m=40.0), (0.0, 0.0))
    guidance = OrbitGuidance(Parameters({}), can_sway=False)
    guidance.start(circle, boat.nav, total_rad=3.0 * math.pi)
    bearings = []
    for _ in range(20_000):
        progress = guidance.update(boat.nav, 0.6, DT_S)
        if progress.swept_rad is not None:
            bearings.append(circle.polar(boat.nav.north_m, boat.nav.east_m)[1])
        if progress.finished:
            break
        assert progress.setpoint.yaw_rad is not None
        boat.step(progress.setpoint.yaw_rad, progress.setpoint.yaw_rate_radps, progress.setpoint.surge_mps)
    swept = sum(wrap_pi(b - a) for a, b in itertools.pairwise(bearings))
    assert swept * circle.sign == pytest.approx(3.0 * math.pi, abs=0.05)


@given(
    radius_m=st.floats(3.0, 500.0),
    clockwise=st.booleans(),
    away=st.floats(0.0, 10.0),
    bearing=BEARINGS,
    lookahead=st.floats(0.05, 0.5),
)
def test_the_way_in_ends_on_the_circle_in_its_direction(
    radius_m: float, clockwise: bool, away: float, bearing: float, lookahead: float
) -> None:
    circle = Circle(5.0, 7.0, radius_m, clockwise)
    place = (5.0 + away * radius_m * math.cos(bearing), 7.0 + away * radius_m * math.sin(bearing))
    line = approach(circle, place, lookahead * radius_m)
    distance_m, at = circle.polar(*line[-1])
    assert line[0] == place and abs(distance_m - radius_m) < 0.05 * radius_m
    if len(line) > 2:
        course = math.atan2(line[-1][1] - line[-2][1], line[-1][0] - line[-2][0])
        assert abs(wrap_pi(course - at - circle.sign * 0.5 * math.pi)) < math.radians(40.0)
    assert max(math.dist(point, (5.0, 7.0)) for point in line) <= max(away, 1.05) * radius_m + 1e-6


@given(radius_m=st.floats(1.0, 1e3), sweep=st.floats(0.1, 2.0 * math.pi), bearing=BEARINGS)
def test_the_polyline_never_cuts_inside_the_circle(radius_m: float, sweep: float, bearing: float) -> None:
    circle = Circle(0.0, 0.0, radius_m, True)
    line = round_line(circle, bearing, sweep)
    middles = [((a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0) for a, b in itertools.pairwise(line)]
    assert all(math.hypot(*middle) >= radius_m * (1.0 - 1e-9) for middle in middles)
    assert all(math.hypot(*point) <= 1.01 * radius_m for point in line)


def test_the_tightest_circle_is_sailed_at_the_slowest_speed() -> None:
    parameters = Parameters({})
    least_m = least_radius_m(parameters, 0.5)
    assert orbit_speed_mps(1.0 / least_m, parameters) == pytest.approx(0.15)  # a quarter of WP_SPEED
    assert least_radius_m(parameters, 3.0) == 3.0  # never tighter than the boat is long
    assert radius_refusal(3.0, 3.0) is None
    assert radius_refusal(2.5, 3.0) == "radius 2.5 m: this boat needs 3.0 m"
    assert radius_refusal(math.nan, 3.0) == radius_refusal(-3.0, 3.0) == "the radius should be above 0 m"


def test_it_leaves_towards_the_next_point() -> None:
    circle = Circle(0.0, 0.0, 15.0, True)
    boat = Boat(replace(AT_REST, north_m=15.0, yaw_rad=0.5 * math.pi), (0.0, 0.0))
    guidance = OrbitGuidance(Parameters({}), can_sway=False)
    guidance.start(circle, boat.nav, total_rad=2.0 * math.pi, leave_to=(-100.0, 0.0))
    for _ in range(20_000):
        progress = guidance.update(boat.nav, 0.6, DT_S)
        if progress.finished:
            break
        assert progress.setpoint.yaw_rad is not None
        boat.step(progress.setpoint.yaw_rad, progress.setpoint.yaw_rate_radps, progress.setpoint.surge_mps)
    assert progress.finished and progress.swept_rad is not None and 2.0 * math.pi < progress.swept_rad < 4.0 * math.pi
    to_point = math.atan2(-boat.nav.east_m, -100.0 - boat.nav.north_m)
    over_ground = math.atan2(boat.nav.east_mps, boat.nav.north_mps)
    assert abs(wrap_pi(to_point - over_ground)) < 0.2


def test_before_the_start_there_is_no_circle() -> None:
    with pytest.raises(RuntimeError):
        OrbitGuidance(Parameters({}), can_sway=True).update(AT_REST, 1.0, DT_S)
