"""Dead reckoning helped by the hull's model: inertial sensors alone drift with the square of time and more, a model's error of speed does not.

While neither position nor velocity is measured, the velocity over ground that thrust, damping and the current learnt so far make is weighed in.
Its error lasts: several seconds of it are worth no more than one measurement, and it is weighed as that.
"""

from __future__ import annotations

import math

from companion.core.frames import body_to_ned
from companion.nav.current import CurrentObserver
from companion.nav.solution import Motion

_SILENT_S = 0.5  # without velocity, before the model's is asked
_PERIOD_S = 1.0
_CORRELATION_S = 6.0  # how long an error of the model's velocity lasts
_CHANGE_SHARE = 0.15  # of a change of velocity through the water, that is doubted: the steady error turns with the hull
_LARGEST_SIGMA_MPS = 0.5


class VelocityAid:
    """`update` every tick → (north_mps, east_mps, sigma_mps) to weigh in now, or None.

    Remembers what the model's velocity lacked when it was last measured, the velocity through the water then, and when it was last weighed in.
    """

    def __init__(self, observer: CurrentObserver) -> None:
        self._observer = observer
        self._missing: tuple[float, float] | None = None
        self._water = (0.0, 0.0)
        self._measured_s = self._last_s = -math.inf

    def update(self, now_s: float, measured: bool, motion: Motion) -> tuple[float, float, float] | None:
        """`measured`: whether position or velocity have come in lately. The observer has been brought up to `now_s`."""
        yaw_rad = motion.attitude[2]
        north, east, sigma = self._observer.over_ground(yaw_rad)
        water = body_to_ned(*self._observer.through_water, yaw_rad)
        if measured:
            self._missing = (motion.velocity[0] - north, motion.velocity[1] - east)
            self._water, self._measured_s = water, now_s
            return None
        known = self._missing is not None and self._observer.knows(now_s)
        if not known or now_s - self._measured_s < _SILENT_S or now_s - self._last_s < _PERIOD_S - 1e-6:
            return None
        assert self._missing is not None
        changed = math.hypot(water[0] - self._water[0], water[1] - self._water[1])
        sigma = math.hypot(sigma, _CHANGE_SHARE * changed)
        if not sigma <= _LARGEST_SIGMA_MPS:
            return None
        self._last_s = now_s
        return north + self._missing[0], east + self._missing[1], sigma * math.sqrt(_CORRELATION_S / _PERIOD_S)
