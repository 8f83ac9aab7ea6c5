"""What the boat can still do with the thrusters that work."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Sequence

from companion.config.devices import ThrusterConfig

_SHARE = 0.2  # share of a force, or of a lever, from which it counts


def lost_motions(thrusters: Sequence[ThrusterConfig], failed: Collection[int]) -> tuple[str, ...]:
    """Which of "thrust", "way ahead", "steering" the boat loses with the thrusters at the indices `failed`.

    A fixed thruster counts by its direction, an azimuth thruster in every direction. Steering needs a lever about the
    boat's origin.
    """
    if not failed:
        return ()
    left = [thruster for i, thruster in enumerate(thrusters) if i not in failed]
    if not left:
        return ("thrust",)
    lost = []
    if not any(t.turns or abs(math.cos(t.azimuth_rad)) > _SHARE for t in left):
        lost.append("way ahead")
    if not any(_steers(t) for t in left):
        lost.append("steering")
    return tuple(lost)


def keeps_straight(thrusters: Sequence[ThrusterConfig], failed: Collection[int]) -> bool:
    """Whether a boat that has lost the thrusters at the indices `failed` can still go ahead without turning: one fixed
    thruster off the centre line drives it in circles. True while none has failed."""
    left = [thruster for i, thruster in enumerate(thrusters) if i not in failed]
    if not failed or any(t.turns for t in left):
        return True
    pushes = [(math.cos(t.azimuth_rad), _moment_m(t)) for t in left]
    circles = any(_steers(t) and abs(math.cos(t.azimuth_rad)) > _SHARE for t in left)
    return not circles or any(_independent(one, other) for one, other in itertools.combinations(pushes, 2))


def _steers(thruster: ThrusterConfig) -> bool:
    lever_m = math.hypot(thruster.x_m, thruster.y_m)
    if thruster.turns:
        return lever_m > 0.0
    return abs(_moment_m(thruster)) > _SHARE * lever_m > 0.0


def _moment_m(thruster: ThrusterConfig) -> float:
    """Yaw moment of a fixed thruster for each newton, positive to starboard."""
    return thruster.x_m * math.sin(thruster.azimuth_rad) - thruster.y_m * math.cos(thruster.azimuth_rad)


def _independent(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether two thrusters give force ahead (first) and moment (second) apart from each other."""
    area = abs(one[0] * other[1] - other[0] * one[1])
    return area > _SHARE * math.hypot(*one) * math.hypot(*other)
