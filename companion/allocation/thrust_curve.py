"""Force of a thruster as a function of its throttle, and its inverse: F = K u|u|, with one K ahead and one astern, a
dead band, and limits (ReVolt thesis 4.3)."""

from __future__ import annotations

import math

from companion.config.devices import ThrusterConfig


class ThrustCurve:
    """Bollard-pull curve of one thruster. Throttle −1…1, force in newtons. Remembers nothing."""

    __slots__ = ("_ahead_n", "_astern_n", "_dead_band", "max_n", "min_n")

    def __init__(self, thruster: ThrusterConfig) -> None:
        self._ahead_n = thruster.ahead_n
        self._astern_n = thruster.astern_n
        self._dead_band = thruster.dead_band
        self.max_n = min(thruster.max_n, thruster.ahead_n)
        self.min_n = max(thruster.min_n, -thruster.astern_n)

    def force_n(self, throttle: float) -> float:
        """The force in N at `throttle`; 0 inside the dead band."""
        if abs(throttle) < self._dead_band:
            return 0.0
        gain = self._ahead_n if throttle >= 0.0 else self._astern_n
        return min(self.max_n, max(self.min_n, gain * throttle * abs(throttle)))

    def throttle(self, force_n: float) -> float:
        """The throttle that gives `force_n`, held within the limits. A force too small for the dead band becomes 0 or
        the smallest possible one, whichever is nearer."""
        if force_n >= 0.0:
            throttle = math.sqrt(min(force_n, self.max_n) / self._ahead_n)
        else:
            throttle = -math.sqrt(max(force_n, self.min_n) / -self._astern_n)
        if abs(throttle) >= self._dead_band:
            return throttle
        if throttle * throttle < 0.5 * self._dead_band * self._dead_band:
            return 0.0
        return math.copysign(self._dead_band, throttle)
