"""Whether the positions of a receiver go along with its velocity, which is found to lie.

False satellites move both together, and the fixes then drag the estimate to the velocity, which seems good again. The
fixes of the last seconds are set against two ways: that of the receiver's velocity, and that of the forces from before
it was found. A receiver whose velocity alone is wrong is on the second one.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from companion.core.readings import FixType
from companion.nav.integrity.evidence import InertialWay, PositionSeen, VelocitySeen

_BEFORE_S, _AFTER_S = 9.0, 12.0  # of when the velocity is found to lie: how long dead reckoning tells a way
_GAP_S = 1.5
_LEAST_M, _NOISES, _ASTRAY_MPS = 0.3, 8.0, 0.08  # off the way of the forces: the least, and of noise and dead reckoning
_SHARE = 1.0 / 3.0  # of that, by which fixes may be off the way of the velocity


class _Point(NamedTuple):
    """A fix, with the way of the velocity by then and that of the forces."""

    t_s: float
    north_m: float
    east_m: float
    velocity_way: tuple[float, float]
    way: InertialWay


class Along:
    """Call `velocity` and `position` for each one of a receiver, in order of time. Remembers its fixes of the last
    seconds, the way of its velocity, and the fix from before that was found to lie."""

    def __init__(self) -> None:
        self._points: deque[_Point] = deque()
        self._start: _Point | None = None
        self._found_s = math.inf
        self._fix = FixType.NONE
        self._velocity: VelocitySeen | None = None
        self._north_m = self._east_m = 0.0

    def clear(self) -> None:
        """Begin anew."""
        self._points.clear()
        self._start, self._velocity = None, None

    def velocity(self, seen: VelocitySeen) -> None:
        """Take a velocity."""
        last, self._velocity = self._velocity, seen
        passed_s = math.inf if last is None else seen.t_s - last.t_s
        if last is None or not 0.0 < passed_s <= _GAP_S:
            self._points.clear()
            self._start = None
            return
        self._north_m += 0.5 * passed_s * (last.north_mps + seen.north_mps)
        self._east_m += 0.5 * passed_s * (last.east_mps + seen.east_mps)

    def position(self, seen: PositionSeen, lies: bool, noise_m: float) -> float | None:
        """Take a fix. `lies`: its receiver's velocity is found to; `noise_m`: the usual size of a step. Returns since
        when both have gone together, if they have."""
        if self._velocity is None or seen.way is None or seen.fix is not self._fix:
            self._points.clear()
            self._start, self._fix = None, seen.fix
            return None
        ahead_s = seen.t_s - self._velocity.t_s
        gone = self._north_m + ahead_s * self._velocity.north_mps, self._east_m + ahead_s * self._velocity.east_mps
        point = _Point(seen.t_s, seen.north_m, seen.east_m, gone, seen.way)
        if not lies:
            self._start = None
            self._points.append(point)
            while self._points[0].t_s < seen.t_s - _BEFORE_S:
                self._points.popleft()
            return None
        if self._points:  # it has just been found
            self._start, self._found_s = self._points[0], seen.t_s
            self._points.clear()
        if self._start is None or seen.t_s - self._found_s > _AFTER_S:
            return None
        return self._start.t_s if _goes_along(self._start, point, noise_m) else None


def _goes_along(start: _Point, now: _Point, noise_m: float) -> bool:
    """Whether the way from one fix to the other is that of the velocity, and not that of the forces."""
    passed_s, began, ended = now.t_s - start.t_s, start.way, now.way
    north, east = now.north_m - start.north_m, now.east_m - start.east_m
    by_velocity_m = math.hypot(
        north - now.velocity_way[0] + start.velocity_way[0], east - now.velocity_way[1] + start.velocity_way[1]
    )
    by_forces_m = math.hypot(
        north - (ended.north_m - began.north_m + passed_s * began.carried_north_mps),
        east - (ended.east_m - began.east_m + passed_s * began.carried_east_mps),
    )
    limit_m = max(_LEAST_M, _NOISES * noise_m, _ASTRAY_MPS * passed_s)
    return by_forces_m >= limit_m and by_velocity_m <= _SHARE * by_forces_m
