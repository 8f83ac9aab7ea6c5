"""Choice of readings: plausible ones, of the source in use."""

from __future__ import annotations

import math
from collections.abc import Mapping

from companion.core.readings import FixType, GroundVelocity, Heading, Imu, MagneticField, Reading, Wind

REACCEPTANCE_S = 5.0
_UNKNOWN_TIMEOUT_S = 2.0


_LARGEST_FORCE_MPS2 = 160.0  # sixteen g
_LARGEST_RATE_RADPS = 35.0
_LARGEST_SPEED_MPS = 100.0
_EARLIEST_S, _LATEST_S = -30.0, 1.0  # against now: a time stamp outside is invalid


def plausible(reading: Reading, now_s: float) -> bool:
    """Whether a reading can be a measurement: recent, finite and within physical limits. Others never reach the
    estimate. (Comparisons with NaN are false.)"""
    if not now_s + _EARLIEST_S <= reading.t_s <= now_s + _LATEST_S:
        return False
    if isinstance(reading, Imu):
        force = math.hypot(reading.x_mps2, reading.y_mps2, reading.z_mps2)
        rate = math.hypot(reading.roll_rate_radps, reading.pitch_rate_radps, reading.yaw_rate_radps)
        return force <= _LARGEST_FORCE_MPS2 and rate <= _LARGEST_RATE_RADPS
    if isinstance(reading, GroundVelocity):
        return math.hypot(reading.north_mps, reading.east_mps) <= _LARGEST_SPEED_MPS
    if isinstance(reading, Heading):
        return math.isfinite(reading.yaw_rad)
    if isinstance(reading, MagneticField):
        return math.isfinite(reading.x + reading.y + reading.z)
    if isinstance(reading, Wind):
        return 0.0 <= reading.speed_mps <= _LARGEST_SPEED_MPS and math.isfinite(reading.from_rad)
    return True


class SourceSelector:
    """Readings of one kind from several sources → the one source in use.

    The one in use is the live source of the highest grade, and among equals the first in the vessel's file. When it
    times out or reports a bad reading, the next takes over at once. A better source returns only after it has been
    good, at that grade, without a break for `REACCEPTANCE_S`. Remembers for each source its grade, when it was last
    good, and since when without a break.
    """

    def __init__(self, timeouts_s: Mapping[str, float]) -> None:
        self._timeouts_s = dict(timeouts_s)
        self._order = list(timeouts_s)
        self._last_s: dict[str, float] = {}
        self._since_s: dict[str, float] = {}
        self._grades: dict[str, int] = {}
        self._current: str | None = None

    @property
    def current(self) -> str | None:
        """The source in use; None before the first good reading."""
        return self._current

    def offer(self, source: str, t_s: float, good: bool = True, grade: int = 0) -> bool:
        """Whether to use this reading of `source`, valid at `t_s`. A reading that is not `good` is never used."""
        if source not in self._timeouts_s:
            self._timeouts_s[source] = _UNKNOWN_TIMEOUT_S
            self._order.append(source)
        if not good:
            self._last_s.pop(source, None)
            return False
        if not self._alive(source, t_s) or grade > self._grades[source]:
            self._since_s[source] = t_s
        self._last_s[source], self._grades[source] = t_s, grade
        if source != self._current and self._better(source, t_s):
            self._current = source
        return source == self._current

    def _alive(self, source: str, t_s: float) -> bool:
        last_s = self._last_s.get(source)
        return last_s is not None and t_s - last_s <= self._timeouts_s[source]

    def _rank(self, source: str) -> tuple[int, int]:
        """Sort key: the best source has the smallest."""
        return -self._grades.get(source, 0), self._order.index(source)

    def _better(self, source: str, t_s: float) -> bool:
        current = self._current
        if current is None or not self._alive(current, t_s):
            return not any(self._alive(rival, t_s) and self._rank(rival) < self._rank(source) for rival in self._order)
        proven = t_s - self._since_s[source] >= REACCEPTANCE_S
        return proven and self._rank(source) < self._rank(current)


class GradeWatch:
    """Fix type and sigma of the position in use → variance to add (m²) when a better fix type takes over.

    The estimate then still holds the slow error of the worse type, the more the longer that lasted, and its covariance
    is too small. Without the added variance the first good fixes would be rejected as outliers. Remembers fix type,
    sigma and since when.
    """

    _FULL_S = 10.0

    def __init__(self) -> None:
        self._grade: FixType | None = None
        self._sigma_m = 0.0
        self._since_s = 0.0

    def update(self, t_s: float, grade: FixType, sigma_m: float) -> float:
        """Take one fix; the variance to add, in m²."""
        added_m2 = 0.0
        if grade is not self._grade:
            if self._grade is not None and grade > self._grade and sigma_m < self._sigma_m:
                added_m2 = self._sigma_m**2 * min(max(t_s - self._since_s, 0.0) / self._FULL_S, 1.0)
            self._since_s = t_s
        self._grade, self._sigma_m = grade, sigma_m
        return added_m2
