"""Whether the slow error of measurements is larger than is said of it: multipath, ambiguities that are solved wrongly
and a latency that nobody knows show in no field of a receiver's sentences, but in the innovations.

**Drift.** Innovations of a filter that knows its errors have nothing to do with one another. Where each is like the one
before, what measurements are off by moves faster than is supposed (Mehra 1970, *On the identification of variances and
adaptive Kalman filtering*: the lagged covariance of innovations). More noise than is claimed does not do that.

**Jump.** An innovation that noise and slow error do not explain is no drift. Either what measurements are off by has
jumped, or it was something else up to now and is not any more: the estimate stays, and is as unsure as the jump is
long.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.nav.error_state import Innovation
from companion.nav.measured_off import Wander

_MEAN_S, _FEWEST = 5.0, 20  # of the mean of the lagged products: time, and innovations
_CLIP = 25.0  # to which the products of two innovations are reduced: an outlier says little
_RATIO = 1.5  # of the mean to the variance that is no drift: by chance it is 0.3 at most
_GAP_S = 2.0
_FADES_S = 60.0  # in which an added sigma goes back, and a doubt
_JUMP = 36.0  # normalised square of two axes: one in 10⁸
_DOUBT = 0.7  # of the distance by which measurements have jumped: one sigma of the estimate
_LASTS_S = 300.0  # a wrong solution lasts for minutes
_FORGOTTEN = 3.0  # times that


@dataclass(frozen=True, slots=True)
class Limits:
    """In the unit of the measurement, `most`: the largest sigma that is added to the slow error; `reach`: of an
    innovation beyond which it is no slow error, but the estimate that is lost; `doubt`: the largest of the estimate.
    `least`: of the mean of the lagged products over the claimed variance, from which on it counts."""

    most: float
    reach: float
    doubt: float
    least: float


class SlowError:
    """Call `take` for each innovation of one sense. `doubt`: one sigma, beside that of the filter, of an estimate that
    has followed what was no motion, or may have. Remembers the last innovation, the mean of the lagged products, the
    sigma that was added, and when what measurements are off by has jumped."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self.doubt = 0.0
        self._t_s = self._jump_s = -math.inf
        self._y1 = self._y2 = self._alike = self._apart = 0.0
        self._added = 0.0

    @property
    def has_jumped(self) -> bool:
        """Whether what measurements are off by has jumped, and is not back."""
        return self._jump_s > -math.inf

    def begin(self) -> None:
        """The filter begins anew."""
        self._t_s = self._jump_s = -math.inf
        self._alike = self._apart = self._added = self.doubt = 0.0

    def expected(self, said: Wander, t_s: float) -> Wander:
        """The slow error to expect, for the one that is said."""
        if self._added == 0.0 and self._jump_s == -math.inf:
            return said
        time_s = max(said.time_s, _LASTS_S) if self._lasts(t_s) else said.time_s
        return Wander(math.hypot(said.sigma, self._added), time_s)

    def take(self, t_s: float, innovation: Innovation, sigma: float | None = None) -> None:
        """Take an innovation. `sigma`: of the slow error that is expected now, to which a drift adds; None: it is only
        a doubt, as whatever else may be wrong, the inertial sensor needs these measurements."""
        limits = self._limits
        dt_s, self._t_s = t_s - self._t_s, t_s
        y1, y2 = innovation.y1, innovation.y2
        alike, apart = _products(innovation, self._y1, self._y2)
        self._y1, self._y2 = y1, y2
        if not 0.0 < dt_s <= _GAP_S or math.hypot(y1, y2) > limits.reach:
            self._alike = self._apart = 0.0
            return
        self._added *= 1.0 - dt_s / _FADES_S
        self.doubt *= 1.0 - dt_s / (_LASTS_S if self._lasts(t_s) else _FADES_S)
        share = min(dt_s / _MEAN_S, 1.0 / _FEWEST)
        counts = min(1.0, _CLIP / max(abs(alike), apart, _CLIP))
        self._alike += share * (counts * alike - self._alike)
        self._apart += share * (counts * apart - self._apart)
        if self._alike <= max(limits.least, _RATIO * self._apart):
            return
        claimed = innovation.s11 if innovation.size == 1 else 0.5 * (innovation.s11 + innovation.s22)
        drift = 2.0 * self._alike * claimed
        if sigma is not None:
            self._added = min(math.sqrt(self._added**2 + max(sigma * sigma, drift)), limits.most)
        self.doubt = min(math.sqrt(self.doubt**2 + drift), limits.doubt)
        self._alike = self._apart = 0.0

    def jumped(self, t_s: float, distance: float) -> None:
        """What measurements are off by has jumped; it is that far from the estimate, or the estimate has come as far.
        0: it is back."""
        self._jump_s = t_s if distance > 0.0 else -math.inf
        self.doubt = min(_DOUBT * distance, self._limits.doubt)

    def _lasts(self, t_s: float) -> bool:
        return t_s - self._jump_s <= _FORGOTTEN * _LASTS_S


def has_jumped(innovation: Innovation) -> bool:
    """Whether noise and slow error do not explain it."""
    return innovation.normalised_square > _JUMP


def _products(innovation: Innovation, before1: float, before2: float) -> tuple[float, float]:
    """Of an innovation and the one before, over the claimed variance: their product, and half of the square of their
    difference, which noise makes and drift does not."""
    y1, y2 = innovation.y1, innovation.y2
    alike, apart = y1 * before1 / innovation.s11, 0.5 * (y1 - before1) ** 2 / innovation.s11
    if innovation.size == 1:
        return alike, apart
    alike += y2 * before2 / innovation.s22
    apart += 0.5 * (y2 - before2) ** 2 / innovation.s22
    return 0.5 * alike, 0.5 * apart
