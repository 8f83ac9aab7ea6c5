"""Dead reckoning aided by the hull model. Inertial sensors alone drift with the square of time or faster; the velocity
error of the model does not grow.

While neither position nor velocity is measured, the modelled velocity over ground (from thrust, damping and the last
estimate of the current) is fused. Its error is correlated over several seconds, so each value gets a larger sigma. Part
of it lasts, as where the current has turned, or the wind takes the boat on another side. That part builds up after the
last measurement, and takes the position further off each second.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.core.frames import body_to_ned
from companion.nav.current import CurrentObserver
from companion.nav.solution import Motion

_SILENT_S = 0.5  # without a measurement, before the model's velocity is used
_PERIOD_S = 1.0
_CORRELATION_S = 6.0  # how long an error of the model's velocity lasts
_MISSING_S = 6.0  # over which the model's error is averaged: a boat in waves swings about it
# Uncertain share of a change of velocity through the water (the steady error turns with the hull), and the part of it
# that lasts: on the next heading the hull turns it on.
_CHANGE_SHARE, _LASTING_CHANGE_SHARE = 0.15, 0.05
# Of the model's sigma, and the time until that much of it lasts; before, with time to the power of 1.5.
_LASTING_SHARE, _BUILT_UP_S = 0.7, 60.0
_LARGEST_SIGMA_MPS = 0.5


class ModelledVelocity(NamedTuple):
    """A velocity over ground to fuse, `sigma_mps` as it should be fused. `variance_m2`: on each axis of the position,
    by the error that lasts, since the last one."""

    north_mps: float
    east_mps: float
    sigma_mps: float
    variance_m2: float


class VelocityAid:
    """Call `update` every tick.

    Remembers the model's mean velocity error up to the last measurement and the time of which that is a mean, the
    velocity through the water then, when a modelled velocity was last fused, and how far the error that lasts has taken
    the position off, one sigma.
    """

    def __init__(self, observer: CurrentObserver) -> None:
        self._observer = observer
        self._missing: tuple[float, float] | None = None
        self._mean_of_s = 0.0
        self._water = (0.0, 0.0)
        self._measured_s = self._last_s = -math.inf
        self._astray_m = 0.0

    def update(self, now_s: float, measured: bool, motion: Motion) -> ModelledVelocity | None:
        """What to fuse now, or None. `measured`: whether a position or velocity arrived
        lately. Call it after the observer's `update` for `now_s`."""
        yaw_rad = motion.attitude[2]
        north, east, sigma = self._observer.over_ground(yaw_rad)
        water = body_to_ned(*self._observer.through_water, yaw_rad)
        if measured:
            self._learn(now_s, motion.velocity[0] - north, motion.velocity[1] - east)
            self._water, self._measured_s, self._astray_m = water, now_s, 0.0
            return None
        known = self._missing is not None and self._observer.can_predict(now_s)
        if not known or now_s - self._measured_s < _SILENT_S or now_s - self._last_s < _PERIOD_S - 1e-6:
            return None
        assert self._missing is not None
        changed = math.hypot(water[0] - self._water[0], water[1] - self._water[1])
        lasting_mps = math.hypot(sigma, _LASTING_CHANGE_SHARE * changed)
        sigma = math.hypot(sigma, _CHANGE_SHARE * changed)
        if not sigma <= _LARGEST_SIGMA_MPS:
            return None
        variance_m2 = self._go_astray(lasting_mps, now_s)
        self._last_s = now_s
        north, east = north + self._missing[0], east + self._missing[1]
        return ModelledVelocity(north, east, sigma * math.sqrt(_CORRELATION_S / _PERIOD_S), variance_m2)

    def _go_astray(self, sigma_mps: float, now_s: float) -> float:
        """By what the variance of the position has grown since the last modelled velocity, m²."""
        before_m, passed_s = self._astray_m, now_s - max(self._last_s, self._measured_s)
        built_up = min((now_s - self._measured_s) / _BUILT_UP_S, 1.0)
        self._astray_m += _LASTING_SHARE * built_up * math.sqrt(built_up) * sigma_mps * passed_s
        return self._astray_m * self._astray_m - before_m * before_m

    def _learn(self, now_s: float, north_mps: float, east_mps: float) -> None:
        """Take the model's error of now into its mean. A silence begins the mean anew."""
        passed_s = now_s - self._measured_s
        if self._missing is None or passed_s > _SILENT_S:
            self._missing, self._mean_of_s = (north_mps, east_mps), 0.0
            return
        self._mean_of_s = min(self._mean_of_s + passed_s, _MISSING_S)
        share = passed_s / self._mean_of_s if self._mean_of_s > 0.0 else 1.0
        north, east = self._missing
        self._missing = north + share * (north_mps - north), east + share * (east_mps - east)
