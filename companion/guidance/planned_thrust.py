"""The thrust along the path that a plan counts on: on a leg that of its steady speed, a little more to speed up, and
ahead of a bend a little less than the bend's speed takes.

The drag does the braking: thrusters that keep pushing ahead can turn their force aside at once, while ones that reverse
would first have to turn round. Between two nearly equal forces thrust also varies least.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from companion.config.hull import AIR_KGPM3
from companion.guidance.agility import Agility, Weather

# Thrust beyond that of the steady speed, and thrust less than that of the bend's speed, as parts of the share of the
# surge limit that a plan may take.
_MORE, _LESS = 0.2, 0.3
_AHEAD_S = 5.0  # how far ahead a bend is braked for, at the leg's speed
_SPEEDS = 65  # for which the drag is computed
_APPROACHES = 5  # the acceleration depends on the speed that it leads to

Floats = NDArray[np.float64]


class PlannedThrust:
    """Thrust by arc length, and the speeds that it can follow. Remembers the thrust that it braked with last.

    `high_n`, `low_n`: the most and the least thrust along the path at each sample.
    """

    def __init__(self, s_m: Floats, course_rad: Floats, leg_mps: Floats, agility: Agility, weather: Weather) -> None:
        """`leg_mps`: the leg's speed at each sample."""
        self._s, self._leg, self._agility = s_m, leg_mps, agility
        c, s = np.cos(course_rad), np.sin(course_rad)
        self._water = weather.water_north_mps * c + weather.water_east_mps * s
        self._air = weather.air_north_mps * c + weather.air_east_mps * s
        self._windy = weather.air_north_mps != 0.0 or weather.air_east_mps != 0.0
        top = float(np.max(leg_mps)) + abs(weather.water_north_mps) + abs(weather.water_east_mps)
        self._speeds = np.linspace(-top, top, _SPEEDS)
        self._drag = np.array([agility.hull.drag_n(float(u)) for u in self._speeds])
        self.high_n = self.low_n = self._resisting(leg_mps)

    def _resisting(self, speed_mps: Floats) -> Floats:
        """As `Agility.resisting_n`, for a speed at each sample."""
        drag: Floats = np.interp(speed_mps - self._water, self._speeds, self._drag)
        if not self._windy:
            return drag
        windage, past = self._agility.windage, self._air - speed_mps
        return drag - 0.5 * AIR_KGPM3 * windage.cx * windage.frontal_m2 * np.abs(past) * past

    def followed(self, most_mps: Floats, share: float, stop_at_end: bool) -> Floats:
        """The highest speeds up to `most_mps` that the thrust can follow. `share`: of the surge limit that may be
        planned with."""
        agility, s = self._agility, self._s
        unit_n = share * agility.surge_n
        self.high_n = np.minimum(self._resisting(self._leg) + _MORE * unit_n, agility.most_n)
        wanted = most_mps.copy()
        if stop_at_end:
            wanted[-1] = 0.0
        bend = _least_ahead(wanted, np.searchsorted(s, s + _AHEAD_S * self._leg))
        bend_n = self._resisting(bend)
        ahead_only = (bend > 0.0) & (bend_n > 0.0)
        low_n = np.where(ahead_only, np.maximum(bend_n - _LESS * unit_n, 0.0), bend_n - _LESS * unit_n)
        self.low_n = np.maximum(low_n, -agility.most_n)
        kept = wanted
        for _ in range(_APPROACHES):
            kept = self._within(wanted, kept)
        return self._within(wanted, kept)

    def _within(self, most_mps: Floats, near_mps: Floats) -> Floats:
        """The highest speeds up to `most_mps` with the accelerations that there are at `near_mps`."""
        step, resisting, agility = np.diff(self._s), self._resisting(near_mps), self._agility
        up = np.maximum(agility.least_mps2, (self.high_n - resisting) / agility.hull.m11_kg)
        down = np.maximum(agility.least_mps2, (resisting - self.low_n) / agility.hull.m11_kg)
        rise = np.concatenate(([0.0], np.cumsum((up[1:] + up[:-1]) * step)))
        fall = np.concatenate(([0.0], np.cumsum((down[1:] + down[:-1]) * step)))
        square = most_mps * most_mps
        square = np.minimum.accumulate((square + fall)[::-1])[::-1] - fall
        square[:-1] = np.minimum.accumulate((square - rise)[:-1]) + rise[:-1]
        kept: Floats = np.sqrt(np.maximum(square, 0.0))
        return kept


def _least_ahead(values: Floats, until: Sequence[int] | NDArray[np.intp]) -> Floats:
    """The least of `values` from each index up to about `until`, by doubling the stretch."""
    least = values.copy()
    longest = int(np.max(np.asarray(until) - np.arange(len(values)))) + 1
    span = 1
    while span < min(longest, len(values)):
        least[:-span] = np.minimum(least[:-span], least[span:])
        span *= 2
    return least
