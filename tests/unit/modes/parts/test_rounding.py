"""Legs led round what lies across them."""

from __future__ import annotations

import math

from companion.fence.allowed import Place, Way
from companion.guidance.waypoint import Waypoint
from companion.modes.parts.rounding import Rounded, rounded, unchanged


def clear(begin: Place, end: Place) -> bool:
    """A bar from 10 to 20 m north lies across."""
    return not (min(begin[0], end[0]) < 10.0 and max(begin[0], end[0]) > 20.0)


def find(begin: Place, end: Place) -> Way | None:
    return Way((begin, (15.0, 30.0), end), 0.5)


ROUTE = [Waypoint(5.0, 0.0), Waypoint(30.0, 0.0, speed_mps=0.4), Waypoint(40.0, 0.0)]


def test_only_the_leg_that_crosses_gets_points() -> None:
    found = rounded(ROUTE, (0.0, 0.0), clear, find)
    assert isinstance(found, Rounded) and found.added == 1
    added = found.waypoints[1]
    assert (added.north_m, added.east_m, added.speed_mps, added.straight) == (15.0, 30.0, 0.4, True)
    assert [found.passed(count) for count in range(5)] == [0, 1, 1, 2, 3]
    assert [found.own_index(i) for i in range(4)] == [0, 1, 1, 2]


def test_no_way_names_the_waypoint() -> None:
    assert rounded(ROUTE, (0.0, 0.0), clear, lambda _a, _b: None) == 1


def test_a_waypoint_that_cannot_be_reached_is_passed_beside_but_not_the_last() -> None:
    def beside(begin: Place, end: Place) -> Way | None:
        return Way((begin, (end[0], end[1] + 3.0)), 0.5)

    found = rounded(ROUTE, (0.0, 0.0), clear, beside)
    assert isinstance(found, Rounded) and found.beside == ((1, 3.0),)
    assert (found.waypoints[1].north_m, found.waypoints[1].east_m) == (30.0, 3.0)
    assert rounded(ROUTE[:2], (0.0, 0.0), clear, beside) == 1


def test_a_route_far_off_is_left_for_later() -> None:
    far = [Waypoint(-500.0, 0.0), Waypoint(30.0, 0.0)]
    assert rounded(far, (0.0, 0.0), clear, find) == unchanged(far)
    assert math.dist((0.0, 0.0), (-500.0, 0.0)) > 400.0
