"""Tells wild measurements from true ones: the thesis's rule for positions, and the gate that replaces it.

Source: Alfheim & Muggerud (2017), wild-point filter. Its fixed 1 m compares with the last approved fix, so that after a dropout or at
speed every true fix is rejected for 20 samples. The gate here asks instead how likely the difference from the *predicted* value is.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from enum import Enum
from statistics import median

FIRST_SAMPLES = 20
REJECTIONS_IN_A_ROW = 20


class Verdict(Enum):
    """What to do with a measurement: weigh it in, leave it, or start again from it."""

    ACCEPT = "accept"
    REJECT = "reject"
    RESET = "reset"


class ThesisRule:
    """Positions (north_m, east_m) → `Verdict`; `approved` is the last position that was not rejected.

    The first approved is the median of the first 20; then a position further than 1 m from the last approved is rejected; after more than
    20 rejections in a row the newest is approved, and the estimate begins again from it. Remembers the last approved and the count.
    """

    def __init__(self, distance_m: float = 1.0) -> None:
        self._distance_m = distance_m
        self._first: list[tuple[float, float]] = []
        self.approved: tuple[float, float] | None = None
        self._rejections = 0

    def update(self, north_m: float, east_m: float) -> Verdict:
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

    `chi_square`: the largest normalised innovation squared that passes (two degrees of freedom: 13.8 is 1 in 1000, one: 10.8).
    `always`: innovations smaller than this pass whatever the covariance says, for noise is not white.
    `agreement`: how near to their median the newest of the rejected must be to be believed at last.
    """

    chi_square: float
    always: float
    agreement: float


POSITION_GATE = GateConfig(chi_square=16.0, always=0.3, agreement=1.0)
VELOCITY_GATE = GateConfig(chi_square=16.0, always=0.15, agreement=0.5)
HEADING_GATE = GateConfig(chi_square=12.0, always=math.radians(1.5), agreement=math.radians(5.0))


class InnovationGate:
    """Innovation (measured − predicted) and its normalised square → `Verdict`.

    The covariance behind the square grows with every prediction, so the gate opens by itself while measurements are missing. More than
    20 rejections in a row are believed if they agree with each other (as differences from the prediction, so also under way).
    After five times that many, the newest is believed if it only agrees with the one before it: the prediction itself must be wrong.
    Remembers the rejected innovations since the last accepted one.
    """

    def __init__(self, config: GateConfig) -> None:
        self._config = config
        self._rejected: deque[tuple[float, float]] = deque(maxlen=REJECTIONS_IN_A_ROW)
        self._rejections = 0

    @property
    def rejections(self) -> int:
        """How many in a row, up to now."""
        return self._rejections

    def clear(self) -> None:
        """Forget the rejected ones."""
        self._rejected.clear()
        self._rejections = 0

    def update(self, first: float, second: float, normalised_square: float, sigma: float) -> Verdict:
        """`first`, `second`: the innovation (second 0 where there is one axis); `sigma`: of the measurement alone."""
        if normalised_square <= self._config.chi_square or math.hypot(first, second) <= self._config.always:
            if self._rejections:
                self.clear()
            return Verdict.ACCEPT
        self._rejections += 1
        believed = self._rejections > REJECTIONS_IN_A_ROW and self._agrees(first, second, sigma)
        self._rejected.append((first, second))
        if not believed:
            return Verdict.REJECT
        self.clear()
        return Verdict.RESET

    def _agrees(self, first: float, second: float, sigma: float) -> bool:
        late = self._rejections > 5 * REJECTIONS_IN_A_ROW
        centre = self._rejected[-1] if late else median_point(self._rejected)
        return math.hypot(first - centre[0], second - centre[1]) <= max(self._config.agreement, 4.0 * sigma)


class FirstPosition:
    """The first positions of a run → where the boat is, once they agree; None before.

    As in the thesis from the median of 20, which no wild point can move, or of those of 2 s (at least 3) from a slow receiver. Approved
    is the newest that lies near the median, for the boat may be moving. Remembers the positions of the last samples.
    """

    _PATIENCE_S = 2.0
    _FEWEST = 3

    def __init__(self, distance_m: float = 1.0) -> None:
        self._distance_m = distance_m
        self._points: deque[tuple[float, float, float]] = deque(maxlen=FIRST_SAMPLES)

    def update(self, north_m: float, east_m: float, sigma_m: float, t_s: float) -> tuple[float, float] | None:
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


def median_point(points: list[tuple[float, float]] | deque[tuple[float, float]]) -> tuple[float, float]:
    """The median of each coordinate."""
    return median(north for north, _ in points), median(east for _, east in points)
