"""The disturbance of a boat beside its thrusters, as a random process, and the filter that whitens a residual.

The velocity residual of a force balance on one axis is p + n + w. p: integral of a gust's acceleration (first-order
Gauss–Markov). n: slow error of the estimated velocity (first-order Gauss–Markov). w: white noise.

Their sum is an ARMA(3, 3) process. The filter that turns it into white innovations makes their least squares weigh each
moment by its information (prediction errors; Ljung 1999, chapters 3 and 7). The five numbers of the process have the
greatest likelihood for the residual itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Stretches = tuple[tuple[int, int], ...]

_START = (
    0.3,
    10.0,
    1.0,
    0.7,
    0.3,
)  # start of the search: fields of `Disturbance` in smallest velocities (per second), and times
_DOUBT = (1.5, 1.0, 1.0, 0.5, 1.0)  # one sigma of the prior of the logarithms
_LOW, _HIGH = (1e-3, 0.5, 1e-3, 0.1, 1e-3), (1e4, 300.0, 1e3, 5.0, 1e3)


@dataclass(frozen=True, slots=True)
class Disturbance:
    """One axis, in SI units. `gust`: one sigma of the acceleration, `gust_s`: its time; `slow`, `slow_s`: the same of
    the velocity's error; `white`: one sigma of the rest."""

    gust: float
    gust_s: float
    slow: float
    slow_s: float
    white: float


class Whitener:
    """Turns residuals of one axis into innovations. Remembers only its filter."""

    def __init__(self, disturbance: Disturbance, period_s: float) -> None:
        d = disturbance
        gust, slow = math.exp(-period_s / d.gust_s), math.exp(-period_s / d.slow_s)
        sums, fades, errs = np.array([1.0, -1.0]), np.array([1.0, -gust]), np.array([1.0, -slow])
        moving = np.convolve(sums, fades)
        self._zeros = np.convolve(moving, errs)
        spectrum = d.white**2 * _squared(self._zeros)
        spectrum[1:-1] += d.slow**2 * (1.0 - slow * slow) * _squared(moving)
        spectrum[2:-2] += (d.gust * period_s) ** 2 * (1.0 - gust * gust) * _squared(errs)
        roots = np.roots(spectrum)
        self._poles = np.real(np.poly(roots[np.argsort(np.abs(roots))[:3]]))
        self.variance = float(spectrum[3] / (self._poles @ self._poles))

    def __call__(self, residual: Array, stretches: Stretches) -> Array:
        """Innovations in sigmas of velocities in m/s or rad/s, (n,) or columns (n, any); zero outside the stretches.

        A constant in a stretch has no effect, since the velocity at its start is not known.
        """
        from scipy.signal import lfilter

        columns = residual.reshape(len(residual), -1)
        out = np.zeros_like(columns)
        for first, end in stretches:
            part = lfilter(self._zeros, self._poles, columns[first:end] - columns[first], axis=0)
            constant = lfilter(self._zeros, self._poles, np.ones(end - first))
            out[first:end] = part - np.outer(constant, constant @ part / (constant @ constant))
        return np.asarray(out.reshape(residual.shape) / math.sqrt(self.variance), dtype=np.float64)


class Noise:
    """The disturbances of several axes, whose innovations are correlated: a gust pushes a boat aside and turns it.
    Without that the fit would explain it by a hull whose sway and yaw are coupled."""

    def __init__(
        self, axes: Sequence[Disturbance], period_s: float, stretches: Stretches, residual: Array | None = None
    ) -> None:
        """`residual`: (n, axes), of which the correlation is; None: none."""
        self.axes = tuple(axes)
        self._whiteners = [Whitener(one, period_s) for one in axes]
        self._stretches = stretches
        self._unmix = np.eye(len(self.axes))
        if residual is not None:
            seen = self(residual)
            self._unmix = np.linalg.inv(np.linalg.cholesky(seen.T @ seen / len(seen))).T

    @property
    def log_size(self) -> float:
        """Logarithm of the determinant of the innovations' covariance, for all samples."""
        count = sum(end - first for first, end in self._stretches)
        own = sum(math.log(whitener.variance) for whitener in self._whiteners)
        return count * (own - 2.0 * float(np.linalg.slogdet(self._unmix)[1]))

    def __call__(self, residual: Array) -> Array:
        """Innovations without correlation, of size one, of residuals (n, axes) or (n, axes, any)."""
        axes = [whitener(residual[:, i], self._stretches) for i, whitener in enumerate(self._whiteners)]
        mixed = [sum(axis * share for axis, share in zip(axes, shares, strict=True)) for shares in self._unmix.T]
        return np.asarray(np.stack(mixed, axis=1), dtype=np.float64)


def most_likely(
    residual: Array, stretches: Stretches, period_s: float, smallest: float, start: Disturbance | None = None
) -> Disturbance:
    """The process of greatest likelihood for this residual (n,) of one axis.

    `smallest`: the smallest velocity that counts; `start`: where the search begins.
    """
    from scipy.optimize import minimize

    units = np.array([smallest, 1.0, smallest, 1.0, smallest])
    usual = np.log(_START)
    count = sum(end - first for first, end in stretches)

    def surprise(x: Array) -> float:
        whitener = Whitener(Disturbance(*(np.exp(x) * units).tolist()), period_s)
        return (
            float((whitener(residual, stretches) ** 2).sum())
            + count * math.log(whitener.variance)
            + float((((x - usual) / _DOUBT) ** 2).sum())
        )

    first = (
        usual
        if start is None
        else np.log(np.array([start.gust, start.gust_s, start.slow, start.slow_s, start.white]) / units)
    )
    bounds = list(zip(np.log(_LOW).tolist(), np.log(_HIGH).tolist(), strict=True))
    best = minimize(
        surprise,
        np.clip(first, *np.log([_LOW, _HIGH])),
        method="L-BFGS-B",
        bounds=bounds,
        options={"eps": 1e-3, "ftol": 1e-7},
    )
    return Disturbance(*(np.exp(best.x) * units).tolist())


def _squared(polynomial: Array) -> Array:
    """The polynomial a(z) a(1/z)."""
    return np.asarray(np.convolve(polynomial, polynomial[::-1]), dtype=np.float64)
