"""The search for the likeliest hull: quantities of `hull_model` and the disturbance beside them, fitted alternately.

Prediction errors (Ljung 1999): the velocity residuals are whitened by `disturbance`, whose numbers are fitted to the
same log. So a lasting gust is no evidence against a damping, even if a control loop answers it. The sum of squares
includes the distances from the known model, each over its doubt.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from companion.analysis.disturbance import Disturbance, Noise, most_likely
from companion.analysis.force_balance import equation_error
from companion.analysis.hull_model import HullModel
from companion.analysis.manoeuvre import Array
from companion.core.progress import Work

SMALLEST = (2e-3, 2e-3, 5e-4)
"""m/s, m/s, rad/s: the best that an estimate can be."""
_STEPS = 12  # of the fit for one disturbance
_SHARES = (1.0, 0.5, 0.25, 0.1, 0.02)  # of a step that are tried
_CONVERGED = 1e-4  # relative fall of the sum of squares that ends it
_FRESH = 0.05  # doubts by which a quantity may have moved since the slopes were computed
_TURNS = 8  # alternations of hull and disturbance
_SETTLED = 0.05  # change of the logarithm of a gust's size that counts as none


def likeliest(model: HullModel, held: Mapping[str, str], work: Work) -> Search:
    """The fit from the model as it is known, or that from a fit without the terms that the file lacks: the likelier of
    both, since a start far off can end in a lesser optimum."""
    plain = {**held, **{name: "" for group in model.candidates for name in group}}
    begun = Search(model, equation_error(model, plain), plain)
    begun.descend(work)
    found = [Search(model, start, held) for start in (model.model, begun.values)]
    for one in found:
        one.settle(work)
    return min(found, key=lambda one: one.surprise)


class Search:
    """A fit on its way: the quantities and the disturbance beside them, fitted alternately.

    Remembers the residuals and how they change with each quantity, which do not depend on the disturbance.
    """

    def __init__(self, model: HullModel, start: Mapping[str, float], held: Mapping[str, str]) -> None:
        self.model, self._start = model, dict(start)
        self.names = [name for name in start if name not in held]
        self.doubts = np.array([model.doubt(name) for name in self.names])
        self._low, self._high = np.array([model.bounds(name) for name in self.names]).T / self.doubts
        self.known = np.array([model.model[name] for name in self.names]) / self.doubts
        self.x = np.clip(np.array([start[name] for name in self.names]) / self.doubts, self._low, self._high)
        self.left = self._left(self.x)
        self.slopes, self._slopes_at = self._change(), self.x
        band = model.band
        axes = [Disturbance(2.0 * one, 10.0, 2.0 * one, 0.7, one) for one in SMALLEST]
        self.noise = Noise(axes, band.period_s, band.stretches)

    @property
    def values(self) -> dict[str, float]:
        """All quantities."""
        return self._values(self.x)

    @property
    def surprise(self) -> float:
        """−2 log of the likelihood and of what was known, but for a constant."""
        innovations = self.noise(self.left)
        return float((innovations**2).sum() + ((self.x - self.known) ** 2).sum()) + self.noise.log_size

    def settle(self, work: Work) -> None:
        """Fit quantities and disturbance until the gusts no longer change. The first disturbance is a small one: what
        the start does not explain yet must not count as gusts."""
        band = self.model.band
        self.descend(work)
        for _ in range(_TURNS):
            before = self.noise.axes
            axes = [
                most_likely(self.left[:, i], band.stretches, band.period_s, SMALLEST[i], before[i]) for i in range(3)
            ]
            self.noise = Noise(axes, band.period_s, band.stretches, self.left)
            self.descend(work)
            if all(abs(math.log(now.gust / then.gust)) < _SETTLED for now, then in zip(axes, before, strict=True)):
                return

    def descend(self, work: Work) -> None:
        """Least squares of the innovations and of the distances from what was known, for this disturbance.

        Gauss–Newton steps, each the least squares of the linear problem within the bounds, halved until the sum falls.
        """
        before = self._sum(self.left, self.x)
        for _ in range(_STEPS):
            work.step()
            fresh = bool(np.abs(self.x - self._slopes_at).max() < _FRESH)
            if not fresh:
                self.slopes, self._slopes_at = self._change(), self.x
            now = self._step(before)
            if before - now < _CONVERGED * before and (fresh or now < before):
                break
            before = now

    def _step(self, before: float) -> float:
        """Go a step; the sum of squares after it, which is `before` where no step makes it fall."""
        step = self._bounded_step()
        for share in _SHARES:
            x = np.clip(self.x + share * step, self._low, self._high)
            left = self._left(x)
            if (now := self._sum(left, x)) < before:
                self.x, self.left = x, left
                return now
        return before

    def innovations(self) -> tuple[Array, Array]:
        """(samples, 3) and their change with each quantity in doubts, (samples, 3, quantities)."""
        return self.noise(self.left), self.noise(self.slopes)

    def renew(self) -> None:
        """Let `slopes` be those of where the fit is."""
        self.slopes, self._slopes_at = self._change(), self.x

    def _sum(self, left: Array, x: Array) -> float:
        return float((self.noise(left) ** 2).sum() + ((x - self.known) ** 2).sum())

    def _bounded_step(self) -> Array:
        """The step that makes the linear problem least, within the bounds."""
        from scipy.optimize import lsq_linear

        here, slopes = self.innovations()
        count = len(self.x)
        matrix = np.concatenate([slopes.reshape(-1, count), np.eye(count)])
        rotated, triangle = np.linalg.qr(matrix)
        aim = -rotated.T @ np.concatenate([here.ravel(), self.x - self.known])
        bounds = (self._low - self.x - 1e-9, self._high - self.x + 1e-9)
        return np.asarray(lsq_linear(triangle, aim, bounds).x, dtype=np.float64)

    def _values(self, x: Array) -> dict[str, float]:
        return {**self._start, **dict(zip(self.names, (x * self.doubts).tolist(), strict=True))}

    def _left(self, x: Array) -> Array:
        return self.model.band.sampled(self.model.imbalance(self._values(x)))

    def _change(self) -> Array:
        """(samples, 3, quantities): change of the residuals with each."""
        here, step = self.model.imbalance(self.values), 1e-4
        moved = [self.model.imbalance(self._values(self.x + step * unit)) - here for unit in np.eye(len(self.x))]
        columns = np.stack(moved, axis=2).reshape(len(here), -1) / step
        return self.model.band.sampled(columns).reshape(-1, 3, len(self.x))
