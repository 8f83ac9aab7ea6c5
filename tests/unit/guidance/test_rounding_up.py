"""Turning the bow into a following stream ahead of the end."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.core.angles import wrap_pi
from companion.core.estimate import NO_ESTIMATE, NavState
from companion.guidance.rounding_up import RoundingUp
from companion.params.store import Parameters

VALUES = {"PATH_YAW_RATE": 12.0, "PATH_ACC": 0.1, "NAV_ACC_RAD": 2.0, "WP_SPEED": 1.0}
STREAM = (0.8, 0.0)


def going(yaw_rad: float = 0.0, north_mps: float = 1.2) -> NavState:
    return replace(NO_ESTIMATE, yaw_rad=yaw_rad, north_mps=north_mps, east_mps=0.0)


def seen(left_m: float, water: tuple[float, float] = STREAM, north_mps: float = 1.2) -> RoundingUp:
    up = RoundingUp(Parameters(VALUES), on_the_spot=False)
    up.update(going(north_mps=north_mps), water, 0.0, left_m, 0.1)
    return up


def test_it_begins_where_the_way_left_is_what_the_turn_and_the_stop_take() -> None:
    turn_s, stop_m = math.pi / math.radians(12.0) + 1.2, 0.8**2 / 0.2
    need_m = 0.5 * (1.2 + 0.8) * turn_s + stop_m
    assert not seen(need_m + 0.1).lasts and seen(need_m - 0.1).lasts
    assert seen(need_m + 0.1, north_mps=1.6).lasts, "faster, it needs more"


@pytest.mark.parametrize("water", [(0.1, 0.0), (-0.8, 0.0), (0.0, 0.8)])
def test_a_stream_that_carries_the_boat_no_way_past_the_end_needs_no_turn(water: tuple[float, float]) -> None:
    up = seen(0.0, water)
    assert not up.lasts and up.most_mps == math.inf


def test_the_boat_lets_itself_be_carried_slower_than_the_stream_bow_into_it() -> None:
    up = seen(5.0)
    assert up.most_mps == pytest.approx(0.4)
    assert abs(wrap_pi(up.heading_rad(STREAM, 0.0, 0.4) - math.pi)) < 1.0e-9
    aside = up.heading_rad((0.8, 0.3), 0.0, 0.4)  # the stream sets it to the east too: the bow lies to the west
    assert -math.pi < aside < -0.5 * math.pi


@pytest.mark.parametrize("course_deg", range(-180, 180, 15))
@pytest.mark.parametrize("water", [(0.8, 0.0), (0.4, 0.4), (0.3, -0.5)])
def test_bow_first_through_the_water_it_makes_any_course_as_back_to_its_track(
    course_deg: float, water: tuple[float, float]
) -> None:
    """Once it fell beside its track, the bow lay as if it could only be carried: it drifted on, over its fence."""
    course, made_mps = math.radians(course_deg), 0.2
    through = made_mps * math.cos(course) - water[0], made_mps * math.sin(course) - water[1]
    heading = seen(5.0).heading_rad(water, course, made_mps)
    assert abs(wrap_pi(heading - math.atan2(through[1], through[0]))) < 1.0e-9


def test_until_the_bow_has_come_round_it_does_not_brake_in_a_flow_from_astern() -> None:
    up = seen(5.0)
    assert up.least_mps(going(0.0), STREAM, math.pi) == pytest.approx(0.8 + 0.3)
    assert up.least_mps(going(math.radians(150.0)), STREAM, math.pi) == -math.inf
    spins = RoundingUp(Parameters(VALUES), on_the_spot=True)
    assert spins.least_mps(going(0.0), STREAM, math.pi) == pytest.approx(0.8)


def test_another_way_begins_without_it() -> None:
    up = seen(5.0)
    up.reset()
    assert not up.lasts


def carried(made_mps: float, seconds: float, water: tuple[float, float] = STREAM) -> RoundingUp:
    """A boat that has rounded up and goes on along its track at that speed."""
    up = seen(5.0)
    for _ in range(round(10.0 * seconds)):
        up.update(going(math.pi, made_mps), water, 0.0, 5.0, 0.1)
    return up


def test_a_boat_that_wind_holds_against_the_stream_sails_to_the_end_bow_first() -> None:
    """A survey of WAM-V ended 14 m before its last waypoint: it lay across, wind against stream, until it gave up."""
    assert carried(0.05, 25.0).lasts, "it turns first"
    up = carried(0.05, 80.0)
    assert not up.lasts and up.most_mps == math.inf
    up.update(going(), STREAM, 0.0, 5.0, 0.1)
    assert not up.lasts, "and does not begin again on this way"
    up.reset()
    up.update(going(), STREAM, 0.0, 5.0, 0.1)
    assert up.lasts


def test_one_that_is_carried_goes_on() -> None:
    assert carried(0.35, 200.0).lasts


def test_in_a_stream_that_seems_weak_it_does_not_creep() -> None:
    assert carried(0.1, 1.0, (0.1, 0.0)).most_mps == pytest.approx(0.1)
