"""What the forces and rates of an inertial sensor add to the velocity along the boat's axes, each axis by itself. Slow
parts are left out, as gravity and biases are: this knows nothing of what a filter has made of them."""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.core.readings import Imu

AXES = ("x", "y", "roll", "pitch")
LEVEL_TIME_S = 5.0  # of the high-pass on force and tilt
_GRAVITY_MPS2 = 9.81
_GAP_S = 0.1


@dataclass(slots=True)
class Parts:
    """Of each axis: what it would add to the velocity along the boat's axes, in the present window."""

    forward: list[float] = field(default_factory=lambda: [0.0] * len(AXES))
    starboard: list[float] = field(default_factory=lambda: [0.0] * len(AXES))

    def gained(self) -> tuple[float, float]:
        """Of all axes together, m/s."""
        return sum(self.forward), sum(self.starboard)


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
        forward, starboard = self.parts.forward, self.parts.starboard
        forward[0] += dt_s * (imu.x_mps2 - fx)
        starboard[1] += dt_s * (imu.y_mps2 - fy)
        starboard[2] += dt_s * _GRAVITY_MPS2 * roll
        forward[3] -= dt_s * _GRAVITY_MPS2 * pitch
        return True
