"""Crossing sides, against a test in exact arithmetic that looks at every pair."""

import math
import random

import pytest

from companion.mission.polygon import find_crossing

Point = tuple[int, int]


def _orientation(a: Point, b: Point, c: Point) -> int:
    value = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return (value > 0) - (value < 0)


def _on(a: Point, b: Point, p: Point) -> bool:
    inside = min(a[0], b[0]) <= p[0] <= max(a[0], b[0]) and min(a[1], b[1]) <= p[1] <= max(a[1], b[1])
    return inside and _orientation(a, b, p) == 0


def _share_a_point(a: Point, b: Point, c: Point, d: Point) -> bool:
    crossing = _orientation(a, b, c) * _orientation(a, b, d) < 0 and _orientation(c, d, a) * _orientation(c, d, b) < 0
    return crossing or _on(a, b, c) or _on(a, b, d) or _on(c, d, a) or _on(c, d, b)


def _is_simple(points: list[Point]) -> bool:
    """Of a polygon without repeated neighbours."""
    count = len(points)
    sides = [(points[i], points[(i + 1) % count]) for i in range(count)]
    for i in range(count):
        a, b = sides[i]
        c = sides[(i + 1) % count][1]
        if _on(a, b, c) or _on(b, c, a):
            return False
        for j in range(i + 2, count):
            if (i, j) != (0, count - 1) and _share_a_point(*sides[i], *sides[j]):
                return False
    return True


def test_agrees_with_exact_arithmetic_on_small_grids() -> None:
    """A small grid makes touching and overlapping sides as common as crossing ones."""
    source = random.Random(7)
    verdicts = {True: 0, False: 0}
    for _ in range(3000):
        count = source.randint(3, 7)
        points = [(source.randint(0, 5), source.randint(0, 5))]
        while len(points) < count or points[0] == points[-1]:
            point = (source.randint(0, 5), source.randint(0, 5))
            if point != points[-1]:
                points.append(point)
        simple = _is_simple(points)
        assert (find_crossing(points) is None) is simple, points
        verdicts[simple] += 1
    assert min(verdicts.values()) > 300


def test_names_the_sides() -> None:
    bow_tie = [(0, 0), (100, 100), (100, 0), (0, 100)]
    assert find_crossing(bow_tie) == (0, 2)


def test_a_repeated_vertex_is_not_a_crossing() -> None:
    assert find_crossing([(0, 0), (0, 0), (100, 0), (100, 100), (0, 0)]) is None


@pytest.mark.parametrize("points", [[(5, 5)] * 3, [(0, 0), (10, 10), (0, 0)], [(0, 0), (10, 10), (20, 20)]])
def test_a_polygon_without_area_is_refused(points: list[Point]) -> None:
    assert find_crossing(points) is not None


def test_across_the_date_line() -> None:
    """The same verdict as anywhere else, wherever the line cuts through."""
    source = random.Random(11)
    for _ in range(500):
        points = [(source.randint(0, 9), source.randint(0, 9)) for _ in range(source.randint(4, 6))]
        moved = [(x, (y + 1_799_999_995 + 1_800_000_000) % 3_600_000_000 - 1_800_000_000) for x, y in points]
        assert (find_crossing(moved) is None) == (find_crossing(points) is None), points


def test_a_large_one() -> None:
    circle = [
        (round(1e5 * math.cos(i * math.tau / 1000)), round(1e5 * math.sin(i * math.tau / 1000))) for i in range(1000)
    ]
    assert find_crossing(circle) is None
    circle[500], circle[501] = circle[501], circle[500]
    assert find_crossing(circle) is not None
