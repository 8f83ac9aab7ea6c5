"""Wrapping of angles, in radians."""

from __future__ import annotations

import math

TWO_PI = 2.0 * math.pi


def wrap_pi(angle_rad: float) -> float:
    """The same direction in (−π, π]."""
    if -math.pi < angle_rad <= math.pi:
        return angle_rad
    wrapped = math.fmod(angle_rad, TWO_PI)
    if wrapped > math.pi:
        return wrapped - TWO_PI
    if wrapped <= -math.pi:
        return wrapped + TWO_PI
    return wrapped


def wrap_two_pi(angle_rad: float) -> float:
    """The same direction in [0, 2π)."""
    wrapped = math.fmod(angle_rad, TWO_PI)
    if wrapped < 0.0:
        wrapped += TWO_PI
    return wrapped if wrapped < TWO_PI else 0.0


def nearest_turn(angle_rad: float, near_rad: float) -> float:
    """The same direction plus whole turns, so that it is nearest to `near_rad`."""
    return near_rad + wrap_pi(angle_rad - near_rad)
