"""How much of a sideways demand thrusters that are left after a failure can give together with the moment asked.

A single turning thruster, or several at one end of the boat, push sideways only as they turn it. Asked for both, they
would give up heading and way ahead for a little of a force that they do not have. The moment has priority.

Two thrusters that do not turn, as one at the stern and one across the bow, give a moment and a force ahead; the
sideways force follows from these. Asked for another one, they pushed a boat ahead that was to go astern: it orbited its
point.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from companion.allocation.geometry import Thruster

_STEPS = 40
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_STEEPEST = 20.0  # newtons of sway for each newton at the longest lever: the price of a moment is no higher
_SINGULAR_M = 1.0e-3
_SLACK = 0.1  # of the thrust of two: so far off its demand the force ahead may be, for some sway
_MOST_YAW = 0.95  # of the moment that the thrusters give at most, for which some sway is found


def sway_reach_n(
    thrusters: Sequence[Thruster], failed: Collection[int], yaw_nm: float, surge_n: float
) -> tuple[float, float]:
    """(least, most) sideways force in N with that moment. Force ahead is free, but for two thrusters that do not turn;
    thrusters push as hard astern as ahead where they turn."""
    left = [t for i, t in enumerate(thrusters) if i not in failed]
    if len(left) == 2 and not any(t.turns for t in left):
        slack_n = _SLACK * (left[0].max_n + left[1].max_n)
        less_n, more_n = (_sway_of_two_n(left[0], left[1], yaw_nm, surge_n + n) for n in (-slack_n, slack_n))
        if less_n is not None and more_n is not None:
            return min(less_n, more_n), max(less_n, more_n)
    most_nm = _MOST_YAW * sum(_most(t, 0.0, math.copysign(1.0, yaw_nm)) for t in left)
    yaw_nm = math.copysign(min(abs(yaw_nm), most_nm), yaw_nm)
    return -_most_sway_n(left, -1.0, yaw_nm), _most_sway_n(left, 1.0, yaw_nm)


def _sway_of_two_n(a: Thruster, b: Thruster, yaw_nm: float, surge_n: float) -> float | None:
    """The sideways force of two thrusters that give the moment, and as much of the force ahead as they can with it;
    None where they do not give both."""
    (ax, ay, an), (bx, by, bn) = _columns(a), _columns(b)
    determinant = ax * bn - bx * an
    if abs(determinant) < _SINGULAR_M:
        return None
    moment = -bx * yaw_nm / determinant, ax * yaw_nm / determinant
    ahead = bn * surge_n / determinant, -an * surge_n / determinant
    within = min(_share(a, 0.0, moment[0]), _share(b, 0.0, moment[1]))
    held = within * moment[0], within * moment[1]
    more = min(_share(a, held[0], ahead[0]), _share(b, held[1], ahead[1]))
    return ay * (held[0] + more * ahead[0]) + by * (held[1] + more * ahead[1])


def _columns(t: Thruster) -> tuple[float, float, float]:
    """Surge, sway and moment of 1 N of a thruster that does not turn."""
    x, y = math.cos(t.rest_rad), math.sin(t.rest_rad)
    return x, y, t.x_m * y - t.y_m * x


def _share(t: Thruster, held_n: float, more_n: float) -> float:
    """The share of `more_n`, up to the whole, that a thruster can add to `held_n`."""
    room_n = t.max_n - held_n if more_n > 0.0 else held_n - t.min_n
    return min(1.0, max(0.0, room_n) / abs(more_n)) if more_n != 0.0 else 1.0


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
