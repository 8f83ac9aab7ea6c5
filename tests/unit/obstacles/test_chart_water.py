"""The water that a chart's obstacles leave."""

from __future__ import annotations

import math

import pytest
from shapely.geometry import LineString, Point, Polygon, box

from companion.config.chart import ChartFeature
from companion.config.vessel import find, load
from companion.core.geodesy import LocalFrame
from companion.core.work import AtOnce
from companion.obstacles.chart_water import ChartKeeper, ChartWater, chart_water
from companion.params.store import Parameters
from tests.unit.obstacles.charted import FRAME, feature

OTTER = load(find("otter"))
ISLAND = feature("land", box(20.0, -10.0, 40.0, 10.0))
BANK = feature("depth", box(60.0, -10.0, 80.0, 10.0), depth_m=1.2)


def water(*features: ChartFeature, depth_m: float = 0.0) -> ChartWater:
    found = chart_water(features, FRAME, 1.0, 3.0, depth_m)
    assert found is not None
    return found


def test_points_are_refused_by_their_distance() -> None:
    chart = water(ISLAND)
    assert chart.point_refusal(30.0, 0.0) == "in a chart obstacle"
    assert chart.point_refusal(17.0, 0.0) == "too near a chart obstacle"
    assert chart.point_refusal(15.9, 0.0) is None


def test_ways_are_free_up_to_where_they_come_too_near() -> None:
    chart = water(ISLAND)
    assert chart.free_m([(0.0, 0.0), (50.0, 0.0)]) == pytest.approx(16.3, abs=0.05)
    assert chart.free_m([(0.0, -30.0), (0.0, 0.0), (50.0, 0.0)]) == pytest.approx(46.3, abs=0.05)
    assert math.isinf(chart.free_m([(0.0, 20.0), (50.0, 20.0)]))


def test_a_boat_too_near_may_lead_away_but_not_through() -> None:
    chart = water(ISLAND)
    assert math.isinf(chart.free_m([(18.5, 0.0), (0.0, 0.0)]))
    assert chart.free_m([(18.5, 0.0), (60.0, 0.0)]) < 1.6
    assert math.isinf(chart.free_m([(30.0, 0.0), (0.0, 0.0)]))  # drawn upon the land: the way out


def test_a_way_that_goes_over_itself_is_judged_leg_by_leg() -> None:
    """One that went back and forth where it is too near, and then away, was refused."""
    chart = water(ISLAND)
    assert chart.line_refusal([(18.5, 0.0), (17.0, 0.0), (18.0, 0.0), (0.0, 0.0)]) is None
    assert chart.line_refusal([(18.5, 0.0), (0.0, 0.0), (18.5, 0.0)]) == "way crosses a chart obstacle"
    assert chart.line_refusal([(18.5, 0.0), (0.0, 0.0), (17.0, 0.0), (0.0, 0.0)]) == "way crosses a chart obstacle"


def test_the_boat_stops_before_it_and_may_always_leave() -> None:
    chart = water(ISLAND)
    assert chart.stop_m((0.0, 0.0), (1.0, 0.0)) == pytest.approx(20.0 - 1.9, abs=0.02)
    assert math.isinf(chart.stop_m((0.0, 0.0), (-1.0, 0.0)))
    assert chart.stop_m((19.0, 0.0), (1.0, 0.0)) == 0.0
    assert math.isinf(chart.stop_m((19.0, 0.0), (-1.0, 0.0)))


def test_points_and_lines_are_as_wide_as_they_are_said_to_be() -> None:
    chart = water(
        feature("rock", Point(30.0, 0.0), radius_m=2.0),
        feature("quay", LineString([(0.0, 50.0), (40.0, 50.0)]), radius_m=0.5),
    )
    assert chart.point_refusal(27.9, 0.0) == "too near a chart obstacle"
    assert chart.point_refusal(28.1, 0.0) == "in a chart obstacle"
    assert chart.point_refusal(20.0, 45.4) is None
    assert chart.point_refusal(20.0, 45.6) is not None


def test_along_a_quay_that_it_leaves_it_stops_before_the_next_one() -> None:
    """Beside a quay, a course a little away from it led on without a limit, until the quay at its end was the nearest."""
    chart = water(feature("quay", box(-50.0, -5.0, 40.0, 0.0)), feature("quay", box(40.0, -5.0, 45.0, 50.0)))
    for beside_m in (1.2, 1.8, 3.0):  # it stops 1.9 m off
        off_rad = math.radians(3.0)
        way_m = chart.stop_m((0.0, beside_m), (math.cos(off_rad), math.sin(off_rad)))
        assert way_m == pytest.approx(38.1 / math.cos(off_rad), abs=0.05), beside_m
    assert chart.stop_m((0.0, 1.2), (math.cos(0.05), -math.sin(0.05))) == 0.0
    assert math.isinf(chart.stop_m((0.0, 1.2), (0.0, 1.0)))
    assert chart.stop_m((38.8, 1.2), (1.0, 0.0)) == 0.0, "into the corner"


def test_depth_areas_count_by_the_depth_that_the_boat_needs() -> None:
    assert water(ISLAND, BANK, depth_m=1.0).point_refusal(70.0, 0.0) is None
    assert water(ISLAND, BANK, depth_m=1.5).point_refusal(70.0, 0.0) == "in a chart obstacle"
    assert chart_water([BANK], FRAME, 1.0, 3.0, 1.0) is None


def test_overlapping_and_broken_shapes_are_one_obstacle() -> None:
    bow_tie = Polygon([(0.0, 0.0), (20.0, 20.0), (20.0, 0.0), (0.0, 20.0)])
    chart = water(feature("land", bow_tie), feature("land", box(15.0, 5.0, 40.0, 15.0)))
    assert chart.point_refusal(18.0, 10.0) == "in a chart obstacle"
    assert len(chart.outline) == 2  # its two halves meet in a point


def test_what_is_far_away_is_left_out() -> None:
    assert chart_water([feature("land", box(25_000.0, 0.0, 26_000.0, 10.0))], FRAME, 1.0, 3.0, 0.0) is None


def test_settings_make_the_water_anew() -> None:
    parameters, plane = Parameters(), [FRAME]
    keeper = ChartKeeper(OTTER, parameters, lambda: plane[0])
    assert keeper.water is None and keeper.key == ()
    keeper.load([ISLAND, BANK])
    keeper.work_with(AtOnce())
    first, key = keeper.water, keeper.key
    assert first is not None and first.point_refusal(70.0, 0.0) is None and len(keeper.outline) == 1
    parameters.set("CP_DEPTH_MIN", 2.0)
    second = keeper.water
    assert second is not None and second.point_refusal(70.0, 0.0) is not None
    assert keeper.key != key
    plane[0] = LocalFrame(*FRAME.to_geodetic(100.0, 0.0))
    third = keeper.water
    assert third is not None and third.point_refusal(-70.0, 0.0) == "in a chart obstacle"
    parameters.set("CP_DIST", -1.0)
    assert keeper.water is None and keeper.key == ()
