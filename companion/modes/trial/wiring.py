"""Which thruster is which: the motion that each one caused, against the motion that each should cause.

A motion is (surge m/s, sway m/s, yaw rate rad/s × half a length): its direction tells thruster and sign, whatever the
strength. The yaw rate counts as much as the rest, since the gyro is the better sensor and tells port from starboard. A
wrong compass turns surge and sway of all of them alike; the yaw rate is the gyro's and stays.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from companion.allocation.geometry import column, thrusters_of
from companion.config.vessel import VesselConfig

Motion = tuple[float, float, float]

_MISPLACED = 0.3  # cosine below which a thruster pushes elsewhere, whatever the wiring
_SILENT = 0.12  # share of the expected motion below which a thruster does nothing
_AGREE = 0.75  # cosine between expected and observed motion from which they agree
_REVERSED_COST, _MOVED_COST, _COMPASS_COST, _ARM_COST = 0.35, 0.25, 0.4, 0.6
_MOST_ORDERS = 4  # thrusters up to which every order is tried
_MOST_WEIGHT = 6.0
_TURNS = 0.1  # share of the yaw part in a motion from which it tells something
_GUSTS = 2.0  # times the gusts that a yaw part must be to count
_MARGIN = 0.4  # by which another wiring must explain the motions better than that of the file
_COMPASS = (0.0, 90.0, 180.0, -90.0)


@dataclass(frozen=True, slots=True)
class Fault:
    """One mistake of wiring or mounting. `kind`: "swapped", "reversed", "misplaced", "silent" or "compass". `names`:
    the thrusters; `text`: for people, at most 50 characters with the mode's prefix."""

    kind: str
    names: tuple[str, ...]
    text: str
    angle_deg: float = 0.0


@dataclass(frozen=True, slots=True)
class _Guess:
    """`order[i]`: the thruster that answers to output i; `signs[i]`: −1 if it pushes the other way; `mirrored[i]`: its
    lever is on the other side of the boat's middle."""

    order: tuple[int, ...]
    signs: tuple[int, ...]
    mirrored: tuple[bool, ...]
    compass_deg: float


def expected_motions(config: VesselConfig, shares: Sequence[float], time_s: float) -> tuple[Motion, ...]:
    """The motion of each thruster after a push of `time_s` at that share of its largest thrust, by the file's model
    without damping."""
    hull = config.hull
    m23, m32 = hull.m23_kgm, hull.yaw_coupling_kgm
    determinant = hull.m22_kg * hull.m33_kgm2 - m23 * m32
    motions = []
    for thruster, share in zip(thrusters_of(config), shares, strict=True):
        force = share * thruster.max_n * time_s
        x, y, n = (force * part for part in column(thruster, thruster.rest_rad))
        sway = (hull.m33_kgm2 * y - m23 * n) / determinant
        turn = (hull.m22_kg * n - m32 * y) / determinant
        motions.append((x / hull.m11_kg, sway, 0.5 * config.length_m * turn))
    return tuple(motions)


def faults(
    config: VesselConfig,
    expected: Sequence[Motion],
    observed: Sequence[Motion | None],
    noise: float,
    gust: float = 0.0,
) -> tuple[Fault, ...]:
    """What is wrong; empty if all is as the file says. `observed`: None for a thruster that was not tried. `noise`: one
    sigma of a motion's parts, m/s; `gust`: of its yaw part by gusts. Yaw parts that drown in gusts do not count."""
    expected, observed = _above_gusts(expected, observed, gust)
    names = [thruster.name for thruster in config.thrusters]
    tried = [i for i, motion in enumerate(observed) if motion is not None]
    found: list[Fault] = []
    loud = []
    for i in tried:
        motion = observed[i]
        assert motion is not None
        if _size(motion) < max(_SILENT * _size(expected[i]), 2.0 * noise):
            if _size(expected[i]) > 6.0 * noise:
                found.append(Fault("silent", (names[i],), f"{names[i]} does not push"))
        else:
            loud.append(i)
    seen = {i: _required(observed[i]) for i in loud}
    if all(_cosine(seen[i], expected[i], noise) >= _AGREE for i in loud):
        return tuple(found)
    guess = _best(loud, expected, seen, noise)
    return (*found, *_named(names, loud, guess, expected, seen, noise))


def rudder_fault(name: str, turned: float, expected: float, noise_radps: float) -> Fault | None:
    """What is wrong with the rudder of a thruster: `turned`, the change of the yaw rate from a push with the blade to
    one side to one with it to the other side, against what it should be. `noise_radps`: one sigma of such a change."""
    if abs(expected) < 2.0 * noise_radps:
        return None  # gusts turn the boat more than this rudder does
    if abs(turned) < max(_SILENT * abs(expected), noise_radps):
        return Fault("silent", (name,), f"rudder of {name} does not steer")
    if turned * expected < 0.0:
        return Fault("reversed", (name,), f"rudder of {name} reversed")
    return None


def _above_gusts(
    expected: Sequence[Motion], observed: Sequence[Motion | None], gust: float
) -> tuple[list[Motion], list[Motion | None]]:
    """Both without the yaw parts of thrusters that should turn the boat by less than gusts do."""
    drowned = [abs(n) < _GUSTS * gust and math.hypot(x, y) > abs(n) for x, y, n in expected]
    pairs = zip(expected, observed, drowned, strict=True)
    kept = [((x, y, 0.0) if lost else (x, y, n), seen, lost) for (x, y, n), seen, lost in pairs]
    return [motion for motion, _, _ in kept], [
        (seen[0], seen[1], 0.0) if lost and seen is not None else seen for _, seen, lost in kept
    ]


def _named(
    names: Sequence[str],
    loud: Sequence[int],
    guess: _Guess,
    expected: Sequence[Motion],
    seen: dict[int, Motion],
    noise: float,
) -> list[Fault]:
    found: list[Fault] = []
    if guess.compass_deg:
        found.append(Fault("compass", (), f"compass {guess.compass_deg:+.0f} deg off", guess.compass_deg))
    for k, i in enumerate(loud):
        j = guess.order[k]
        if j > i and j in loud and guess.order[list(loud).index(j)] == i:
            found.append(Fault("swapped", (names[i], names[j]), f"{names[i]} and {names[j]} swapped"))
        elif j != i and not (j in loud and guess.order[list(loud).index(j)] == i):
            found.append(Fault("swapped", (names[i], names[j]), f"{names[i]} drives {names[j]}"))
        if guess.signs[k] < 0:
            found.append(Fault("reversed", (names[j],), f"{names[j]} reversed"))
        if guess.mirrored[k]:
            found.append(Fault("misplaced", (names[j],), f"{names[j]} at the other end"))
        elif not guess.compass_deg and _cosine(seen[i], _as_guessed(expected[j], guess, k), noise) < _MISPLACED:
            found.append(Fault("misplaced", (names[j],), f"{names[j]} misplaced"))
    return found


def _best(loud: Sequence[int], expected: Sequence[Motion], seen: dict[int, Motion], noise: float) -> _Guess:
    orders = itertools.permutations(loud) if len(loud) <= _MOST_ORDERS else iter([tuple(loud)])
    count = len(loud)
    best = _Guess(tuple(loud), (1,) * count, (False,) * count, 0.0)
    least = sum(1.0 - _cosine(seen[i], expected[i], noise) for i in loud) - _MARGIN
    for order, compass in itertools.product(orders, _COMPASS):
        guess = _Guess(tuple(order), (1,) * count, (False,) * count, compass)
        cost = _COMPASS_COST if compass else 0.0
        signs, mirrored = [], []
        for k, i in enumerate(loud):
            options = (
                (
                    (0.0 if sign > 0 else _REVERSED_COST)
                    + (_ARM_COST if mirror else 0.0)
                    + 1.0
                    - _cosine(seen[i], _changed(expected[order[k]], sign, mirror, compass), noise),
                    sign,
                    mirror,
                )
                for sign in (1, -1)
                for mirror in (False, True)
            )
            one, sign, mirror = min(options)
            cost += one + (_MOVED_COST if order[k] != i else 0.0)
            signs.append(sign)
            mirrored.append(mirror)
        if cost < least - 1e-9:
            best, least = replace(guess, signs=tuple(signs), mirrored=tuple(mirrored)), cost
    return best


def _as_guessed(motion: Motion, guess: _Guess, k: int) -> Motion:
    return _changed(motion, guess.signs[k], guess.mirrored[k], guess.compass_deg)


def _changed(motion: Motion, sign: int, mirrored: bool, compass_deg: float) -> Motion:
    """The motion as it is seen with a compass that reads `compass_deg` too much."""
    x, y, n = (sign * part for part in motion)
    c, s = math.cos(math.radians(compass_deg)), math.sin(math.radians(compass_deg))
    return c * x + s * y, c * y - s * x, -n if mirrored else n


def _required(motion: Motion | None) -> Motion:
    assert motion is not None
    return motion


def _size(motion: Motion) -> float:
    return math.hypot(*motion)


def _yaw_weight(expected: Motion) -> float:
    """Factor on the yaw part that makes it as large as the rest, for a thruster that turns the boat."""
    rest, yaw = math.hypot(*expected[:2]), abs(expected[2])
    return min(_MOST_WEIGHT, max(1.0, rest / yaw)) if yaw > _TURNS * rest else 1.0


def _cosine(seen: Motion, expected: Motion, noise: float) -> float:
    """Cosine of the angle between two motions, as large as the noise allows. 1 for one that should not be seen."""
    weight = _yaw_weight(expected)
    seen, expected = (*seen[:2], weight * seen[2]), (*expected[:2], weight * expected[2])
    size, other = _size(seen), _size(expected)
    if other < 1e-9 or size < 1e-9:
        return 1.0
    cosine = sum(a * b for a, b in zip(seen, expected, strict=True)) / (size * other)
    doubt = min(1.0, 2.0 * noise / size)
    return min(1.0, math.cos(max(0.0, math.acos(min(1.0, max(-1.0, cosine))) - math.asin(doubt))))
