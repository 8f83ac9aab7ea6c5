"""Rejection of outliers: the thesis's rule for positions, and the gate that replaces it.

Source: Alfheim & Muggerud (2017), wild-point filter. It compares a fix with the last accepted one, by a fixed 1 m.
After a dropout, or at speed, it rejects 20 good fixes. The gate here tests how likely the difference from the
*predicted* value is.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from enum import Enum
from statistics import median
from typing import NamedTuple

FIRST_SAMPLES = 20
REJECTIONS_IN_A_ROW = 20
_ON_A_LINE = 4  # rejected ones, and one more, that tell how a prediction goes astray
_GONE = 2.0  # times as far off as the first of these
_UNKNOWN_MPS, _LEAST_MPS, _TURN_RADPS = 5.0, 0.5, 0.2  # of a boat just found: its speed, by waves, its rate of turn


class Verdict(Enum):
    """What becomes of a measurement: it is fused, rejected, or the estimate restarts from it."""

    ACCEPT = "accept"
    REJECT = "reject"
    RESET = "reset"


class ThesisOutlierRule:
    """Positions (north_m, east_m) → `Verdict`; `approved` is the last position that was not rejected.

    The median of the first 20 positions is approved. After that, a position more than 1 m from the last approved one is
    rejected. After more than 20 rejections in a row the newest is approved, and the estimate restarts from it.
    Remembers the last approved position and the count of rejections.
    """

    def __init__(self, distance_m: float = 1.0) -> None:
        self._distance_m = distance_m
        self._first: list[tuple[float, float]] = []
        self.approved: tuple[float, float] | None = None
        self._rejections = 0

    def update(self, north_m: float, east_m: float) -> Verdict:
        """The verdict on one position."""
        if self.approved is None:
            self._first.append((north_m, east_m))
            if len(self._first) == FIRST_SAMPLES:
                self.approved = median_point(self._first)
            return Verdict.REJECT
        verdict = Verdict.ACCEPT
        if math.hypot(north_m - self.approved[0], east_m - self.approved[1]) > self._distance_m:
            self._rejections += 1
            if self._rejections <= REJECTIONS_IN_A_ROW:
                return Verdict.REJECT
            verdict = Verdict.RESET
        self._rejections = 0
        self.approved = (north_m, east_m)
        return verdict


@dataclass(frozen=True, slots=True)
class GateConfig:
    """Sizes of a gate, in the unit of the measurement.

    `chi_square`: the largest normalised innovation squared that is accepted (13.8 is 1 in 1000 for two degrees of
    freedom, 10.8 for one). `always`: smaller innovations are accepted whatever the covariance, since noise is not
    white. `agreement`: largest distance from the median of the rejected ones at which the newest causes a reset.
    """

    chi_square: float
    always: float
    agreement: float


POSITION_GATE = GateConfig(chi_square=16.0, always=0.3, agreement=1.0)
VELOCITY_GATE = GateConfig(chi_square=16.0, always=0.15, agreement=0.5)
HEADING_GATE = GateConfig(chi_square=12.0, always=math.radians(1.5), agreement=math.radians(5.0))


class InnovationGate:
    """Innovation (measured − predicted) and its normalised square → `Verdict`.

    The covariance behind the square grows with every prediction, so the gate opens by itself while measurements are
    missing. After more than 20 rejections in a row, a measurement that agrees with their median causes a reset
    (compared as innovations, so also under way). After five times as many, it need only agree with the one before: the
    prediction must be wrong. Remembers the rejected innovations since the last accepted one.
    """

    def __init__(self, config: GateConfig) -> None:
        self._config = config
        self._rejected: deque[tuple[float, float]] = deque(maxlen=REJECTIONS_IN_A_ROW)
        self._rejections = 0

    @property
    def chi_square(self) -> float:
        """The largest normalised square that is accepted at once."""
        return self._config.chi_square

    @property
    def rejections(self) -> int:
        """The present number of rejections in a row."""
        return self._rejections

    def clear(self) -> None:
        """Forget the rejected measurements."""
        self._rejected.clear()
        self._rejections = 0

    def update(
        self, first: float, second: float, normalised_square: float, sigma: float, drifts: bool = False
    ) -> Verdict:
        """The verdict on one measurement. `first`, `second`: the innovation (second 0 for one axis); `sigma`: of the
        measurement alone. `drifts`: the prediction may go astray, so that rejected ones agree that are on a line."""
        if normalised_square <= self._config.chi_square or math.hypot(first, second) <= self._config.always:
            if self._rejections:
                self.clear()
            return Verdict.ACCEPT
        self._rejections += 1
        agreed = self._agrees(first, second, sigma) or (drifts and self._is_on_their_line(first, second, sigma))
        self._rejected.append((first, second))
        if not agreed:
            return Verdict.REJECT
        self.clear()
        return Verdict.RESET

    def _agrees(self, first: float, second: float, sigma: float) -> bool:
        if self._rejections <= REJECTIONS_IN_A_ROW:
            return False
        late = self._rejections > 5 * REJECTIONS_IN_A_ROW
        centre = self._rejected[-1] if late else median_point(self._rejected)
        return self._are_near(first - centre[0], second - centre[1], sigma)

    def _is_on_their_line(self, first: float, second: float, sigma: float) -> bool:
        """Whether the rejected ones move away steadily, and this one with them."""
        if len(self._rejected) < _ON_A_LINE:
            return False
        (a1, a2), (b1, b2) = self._rejected[-_ON_A_LINE], self._rejected[-1]
        share = _ON_A_LINE / (_ON_A_LINE - 1.0)
        if first * a1 + second * a2 < _GONE * (a1 * a1 + a2 * a2):
            return False
        return self._are_near(first - a1 - share * (b1 - a1), second - a2 - share * (b2 - a2), sigma)

    def _are_near(self, first: float, second: float, sigma: float) -> bool:
        return math.hypot(first, second) <= max(self._config.agreement, 4.0 * sigma)


class FirstWay(NamedTuple):
    """Velocity of a boat that has just been found, and one sigma on each axis."""

    north_mps: float
    east_mps: float
    sigma_mps: float


class FirstPosition:
    """The first positions of a run → the boat's position, once they agree.

    As in the thesis, outliers are found by the median of 20 positions; from a slow receiver, by that of the positions
    of 2 s (at least 3). The result is the newest position near the median, since the boat may be moving; `way` says how
    fast. Remembers the last positions.
    """

    _PATIENCE_S = 2.0
    _FEWEST = 3

    def __init__(self, distance_m: float = 1.0) -> None:
        self._distance_m = distance_m
        self._points: deque[tuple[float, float, float]] = deque(maxlen=FIRST_SAMPLES)

    def update(self, north_m: float, east_m: float, sigma_m: float, t_s: float) -> tuple[float, float] | None:
        """Take one position; (north_m, east_m) if it is the boat's, else None."""
        self._points.append((north_m, east_m, t_s))
        count = len(self._points)
        waited = count >= self._FEWEST and t_s - self._points[0][2] >= self._PATIENCE_S
        if count < FIRST_SAMPLES and not waited:
            return None
        centre = median_point([(n, e) for n, e, _ in self._points])
        distances = [math.hypot(n - centre[0], e - centre[1]) for n, e, _ in self._points]
        reach_m = max(self._distance_m, 4.0 * sigma_m, 3.0 * median(distances))
        if distances[-1] <= reach_m:
            return north_m, east_m
        return None

    def way(self, noise_m: float) -> FirstWay:
        """The velocity that the last positions tell: the median of those between two of them that lie far apart in
        time (Theil 1950; Sen 1968), so that some outliers do not count. `noise_m`: one sigma of a position."""
        points = list(self._points)
        span_s = points[-1][2] - points[0][2] if points else 0.0
        if span_s <= 0.0:
            return FirstWay(0.0, 0.0, _UNKNOWN_MPS)
        pairs = [(a, b) for i, a in enumerate(points) for b in points[i + 1 :] if b[2] - a[2] >= 0.5 * span_s]
        ways = [((b[0] - a[0]) / (b[2] - a[2]), (b[1] - a[1]) / (b[2] - a[2])) for a, b in pairs]
        north_mps, east_mps = median_point(ways)
        turned_mps = 0.5 * span_s * _TURN_RADPS * math.hypot(north_mps, east_mps)  # it is that of half the time ago
        by_noise_mps = math.sqrt(2.0) * noise_m / span_s
        return FirstWay(north_mps, east_mps, math.hypot(_LEAST_MPS, by_noise_mps, turned_mps))


def median_point(points: list[tuple[float, float]] | deque[tuple[float, float]]) -> tuple[float, float]:
    """(north, east) medians of the points."""
    return median(north for north, _ in points), median(east for _, east in points)
