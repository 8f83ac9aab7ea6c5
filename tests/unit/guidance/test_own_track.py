"""The way back along the own track."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.core.geodesy import LocalFrame
from companion.guidance.own_track import OwnTrack, Place, straightened
from tests.unit.estimates import AT_REST

FRAME = LocalFrame(63.44, 10.4)


def sailed(*corners: Place, step_m: float = 0.3, armed: bool = True) -> OwnTrack:
    """A track through these corners."""
    track = OwnTrack(lambda: FRAME)
    for a, b in itertools.pairwise(corners):
        count = max(1, math.ceil(math.dist(a, b) / step_m))
        for i in range(count + 1):
            north, east = (a[axis] + (b[axis] - a[axis]) * i / count for axis in (0, 1))
            track.update(at(north, east), armed)
    return track


def at(north_m: float, east_m: float, **more: object) -> object:
    return replace(AT_REST, north_m=north_m, east_m=east_m, **{"position_valid": True, **more})


def length(points: Sequence[Place]) -> float:
    return sum(math.dist(a, b) for a, b in itertools.pairwise(points))


def way_back(track: OwnTrack, begin: Place) -> tuple[Place, ...]:
    back = track.back()
    assert back is not None
    return back.way(begin)


def test_back_along_both_legs_of_a_bend() -> None:
    back = way_back(sailed((0.0, 0.0), (60.0, 0.0), (60.0, 40.0)), (60.0, 40.0))
    assert length(back) == pytest.approx(100.0, abs=2.5)
    assert back[0] == (60.0, 40.0) and math.dist(back[-1], (0.0, 0.0)) < 0.1
    assert min(math.dist(point, (60.0, 0.0)) for point in back) < 2.1, "not straight across the land between"
    assert len(back) <= 5


def test_a_loop_is_cut() -> None:
    """Out 50 m, round a square of 30 m and back to where that began, then on."""
    track = sailed((0, 0), (50, 0), (50, 30), (80, 30), (80, 0), (50, 0), (50, -20))
    assert length(way_back(track, (50.0, -20.0))) == pytest.approx(70.0, abs=5.0)


def test_laps_do_not_add_up() -> None:
    lap = [(30.0, 0.0), (30.0, 30.0), (0.0, 30.0), (0.0, 0.0)]
    track = sailed((0.0, 0.0), *lap * 6, (20.0, 0.0))
    assert length(way_back(track, (20.0, 0.0))) < 30.0


def test_there_and_back_again_leads_straight_home() -> None:
    track = sailed((0.0, 0.0), (100.0, 0.0), (20.0, 0.5))
    assert length(way_back(track, (20.0, 0.5))) < 26.0


def test_arming_begins_it_anew_and_disarmed_nothing_is_kept() -> None:
    track = sailed((0.0, 0.0), (50.0, 0.0))
    track.update(at(50.0, 0.0), False)
    assert way_back(track, (50.0, 0.0)), "still known, for the checks before arming"
    track.update(at(90.0, 0.0), False)
    track.update(at(90.0, 0.0), True)
    assert length(way_back(track, (90.0, 0.0))) < 0.01


def test_without_a_position_nothing_is_kept() -> None:
    track = OwnTrack(lambda: FRAME)
    track.update(at(0.0, 0.0, position_valid=False), True)
    assert track.back() is None


def test_the_plane_of_the_estimate_may_move() -> None:
    planes = [FRAME]
    track = OwnTrack(lambda: planes[-1])
    for north_m in range(0, 41, 2):
        track.update(at(float(north_m), 0.0), True)
    planes.append(LocalFrame(*FRAME.to_geodetic(1000.0, 0.0)))
    back = way_back(track, (-960.0, 0.0))
    assert math.dist(back[-1], (-1000.0, 0.0)) < 0.5


def test_a_long_voyage_is_kept_in_bounds() -> None:
    track = sailed(*((500.0 * (i % 2), 12.0 * i) for i in range(60)), step_m=2.0)
    back = way_back(track, (500.0, 12.0 * 59))
    assert len(back) <= 300
    assert math.dist(back[-1], (0.0, 0.0)) < 0.1
    assert 0.7 < length(back) / (59 * math.hypot(500.0, 12.0)) <= 1.0


@settings(deadline=None, derandomize=True, max_examples=60)
@given(st.lists(st.tuples(st.floats(-80, 80), st.floats(-80, 80)), min_size=2, max_size=12))
def test_the_way_back_stays_where_the_boat_has_been(corners: list[Place]) -> None:
    """Whatever is cut: within a step and the straightening of the track itself, and never longer than it."""
    track = sailed(*corners, step_m=0.5)
    back = way_back(track, corners[-1])
    legs = list(itertools.pairwise(corners))
    for a, b in itertools.pairwise(back):
        for share in (0.0, 0.25, 0.5, 0.75, 1.0):
            point = a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
            assert min(off(point, *leg) for leg in legs) <= 3.1
    assert length(back) <= length(corners) + 3.0


def off(point: Place, a: Place, b: Place) -> float:
    along = (b[0] - a[0], b[1] - a[1])
    square = along[0] ** 2 + along[1] ** 2
    share = 0.0 if square == 0.0 else ((point[0] - a[0]) * along[0] + (point[1] - a[1]) * along[1]) / square
    share = min(max(share, 0.0), 1.0)
    return math.dist(point, (a[0] + share * along[0], a[1] + share * along[1]))


def test_a_line_of_few_points_stays() -> None:
    assert straightened([(0.0, 0.0), (1.0, 1.0)]) == ((0.0, 0.0), (1.0, 1.0))
