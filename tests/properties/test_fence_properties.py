"""Ways inside fences of any shape: they never leave them, and are no longer than they must be."""

from __future__ import annotations

import itertools
import math

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely.geometry import LineString, Point

from companion.config.vessel import find, load
from companion.fence.allowed import Allowed
from companion.fence.area import Disc, FenceArea
from companion.fence.areas import FenceAreas
from companion.fence.limit import speed_to_stop_in
from companion.fence.preparation import Ways
from companion.fence.way_round import ClearRoutes

REVOLT = load(find("revolt"))


def star(seed: int, corners: int, north_m: float, east_m: float, size_m: float) -> list[tuple[float, float]]:
    """A polygon that does not cross itself, with corners in and out."""
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0.0, math.tau, corners))
    radii = rng.uniform(0.3, 1.0, corners) * size_m
    return [(north_m + r * math.cos(a), east_m + r * math.sin(a)) for a, r in zip(angles, radii, strict=True)]


@st.composite
def waters(draw: st.DrawFn) -> FenceArea:
    seed = draw(st.integers(0, 10_000))
    rng = np.random.default_rng(seed)
    outer = star(seed, draw(st.integers(4, 14)), 0.0, 0.0, 120.0)
    obstacles: list[object] = [
        Disc(*rng.uniform(-60.0, 60.0, 2), rng.uniform(1.0, 15.0)) for _ in range(draw(st.integers(0, 3)))
    ]
    obstacles += [star(seed + i + 1, 5, *rng.uniform(-60.0, 60.0, 2), 15.0) for i in range(draw(st.integers(0, 3)))]
    return FenceArea({0: [outer]}, obstacles)  # type: ignore[arg-type]


@given(waters(), st.integers(0, 1000))
@settings(max_examples=60, deadline=None)
def test_a_way_keeps_inside_and_is_short(area: FenceArea, seed: int) -> None:
    kept = area.shrunk(2.0)
    assume(not kept.empty)
    rng = np.random.default_rng(seed)
    inside = [place for place in rng.uniform(-120.0, 120.0, (200, 2)).tolist() if kept.contains(*place)]
    assume(len(inside) >= 2)
    begin, end = tuple(inside[0]), tuple(inside[1])
    way = ClearRoutes(kept).find(begin, end, through=kept)
    if way is None:
        return
    line = LineString(way)
    assert way[0] == begin and way[-1] == end
    assert area.geometry.boundary.distance(line) >= 1.9 and area.geometry.contains(line)
    assert line.length >= math.dist(begin, end) - 1e-9
    for i, j in itertools.combinations(range(len(way)), 2):
        if j > i + 1 and kept.shrunk(0.5).covers((way[i], way[j])):
            part = LineString(way[i : j + 1]).length
            assert part <= math.dist(way[i], way[j]) + 3.0, "it does not go round what it can cross"


@given(waters(), st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_in_one_piece_of_water_there_is_always_a_way(area: FenceArea, seed: int) -> None:
    """A thousandth of the water may be lost in corners that the simpler area cuts off; a piece that stays in one piece
    when shrunk has a way."""
    kept = area.shrunk(2.0)
    narrow = kept.shrunk(0.6)
    rng = np.random.default_rng(seed)
    parts = [part for part in getattr(narrow.geometry, "geoms", [narrow.geometry]) if part.area > 1.0]
    assume(parts)
    part = parts[0]
    inside = [place for place in rng.uniform(-120.0, 120.0, (300, 2)).tolist() if part.contains(Point(place))]
    assume(len(inside) >= 2)
    assert ClearRoutes(kept).find(tuple(inside[0]), tuple(inside[1]), through=kept) is not None


@given(st.floats(0.0, 500.0), st.floats(0.01, 2.0), st.floats(0.0, 10.0))
def test_the_speed_stops_within_the_way(way_m: float, deceleration_mps2: float, lag_s: float) -> None:
    speed = speed_to_stop_in(way_m, deceleration_mps2, lag_s)
    assert speed * lag_s + speed * speed / (2.0 * deceleration_mps2) <= way_m * (1.0 + 1e-6) + 1e-9
    assert speed >= 0.0


@given(waters(), st.floats(-100.0, 100.0), st.floats(-100.0, 100.0), st.floats(5.0, 150.0), st.floats(0.1, 8.0))
@settings(max_examples=60, deadline=None)
def test_cutting_a_shrunk_area_is_shrinking_a_cut_one(
    area: FenceArea, north_m: float, east_m: float, radius_m: float, by_m: float
) -> None:
    """So the areas of a plan need not be built anew when the circle around home moves."""
    slow = area.within(Disc(north_m, east_m, radius_m)).shrunk(by_m)
    quick = area.shrunk(by_m).within(Disc(north_m, east_m, radius_m - by_m))
    for place in np.random.default_rng(1).uniform(-130.0, 130.0, (300, 2)).tolist():
        if slow.contains(*place) is not quick.contains(*place):
            assert min(abs(slow.margin(*place).distance_m), abs(quick.margin(*place).distance_m)) < 0.1


@given(waters(), st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_a_line_is_open_where_nothing_refuses_it(fence: FenceArea, seed: int) -> None:
    kept = fence.shrunk(2.0)
    assume(not kept.empty)
    allowed = Allowed(FenceAreas(fence, fence.shrunk(1.0), kept), None, 2.0, 5.0)
    places = np.random.default_rng(seed).uniform(-130.0, 130.0, (40, 2)).tolist()
    for begin, end in itertools.pairwise(tuple(place) for place in places):
        assert allowed.is_open(begin, end) is (allowed.line_refusal((begin, end)) is None)


@given(st.integers(0, 1000), st.sampled_from((31, 60, 100, 200)))
@settings(max_examples=8, deadline=None)
def test_a_way_among_many_zones_is_found(seed: int, count: int) -> None:
    """So many that not even three corners of each can be kept (`ClearRoutes`)."""
    rng, across = np.random.default_rng(seed), math.ceil(math.sqrt(count))
    grid = [(40.0 * (i // across), 40.0 * (i % across)) for i in range(count)]
    kept = FenceArea({}, [Disc(n + 15.0, e + 15.0, rng.uniform(4.0, 8.0)) for n, e in grid]).shrunk(2.0)
    begin, end = (-5.0, -5.0), (40.0 * (count // across) - 5.0, 40.0 * across - 5.0)
    points = Ways(kept, 2.0, large=False).of(2.0).find(begin, end)
    assert points is not None and kept.covers(points)
    assert LineString(points).length < 1.3 * math.dist(begin, end)
