"""How much of a sideways demand thrusters that are left after a failure can give together with the moment asked.

A single turning thruster, or several at one end of the boat, push sideways only as they turn it. Asked for both, they
would give up heading and way ahead for a little of a force that they do not have. The moment has priority.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from companion.allocation.geometry import Thruster

_STEPS = 40
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_STEEPEST = 20.0  # newtons of sway for each newton at the longest lever: the price of a moment is no higher
_MOST_YAW = 0.95  # of the moment that the thrusters give at most, for which some sway is found


def sway_reach_n(thrusters: Sequence[Thruster], failed: Collection[int], yaw_nm: float) -> tuple[float, float]:
    """(least, most) sideways force in N with that moment. Force ahead is free; thrusters push as hard astern as ahead
    where they turn."""
    left = [t for i, t in enumerate(thrusters) if i not in failed]
    most_nm = _MOST_YAW * sum(_most(t, 0.0, math.copysign(1.0, yaw_nm)) for t in left)
    yaw_nm = math.copysign(min(abs(yaw_nm), most_nm), yaw_nm)
    return -_most_sway_n(left, -1.0, yaw_nm), _most_sway_n(left, 1.0, yaw_nm)


def _most_sway_n(left: Sequence[Thruster], side: float, yaw_nm: float) -> float:
    """The most force to that side, by its dual: the least, over the price of a moment, of what each thruster gives at
    that price. Convex in the price, so that a golden-section search finds it."""

    def bound_n(price: float) -> float:
        return sum(_most(t, side, price) for t in left) - price * yaw_nm

    lever_m = max((math.hypot(t.x_m, t.y_m) for t in left), default=0.0)
    if lever_m <= 0.0:
        return bound_n(0.0)
    low, high = -_STEEPEST / lever_m, _STEEPEST / lever_m
    for _ in range(_STEPS):
        a, b = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        low, high = (low, b) if bound_n(a) < bound_n(b) else (a, high)
    return bound_n(0.5 * (low + high))


def _most(t: Thruster, sway: float, price: float) -> float:
    """The most that one thruster gives of sway · Y + price · N."""
    x, y = -price * t.y_m, sway + price * t.x_m
    if t.turns:
        return t.max_n * math.hypot(x, y)
    along = x * math.cos(t.rest_rad) + y * math.sin(t.rest_rad)
    return max(t.max_n * along, t.min_n * along)
