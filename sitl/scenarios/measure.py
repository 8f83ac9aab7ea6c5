"""Figures from a run's truth.csv, computed without any of the companion's code."""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from companion.core.frames import body_to_ned

Track = list[dict[str, float]]
Point = tuple[float, float]

_SLOW_ERRORS_M = {"sbas": 0.75, "standalone": 3.85}  # by grade of the receiver, of those that wander


@dataclass(frozen=True, slots=True)
class Check:
    """One condition: `value` at most `limit`, or at least where `at_least`."""

    name: str
    value: float
    limit: float
    unit: str
    at_least: bool = False

    @property
    def ok(self) -> bool:
        """Whether it holds."""
        return self.value >= self.limit if self.at_least else self.value <= self.limit

    def row(self) -> dict[str, Any]:
        """As it is written to result.json."""
        return {**asdict(self), "ok": self.ok}


def read_truth(folder: Path) -> Track:
    """Rows of truth.csv, by column; without a last one that was cut off."""
    data = (folder / "truth.csv").read_bytes()
    lines = data[: data.rfind(b"\n") + 1].decode().splitlines()
    return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]


def read_estimates(folder: Path) -> Track:
    """The vessel's estimates, a row a tick: the columns that ticks.csv shares with truth.csv."""
    names = ("t_s", "north_m", "east_m", "yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps")
    with (folder / "ticks.csv").open(encoding="utf-8") as file:
        return [{name: float(row[name]) for name in names} for row in csv.DictReader(file)]


@dataclass(frozen=True, slots=True)
class EstimateError:
    """Estimate less truth at one tick, in NED. `yaw_rad`: the true heading."""

    t_s: float
    north_m: float
    east_m: float
    north_mps: float
    east_mps: float
    yaw_rad: float

    @property
    def distance_m(self) -> float:
        """Of the position."""
        return math.hypot(self.north_m, self.east_m)

    @property
    def speed_mps(self) -> float:
        """Of the velocity."""
        return math.hypot(self.north_mps, self.east_mps)


def estimate_errors(folder: Path, from_s: float = -math.inf, to_s: float = math.inf) -> list[EstimateError]:
    """The error of each tick between two times. Raises ValueError where the times of both files disagree."""
    errors = []
    for estimate, true in zip(read_estimates(folder), read_truth(folder), strict=True):
        if abs(estimate["t_s"] - true["t_s"]) > 0.006:
            raise ValueError(f"ticks.csv and truth.csv disagree at {estimate['t_s']:.3f} s")
        if from_s <= true["t_s"] <= to_s:
            (bn, be), (tn, te) = (
                body_to_ned(row["surge_mps"], row["sway_mps"], row["yaw_rad"]) for row in (estimate, true)
            )
            north_m, east_m = estimate["north_m"] - true["north_m"], estimate["east_m"] - true["east_m"]
            errors.append(EstimateError(true["t_s"], north_m, east_m, bn - tn, be - te, true["yaw_rad"]))
    return errors


def square(side_m: float) -> tuple[Point, ...]:
    """Corners north, north-east and east of home, and home."""
    return (side_m, 0.0), (side_m, side_m), (0.0, side_m), (0.0, 0.0)


def between(track: Track, from_s: float, to_s: float = math.inf) -> Track:
    """The rows between two times."""
    return [row for row in track if from_s <= row["t_s"] <= to_s]


def means(values: Sequence[float], width: int) -> list[float]:
    """The mean of every `width` values in a row, from the first on."""
    sums = [0.0, *itertools.accumulate(values)]
    return [(b - a) / width for a, b in zip(sums, sums[width:], strict=False)]


def receiver_error_m(gnss: str) -> float:
    """How far a boat may be off by the slow error of its receiver alone, which no law can know; 0 with corrections."""
    return _SLOW_ERRORS_M.get(gnss, 0.0)


def rms(values: Sequence[float]) -> float:
    """Root mean square."""
    return math.sqrt(sum(value * value for value in values) / len(values)) if values else math.nan


def distance_to(row: dict[str, float], north_m: float, east_m: float) -> float:
    """Distance of a row's position from a point, in metres."""
    return math.hypot(row["north_m"] - north_m, row["east_m"] - east_m)


def closest(track: Track, point: Point) -> float:
    """Smallest distance of the track from a point, in metres."""
    return min(distance_to(row, *point) for row in track)


def sampled_path(points: Sequence[Point], kind: str, step_m: float = 0.05) -> list[Point]:
    """The curve of that kind through `points`, by scipy over chord length, densely sampled: the reference for
    cross-track errors."""
    import numpy as np
    from scipy.interpolate import Akima1DInterpolator, CubicSpline, PchipInterpolator

    steps = [math.dist(a, b) for a, b in itertools.pairwise(points)]
    chord = np.concatenate([[0.0], np.cumsum(steps)])
    at = np.linspace(0.0, chord[-1], max(2, int(chord[-1] / step_m)))

    def column(values: Any) -> Any:
        if kind == "linear":
            return np.interp(at, chord, values)
        if kind == "cubic":
            return CubicSpline(chord, values)(at)
        return (
            PchipInterpolator(chord, values)(at)
            if kind == "pchip"
            else Akima1DInterpolator(chord, values, method="makima")(at)
        )

    north, east = (column(np.array([point[axis] for point in points])) for axis in (0, 1))
    return list(zip(north.tolist(), east.tolist(), strict=True))


def cross_track_errors(track: Track, path: Sequence[Point]) -> list[float]:
    """Distance of each row from the sampled path."""
    import numpy as np
    from scipy.spatial import cKDTree

    distances, _ = cKDTree(np.array(path)).query(np.array([(row["north_m"], row["east_m"]) for row in track]))
    return [float(distance) for distance in np.atleast_1d(distances)]


@dataclass(frozen=True, slots=True)
class EventRow:
    """A row of events.csv."""

    t_s: float
    name: str
    text: str


def read_events(folder: Path) -> list[EventRow]:
    """All rows of events.csv."""
    with (folder / "events.csv").open(encoding="utf-8") as file:
        return [EventRow(float(row["t_s"]), row["name"], row["text"]) for row in csv.DictReader(file)]


def along_path(track: Track, path: Sequence[Point], reach_m: float = 4.0) -> list[tuple[float, float]]:
    """(arc length, distance) of each row's nearest point on the sampled path, searched within `reach_m` of the last
    one.

    So it stays on its branch where the path crosses itself. The arc length may decrease.
    """
    length = [0.0, *itertools.accumulate(math.dist(a, b) for a, b in itertools.pairwise(path))]
    result: list[tuple[float, float]] = []
    at = 0
    for row in track:
        low = high = at
        while low > 0 and length[at] - length[low] < reach_m:
            low -= 1
        while high < len(path) - 1 and length[high] - length[at] < reach_m:
            high += 1
        distance, at = min((distance_to(row, *path[i]), i) for i in range(low, high + 1))
        result.append((length[at], distance))
    return result


def largest_turn_rad(track: Track, times_s: Sequence[float]) -> float:
    """The largest span of the heading in one stretch, with whole turns; `times_s` divides the stretches. A span of 2π
    or more between two waypoints is a circle."""
    largest, unwrapped = 0.0, 0.0
    ends = iter([*sorted(times_s), math.inf])
    end = next(ends)
    lowest = highest = last = None
    for row in track:
        if last is not None:
            unwrapped += math.remainder(row["yaw_rad"] - last, 2.0 * math.pi)
        last = row["yaw_rad"]
        if row["t_s"] > end or lowest is None or highest is None:
            lowest = highest = unwrapped
            while row["t_s"] > end:
                end = next(ends)
        lowest, highest = min(lowest, unwrapped), max(highest, unwrapped)
        largest = max(largest, highest - lowest)
    return largest


def longest_standstill_s(times_s: Sequence[float], along_m: Sequence[float], step_m: float) -> float:
    """Longest time in which the furthest point reached did not advance by `step_m`."""
    longest, since_s, best = 0.0, times_s[0], along_m[0]
    for t_s, s in zip(times_s, along_m, strict=True):
        if s >= best + step_m:
            best, since_s = s, t_s
        longest = max(longest, t_s - since_s)
    return longest
