"""Figures of many runs: a failure rate and percentiles with their intervals, and the comparison of two sets of runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

CONFIDENCE = 0.95
PERCENTILES = (5.0, 50.0, 95.0)
_LEAST_PAIRS = 2

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Estimated:
    """A figure and its interval. An end of it is infinite where so few values do not tell it."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Paired:
    """The same seeds sailed twice: how one metric differs. `median`: of the differences, second less first; `p`: that
    it is at least so far from 0 by chance; `adjusted`: the same among all metrics that were compared."""

    name: str
    count: int
    first: float
    second: float
    median: Estimated
    p: float
    adjusted: float = math.nan


@dataclass(frozen=True, slots=True)
class PairedFailures:
    """The same seeds sailed twice: how many fail in the one alone, in the other alone, in both; `p`: exact McNemar."""

    count: int
    only_first: int
    only_second: int
    both: int
    p: float


def failure_rate(failures: int, count: int) -> Estimated:
    """Wilson's interval of a share. Source: Wilson (1927), by scipy.stats.binomtest."""
    interval = stats.binomtest(failures, count).proportion_ci(CONFIDENCE, method="wilson")
    return Estimated(failures / count, float(interval.low), float(interval.high))


def percentiles(values: Sequence[float]) -> tuple[Estimated, ...]:
    """The 5th, 50th and 95th percentile, each with its interval, which holds for any distribution: a median's has both
    ends from 6 values on, the others' from 72 on. Source: order statistics, Conover (1999), section 3.2."""
    return _with_intervals(np.asarray(values, dtype=float), PERCENTILES)


def paired(name: str, first: Sequence[float], second: Sequence[float]) -> Paired | None:
    """How the second values differ from the first, pair by pair: Wilcoxon's signed-rank test, of which equal pairs are
    no part. Pairs with a value that is not finite do not count; None with fewer than two pairs."""
    a, b = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    whole = np.isfinite(a) & np.isfinite(b)
    a, b = a[whole], b[whole]
    if len(a) < _LEAST_PAIRS:
        return None
    differences = b - a
    unequal = differences[differences != 0.0]  # with equal ones, scipy takes the approximation for many pairs
    p = float(stats.wilcoxon(unequal).pvalue) if len(unequal) else 1.0
    (middle,) = _with_intervals(differences, (50.0,))
    return Paired(name, len(a), float(np.median(a)), float(np.median(b)), middle, p)


def paired_failures(first: Sequence[bool], second: Sequence[bool]) -> PairedFailures:
    """Which of the pairs fail. `first`, `second`: whether each is good. Source: McNemar (1947), by the exact binomial
    test of the pairs that differ."""
    only_first = sum(not a and b for a, b in zip(first, second, strict=True))
    only_second = sum(a and not b for a, b in zip(first, second, strict=True))
    both = sum(not a and not b for a, b in zip(first, second, strict=True))
    differing = only_first + only_second
    p = float(stats.binomtest(only_second, differing).pvalue) if differing else 1.0
    return PairedFailures(len(first), only_first, only_second, both, p)


def adjusted(ps: Sequence[float]) -> list[float]:
    """Of many tests: the share of false alarms among all that are at least as clear as this one. Source: Benjamini and
    Hochberg (1995), by scipy.stats.false_discovery_control."""
    return [float(p) for p in stats.false_discovery_control(ps)] if ps else []


def influences(factors: Mapping[str, Sequence[float]], values: Sequence[float]) -> dict[str, float]:
    """Spearman's rank correlation of a metric with each sampled factor, −1 to 1; without those that are constant."""
    found = {}
    for name, of_runs in factors.items():
        if len(set(of_runs)) > 1 and len(set(values)) > 1:
            found[name] = float(stats.spearmanr(of_runs, values).statistic)
    return found


def _with_intervals(values: Vector, wanted: Sequence[float]) -> tuple[Estimated, ...]:
    ordered, tail = np.sort(values), 0.5 * (1.0 - CONFIDENCE)
    found = []
    for percent in wanted:
        low, high = (int(stats.binom.ppf(share, len(ordered), percent / 100.0)) for share in (tail, 1.0 - tail))
        found.append(
            Estimated(
                float(np.percentile(ordered, percent)),
                float(ordered[low - 1]) if low > 0 else -math.inf,
                float(ordered[high]) if high < len(ordered) else math.inf,
            )
        )
    return tuple(found)
