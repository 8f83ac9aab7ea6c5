"""Sail trim: from the apparent wind and the drive that is wanted to the angle of the boom.

Lift across the wind and drag along it by the angle between wind and boom, for a soft sail of a usual camber: rounded
figures of the order of what wind tunnels show (Marchaj 1979). A vessel's file scales them for its own sail.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import NamedTuple

from companion.config.hull import AIR_KGPM3
from companion.config.sail import SailConfig

_POLAR = (  # degrees off the wind, C_L, C_D
    (0.0, 0.0, 0.1),
    (5.0, 0.6, 0.1),
    (10.0, 1.0, 0.12),
    (15.0, 1.3, 0.2),
    (20.0, 1.3, 0.35),
    (30.0, 1.1, 0.6),
    (40.0, 1.0, 0.75),
    (50.0, 0.9, 0.9),
    (60.0, 0.7, 1.0),
    (70.0, 0.5, 1.1),
    (80.0, 0.25, 1.15),
    (90.0, 0.0, 1.17),
    (180.0, 0.0, 0.1),
)
_ANGLES = tuple(math.radians(row[0]) for row in _POLAR)
_STEP_RAD = math.radians(2.5)  # of the booms that are compared
STILL_MPS = 0.1  # of apparent wind: less drives nothing


class SailForce(NamedTuple):
    """Drive ahead, force to leeward, and heel to leeward."""

    drive_n: float
    leeward_n: float
    heel_rad: float


def sail_force(sail: SailConfig, lift: float, drag: float, off_rad: float, wind_mps: float) -> SailForce:
    """The force of a sail or a wing by its coefficients of lift and drag, in an apparent wind from `off_rad` (0…π) off
    the bow, and the heel at which the boat stands up to it."""
    pressure = 0.5 * AIR_KGPM3 * sail.area_m2 * sail.force_scale * wind_mps * wind_mps
    s, c = math.sin(off_rad), math.cos(off_rad)
    drive_n, upright_n = pressure * (lift * s - drag * c), pressure * (lift * c + drag * s)
    heel_rad = math.atan2(sail.height_m * upright_n, sail.righting_nm)
    return SailForce(drive_n, upright_n * math.cos(heel_rad), heel_rad)


class SailTrim:
    """`best(…)` → the boom; `force(…)` → what a boom gives. Remembers nothing."""

    __slots__ = ("_sail",)

    def __init__(self, sail: SailConfig) -> None:
        self._sail = sail

    def setting_rad(self, throttle: float, side: float) -> float:
        """The boom at a sheet 0…1, on either side."""
        del side  # the wind carries the boom to leeward
        return self._sail.boom_rad(throttle)

    def throttle(self, setting_rad: float, side: float) -> float:
        """The sheet for a boom, on either side."""
        del side
        return self._sail.sheet(setting_rad)

    def force(self, boom_rad: float, off_rad: float, wind_mps: float) -> SailForce:
        """The force of the sail with a sheet that lets the boom out to `boom_rad`, in an apparent wind from `off_rad`
        (0…π) off the bow."""
        lift, drag = _coefficients(off_rad - min(boom_rad, off_rad))
        return sail_force(self._sail, lift, drag, off_rad, wind_mps)

    def best(self, wanted_n: float, off_rad: float, wind_mps: float, heel_max_rad: float) -> float:
        """The boom with the most drive up to `wanted_n` that heels the boat by at most `heel_max_rad`. To give less, or
        to heel less, the sheet is eased, never hauled in further."""
        sail = self._sail
        widest = min(sail.boom_max_rad, max(off_rad, sail.boom_min_rad))
        if wanted_n <= 0.0 or wind_mps < STILL_MPS:
            return sail.boom_max_rad
        steps = max(1, round((widest - sail.boom_min_rad) / _STEP_RAD))
        booms = [sail.boom_min_rad + (widest - sail.boom_min_rad) * k / steps for k in range(steps + 1)]
        forces = [self.force(boom, off_rad, wind_mps) for boom in booms]
        first = max(range(steps + 1), key=lambda k: forces[k].drive_n)
        for k in range(first, steps + 1):
            if forces[k].drive_n <= wanted_n and forces[k].heel_rad <= heel_max_rad:
                return booms[k]
        return sail.boom_max_rad


def _coefficients(angle_rad: float) -> tuple[float, float]:
    i = min(len(_POLAR) - 2, max(0, bisect_right(_ANGLES, angle_rad) - 1))
    share = (angle_rad - _ANGLES[i]) / (_ANGLES[i + 1] - _ANGLES[i])
    (_, low_lift, low_drag), (_, high_lift, high_drag) = _POLAR[i], _POLAR[i + 1]
    return low_lift + share * (high_lift - low_lift), low_drag + share * (high_drag - low_drag)
