"""Whether a filter's covariance is that of its errors: normalised squares over many runs, against their chi-square
bands.

Bar-Shalom, Li & Kirubarajan (2001), *Estimation with Applications to Tracking and Navigation*, 5.4.2: of N independent
runs the sum of a normalised square of n degrees of freedom is chi-square distributed with N·n of them. Every square is
divided by its freedom here, so that an honest filter has a mean of 1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import binom, chi2, norm, t

SHARE = 0.95  # of a consistent filter's means that lie in a band

Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True, slots=True)
class Verdict:
    """One normalised quantity over all runs.

    `means`: of the runs at each instant; `band`: in which 95 % of them lie; `allowed`: how many may lie outside where
    the instants are independent, in 95 % of all cases; `mean`: of all, and `half`: half of its 95 % interval by how the
    runs differ, which does not ask the instants to be independent.
    """

    means: tuple[float, ...]
    band: tuple[float, float]
    allowed: int
    mean: float
    half: float

    @property
    def outside(self) -> int:
        """Instants outside of the band."""
        return sum(not self.band[0] <= mean <= self.band[1] for mean in self.means)

    @property
    def inside(self) -> bool:
        """Whether no more instants lie outside of the band than chance explains."""
        return self.outside <= self.allowed

    @property
    def word(self) -> str:
        """For people."""
        if self.inside:
            return "inside"
        if self.band[0] < 0.0:
            return "biased"
        return "over-confident" if self.mean > 1.0 else "cautious"


def normalised_squares(errors: Array, covariances: Array) -> Array:
    """eᵀ P⁻¹ e / n of errors (…, n) with covariances (…, n, n)."""
    weighed = np.linalg.solve(covariances, errors[..., None])[..., 0]
    squares: Array = (errors * weighed).sum(axis=-1) / errors.shape[-1]
    return squares


def square_band(freedom: int, runs: int) -> tuple[float, float]:
    """The two-sided 95 % band of the mean over the runs of a normalised square, divided by its freedom."""
    whole = freedom * runs
    low, high = (float(chi2.ppf(share, whole)) / whole for share in ((1.0 - SHARE) / 2.0, (1.0 + SHARE) / 2.0))
    return low, high


def judge_squares(squares: Sequence[Sequence[float]] | Array, freedom: int) -> Verdict:
    """Normalised squares divided by `freedom`, a row a run and a column an instant. Raises ValueError for less than two
    runs."""
    return _judged(squares, square_band(freedom, len(squares)))


def judge_bias(normalised: Sequence[Sequence[float]] | Array) -> Verdict:
    """Errors divided by their sigma, a row a run and a column an instant: their means should be 0. Raises ValueError
    for less than two runs."""
    reach = float(norm.ppf((1.0 + SHARE) / 2.0)) / math.sqrt(max(len(normalised), 1))
    return _judged(normalised, (-reach, reach))


def _judged(rows: Sequence[Sequence[float]] | Array, band: tuple[float, float]) -> Verdict:
    table = np.asarray(rows, dtype=float)
    runs, instants = table.shape
    if runs < 2:
        raise ValueError("one run tells nothing of how runs differ")
    of_runs = table.mean(axis=1)
    half = float(t.ppf((1.0 + SHARE) / 2.0, runs - 1)) * float(of_runs.std(ddof=1)) / math.sqrt(runs)
    allowed = int(binom.ppf(SHARE, instants, 1.0 - SHARE))
    return Verdict(tuple(table.mean(axis=0).tolist()), band, allowed, float(of_runs.mean()), half)


def shown(verdict: Verdict) -> Mapping[str, Any]:
    """As it is written to a file."""
    return {
        "mean": round(verdict.mean, 4),
        "half": round(verdict.half, 4),
        "means": [round(mean, 4) for mean in verdict.means],
        "band": [round(edge, 4) for edge in verdict.band],
        "outside": verdict.outside,
        "allowed": verdict.allowed,
        "word": verdict.word,
    }
