"""What the forces and rates of an inertial sensor add to the velocity along the boat's axes, each axis by itself. Slow
parts are left out, as gravity and biases are: this knows nothing of what a filter has made of them.

The axes are those of the beginning of a window: a boat that spins at 150 °/s turns by a quarter in half a second, and
what it feels meanwhile is added to its velocity in as many directions. The gyro of the sensor tells how it turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from companion.core.angles import wrap_pi
from companion.core.frames import ned_to_body
from companion.core.readings import Imu

AXES = ("x", "y", "roll", "pitch")
LEVEL_TIME_S = 5.0  # of the high-pass on force and tilt
_GRAVITY_MPS2 = 9.81
_GAP_S = 0.1
_MOST_TURN_RAD = 2.5  # in a window: a boat that turns on and on ends where it began, and shows no force that lasts
_SAME_TURN_RAD = 0.3  # by which gyro and estimate may differ


@dataclass(slots=True)
class Parts:
    """Of each axis: what it would add to the velocity along the axes that the boat had when the window began, and how
    far it has turned since."""

    forward: list[float] = field(default_factory=lambda: [0.0] * len(AXES))
    starboard: list[float] = field(default_factory=lambda: [0.0] * len(AXES))
    turned_rad: float = 0.0

    def gained(self, turned_rad: float = 0.0) -> tuple[float, float]:
        """Of all axes together, m/s, along the axes that the boat has after that turn."""
        return ned_to_body(sum(self.forward), sum(self.starboard), turned_rad)

    def reversed(self, turned_rad: float) -> list[tuple[float, float]]:
        """As `gained`, had each axis the other sign."""
        return [
            ned_to_body(sum(self.forward) - 2.0 * forward, sum(self.starboard) - 2.0 * starboard, turned_rad)
            for forward, starboard in zip(self.forward, self.starboard, strict=True)
        ]

    def tells(self, from_rad: float, to_rad: float) -> bool:
        """Whether the turn is small enough to tell directions in it, and that of the estimate's headings."""
        apart_rad = wrap_pi(to_rad - from_rad - self.turned_rad)
        return abs(self.turned_rad) <= _MOST_TURN_RAD and abs(apart_rad) <= _SAME_TURN_RAD


class Felt:
    """Call `sample` for each sample, in the order of time. Remembers means of force, tilt by the gyro, and the parts
    since `parts` was last set anew."""

    def __init__(self, imu: Imu) -> None:
        self._t_s = imu.t_s
        self._force = imu.x_mps2, imu.y_mps2
        self._tilt = 0.0, 0.0
        self.parts = Parts()

    def sample(self, imu: Imu) -> bool:
        """Take one sample; False after a gap: what came before means nothing."""
        dt_s = imu.t_s - self._t_s
        if not 0.0 < dt_s <= _GAP_S:
            return False
        self._t_s = imu.t_s
        share = dt_s / LEVEL_TIME_S
        fx, fy = self._force
        self._force = fx, fy = fx + share * (imu.x_mps2 - fx), fy + share * (imu.y_mps2 - fy)
        roll, pitch = self._tilt
        roll += dt_s * imu.roll_rate_radps - share * roll
        pitch += dt_s * imu.pitch_rate_radps - share * pitch
        self._tilt = roll, pitch
        parts = self.parts
        c, s = math.cos(parts.turned_rad), math.sin(parts.turned_rad)
        parts.turned_rad += dt_s * imu.yaw_rate_radps
        x, y = dt_s * (imu.x_mps2 - fx), dt_s * (imu.y_mps2 - fy)
        by_roll, by_pitch = dt_s * _GRAVITY_MPS2 * roll, -dt_s * _GRAVITY_MPS2 * pitch
        forward, starboard = parts.forward, parts.starboard
        forward[0] += c * x
        starboard[0] += s * x
        forward[1] -= s * y
        starboard[1] += c * y
        forward[2] -= s * by_roll
        starboard[2] += c * by_roll
        forward[3] += c * by_pitch
        starboard[3] += s * by_pitch
        return True
