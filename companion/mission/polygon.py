"""Test of a polygon for self-intersection."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

MOST_VERTICES = 1_000  # keeps this test, and the work of the fence in each tick, within milliseconds
_TURN = 3_600_000_000  # 360°, in degrees·1e7

_Vectors = NDArray[np.float64]
_Numbers = NDArray[np.intp]


def find_crossing(vertices: Sequence[tuple[int, int]]) -> tuple[int, int] | None:
    """Numbers of two sides that cross, touch or overlap; None for a simple polygon.

    `vertices`: at least 3 (latitude, longitude) in degrees·1e7. Side i runs from vertex i to the next, the last one
    back to the first. Sides of no length (repeated vertices) are ignored. Exact for polygons up to some 5 degrees
    across.
    """
    sides, numbers = _sides(vertices)
    if len(sides) < 3:
        return 0, 1
    for i in range(len(sides)):
        if _turns_back(sides[i - 1], sides[i]):
            return numbers[i - 1], numbers[i]
    first, second = _near_pairs(sides)
    hits = _meet(sides[first], sides[second])
    if not hits.any():
        return None
    hit = int(hits.argmax())
    return numbers[int(first[hit])], numbers[int(second[hit])]


def _sides(vertices: Sequence[tuple[int, int]]) -> tuple[_Vectors, list[int]]:
    """Sides with length as [start, end] relative to the first vertex, and their numbers."""
    x0, y0 = vertices[0]
    points = [(x - x0, (y - y0 + _TURN // 2) % _TURN - _TURN // 2) for x, y in vertices]
    pairs = list(zip(points, [*points[1:], points[0]], strict=True))
    numbers = [i for i, (start, end) in enumerate(pairs) if start != end]
    return np.array([pairs[i] for i in numbers], dtype=np.float64).reshape(-1, 2, 2), numbers


def _turns_back(side: _Vectors, following: _Vectors) -> bool:
    """Whether a side goes back over the one before it."""
    (ax, ay), (bx, by) = (side[1] - side[0]).tolist(), (following[1] - following[0]).tolist()
    return bool(ax * by == ay * bx and ax * bx + ay * by < 0.0)


def _near_pairs(sides: _Vectors) -> tuple[_Numbers, _Numbers]:
    """All pairs of sides that are not neighbours and whose bounding boxes overlap; first < second."""
    low, high = sides.min(axis=1), sides.max(axis=1)
    near = np.ones((len(sides), len(sides)), dtype=np.bool_)
    for axis in (0, 1):
        near &= low[:, None, axis] <= high[None, :, axis]
        near &= low[None, :, axis] <= high[:, None, axis]
    near[0, -1] = False
    first, second = np.nonzero(np.triu(near, k=2))
    return first, second


def _meet(sides: _Vectors, others: _Vectors) -> NDArray[np.bool_]:
    """For each pair of sides whose bounding boxes overlap: whether they have a point in common."""
    result: NDArray[np.bool_] = _straddles(sides, others) & _straddles(others, sides)
    return result


def _straddles(sides: _Vectors, others: _Vectors) -> NDArray[np.bool_]:
    """Whether the line through each side has a point in common with the other side of the pair."""
    start, along = sides[:, 0], sides[:, 1] - sides[:, 0]
    ends = (np.sign(_cross(along, others[:, end] - start)) for end in (0, 1))
    result: NDArray[np.bool_] = next(ends) * next(ends) <= 0.0
    return result


def _cross(u: _Vectors, v: _Vectors) -> _Vectors:
    result: _Vectors = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return result
