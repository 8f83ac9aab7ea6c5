"""Distance that a hull coasts without thrust."""

from __future__ import annotations

import math
from bisect import bisect_left

from companion.config.hull import HullConfig

_REST_MPS = 0.2
_TABLE_MPS = 0.1


class Coasting:
    """Distance that the hull coasts without thrust: s(v) = ∫ m u / D(u) du, tabulated at start, from `_REST_MPS` (which
    counts as rest) up to `fastest_mps`."""

    def __init__(self, hull: HullConfig, fastest_mps: float) -> None:
        self._speeds = [_REST_MPS + i * _TABLE_MPS for i in range(max(2, math.ceil(fastest_mps / _TABLE_MPS)))]
        ways = [0.0]
        for low in self._speeds[:-1]:
            middle = low + 0.5 * _TABLE_MPS
            ways.append(ways[-1] + _TABLE_MPS * hull.m11_kg * middle / max(1.0e-3, hull.drag_n(middle)))
        self._ways = ways

    def way_m(self, speed_mps: float) -> float:
        """Distance in m that the hull coasts from that speed to rest."""
        return self._ways[min(len(self._ways) - 1, bisect_left(self._speeds, speed_mps))]

    def speed_mps(self, way_m: float) -> float:
        """The speed from which the hull coasts to rest within `way_m`; infinite beyond the table."""
        if way_m <= 0.0:
            return 0.0
        i = bisect_left(self._ways, way_m)
        if i >= len(self._ways):
            return math.inf
        if i == 0:
            return self._speeds[0]
        share = (way_m - self._ways[i - 1]) / (self._ways[i] - self._ways[i - 1])
        return self._speeds[i - 1] + share * _TABLE_MPS
