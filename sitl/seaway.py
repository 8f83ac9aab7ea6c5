"""Chop of the wind as a small boat under way meets it, with the wakes of other boats: heave, roll, pitch, and forces.

It is what a plant with `seaway` feels where no sea state is set; `sitl/sea.py` has the sea states.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.core.angles import TWO_PI
from sitl.environment import Waves, WindModel
from sitl.hull import Hull
from sitl.noise import stream
from sitl.wake import Wake
from sitl.wake_feel import ARM_SHARE, WakeFeel

_GRAVITY_MPS2 = 9.81
_CHOP_M_PER_MPS = 0.01  # wave height for each m/s of wind
_SPREAD_RAD = math.radians(25.0)
_COUNT = 5
_HEAVE_RADPS = 5.0  # frequency of encounter above which the hull no longer follows the surface
_TILT_SHARE = 0.6  # share of the surface's slope that the hull follows


class Seaway(Waves):
    """As `Waves`, at the boat's own place and heading, and so at the frequency of encounter.

    Five components about the period 4.2 √H s, within ±25° of the wind. The surface slope s pushes the hull with −m g s,
    half at the bow and half at the stern, which turns it. Heave follows the surface up to a frequency of encounter.
    Short waves act less on a long hull. Rates of roll and pitch are the difference between two steps, also while the
    hull turns.
    """

    __slots__ = ("_arm_m", "_components", "_hull", "_mass_kg", "_t_s", "_turn_nm", "_wakes", "_x_n", "_y_n")

    def __init__(
        self,
        wind: WindModel,
        length_m: float,
        seed: int,
        hull: Hull,
        mass_kg: float,
        wakes: Sequence[Wake] = (),
    ) -> None:
        self._hull, self._mass_kg = hull, mass_kg
        self._wakes = WakeFeel(wakes, length_m)
        self._arm_m = ARM_SHARE * length_m
        self._t_s = -1.0
        self.roll_rad = self.pitch_rad = 0.0
        self._x_n = self._y_n = self._turn_nm = 0.0
        rng = stream(seed, "seaway")
        height_m = _CHOP_M_PER_MPS * wind.mean_mps
        components = []
        for i in range(_COUNT if height_m > 0.0 else 0):
            period_s = max(1.2, 4.2 * math.sqrt(height_m)) * (0.8 + 0.1 * i)
            omega = TWO_PI / period_s
            number = omega * omega / _GRAVITY_MPS2
            towards = wind.mean_from_rad + math.pi + rng.uniform(-_SPREAD_RAD, _SPREAD_RAD)
            amplitude = 0.25 * height_m * math.sqrt(2.0 / _COUNT) / (1.0 + (length_m * number / TWO_PI) ** 2)
            components.append(
                (amplitude, omega, number * math.cos(towards), number * math.sin(towards), rng.uniform(0.0, TWO_PI))
            )
        self._components = tuple(components)
        super().__init__(wind, seed)

    def update(self, t_s: float) -> None:
        """Compute attitude, rates, heave and forces at `t_s`."""
        hull, dt_s = self._hull, t_s - self._t_s
        self._wakes.update(hull, t_s, dt_s)
        bow_x, bow_y, stern_x, stern_y = self._wakes.felt
        ahead, across = 0.5 * (bow_x + stern_x), 0.5 * (bow_y + stern_y)
        heave_mps2 = 0.0
        twist = 0.5 * (bow_y - stern_y)
        c, s = math.cos(hull.yaw_rad), math.sin(hull.yaw_rad)
        for amplitude, omega, north, east, phase in self._components:
            x, y = c * north + s * east, c * east - s * north  # wave number in body axes
            met = omega - north * hull.north_mps - east * hull.east_mps
            angle = omega * t_s - north * hull.north_m - east * hull.east_m + phase
            rise, fall = amplitude * math.cos(angle), amplitude * math.sin(angle)
            ahead, across = ahead + x * fall, across + y * fall
            twist -= y * x * rise * self._arm_m
            heave_mps2 += rise * met * met / (1.0 + (met / _HEAVE_RADPS) ** 2) ** 2
        weight_n = self._mass_kg * _GRAVITY_MPS2
        self._x_n, self._y_n, self._turn_nm = -weight_n * ahead, -weight_n * across, -weight_n * twist * self._arm_m
        self.heave_mps2 = heave_mps2
        roll, pitch = -_TILT_SHARE * across, _TILT_SHARE * ahead
        begun = self._t_s >= 0.0 and dt_s > 0.0
        self.roll_rate_radps = (roll - self.roll_rad) / dt_s if begun else 0.0
        self.pitch_rate_radps = (pitch - self.pitch_rad) / dt_s if begun else 0.0
        self.roll_rad, self.pitch_rad, self._t_s = roll, pitch, t_s

    def force(self) -> tuple[float, float, float]:
        """(surge_n, sway_n, yaw_nm) at the last update."""
        return self._x_n, self._y_n, self._turn_nm
