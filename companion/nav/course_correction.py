"""Slow correction of a heading with a lasting error, to the course over ground.

Source: RescueRunner thesis (Hallhagen & Persson 2016), sections 3.6.4 and 6.3.5.1: ψ = ψ_q + ψ_corr, ψ_corr ← ψ_corr +
α (ψ_GNSS − ψ) at 200 Hz with α = 1e-4, a time constant of 50 s, after 10 s faster than 5 m/s.
"""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi

_SPEED_MPS = 5.0
_AFTER_S = 10.0
_COURSE_AGE_S = 1.0
_STRAIGHT_RADPS = math.radians(3.0)
_STRAIGHT_S = 2.0


class CourseCorrection:
    """Heading and course over ground → correction of the heading. Remembers the course, and since when the boat has
    been fast and on a straight course."""

    def __init__(self) -> None:
        self._course_rad = self._speed_mps = 0.0
        self._course_s = -math.inf
        self._slow_s = self._turning_s = math.inf
        self._t_s = math.inf

    def velocity(self, t_s: float, north_mps: float, east_mps: float) -> None:
        """Take a velocity over ground."""
        if self._slow_s == math.inf or t_s - self._course_s > _COURSE_AGE_S:
            self._slow_s = t_s
        self._course_s, self._speed_mps = t_s, math.hypot(north_mps, east_mps)
        self._course_rad = math.atan2(east_mps, north_mps)
        if self._speed_mps <= _SPEED_MPS:
            self._slow_s = t_s

    def update(
        self, t_s: float, yaw_rad: float, yaw_rate_radps: float, time_s: float, drift_mps: float | None
    ) -> float:
        """The correction in rad since the last call, positive clockwise.

        `time_s`: time constant; 0: no correction. `drift_mps`: largest sideways drift by wind and current; the part of
        the error that drift explains is not corrected, and nothing is corrected while the boat turns and slips. None:
        the thesis's rule, without both exceptions.
        """
        dt = min(max(t_s - self._t_s, 0.0), 0.2)
        self._t_s = t_s
        if abs(yaw_rate_radps) > _STRAIGHT_RADPS or self._turning_s == math.inf:
            self._turning_s = t_s
        if time_s <= 0.0 or t_s - self._course_s > _COURSE_AGE_S or not t_s - self._slow_s > _AFTER_S:
            return 0.0
        error = wrap_pi(self._course_rad - yaw_rad)
        if drift_mps is not None:
            if not t_s - self._turning_s > _STRAIGHT_S:
                return 0.0
            explained = math.asin(min(drift_mps / self._speed_mps, 1.0))
            error = math.copysign(max(abs(error) - explained, 0.0), error)
        return dt / time_s * error
