"""The yardstick of routes, on tracks whose figures are known."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from sitl.scenarios.measure import Track
from sitl.scenarios.route_measure import follow, line, most_turn_rad, percentile, reached_rows

LEG = [(0.0, 0.0), (50.0, 0.0), (50.0, 50.0)]


def track(*places: tuple[float, float, float]) -> Track:
    return [
        {"t_s": float(i), "north_m": n, "east_m": e, "yaw_rad": math.remainder(yaw, math.tau)}
        for i, (n, e, yaw) in enumerate(places)
    ]


def along(offset: Callable[[float], float]) -> Track:
    """Along both legs, `offset` to starboard."""
    first = [(0.5 * i, offset(0.5 * i), 0.0) for i in range(100)]
    second = [(50.0 - offset(50.0 + 0.5 * i), 0.5 * i, 0.5 * math.pi) for i in range(101)]
    return track(*first, *second)


def test_errors_are_signed_and_measured_at_right_angles() -> None:
    sailed = follow(along(lambda s: 0.4), line(LEG, "linear"))
    assert sailed.error_m[40] == pytest.approx(0.4, abs=1e-3) and sailed.error_m[160] == pytest.approx(0.4, abs=1e-3)
    assert sailed.s_m[40] == pytest.approx(20.0, abs=0.06) and sailed.s_m[160] == pytest.approx(80.0, abs=0.06)


def test_stations_of_waypoints_lie_where_the_path_passes_them() -> None:
    assert line(LEG, "linear").waypoint_s_m == pytest.approx([0.0, 50.0, 100.0], abs=0.1)


def test_another_branch_near_by_is_not_taken_for_the_one_being_sailed() -> None:
    """Out and back a metre apart: a boat on its way out that is 0.9 m off is not on the way back."""
    path = line([(0.0, 0.0), (100.0, 0.0), (100.0, 1.0), (0.0, 1.0)], "linear")
    sailed = follow(track(*((float(i), 0.9, 0.0) for i in range(60))), path)
    assert min(sailed.error_m) > 0.85


def test_waypoints_count_in_their_order_only() -> None:
    wanted = [(50.0, 0.0), (50.0, 50.0)]
    there = along(lambda s: 0.0)
    assert len(reached_rows(there, wanted, 5.0)) == 2
    assert len(reached_rows(there[::-1], wanted, 5.0)) == 1


def test_a_circle_shows_and_the_turn_of_the_path_does_not() -> None:
    path, straight = line(LEG, "linear"), along(lambda s: 0.0)
    rows = reached_rows(straight, LEG[1:], 5.0)
    assert (
        math.degrees(most_turn_rad(follow(straight, path), path, rows)) < 91.0
    )  # a corner is turned before or after its waypoint
    circle = [(20.0 + 3.0 * math.sin(a), 3.0 - 3.0 * math.cos(a), a) for a in (0.1 * i for i in range(64))]
    circling = track(
        *((0.5 * i, 0.0, 0.0) for i in range(40)), *circle, *((20.0 + 0.5 * i, 0.0, 0.0) for i in range(60))
    )
    rows = reached_rows(circling, LEG[1:], 5.0)
    assert math.degrees(most_turn_rad(follow(circling, path), path, rows)) > 350.0


def test_percentile() -> None:
    assert percentile([float(i) for i in range(100)], 0.95) == 95.0 and percentile([1.0], 0.95) == 1.0
