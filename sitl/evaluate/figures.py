"""Figures of one run from its truth.csv, whichever autopilot sailed it. Rows are brought to 10 a second, so that two
logs of different rates compare."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from sitl.scenarios.measure import Point, Track, closest, distance_to, rms
from sitl.scenarios.route_measure import follow, line, percentile, reached_rows

_ROW_S = 0.1
_AWAY_M = 0.5  # from the first waypoint: under way
_CORNER_M = 5.0  # a leg alone is what is farther than this from both its ends
_ROUTE_ENDS_M = 2.0
_METRICS = {
    "legs_rms_m": "cross-track on legs alone, RMS",
    "route_rms_m": "cross-track, RMS",
    "route_miss_m": "worst miss of a waypoint passed",
    "route_time_s": "time",
    "route_power_percent": "mean power",
    "route_variation_percent_ps": "thrust variation",
}


@dataclass(frozen=True, slots=True)
class Figure:
    """One number of a run; less is better for all of them."""

    name: str
    unit: str
    value: float


def regular(track: Track) -> Track:
    """The rows nearest to every tenth of a second. Raises ValueError for a track without rows."""
    if not track:
        raise ValueError("truth.csv has no rows in that time")
    rows, due_s = [], track[0]["t_s"]
    for row in track:
        if row["t_s"] >= due_s - 1.0e-6:
            rows.append(row)
            due_s += _ROW_S * max(1, math.ceil((row["t_s"] - due_s + 1.0e-6) / _ROW_S))
    return rows


def hold(track: Track, vessel: VesselConfig, point: Point | None, yaw_rad: float | None) -> list[Figure]:
    """Station keeping over the whole track. Without `point` the place of the first row is meant; without `yaw_rad` the
    heading is not judged."""
    rows = regular(track)
    north_m, east_m = point or (rows[0]["north_m"], rows[0]["east_m"])
    off_m = [distance_to(row, north_m, east_m) for row in rows]
    found = [
        Figure("position, RMS", "m", rms(off_m)),
        Figure("position, 95 %", "m", percentile(off_m, 0.95)),
        Figure("position, largest", "m", max(off_m)),
    ]
    if yaw_rad is not None:
        turned = [math.degrees(wrap_pi(row["yaw_rad"] - yaw_rad)) for row in rows]
        found.append(Figure("heading, RMS", "deg", rms(turned)))
    return [*found, *thrust(rows, vessel)]


def route(track: Track, vessel: VesselConfig, waypoints: Sequence[Point], radius_m: float) -> list[Figure]:
    """A route of straight legs, from where the boat leaves the first waypoint to where it reaches the last.

    Raises ValueError where a waypoint was not reached, in order, within `radius_m`.
    """
    rows = regular(track)
    begin = next((i for i, row in enumerate(rows) if distance_to(row, *waypoints[0]) > _AWAY_M), 0)
    rows = rows[begin:]
    reached = reached_rows(rows, waypoints[1:], radius_m)
    if len(reached) < len(waypoints) - 1:
        raise ValueError(f"waypoint {len(reached) + 1} was not reached within {radius_m:g} m")
    rows = rows[: reached[-1] + 1]
    path = line(waypoints, "linear")
    sailed = follow(rows, path)
    legs_m = [
        error
        for error, s_m in zip(sailed.error_m, sailed.s_m, strict=True)
        if min(abs(s_m - at_m) for at_m in path.waypoint_s_m) > _CORNER_M
    ]
    return [
        Figure("cross-track, RMS", "m", rms(sailed.error_m)),
        Figure("cross-track on legs alone, RMS", "m", rms(legs_m)),
        Figure("cross-track, 95 %", "m", percentile([abs(error) for error in sailed.error_m], 0.95)),
        Figure("worst miss of a waypoint passed", "m", max((closest(rows, at) for at in waypoints[1:-1]), default=0.0)),
        Figure("time", "s", rows[-1]["t_s"] - rows[0]["t_s"]),
        *thrust(rows, vessel),
    ]


def route_metrics(track: Track, vessel: VesselConfig, waypoints: Sequence[Point]) -> dict[str, float]:
    """The figures of `route`, as a scenario's metrics; a route is over 2 m from its last waypoint, before a boat that
    stops there slows down. Empty where a waypoint was not reached so near."""
    try:
        figures = {figure.name: figure.value for figure in route(track, vessel, waypoints, _ROUTE_ENDS_M)}
    except ValueError:
        return {}
    return {metric: figures[name] for metric, name in _METRICS.items() if math.isfinite(figures[name])}


def thrust(rows: Track, vessel: VesselConfig) -> list[Figure]:
    """Mean power and variation of the true forces, as shares of full force, over all thrusters: two figures."""
    full_n: Mapping[str, float] = {
        f"{thruster.name}_force_n": max(thruster.max_n, -thruster.min_n) for thruster in vessel.thrusters
    }
    span_s = rows[-1]["t_s"] - rows[0]["t_s"]
    power = moved = 0.0
    for a, b in itertools.pairwise(rows):
        for column, most_n in full_n.items():
            power += (abs(a[column]) / most_n) ** 1.5 * (b["t_s"] - a["t_s"])
            moved += abs(b[column] - a[column]) / most_n
    scale = 100.0 / (max(span_s, _ROW_S) * len(full_n))
    return [
        Figure("mean power", "% of full", scale * power),
        Figure("thrust variation", "% of full a second", scale * moved),
    ]
