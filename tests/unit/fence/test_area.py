"""The fence as an area, against plain shapely and closed forms."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely.geometry import LineString, Point, Polygon

from companion.core.work import Lane
from companion.fence.area import Disc, FenceArea

BOX = [(-50.0, -40.0), (50.0, -40.0), (50.0, 40.0), (-50.0, 40.0)]
HOLE = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
PLAIN = FenceArea({0: [BOX]}, [HOLE])

places = st.tuples(st.floats(-80.0, 80.0), st.floats(-80.0, 80.0))


def test_distance_and_direction_in_a_box() -> None:
    margin = PLAIN.margin(30.0, -35.0)
    assert (margin.distance_m, margin.north, margin.east) == pytest.approx((5.0, 0.0, -1.0))
    outside = PLAIN.margin(53.0, 44.0)
    assert (outside.distance_m, outside.north, outside.east) == pytest.approx((-5.0, -0.6, -0.8))
    in_the_hole = PLAIN.margin(5.0, 8.0)
    assert (in_the_hole.distance_m, in_the_hole.north, in_the_hole.east) == pytest.approx((-2.0, 0.0, 1.0))
    assert PLAIN.margin(50.0, 0.0).distance_m == 0.0


@pytest.mark.parametrize("corners", [BOX, [(0.0, 0.0), (8.0, 0.0), (8.0, 500.0), (0.0, 500.0)], [*BOX, (40.0, 0.0)]])
def test_the_middle_is_as_deep_as_the_largest_disc_inside(corners: list[tuple[float, float]]) -> None:
    area = FenceArea({0: [corners]}, [])
    deepest_m = shapely.maximum_inscribed_circle(Polygon(corners)).length
    for place in shapely.get_coordinates(area.middle.geometry):
        assert area.margin(*place).distance_m == pytest.approx(0.9 * deepest_m, rel=0.03)
    assert area.middle.nearest_inside(-60.0, 250.0) is not None
    assert FenceArea({0: [BOX], 1: [HOLE]}, [BOX, HOLE]).middle.empty


@given(places)
@settings(max_examples=300, deadline=None)
def test_signed_distance_is_shapelys(place: tuple[float, float]) -> None:
    whole = Polygon(BOX, [HOLE])
    distance = whole.boundary.distance(Point(place))
    expected = distance if whole.contains(Point(place)) else -distance
    margin = PLAIN.margin(*place)
    assert margin.distance_m == pytest.approx(expected, abs=1e-9)
    if distance > 1e-6:
        foot = (place[0] + distance * margin.north, place[1] + distance * margin.east)
        assert whole.boundary.distance(Point(foot)) < 1e-6


@given(places, st.floats(-math.pi, math.pi))
@settings(max_examples=300, deadline=None)
def test_way_to_the_line_is_shapelys(place: tuple[float, float], course: float) -> None:
    assume(
        abs(math.sin(2.0 * course)) > 1e-3 and abs(PLAIN.margin(*place).distance_m) > 1e-3
    )  # along a side anything goes
    north, east = math.cos(course), math.sin(course)
    way = PLAIN.way_to_line_m(*place, north, east)
    ray = LineString([place, (place[0] + 1000.0 * north, place[1] + 1000.0 * east)])
    hit = ray.intersection(Polygon(BOX, [HOLE]).boundary)
    if hit.is_empty:
        assert way == math.inf
    else:
        assert way == pytest.approx(hit.distance(Point(place)), abs=1e-6)


def test_circles_err_to_the_safe_side_by_no_more_than_centimetres() -> None:
    for radius_m in (0.5, 5.0, 200.0, 2000.0):
        inclusion, exclusion = FenceArea({0: [Disc(3.0, 4.0, radius_m)]}, []), FenceArea({}, [Disc(3.0, 4.0, radius_m)])
        for angle in np.linspace(0.0, math.tau, 97):
            c, s = math.cos(angle), math.sin(angle)
            assert not inclusion.contains(3.0 + 1.0001 * radius_m * c, 4.0 + 1.0001 * radius_m * s)
            assert not exclusion.contains(3.0 + 0.9999 * radius_m * c, 4.0 + 0.9999 * radius_m * s)
            assert inclusion.contains(3.0 + (radius_m - 0.03) * c, 4.0 + (radius_m - 0.03) * s)
            assert exclusion.contains(3.0 + (radius_m + 0.03) * c, 4.0 + (radius_m + 0.03) * s)


def test_all_of_a_group_any_of_the_groups_none_of_the_exclusions() -> None:
    west, east, far = (
        [(-10.0, -10.0), (10.0, -10.0), (10.0, 2.0), (-10.0, 2.0)],
        Disc(0.0, 5.0, 6.0),
        Disc(100.0, 100.0, 5.0),
    )
    area = FenceArea({0: [west, east], 7: [far]}, [Disc(100.0, 100.0, 1.0)])
    assert area.contains(0.0, 1.0) and not area.contains(0.0, -5.0) and not area.contains(0.0, 8.0)
    assert area.contains(103.0, 100.0) and not area.contains(100.0, 100.0)
    assert FenceArea({0: [west], 1: [east]}, []).contains(0.0, 8.0)
    assert FenceArea({0: [west, far]}, []).empty
    assert FenceArea({0: [west, far]}, []).margin(0.0, 0.0).distance_m == -math.inf


def test_exclusions_alone_leave_the_rest_of_the_world() -> None:
    area = FenceArea({}, [HOLE])
    assert area.contains(1000.0, -90_000.0) and not area.contains(5.0, 5.0)
    assert area.margin(20.0, 5.0).distance_m == pytest.approx(10.0)


def test_where_a_line_leaves() -> None:
    assert PLAIN.first_exit([(-40.0, 0.0), (-40.0, 30.0), (40.0, 30.0)]) is None
    assert PLAIN.first_exit([(-40.0, 5.0), (40.0, 5.0)]) == pytest.approx((0.0, 5.0), abs=1e-5)
    assert PLAIN.first_exit([(-40.0, 0.0), (-40.0, 60.0), (-30.0, 30.0), (-30.0, -60.0)]) == pytest.approx(
        (-40.0, 40.0), abs=1e-5
    )
    assert PLAIN.first_exit([(0.0, 60.0), (0.0, 20.0)], forgive_start=True) is None
    assert PLAIN.first_exit([(0.0, 60.0), (0.0, 20.0)]) is not None
    assert PLAIN.first_exit([(5.0, 60.0), (5.0, 20.0), (5.0, -20.0)], forgive_start=True) == pytest.approx(
        (5.0, 10.0), abs=1e-5
    )
    assert PLAIN.first_exit([(-40.0, 40.0), (40.0, 40.0)]) is None, "along the line is inside"


def test_a_shrunk_area_keeps_its_distance() -> None:
    inner = PLAIN.shrunk(2.0)
    rng = np.random.default_rng(1)
    for north, east in rng.uniform(-60.0, 60.0, (500, 2)):
        distance = PLAIN.margin(north, east).distance_m
        if inner.contains(north, east):
            assert distance >= 1.9
        elif distance > 0.0:
            assert distance <= 2.01
    assert PLAIN.shrunk(45.0).empty


def test_corners_stick_into_the_area() -> None:
    concave = FenceArea({0: [[(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (10.0, 5.0), (0.0, 20.0)]]}, [])
    found = {(round(n, 6), round(e, 6)) for n, e in concave.corners().tolist()}
    for north, east in found:
        ring = Point(north, east).buffer(0.1)
        assert shapely.intersection(ring, concave.geometry).area > 0.5 * ring.area
    assert found == {(10.0, 5.0)}
    assert FenceArea({0: [BOX]}, []).corners().shape == (0, 2)
    assert len(FenceArea({0: [BOX]}, [HOLE]).corners()) == 4


def test_notches_are_where_two_exclusion_zones_meet() -> None:
    zones = [Disc(0.0, -9.0, 10.0), Disc(0.0, 9.0, 10.0)]
    found = FenceArea({}, zones).notches(0.0, math.radians(20.0))
    inner = found[np.abs(found).max(axis=1) < 100.0]
    assert sorted(inner[:, 0].tolist()) == pytest.approx([-math.sqrt(19.0), math.sqrt(19.0)], abs=0.1)
    assert inner[:, 1].tolist() == pytest.approx([0.0, 0.0], abs=0.1)


FIELD = FenceArea(
    {0: [Disc(0.0, 0.0, 200.0)]}, [Disc(25.0 * i, 25.0 * k, 6.0) for i in range(-4, 5) for k in range(-4, 5)]
)
far_places = st.tuples(st.integers(-250, 250), st.integers(-250, 250))


@given(st.lists(far_places, min_size=2, max_size=5, unique=True), st.booleans())
@settings(max_examples=300, deadline=None)
def test_a_long_line_leaves_a_large_area_where_its_difference_begins(
    line: list[tuple[int, int]], forgive: bool
) -> None:
    whole = LineString(line)
    assume(whole.is_simple)
    parts = [part for part in shapely.get_parts(whole.difference(FIELD.geometry.buffer(1e-6))) if part.length > 1e-3]
    assume(all(part.length < 1e-6 or part.length > 0.1 for part in parts))
    begin = Point(line[0])
    counting = [part for part in parts if not (forgive and part.distance(begin) < 1e-6)]
    found = FIELD.first_exit(line, forgive)
    if not counting:
        assert found is None
    else:
        assert found is not None
        assert whole.project(Point(found)) == pytest.approx(
            min(whole.project(Point(part.coords[0])) for part in counting), abs=1e-3
        )


@given(st.tuples(st.floats(-250.0, 250.0), st.floats(-250.0, 250.0)), st.floats(-math.pi, math.pi))
@settings(max_examples=200, deadline=None)
def test_of_many_sides_the_nearest_is_found(place: tuple[float, float], course: float) -> None:
    boundary = FIELD.geometry.boundary
    assert len(boundary.geoms) > 64 and shapely.get_num_coordinates(boundary) > 2_000
    margin = FIELD.margin(*place)
    assert abs(margin.distance_m) == pytest.approx(boundary.distance(Point(place)), abs=1e-9)
    north, east = math.cos(course), math.sin(course)
    way = FIELD.way_to_line_m(*place, north, east)
    ray = LineString([place, (place[0] + 1000.0 * north, place[1] + 1000.0 * east)])
    hit = ray.intersection(boundary)
    assume(hit.is_empty or abs(margin.distance_m) > 1e-3)
    assert way == (math.inf if hit.is_empty else pytest.approx(hit.distance(Point(place)), abs=1e-6))


_TWO_THREADS = """
import random, sys, threading
from companion.core.work import Lane
from companion.core.work import Lane
from companion.fence.area import Disc, FenceArea

area = FenceArea({}, [Disc(9.0 * (k // 40), 9.0 * (k % 40), 3.0) for k in range(1600)])
begin = threading.Barrier(2)

def query(lane):
    dice, mine = random.Random(lane.value), area.in_lane(lane)
    begin.wait()
    for _ in range(8000):
        here = dice.uniform(-5.0, 360.0), dice.uniform(-5.0, 360.0)
        mine.covers((here, (here[0] + dice.uniform(-40.0, 40.0), here[1] + dice.uniform(-40.0, 40.0))))

threads = [threading.Thread(target=query, args=(lane,)) for lane in (Lane.CONTROL, Lane.URGENT)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
"""


def test_two_threads_query_an_area_each_in_its_lane() -> None:
    """Two threads in one prepared geometry end the process."""
    assert subprocess.run([sys.executable, "-c", _TWO_THREADS], check=False, timeout=300).returncode == 0


def test_another_lane_has_the_same_area() -> None:
    line = [(-100.0, 3.0), (100.0, 7.0)]
    other = FIELD.in_lane(Lane.URGENT)
    assert other is FIELD.in_lane(Lane.URGENT) is not FIELD.in_lane(Lane.USUAL) is not FIELD.in_lane(Lane.CONTROL)
    assert FIELD.in_lane(Lane.CONTROL) is FIELD
    assert other.first_exit(line) == FIELD.first_exit(line) and other.margin(1.0, 2.0) == FIELD.margin(1.0, 2.0)
    assert FenceArea({0: [Disc(0.0, 0.0, 1.0), Disc(9.0, 9.0, 1.0)]}, []).in_lane(Lane.USUAL).empty


def test_zones_with_spikes_and_without_an_area_make_a_fence_with_any_others() -> None:
    """GEOS raised for an exclusion with a spike beside inclusions that do not overlap: the upload was refused as one
    that could not be checked."""
    spike = [(0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 20.0), (10.0, 10.0), (10.0, 0.0)]
    flat, far = [(0.0, 0.0), (5.0, 5.0), (9.0, 9.0)], [(100.0, 100.0), (100.0, 120.0), (120.0, 120.0)]
    assert FenceArea({0: [far, HOLE]}, [spike]).empty
    assert FenceArea({0: [flat, Disc(50.0, 50.0, 5.0)]}, [spike]).empty
    spiked = FenceArea({0: [BOX], 1: [flat]}, [spike, flat])
    assert spiked.margin(5.0, 5.0).distance_m == pytest.approx(-5.0) and spiked.contains(10.0, 15.0)
