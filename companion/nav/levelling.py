"""Roll and pitch of a boat by the specific force alone, before a filter runs, and how far they may be off."""

from __future__ import annotations

import math

from companion.nav.lever_arms import ZERO, Vector

TILT_SIGMA_RAD = math.radians(2.0)  # at rest
_AT_REST_MPS, _UNDER_WAY_MPS = 0.5, 2.0  # up to the first speed the tilt is as good as at rest, from the second on not
_UNKNOWN_MPS2 = 1.0  # acceleration of a boat under way that nothing tells while the filter does not run
_GRAVITY_MPS2 = 9.81


def averaged(mean: Vector, force: Vector, share: float) -> Vector:
    """The mean of specific forces, moved by that share towards the newest one."""
    return (
        mean[0] + share * (force[0] - mean[0]),
        mean[1] + share * (force[1] - mean[1]),
        mean[2] + share * (force[2] - mean[2]),
    )


def swung(mean: Vector, rates_radps: Vector, dt_s: float) -> Vector:
    """A mean force in the axes of a boat that has rolled and pitched for `dt_s` since: −(ω × f) dt. Its turn is left
    out, since what that adds to the force turns with the boat."""
    (x, y, z), (p, q, _) = mean, rates_radps
    return x - dt_s * q * z, y + dt_s * p * z, z + dt_s * (q * x - p * y)


def tilt_by(force: Vector, sideways_mps2: float = 0.0) -> tuple[float, float]:
    """(roll_rad, pitch_rad) by a specific force in body axes (m/s²) of a boat that accelerates by `sideways_mps2` to
    starboard, as in a turn."""
    x, y, z = force
    y -= sideways_mps2
    return math.atan2(-y, -z), math.atan2(x, math.hypot(y, z))


def unfelt_tilt_rad(surge_mps: float, turn_radps: float) -> float:
    """One sigma of that tilt by what nobody tells: 0 at rest, where the force is gravity. Under way the boat gathers
    and loses speed, and half of what a turn takes off may be wrong."""
    under_way = min(abs(surge_mps) / _UNDER_WAY_MPS, 1.0) if abs(surge_mps) >= _AT_REST_MPS else 0.0
    unknown_mps2 = math.hypot(under_way * _UNKNOWN_MPS2, 0.5 * under_way * surge_mps * turn_radps)
    return unknown_mps2 / _GRAVITY_MPS2


class Levelling:
    """Roll and pitch from the direction of gravity: the specific force, low-pass filtered over 1 s. The gyro carries
    the mean along: a boat that rolls is elsewhere now.

    Remembers the means of force and rate of turn, and since when samples have come without a gap.
    """

    _TIME_S = 1.0
    _GAP_S = 0.5

    def __init__(self) -> None:
        self._since_s = self._last_s = -math.inf
        self._mean: Vector = (0.0, 0.0, 0.0)
        self._turn_radps = 0.0

    def update(self, t_s: float, force: Vector, rates_radps: Vector = ZERO) -> None:
        """Take one specific force (m/s²) and the rates, in body axes."""
        if not 0.0 <= t_s - self._last_s <= self._GAP_S:
            self._since_s = t_s
            self._mean, self._turn_radps = force, rates_radps[2]
        if t_s > self._since_s:
            dt_s = t_s - self._last_s
            weight = 1.0 - math.exp(-dt_s / self._TIME_S)
            self._mean = averaged(swung(self._mean, rates_radps, dt_s), force, weight)
            self._turn_radps += weight * (rates_radps[2] - self._turn_radps)
        self._last_s = t_s

    def tilt(self, surge_mps: float = 0.0) -> tuple[float, float] | None:
        """(roll_rad, pitch_rad) of a boat that goes ahead at that speed: in a turn the force is not gravity alone. None
        in the first second."""
        if self._last_s - self._since_s < self._TIME_S or math.isinf(self._last_s):
            return None
        return tilt_by(self._mean, surge_mps * self._turn_radps)

    def sigma_rad(self, surge_mps: float) -> float:
        """One sigma of that tilt. At rest the force is gravity; under way the boat gathers and loses speed, and half of
        what a turn takes off may be wrong."""
        return math.hypot(TILT_SIGMA_RAD, unfelt_tilt_rad(surge_mps, self._turn_radps))
