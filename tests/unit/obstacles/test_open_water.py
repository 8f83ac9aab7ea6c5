"""Ways through open water: shapely judges that none crosses an obstacle."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely.geometry import LineString, MultiPolygon, Point, box

from companion.fence.allowed import Allowed
from companion.fence.area import FenceArea
from companion.fence.areas import FenceAreas
from companion.fence.preparation import Ways
from companion.obstacles.chart_water import chart_water
from companion.obstacles.circling import Circling
from companion.obstacles.open_water import Water
from tests.unit.obstacles.charted import FRAME, feature

KEEP_M, RADIUS_M = 4.0, 1.5
NO_FENCE = Allowed(None, None, 0.0, RADIUS_M)
BEGIN, END = (0.0, 0.0), (80.0, 0.0)
Circle = tuple[float, float, float]


def water(circles: list[Circle], allowed: Allowed = NO_FENCE, charted: MultiPolygon | None = None) -> Water:
    chart = None if charted is None else chart_water([feature("land", charted)], FRAME, 1.0, 3.0, 0.0)
    return Water(np.array(circles, dtype=float).reshape(-1, 3), KEEP_M, allowed, chart)


def circle_fields(largest_m: float) -> st.SearchStrategy[list[Circle]]:
    circle = st.tuples(st.floats(5.0, 75.0), st.floats(-25.0, 25.0), st.floats(0.25, largest_m))
    return st.lists(circle, min_size=1, max_size=14)


def is_open(place: tuple[float, float], circles: list[Circle], room_m: float = 0.0) -> bool:
    return all(math.dist(place, (n, e)) > r + KEEP_M + room_m for n, e, r in circles)


@settings(max_examples=40)
@given(circle_fields(0.3))
def test_a_way_keeps_its_distance_from_every_obstacle(circles: list[Circle]) -> None:
    """Obstacles too small to be hoped smaller."""
    assume(is_open(BEGIN, circles, 1.0) and is_open(END, circles, 1.0))
    field = water(circles)
    way = field.way(BEGIN, END)
    if way is None:
        return
    assert way.points[0] == BEGIN and way.points[-1] == END
    line = LineString(way.points)
    for north_m, east_m, radius_m in circles:
        assert line.distance(Point(north_m, east_m)) >= radius_m + KEEP_M - 0.3
    assert math.isinf(field.free_m(way.points)), "what was planned is not found blocked again"


@settings(max_examples=40)
@given(circle_fields(4.0))
def test_a_way_never_crosses_an_obstacle_that_is_near(circles: list[Circle]) -> None:
    """Those further off than 15 m may be hoped smaller; they are looked at again on the way."""
    assume(is_open(BEGIN, circles, 1.0))
    way = water(circles).way(BEGIN, END)
    if way is None:
        return
    line = LineString(way.points)
    for north_m, east_m, radius_m in circles:
        if math.dist(BEGIN, (north_m, east_m)) <= 15.0:
            assert line.distance(Point(north_m, east_m)) >= radius_m + KEEP_M - 0.3


islands = st.lists(
    st.tuples(st.floats(10.0, 65.0), st.floats(-20.0, 15.0), st.floats(1.0, 8.0), st.floats(1.0, 12.0)),
    min_size=1,
    max_size=6,
)


@settings(max_examples=25)
@given(islands, circle_fields(0.3))
def test_a_way_crosses_neither_chart_nor_fence_nor_what_is_seen(
    boxes: list[tuple[float, float, float, float]], circles: list[Circle]
) -> None:
    land = box(0.0, 0.0, 0.0, 0.0)
    for north_m, east_m, height_m, width_m in boxes:
        land = land.union(box(north_m, east_m, north_m + height_m, east_m + width_m))
    assume(is_open(BEGIN, circles, 1.0) and is_open(END, circles, 1.0))
    assume(min(land.distance(Point(BEGIN)), land.distance(Point(END))) > KEEP_M + 1.0)
    fence = FenceArea({0: [[(-20.0, -40.0), (100.0, -40.0), (100.0, 40.0), (-20.0, 40.0)]]}, ())
    keeping = fence.shrunk(2.0)
    allowed = Allowed(FenceAreas(fence, fence.shrunk(1.0), keeping), Ways(keeping, RADIUS_M, False), 2.0, RADIUS_M)
    field = water(circles, allowed, land)
    way = field.way(BEGIN, END)
    if way is None:
        return
    line = LineString(way.points)
    assert line.distance(land) >= KEEP_M - 0.3
    assert fence.geometry.buffer(-2.0 + 1e-3).covers(line)
    assert all(line.distance(Point(n, e)) >= r + KEEP_M - 0.3 for n, e, r in circles)
    assert field.line_refusal(way.points) is None


@given(circle_fields(3.0))
def test_a_way_is_as_free_as_shapely_says(circles: list[Circle]) -> None:
    """How far a straight way is free, against the discs that it must not enter."""
    assume(is_open(BEGIN, circles))
    line, free_m = LineString([BEGIN, END]), water(circles).free_m([BEGIN, END])
    reach = [
        Point(n, e).buffer(KEEP_M - 0.3 + (r if math.dist(BEGIN, (n, e)) <= 15.0 else min(r, 0.3)), quad_segs=64)
        for n, e, r in circles
    ]
    met = [disc for disc in reach if disc.intersection(line).length > 0.2]
    missed = [disc for disc in reach if disc.distance(line) > 0.05]
    if met:
        assert free_m < math.inf
    if len(missed) == len(reach):
        assert math.isinf(free_m)


def test_one_obstacle_is_always_led_round() -> None:
    for radius_m in (0.3, 1.0, 5.0, 12.0):
        way = water([(40.0, 0.0, radius_m)]).way(BEGIN, END)
        assert way is not None and way.length_m < 80.0 + 4.0 * radius_m + 10.0


def test_a_clear_way_is_straight() -> None:
    way = water([(40.0, 30.0, 2.0)]).way(BEGIN, END)
    assert way is not None and way.points == (BEGIN, END)


def test_a_way_out_of_an_obstacle_that_is_too_near_leads_away() -> None:
    field = water([(3.0, 0.0, 0.5)])
    assert math.isinf(field.free_m([BEGIN, (-30.0, 0.0)]))
    assert math.isfinite(field.free_m([BEGIN, END]))
    way = field.way(BEGIN, END)
    assert way is not None and LineString(way.points).distance(Point(3.0, 0.0)) == pytest.approx(3.0, abs=0.1)


def test_an_end_in_an_obstacle_is_replaced_by_a_place_beside_it() -> None:
    way = water([(80.0, 0.0, 2.0)]).way(BEGIN, END)
    assert way is not None and math.dist(way.points[-1], END) == pytest.approx(6.0, abs=0.4)


def test_a_closed_ring_has_no_way() -> None:
    ring = [(10.0 + 12.0 * math.cos(a), 12.0 * math.sin(a), 3.0) for a in np.linspace(0.0, math.tau, 16)]
    assert water(ring).way((10.0, 0.0), (40.0, 0.0)) is None


def circling(radius_m: float, yaw_rad: float = 0.0) -> Circling:
    """Of a boat that needs way to turn, at the begin."""
    return Circling(radius_m, 0.5 * KEEP_M, BEGIN, yaw_rad)


def wall(east_m: float, gap_m: float) -> list[Circle]:
    """Across the way at 10 m, from 60 m west up to 60 m east; a gap about `east_m`, whose ways bend narrowly."""
    places = [e for e in np.arange(-60.0, 60.5, 0.5).tolist() if abs(e - east_m) >= 0.5 * gap_m + 0.3]
    return [(10.0, e, 0.3) for e in places]


def test_a_narrow_gap_spares_a_long_way_round() -> None:
    """A way with wide bends led past a harbour's entrance, round all of its quays."""
    way = water(wall(8.0, 9.2)).way(BEGIN, END)
    assert way is not None and way.length_m < 90.0
    assert way.radius_m is not None and way.radius_m < RADIUS_M
    for turn_m, narrow in ((4.0, False), (0.3, True)):
        jet = replace(water(wall(8.0, 9.2)), circling=circling(turn_m)).way(BEGIN, END)
        assert jet is not None and jet.radius_m is not None
        assert (jet.radius_m < RADIUS_M) == narrow, "by how narrow the bends are that it sails"


def test_a_gap_as_wide_as_the_boat_keeps_is_sailed_straight_through() -> None:
    """Room for a bend in the gap itself was asked for too: a boat that fits a harbour's entrance went round all its
    quays. What no leg fits is still left."""
    wide = Allowed(None, None, 0.0, 4.0)
    for gap_m, fits in ((2.0 * KEEP_M + 0.4, True), (2.0 * KEEP_M - 0.4, False)):
        quay = [(30.0, side * (0.5 * gap_m + 0.25 + 0.5 * k), 0.25) for side in (-1.0, 1.0) for k in range(120)]
        way = Water(np.array(quay), KEEP_M, wide).way((0.0, -8.0), END)
        assert way is not None and (way.length_m < 90.0) == fits
        line = LineString(way.points)
        assert all(line.distance(Point(n, e)) >= r + KEEP_M - 0.05 for n, e, r in quay)


def test_a_gap_that_may_be_wide_enough_is_looked_at_before_a_long_way_round() -> None:
    """What is seen from afar is as wide as the beam that saw it, and a quay's ends seem nearer to each other."""
    coarse = [(40.0, side * (5.0 + 2.0 * k), 1.6) for side in (-1.0, 1.0) for k in range(40)]
    field = water(coarse)
    way = field.way(BEGIN, END)
    assert way is not None and way.length_m < 90.0 and math.isinf(field.free_m(way.points))
    near = field.way((30.0, 0.0), END)
    assert near is not None and near.length_m > 150.0, "near by, it is as wide as it looks"


def test_what_the_boat_lies_at_is_as_large_as_it_is() -> None:
    """The middle of a large shoal is far, its edge is not: the way led through it, and the boat stood before it."""
    shoal = (20.0, 5.0, 16.0)
    begin, end = (20.0, -15.5), (60.0, 20.0)
    field = water([shoal])
    assert math.isfinite(field.free_m((begin, end)))
    way = field.way(begin, end)
    assert way is not None
    assert LineString(way.points[1:]).distance(Point(*shoal[:2])) >= shoal[2] + KEEP_M - 0.05


def ring(radius_m: float, count: int) -> list[Circle]:
    """Round the begin."""
    angles = np.linspace(0.0, math.tau, count, endpoint=False).tolist()
    return [(radius_m * math.cos(a), radius_m * math.sin(a), 0.3) for a in angles]


@pytest.mark.parametrize("turns", [True, False])
def test_no_way_begins_through_an_obstacle(turns: bool) -> None:
    """The begin has room, but none for wide bends: the nearest place with that lies beyond the stones. Launches were
    sent straight through them."""
    wide = Allowed(None, None, 0.0, 8.0)
    field = replace(water(ring(7.5, 12), wide), circling=None if turns else circling(8.0))
    assert field.way(BEGIN, END) is None
    assert replace(field, circles=field.circles[1:]).way((60.0, 0.0), END) is not None


def test_a_boat_without_room_to_turn_has_no_way_back() -> None:
    """In a lane of stones that is as wide as its turn, bow in; with a turn half as wide it has."""
    lane = [(float(n), side * 8.0, 0.3) for n in range(-10, 40, 2) for side in (-1.0, 1.0)]
    end = (-60.0, 0.0)
    assert replace(water(lane), circling=circling(6.0)).way(BEGIN, end) is None
    assert replace(water(lane), circling=circling(2.0)).way(BEGIN, end) is not None


def test_wide_bends_are_worth_a_few_metres() -> None:
    """Beside the straight way through a narrow gap, there is one with room."""
    obstacles = [c for c in wall(0.0, 9.2) if c[1] < 8.0 or c[1] > 22.0]
    assert len(obstacles) < len(wall(0.0, 9.2))
    way = water(obstacles).way(BEGIN, END)
    assert way is not None and way.radius_m == RADIUS_M and 80.5 < way.length_m < 90.0


def test_a_long_headland_is_led_round() -> None:
    """Its end is further away than what is looked at first."""
    way = water([], charted=box(30.0, -400.0, 40.0, 300.0)).way(BEGIN, END)
    assert way is not None and way.length_m > 2.0 * 300.0


def test_among_many_obstacles_there_is_a_way() -> None:
    """120 buoys, 12 m apart: their corners are too many for the search by corners, which then dropped them."""
    buoys = [(10.0 + 12.0 * (k // 10), -54.0 + 12.0 * (k % 10), 0.3) for k in range(120)]
    end = (160.0, 3.0)
    field = water(buoys)
    way = field.way((0.0, -3.0), end)
    assert way is not None and way.points[-1] == end
    line = LineString(way.points)
    assert all(line.distance(Point(north_m, east_m)) >= KEEP_M for north_m, east_m, _ in buoys)
    assert way.length_m < 260.0
