"""The wind triangle: against geometry, and at its limits."""

from __future__ import annotations

import itertools
import math

import pytest

from companion.config.top_speed import top_speed_mps
from companion.guidance.crab_compensation import CrabCompensation
from tests.unit.control.simple_boat import REVOLT, nav_state


def made_good(heading_rad: float, through_mps: float, current: tuple[float, float]) -> tuple[float, float]:
    return through_mps * math.cos(heading_rad) + current[0], through_mps * math.sin(heading_rad) + current[1]


def test_top_speed_is_where_drag_takes_all_the_thrust() -> None:
    assert top_speed_mps(REVOLT) == pytest.approx(REVOLT.limits.surge_n / REVOLT.hull.damping.x_u, rel=1e-6)


@pytest.mark.parametrize("towards_deg", range(0, 360, 30))
@pytest.mark.parametrize("strength_mps", [0.2, 0.5, 0.79])
def test_the_course_is_kept_in_any_current_that_leaves_some_speed(towards_deg: int, strength_mps: float) -> None:
    a = math.radians(towards_deg)
    current = (strength_mps * math.cos(a), strength_mps * math.sin(a))
    crab = CrabCompensation(1.0)
    for course_deg in range(0, 360, 15):
        course, speed = math.radians(course_deg), 0.6
        heading = crab.heading_rad(nav_state(current=current), course, speed, course)
        along = current[0] * math.cos(course) + current[1] * math.sin(course)
        across = current[1] * math.cos(course) - current[0] * math.sin(course)
        reached = min(speed, along + math.sqrt(1.0 - across * across))
        if reached - along < 0.15:
            continue  # set along faster than asked: see the next test
        north, east = made_good(heading, math.hypot(reached - along, across), current)
        assert math.remainder(math.atan2(east, north) - course, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
        assert math.hypot(north, east) == pytest.approx(reached, abs=1e-9)


def test_in_a_following_current_that_is_too_fast_the_nearer_heading_is_used() -> None:
    crab, nav = CrabCompensation(1.0), nav_state(current=(0.8, 0.0))
    assert crab.heading_rad(nav, 0.0, 0.5, 0.3) == pytest.approx(0.0)
    assert abs(crab.heading_rad(nav, 0.0, 0.5, 2.8)) == pytest.approx(math.pi)


@pytest.mark.parametrize("current", [(0.0, 1.2), (-1.2, 0.0), (0.9, 1.1)])
def test_where_the_course_cannot_be_kept_the_heading_is_into_the_current(current: tuple[float, float]) -> None:
    heading = CrabCompensation(1.0).heading_rad(nav_state(current=current), 0.0, 0.6, 0.0)
    assert math.remainder(heading - math.atan2(-current[1], -current[0]), 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_without_a_known_current_the_learnt_drift_is_used() -> None:
    crab = CrabCompensation(math.inf)
    for _ in range(300):
        crab.update(nav_state(surge_mps=0.5, sway_mps=0.2), 0.5, 1.0, 0.1)
    assert crab.water(nav_state()) == pytest.approx((0.0, 0.2), abs=1e-3)
    crab.update(nav_state(surge_mps=0.5, sway_mps=-0.5), 0.5, 0.0, 0.1)
    assert crab.water(nav_state()) == pytest.approx((0.0, 0.2), abs=1e-3), "nothing is learnt in a bend"
    crab.reset()
    assert crab.water(nav_state()) == (0.0, 0.0)


def test_what_carries_a_boat_aside_as_it_begins_is_its_drift_while_no_current_is_known() -> None:
    crab, set_aside = CrabCompensation(1.0), nav_state(sway_mps=0.6, yaw_rad=0.5)
    crab.begin(set_aside)
    assert crab.water(set_aside) == pytest.approx((-0.6 * math.sin(0.5), 0.6 * math.cos(0.5)))
    known = nav_state(sway_mps=0.6, current=(0.0, 0.1))
    crab.begin(known)
    assert crab.water(known) == (0.0, 0.1)


def test_a_drift_supposed_at_the_beginning_is_forgotten_where_no_current_becomes_known() -> None:
    """A boat that began a mission in a turn would keep what its slip was."""
    crab, slipping = CrabCompensation(1.0), nav_state(sway_mps=0.4)
    crab.begin(slipping)
    for _ in range(20):
        crab.update(slipping, 0.5, 0.0, 0.1)
    assert crab.water(slipping)[1] == pytest.approx(0.36, abs=0.01), "until the current is known it counts"
    for _ in range(600):
        crab.update(slipping, 0.5, 0.0, 0.1)
    assert abs(crab.water(slipping)[1]) < 0.03


def across(heading_rad: float, through: tuple[float, float]) -> float:
    """Sideways part of the velocity through the water that a boat with that heading needs."""
    return through[1] * math.cos(heading_rad) - through[0] * math.sin(heading_rad)


def test_a_boat_that_slows_down_keeps_the_bow_of_its_leg_where_its_thrusters_push_it_aside() -> None:
    crab, nav = CrabCompensation(1.0), nav_state(current=(0.0, 0.09))
    crab.sail_at(1.0, 0.1)
    assert crab.bow_rad(nav, 0.0, 0.05, 0.1, 0.0) == pytest.approx(-0.09, abs=1e-3), "turned by 31 deg before"
    assert crab.bow_rad(nav, 0.0, 1.0, 0.1, 0.0) == crab.heading_rad(nav, 0.0, 1.0, 0.0)


@pytest.mark.parametrize("speed_mps", [0.15, 0.2, 0.3])
def test_it_turns_further_into_a_current_that_its_sideways_speed_does_not_withstand(speed_mps: float) -> None:
    crab, nav = CrabCompensation(1.0), nav_state(current=(0.0, 0.3))
    crab.sail_at(0.8, 0.1)
    heading = crab.bow_rad(nav, 0.0, speed_mps, 0.1, 0.0)
    assert abs(across(heading, (speed_mps, -0.3))) == pytest.approx(0.1, abs=1e-9)
    assert abs(heading) < abs(crab.heading_rad(nav, 0.0, speed_mps, 0.0))


def test_beside_a_current_that_is_too_fast_for_the_slow_boat_the_bow_points_as_without_thrusters_aside() -> None:
    crab, nav = CrabCompensation(1.0), nav_state(current=(0.8, 0.0))
    crab.sail_at(0.9, 0.1)
    assert abs(crab.bow_rad(nav, 0.0, 0.5, 0.1, 2.8)) == pytest.approx(math.pi)


def test_a_slower_leg_counts_after_a_while_and_a_faster_one_at_once() -> None:
    crab, nav = CrabCompensation(2.0), nav_state(current=(0.0, 0.1))
    crab.sail_at(1.0, 0.1)
    for _ in range(600):
        crab.sail_at(0.5, 0.1)
    assert crab.bow_rad(nav, 0.0, 0.4, 0.5, 0.0) == pytest.approx(-math.asin(0.1 / math.hypot(0.51, 0.1)), abs=0.02)
    crab.sail_at(1.0, 0.1)
    assert crab.bow_rad(nav, 0.0, 0.4, 0.5, 0.0) == pytest.approx(-0.1, abs=1e-3)


def test_a_current_that_becomes_known_under_way_turns_the_bow_gradually() -> None:
    """The heading setpoint of a boat that had kept to its path by pushing sideways jumped by 15 deg."""
    crab, known = CrabCompensation(2.0), nav_state(surge_mps=1.2, current=(0.0, 0.32))
    for _ in range(40):
        crab.update(nav_state(surge_mps=1.2), 1.2, 1.0, 0.1)
    headings = [crab.heading_rad(known, 0.0, 1.2, 0.0)]
    for _ in range(150):
        crab.update(known, 1.2, 1.0, 0.1)
        headings.append(crab.heading_rad(known, 0.0, 1.2, 0.0))
    assert max(abs(b - a) for a, b in itertools.pairwise(headings)) < math.radians(0.6)
    assert headings[-1] == pytest.approx(-math.atan2(0.32, 1.2), abs=0.01)


def test_a_current_that_is_known_from_the_start_is_used_at_once() -> None:
    crab, known = CrabCompensation(2.0), nav_state(current=(0.0, 0.32))
    crab.update(known, 1.2, 1.0, 0.1)
    assert crab.water(known) == pytest.approx((0.0, 0.32))
