"""Ways around: where the boat is along them, how near that is, and which ways there are; against shapely and a
step-by-step sum."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import LineString, Point

from companion.core.estimate import Contact
from companion.traffic import evasion
from companion.traffic.evasion import SpeedRamp

BENT = ((0.0, 0.0), (50.0, 0.0), (50.0, 80.0), (120.0, 80.0))


@given(st.floats(0.0, 250.0))
def test_a_way_is_cut_in_two(length_m: float) -> None:
    line, begin, end = LineString(BENT), evasion.first_part(BENT, length_m), evasion.remainder(BENT, length_m)
    at = line.interpolate(min(length_m, line.length))
    assert math.dist(begin[-1], (at.x, at.y)) < 1e-6 and evasion.length_of(begin) == pytest.approx(
        min(length_m, line.length), abs=1e-6
    )
    if length_m < line.length - 1e-6:
        assert math.dist(end[0], (at.x, at.y)) < 1e-6
        assert evasion.length_of(begin) + evasion.length_of(end) == pytest.approx(line.length)


def test_a_thinned_way_is_the_same_way() -> None:
    dense = evasion.first_part([(0.1 * n, 3.0 * math.sin(0.01 * n)) for n in range(1000)], 90.0)
    thin = evasion.thinned(dense, 2.0)
    assert len(thin) < 50 and (thin[0], thin[-1]) == (dense[0], dense[-1])
    assert LineString(thin).hausdorff_distance(LineString(dense)) < 0.05


@pytest.mark.parametrize(("begin", "speed"), [(0.0, 1.2), (1.5, 0.0), (1.0, 1.0), (1.6, 0.6)])
def test_places_along_a_way(begin: float, speed: float) -> None:
    t_s = evasion.time_steps(100.0)
    places = evasion.places_along(BENT, SpeedRamp(begin, speed, 0.08), t_s)
    line, s, v, dt = LineString(BENT), 0.0, begin, 0.01
    for step in range(10_001):
        if step % 100 == 0:
            at = line.interpolate(min(s, line.length))
            assert math.dist(places[step // 100], (at.x, at.y)) < 0.05
        v += math.copysign(min(0.08 * dt, abs(speed - v)), speed - v)
        s += v * dt


def test_clear_water_and_crossing_ahead() -> None:
    t_s = np.array([0.0, 10.0, 20.0, 30.0])
    places = np.array([[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]])
    crossing = Contact(
        1, "NORA", 15.0, 40.0, 0.0, -1.0, 4.0, 0
    )  # its bow is at east 25 when the boat crosses its track at 15 s
    gaps = evasion.clear_water(places, t_s, crossing, 2.0)
    assert gaps[1] == pytest.approx(math.hypot(5.0, 30.0) - 6.0)
    assert evasion.crosses_ahead(places, t_s, crossing, 100.0) and not evasion.crosses_ahead(
        places, t_s, crossing, 10.0
    )
    assert evasion.least_clear_water(places, t_s, [crossing], 2.0) == pytest.approx(gaps.min())
    assert math.isinf(evasion.least_clear_water(places, t_s, [], 2.0))
    past = Contact(1, "NORA", 15.0, 5.0, 0.0, -1.0, 4.0, 0)
    assert not evasion.crosses_ahead(places, t_s, past, 100.0)


@pytest.mark.parametrize("side", [1, -1])
def test_a_detour_leaves_at_45_degrees_to_its_side_and_comes_back(side: int) -> None:
    found = [d for d in evasion.detours((0.0, 0.0), ((0.0, 0.0), (0.0, 400.0)), 20.0, (side,)) if d.side]
    assert found
    for detour in found:
        (n0, e0), (n1, e1), (n2, e2), (n3, e3) = detour.points
        assert (n0, e0) == (0.0, 0.0) and (n3, e3) == pytest.approx((0.0, detour.length_m))
        assert n1 == pytest.approx(-side * e1) and n2 == pytest.approx(n1), "eastwards, starboard is south"
        assert n1 * side < 0.0 and e2 > e1
    costs = [d.cost_m for d in found]
    assert costs == sorted(costs)


def test_those_of_a_fast_boat_take_a_minute_and_no_sharp_corners() -> None:
    route = ((0.0, 0.0), (0.0, 900.0))
    found = [d for d in evasion.detours((0.0, 0.0), route, 20.0, (1,), speed_mps=8.0) if d.side]
    assert max(d.length_m for d in found) == pytest.approx(60.0 * 8.0)
    assert min(d.points[1][1] for d in found) >= 4.0 * 8.0
    assert evasion.reach_m(8.0) == pytest.approx(0.8 * 60.0 * 8.0) and evasion.reach_m(1.0) == pytest.approx(
        0.8 * 330.0
    )


def test_no_detour_goes_past_the_end_of_the_route() -> None:
    route = ((0.0, 0.0), (90.0, 0.0))
    line = LineString(route)
    for detour in evasion.detours((0.0, 0.0), route, 15.0, (1, -1)):
        assert line.distance(Point(detour.points[-1])) < 1e-9 and detour.length_m <= 90.0
    assert list(evasion.detours((0.0, 0.0), ((0.0, 0.0), (10.0, 0.0)), 15.0, (1,))) == []
