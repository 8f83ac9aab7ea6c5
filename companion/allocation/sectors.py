"""Allowed azimuths of a thruster: between its stops and outside its forbidden sectors. Azimuths are unwrapped, in
radians."""

from __future__ import annotations

import math
from collections.abc import Sequence

_EDGE = 1.0e-9


class Sectors:
    """`low_rad`, `high_rad`: the stops, infinite if there are none. `forbidden`: sectors, each clockwise from its first
    to its second direction."""

    __slots__ = ("_forbidden", "high_rad", "low_rad")

    def __init__(self, low_rad: float | None, high_rad: float | None, forbidden: Sequence[tuple[float, float]]) -> None:
        self.low_rad = -math.inf if low_rad is None else low_rad
        self.high_rad = math.inf if high_rad is None else high_rad
        self._forbidden = tuple((start, (end - start) % math.tau) for start, end in forbidden)

    @property
    def endless(self) -> bool:
        """Whether it has no stops."""
        return math.isinf(self.low_rad) and math.isinf(self.high_rad)

    @property
    def free(self) -> bool:
        """Whether every azimuth is allowed."""
        return self.endless and not self._forbidden

    def allowed(self, azimuth_rad: float) -> bool:
        """Whether it may give thrust at that azimuth."""
        inside = self.low_rad - _EDGE <= azimuth_rad <= self.high_rad + _EDGE
        return inside and not any(
            _EDGE < (azimuth_rad - start) % math.tau < width - _EDGE for start, width in self._forbidden
        )

    def span(self, azimuth_rad: float) -> tuple[float, float]:
        """The allowed interval (low, high) around `azimuth_rad`; inside a forbidden sector, that azimuth alone."""
        low, high = self.low_rad, self.high_rad
        for start, width in self._forbidden:
            past = (azimuth_rad - start) % math.tau
            if past > math.tau - _EDGE:  # on the first edge, but for rounding
                past = 0.0
            if _EDGE < past < width - _EDGE:
                return azimuth_rad, azimuth_rad
            if past <= _EDGE:
                low, high = max(low, azimuth_rad - (math.tau - width)), min(high, azimuth_rad)
            else:
                low, high = max(low, azimuth_rad - (past - width)), min(high, azimuth_rad + (math.tau - past))
        return low, max(low, high)

    def nearest(self, azimuth_rad: float, present_rad: float) -> float:
        """The azimuth in the direction of `azimuth_rad`, or the allowed one nearest to that direction, with the least
        turn from `present_rad`."""
        turned = present_rad + math.remainder(azimuth_rad - present_rad, math.tau)
        best, least = present_rad, (math.inf, math.inf)
        for candidate in (turned, turned - math.tau, turned + math.tau):
            held = self._into(min(self.high_rad, max(self.low_rad, candidate)))
            if self.low_rad - _EDGE <= held <= self.high_rad + _EDGE:
                cost = (round(abs(math.remainder(held - azimuth_rad, math.tau)), 9), abs(held - present_rad))
                if cost < least:
                    best, least = held, cost
        return best

    def _into(self, azimuth_rad: float) -> float:
        """The azimuth, or the nearer edge of the forbidden sector that it is in."""
        for start, width in self._forbidden:
            past = (azimuth_rad - start) % math.tau
            if _EDGE < past < width - _EDGE:
                edge = azimuth_rad - past if past < width - past else azimuth_rad + (width - past)
                if not self.low_rad - _EDGE <= edge <= self.high_rad + _EDGE:
                    edge = azimuth_rad + (width - past) if past < width - past else azimuth_rad - past
                return edge
        return azimuth_rad
