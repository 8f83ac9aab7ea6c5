"""The largest wrench of all thrusters together on each axis, with the other axes at zero."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from functools import lru_cache

from companion.config.blades import steered_by_rudder, without_blades
from companion.config.devices import ThrusterConfig
from companion.config.dimensions.figure import Figure
from companion.config.kinds import Problem

KEYS = ("surge_n", "sway_n", "yaw_nm")
SHARE = 0.9
"""Of what the thrusters give, that limits keep: the rest is for the other axes."""
_STEERING_SHARE = 0.35  # default of RUD_STEER: of the thrust ahead, which the boat adds for its rudders
_USEFUL_SHARE = 0.05  # of the force ahead; a smaller force sideways counts as none
_NONE = 1.0e-6  # of the thrust of all: what the search leaves of nothing
_NARROWINGS = 40
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)

_Support = Callable[[float, float, float], float]


def support_n(thruster: ThrusterConfig, surge: float, sway: float, yaw: float, way: int = 0) -> float:
    """Largest value of surge·X + sway·Y + yaw·N that the thruster can give. Forbidden sectors do not count. `way`: 1
    for an azimuth that turns ahead, −1 for one in reverse, 0 for either."""
    return _support(thruster, way)(surge, sway, yaw)


def _support(thruster: ThrusterConfig, way: int) -> _Support:
    """`support_n` of one thruster: a search asks it ten thousand times."""
    x_m, y_m, max_n, min_n = thruster.x_m, thruster.y_m, thruster.max_n, thruster.min_n
    if thruster.kind == "rudder" and (rudder := thruster.rudder) is not None:
        return lambda surge, sway, yaw: _rudder_n(thruster, surge - y_m * yaw, sway + rudder.x_m * yaw)
    if thruster.turns:
        return _turning_support(thruster, way)
    azimuth_rad = thruster.azimuth_rad

    def fixed_n(surge: float, sway: float, yaw: float) -> float:
        along_x, along_y = surge - y_m * yaw, sway + x_m * yaw
        value = math.hypot(along_x, along_y) * math.cos(math.atan2(along_y, along_x) - azimuth_rad)
        return max(max_n * value, min_n * value)

    return fixed_n


def _turning_support(thruster: ThrusterConfig, way: int) -> _Support:
    x_m, y_m = thruster.x_m, thruster.y_m
    ahead_n, astern_n = thruster.max_n if way >= 0 else 0.0, -thruster.min_n if way <= 0 else 0.0
    low, high = thruster.azimuth_min_rad, thruster.azimuth_max_rad
    if low is None or high is None or high - low >= math.tau:
        most_n = max(0.0, ahead_n, astern_n)
        return lambda surge, sway, yaw: most_n * math.hypot(surge - y_m * yaw, sway + x_m * yaw)

    def turning_n(surge: float, sway: float, yaw: float) -> float:
        along_x, along_y = surge - y_m * yaw, sway + x_m * yaw
        size, direction = math.hypot(along_x, along_y), math.atan2(along_y, along_x)
        ahead, astern = (size * math.cos(_beyond(low, high, each)) for each in (direction, direction + math.pi))
        return max(0.0, ahead_n * ahead, astern_n * astern)

    return turning_n


def _rudder_n(thruster: ThrusterConfig, along_x: float, along_y: float) -> float:
    """Largest value of along_x·X + along_y·Y, with the boat at rest: a side force comes with its thrust ahead alone."""
    return max(0.0, thruster.max_n * (along_x + abs(along_y) * rudder_share(thruster)), thruster.min_n * along_x)


def rudder_share(thruster: ThrusterConfig) -> float:
    """Side force at the nearer stop over the thrust ahead, with the boat at rest; 0 without a rudder."""
    if thruster.rudder is None or thruster.propeller_m is None:
        return 0.0
    stops = (thruster.azimuth_min_rad or 0.0, thruster.azimuth_max_rad or 0.0)
    return thruster.rudder.side_share(min(map(abs, stops)), thruster.propeller_m)


def _beyond(low: float, high: float, direction: float) -> float:
    """Angle from `direction` to the nearest azimuth between the stops, rad."""
    if (direction - low) % math.tau <= high - low:
        return 0.0
    return min(abs(math.remainder(direction - low, math.tau)), abs(math.remainder(direction - high, math.tau)))


def largest(thrusters: Sequence[ThrusterConfig], axis: int, free: Sequence[int] = ()) -> float:
    """Largest force or moment on `axis` (0 surge, 1 sway, 2 yaw), to its stronger side, with the others at zero but
    those that are `free`. An azimuth with stops less than 180° apart turns ahead or in reverse, it is not both at once.
    """
    return max(_sides(thrusters, axis, free))


@lru_cache(maxsize=64)
def sides_nm(thrusters: tuple[ThrusterConfig, ...]) -> tuple[float, float]:
    """Largest moments to port and to starboard with surge and sway at zero, as the share of them that limits keep."""
    port_nm, starboard_nm = _sides(thrusters, 2, ())
    return SHARE * port_nm, SHARE * starboard_nm


def _sides(thrusters: Sequence[ThrusterConfig], axis: int, free: Sequence[int]) -> tuple[float, float]:
    """As `largest`, to the negative and to the positive side."""
    ways = itertools.product(*(_ways(thruster) for thruster in thrusters))
    found = [_largest(thrusters, axis, free, each) for each in ways]
    return max(negative for negative, _ in found), max(positive for _, positive in found)


def _ways(thruster: ThrusterConfig) -> tuple[int, ...]:
    low, high = thruster.azimuth_min_rad, thruster.azimuth_max_rad
    narrow = thruster.kind == "azimuth" and low is not None and high is not None and 0.0 < high - low < math.pi
    return (1, -1) if narrow and thruster.min_n < 0.0 else (0,)


def _largest(
    thrusters: Sequence[ThrusterConfig], axis: int, free: Sequence[int], ways: Sequence[int]
) -> tuple[float, float]:
    """By duality: the least of the support function over the multipliers of the axes at zero, which is convex."""
    held = [other for other in range(3) if other != axis and other not in free]
    scale = 1.0 if axis == 2 else 1.0 / max(0.1, max(math.hypot(t.x_m, t.y_m) for t in thrusters))

    supports = [_support(t, way) for t, way in zip(thrusters, ways, strict=True)]

    def value(side: float, multipliers: Sequence[float]) -> float:
        weights = [0.0, 0.0, 0.0]
        weights[axis] = side
        for other, multiplier in zip(held, multipliers, strict=True):
            weights[other] = multiplier
        surge, sway, yaw = weights
        return sum(support(surge, sway, yaw) for support in supports)

    bounds = [20.0 * (scale if other == 2 else 1.0) * (1.0 if axis != 2 else _reach(thrusters)) for other in held]

    def to_side(side: float) -> float:
        if not held:
            return value(side, ())
        if len(held) == 1:
            return _least(lambda m: value(side, (m,)), bounds[0])
        return _least(lambda m: _least(lambda k: value(side, (m, k)), bounds[1]), bounds[0])

    return to_side(-1.0), to_side(1.0)


def turning_nm(thrusters: Sequence[ThrusterConfig], surge_n: float) -> float:
    """Largest moment to the weaker side beside `surge_n` ahead, with sway free, as a share of it that limits keep."""
    bound = 20.0 * _reach(thrusters)

    def to_side(side: float) -> float:
        return _least(lambda m: sum(support_n(t, m, 0.0, side) for t in thrusters) - m * surge_n / SHARE, bound)

    return SHARE * min(to_side(1.0), to_side(-1.0))


def _reach(thrusters: Sequence[ThrusterConfig]) -> float:
    return max(0.1, max(math.hypot(t.x_m, t.y_m) for t in thrusters))


def _least(function: Callable[[float], float], bound: float) -> float:
    """Least value of a convex function within ±bound, by golden sections."""
    low, high = -bound, bound
    a, b = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_a, at_b = function(a), function(b)
    for _ in range(_NARROWINGS):
        if at_a <= at_b:
            high, b, at_b = b, a, at_a
            a = high - _GOLDEN * (high - low)
            at_a = function(a)
        else:
            low, a, at_a = a, b, at_b
            b = low + _GOLDEN * (high - low)
            at_b = function(b)
    return min(at_a, at_b)


@lru_cache(maxsize=64)
def figures(thrusters: tuple[ThrusterConfig, ...]) -> tuple[Figure, ...]:
    """Limits of surge, sway and yaw. Sway is 0 for a boat that cannot push itself sideways without turning. Of a boat
    whose only thruster turns beside the middle some force sideways comes with that ahead."""
    ahead_n = largest(thrusters, 0)
    if ahead_n < _NONE * sum(t.max_n for t in thrusters):
        ahead_n = largest(thrusters, 0, free=(1,))
    pushing = without_blades(thrusters)
    sideways_n = 0.0 if any(t.kind in ("jet", "rudder", "sail") for t in pushing) else largest(pushing, 1)
    if sideways_n < _USEFUL_SHARE * ahead_n:
        sideways_n = 0.0
    # A screw that pushes ahead beside one that pushes astern has its race on its rudder; a single one does not.
    rudders = [t for t in thrusters if t.kind == "rudder"]
    turning = thrusters if len(rudders) > 1 else pushing
    most_nm = largest(pushing, 2) if sideways_n > 0.0 else largest(turning, 2, free=(1,))
    if most_nm < 1.0e-3 * ahead_n or steered_by_rudder(thrusters):
        most_nm = largest(thrusters, 2, free=(0, 1))
    if sideways_n == 0.0 and rudders and len(thrusters) > 1:
        most_nm = max(most_nm, _STEERING_SHARE * largest(rudders, 2, free=(0, 1)))
    source = "places and directions of the thrusters"
    return (
        Figure("limits.surge_n", SHARE * ahead_n, 1.5, "0.9 of the largest X with Y = N = 0", source),
        Figure("limits.sway_n", SHARE * sideways_n, 1.5, "0.9 of the largest Y with X = N = 0", source),
        Figure(
            "limits.yaw_nm",
            SHARE * most_nm,
            1.5,
            "0.9 of the largest N with X = 0, and Y = 0 where it can be; of a rudder or one outboard with full thrust, "
            "of rudders beside other thrusters with 0.35 of it if that is more",
            source,
        ),
    )


def lack(thrusters: Sequence[ThrusterConfig], found: Sequence[Figure]) -> Problem | None:
    """What keeps a boat with these limits from being steered at all; None where nothing does."""
    surge_n, _, yaw_nm = (figure.value for figure in found)
    least_n = _NONE * sum(thruster.max_n for thruster in thrusters)
    if surge_n < least_n:
        text = "no thrust goes ahead without turning the boat: check the signs of all y_m, or is a thruster missing?"
        return ("thruster", 0, "y_m"), text
    if yaw_nm < least_n * _reach(thrusters):
        text = "nothing turns the boat: it needs a thruster of kind 'azimuth' or 'rudder', or one more beside this one"
        return ("thruster", 0, "kind"), text
    return None
