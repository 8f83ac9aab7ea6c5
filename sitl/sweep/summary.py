"""The rows of a sweep, point by point: failures, distributions, worst cases; and two sets of rows, pair by pair."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from companion.core.nearest import did_you_mean
from sitl.sweep.rows import Row, SweepError
from sitl.sweep.statistics import (
    Estimated,
    Paired,
    PairedFailures,
    adjusted,
    failure_rate,
    influences,
    paired,
    paired_failures,
    percentiles,
)

_WORST = 3


@dataclass(frozen=True, slots=True)
class Distribution:
    """One metric of a design point. `largest`: the run with the largest value. `influences`: see `statistics`."""

    name: str
    values: tuple[float, ...]
    low: Estimated
    median: Estimated
    high: Estimated
    least: float
    most: float
    largest: Row
    influences: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class PointSummary:
    """One design point. `worst`: those that failed most clearly, or came nearest to it."""

    point: str
    scenario: str
    count: int
    failures: int
    rate: Estimated
    distributions: tuple[Distribution, ...]
    worst: tuple[Row, ...]


@dataclass(frozen=True, slots=True)
class Comparison:
    """One design point in two sets of runs, paired by seed, settings and faults. `unpaired`: runs that one set alone
    has."""

    point: str
    scenario: str
    failures: PairedFailures
    metrics: tuple[Paired, ...]
    unpaired: int


def summaries(rows: Iterable[Row]) -> list[PointSummary]:
    """A summary of each design point, in order of their first rows."""
    return [_summary(point, of_point) for point, of_point in _by_point(rows).items()]


def compared(first: Sequence[Row], second: Sequence[Row], by: str | None = None) -> list[Comparison]:
    """The second set of runs against the first, point by point. `by`: a setting that differs between both, which is
    left out in pairing. Every p is adjusted for all tests of metrics. Raises SweepError where one set has several
    values of it, or none has it."""
    if by is not None:
        _judge_setting([*first, *second], by)
    ours, theirs = _by_pair(first, by), _by_pair(second, by)
    groups: dict[str, list[tuple[Row, Row]]] = {}
    for pair, row in ours.items():
        if pair in theirs:
            groups.setdefault(_point_without(row.point, by), []).append((row, theirs[pair]))
    lonely = [
        _point_without(row.point, by) for pair, row in {**theirs, **ours}.items() if (pair in ours) != (pair in theirs)
    ]
    found = [_comparison(point, pairs, lonely.count(point)) for point, pairs in groups.items()]
    return adjusted_together([found])[0]


def compared_by(rows: Sequence[Row], key: str) -> dict[tuple[str, str], list[Comparison]]:
    """Each value of a setting, first in the key, against the one that comes first in the rows, second in the key.
    Every p is adjusted for all tests of metrics of all of them. Raises SweepError where there are not two values."""
    first, *others = values_of(rows, key)
    if not others:
        raise SweepError(f"--by {key}: all runs have the same, {first}")
    of = {value: [row for row in rows if row.settings.get(key, "") == value] for value in (first, *others)}
    found = adjusted_together([compared(of[first], of[value], key) for value in others])
    return {(value, first): one for value, one in zip(others, found, strict=True)}


def adjusted_together(sets: Sequence[Sequence[Comparison]]) -> list[list[Comparison]]:
    """The comparisons of a page, every p adjusted for all of their tests of metrics."""
    every = iter(adjusted([metric.p for found in sets for one in found for metric in one.metrics]))
    return [
        [replace(one, metrics=tuple(replace(metric, adjusted=next(every)) for metric in one.metrics)) for one in found]
        for found in sets
    ]


def values_of(rows: Sequence[Row], key: str) -> list[str]:
    """The values of a setting, in order of their first rows; empty text where a row leaves it at its default. Raises
    SweepError for a setting that no row has."""
    _judge_setting(rows, key)
    return list(dict.fromkeys(row.settings.get(key, "") for row in rows))


def _judge_setting(rows: Sequence[Row], key: str) -> None:
    names = sorted({name for row in rows for name in row.settings})
    if key not in names:
        there = f"those that are set: {', '.join(names)}" if names else "no run sets any"
        raise SweepError(f"--by {key}: no run sets that; {there}{did_you_mean(key, names)}")


def _by_point(rows: Iterable[Row]) -> dict[str, list[Row]]:
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(row.point, []).append(row)
    return groups


def _summary(point: str, rows: Sequence[Row]) -> PointSummary:
    failures = sum(not row.ok for row in rows)
    names = dict.fromkeys(name for row in rows for name in row.metrics)
    distributions = tuple(one for name in names if (one := _distribution(name, rows)) is not None)
    return PointSummary(
        point,
        rows[0].scenario,
        len(rows),
        failures,
        failure_rate(failures, len(rows)),
        distributions,
        tuple(sorted(rows, key=_badness)[:_WORST]),
    )


def _badness(row: Row) -> tuple[bool, bool, float, int]:
    """Sorts runs without a result first, then failed ones, then by margin."""
    return row.error is None, row.ok, math.inf if row.margin is None else row.margin, row.seed


def _distribution(name: str, rows: Sequence[Row]) -> Distribution | None:
    having = [row for row in rows if math.isfinite(row.metrics.get(name, math.nan))]
    if not having:
        return None
    values = [row.metrics[name] for row in having]
    low, median, high = percentiles(values)
    largest = having[int(np.argmax(values))]
    common = [factor for factor in having[0].factors if all(factor in row.factors for row in having)]
    drivers = influences({factor: [row.factors[factor] for row in having] for factor in common}, values)
    return Distribution(name, tuple(values), low, median, high, min(values), max(values), largest, drivers)


def _pair_of(row: Row, by: str | None) -> tuple[object, ...]:
    settings = tuple(sorted((key, value) for key, value in row.settings.items() if key != by))
    return row.scenario, row.vessel, settings, row.faults, row.seed


def _by_pair(rows: Sequence[Row], by: str | None) -> dict[tuple[object, ...], Row]:
    found: dict[tuple[object, ...], Row] = {}
    for row in rows:
        other = found.setdefault(_pair_of(row, by), row)
        if by is not None and other.settings.get(by) != row.settings.get(by):
            raise SweepError(
                f"--by {by}: one sweep has {row.scenario} with several values of it, so it is not clear which "
                "are pairs; leave out --by or --against"
            )
        found[_pair_of(row, by)] = row
    return found


def _point_without(point: str, by: str | None) -> str:
    return " ".join(word for word in point.split(" ") if by is None or not word.startswith(f"{by}="))


def _comparison(point: str, pairs: Sequence[tuple[Row, Row]], unpaired: int) -> Comparison:
    names = dict.fromkeys(name for row, _ in pairs for name in row.metrics)
    metrics = []
    for name in names:
        both = [(a.metrics[name], b.metrics[name]) for a, b in pairs if name in a.metrics and name in b.metrics]
        if (found := paired(name, [a for a, _ in both], [b for _, b in both])) is not None:
            metrics.append(found)
    failures = paired_failures([a.ok for a, _ in pairs], [b.ok for _, b in pairs])
    return Comparison(point, pairs[0][0].scenario, failures, tuple(metrics), unpaired)
