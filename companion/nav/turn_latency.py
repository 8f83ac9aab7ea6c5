"""How late headings are, by the gyro: in a turn a late heading lags behind the gyro's sum by latency times rate.

    heading − turned = constant + slow errors − latency · rate

Both sides go through the same high-pass, which removes constant and slow errors and keeps the relation; the latency is
the slope of the regression, its variance that of the residuals. The error-state filter is not asked: headings that lag
by degrees in every turn have spoilt its estimate long before it could tell why.
"""

from __future__ import annotations

import math

_SLOW_S = 10.0  # time constant of the high-pass
_FORGET_S = 60.0
_ALIKE_S = 2.0  # errors of headings are alike for that long
_LEAST_S = 5.0  # of headings: a few of them fit any latency
_GAP_S = 2.0
_LEAST_RADPS2S = 1e-3  # of turning, squared and summed over time, without which there is nothing to tell


class TurnLatency:
    """Call `take` for each heading. Remembers the means of the high-pass, and the sums of the regression."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Forget all: the times of the headings have changed, or the gyro's sum begins anew."""
        self._t_s = -math.inf
        self._off = self._rate = 0.0  # slow parts
        self._time_s = self._rates = self._offs = self._both = 0.0

    def take(self, t_s: float, off_rad: float, rate_radps: float) -> None:
        """`off_rad`: heading less the gyro's sum, by whole turns as near as can be to the last one; `rate_radps`: of
        turn."""
        dt_s, self._t_s = t_s - self._t_s, t_s
        if not 0.0 < dt_s <= _GAP_S or abs(math.remainder(off_rad - self._off, 2.0 * math.pi)) > 1.0:
            self._off, self._rate = off_rad, rate_radps
            return
        share = 1.0 - math.exp(-dt_s / _SLOW_S)
        off = math.remainder(off_rad - self._off, 2.0 * math.pi)
        rate = rate_radps - self._rate
        self._off += share * off
        self._rate += share * rate
        kept = math.exp(-dt_s / _FORGET_S)
        off, rate = (1.0 - share) * off, (1.0 - share) * rate
        self._time_s = kept * self._time_s + dt_s
        self._rates = kept * self._rates + rate * rate * dt_s
        self._offs = kept * self._offs + off * off * dt_s
        self._both = kept * self._both - off * rate * dt_s

    def latency_s(self) -> tuple[float, float] | None:
        """Latency and one sigma of it; None while the boat has not turned."""
        if self._rates < _LEAST_RADPS2S or self._time_s < _LEAST_S:
            return None
        latency_s = self._both / self._rates
        left = max(self._offs - latency_s * self._both, 0.0) / self._time_s
        return latency_s, math.sqrt(left * _ALIKE_S / self._rates)
