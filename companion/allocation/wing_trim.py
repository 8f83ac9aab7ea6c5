"""Trim of a wing sail: from the apparent wind and the drive that is wanted to the wing's angle to the wind.

A rigid wing turns freely on its mast, and its tail sets that angle (Elkaim 2006, the Atlantis). So no boom is in the
way, the wing gives the same force on every course, and with the tail amidships it lies in the wind and gives drag
alone. Up to the stall lift and drag are those of Prandtl's lifting line: C_L = 2π Λ/(Λ + 2) α and C_D = C_D0 +
C_L²/(0.9 π Λ).
"""

from __future__ import annotations

import math

from companion.allocation.sail_trim import STILL_MPS, SailForce, sail_force
from companion.config.sail import SailConfig

_FLAT_DRAG = 0.03  # of wing, mast and tail
_SPAN_EFFICIENCY = 0.9
_STEP_RAD = math.radians(0.5)  # of the angles that are compared


class WingTrim:
    """As `SailTrim`, with the angle of the wing to the wind in the place of the boom's: positive where it drives to
    leeward of the present wind. Remembers nothing."""

    __slots__ = ("_most_rad", "_room", "_sail", "_slope")

    def __init__(self, sail: SailConfig, attack_max_rad: float) -> None:
        self._sail, self._most_rad = sail, attack_max_rad
        self._slope = math.tau * sail.aspect / (sail.aspect + 2.0)
        self._room = _SPAN_EFFICIENCY * math.pi * sail.aspect

    def setting_rad(self, throttle: float, side: float) -> float:
        """The angle at a throttle, with leeward to starboard (`side` 1) or to port (−1)."""
        return side * throttle * self._most_rad

    def throttle(self, setting_rad: float, side: float) -> float:
        """The throttle for an angle."""
        return side * setting_rad / self._most_rad

    def force(self, setting_rad: float, off_rad: float, wind_mps: float) -> SailForce:
        """The force of the wing at that angle, in an apparent wind from `off_rad` (0…π) off the bow."""
        lift = self._slope * setting_rad
        return sail_force(self._sail, lift, _FLAT_DRAG + lift * lift / self._room, off_rad, wind_mps)

    def best(self, wanted_n: float, off_rad: float, wind_mps: float, heel_max_rad: float) -> float:
        """The angle with the most drive up to `wanted_n` that heels the boat by at most `heel_max_rad` to either
        side."""
        if wanted_n <= 0.0 or wind_mps < STILL_MPS:
            return 0.0
        steps = round(self._most_rad / _STEP_RAD)
        angles = [self._most_rad * k / steps for k in range(steps + 1)]
        forces = [self.force(angle, off_rad, wind_mps) for angle in angles]
        first = max(range(steps + 1), key=lambda k: forces[k].drive_n)
        for k in range(first, 0, -1):
            if forces[k].drive_n <= wanted_n and abs(forces[k].heel_rad) <= heel_max_rad:
                return angles[k]
        return 0.0
