"""Altitude of the boat's origin: a slow mean of what its receivers say."""

from __future__ import annotations

from companion.core.readings import GnssFix
from companion.nav.lever_arms import Vector

_SHARE = 0.05  # of each further fix


class Altitude:
    """Call `take` for each fix in use. Remembers the altitude (m), and whether a fix has told it."""

    def __init__(self, altitude_m: float) -> None:
        """`altitude_m`: until a fix tells it."""
        self.altitude_m = altitude_m
        self._known = False

    def take(self, fix: GnssFix, lever: Vector) -> None:
        """`lever`: of the antenna, from the origin. The first fix counts in full."""
        if fix.altitude_m is not None:
            share = _SHARE if self._known else 1.0
            self.altitude_m += share * (fix.altitude_m + lever[2] - self.altitude_m)
            self._known = True
