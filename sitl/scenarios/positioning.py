"""Figures of dynamic positioning as the ReVolt thesis defines them (10.14 to 10.19), from truth.csv and ticks.csv."""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from companion.core.angles import wrap_pi
from sitl.scenarios.measure import Track, read_truth

_UNIT_M = 5.0
_UNIT_RAD = math.radians(50.0)
_UNIT_AZIMUTH_RAD = 0.5 * math.pi


@dataclass(frozen=True, slots=True)
class ThrusterFigures:
    """What the figures need of a thruster: the name of its columns, its full force and its place."""

    name: str
    full_n: float
    x_m: float
    y_m: float


@dataclass(frozen=True, slots=True)
class PositioningLog:
    """Truth and ticks, row by row of the same moment."""

    truth: Track
    ticks: Track


def read(folder: Path, from_s: float, to_s: float) -> PositioningLog:
    """Both logs between two times. Cells that are empty or words are NaN."""
    with (folder / "ticks.csv").open(encoding="utf-8") as file:
        ticks = [{key: _number(value) for key, value in row.items()} for row in csv.DictReader(file)]
    truth = read_truth(folder)
    pairs = [(a, b) for a, b in zip(truth, ticks, strict=False) if from_s <= b["t_s"] <= to_s]
    return PositioningLog([a for a, _ in pairs], [b for _, b in pairs])


def errors(sailed: PositioningLog) -> list[tuple[float, float, float]]:
    """(north m, east m, yaw rad) of the true pose less the desired one."""
    return [
        (
            a["north_m"] - b["desired_north_m"],
            a["east_m"] - b["desired_east_m"],
            wrap_pi(a["yaw_rad"] - b["desired_yaw_rad"]),
        )
        for a, b in zip(sailed.truth, sailed.ticks, strict=True)
    ]


def iae(sailed: PositioningLog) -> list[float]:
    """Running ∫ √((Δp/5 m)² + (Δψ/50°)²) dt."""
    return _accumulated(
        sailed.ticks, [math.hypot(n / _UNIT_M, e / _UNIT_M, yaw / _UNIT_RAD) for n, e, yaw in errors(sailed)]
    )


def iadc(sailed: PositioningLog, thrusters: Sequence[ThrusterFigures]) -> list[float]:
    """Running ∫ |dū/dt| + |dᾱ/dt| dt over all commanded thrusters, ū in full throttles and ᾱ in right angles."""
    total, running = 0.0, [0.0]
    for a, b in itertools.pairwise(sailed.ticks):
        for thruster in thrusters:
            total += abs(b[f"{thruster.name}_throttle"] - a[f"{thruster.name}_throttle"])
            turn = b[f"{thruster.name}_azimuth_rad"] - a[f"{thruster.name}_azimuth_rad"]
            if not math.isnan(turn):
                total += abs(wrap_pi(turn)) / _UNIT_AZIMUTH_RAD
        running.append(total)
    return running


def energy(sailed: PositioningLog, thrusters: Sequence[ThrusterFigures]) -> list[float]:
    """Running ∫ mean (|F|/F_full)^1.5 dt of the true forces: energy, in seconds of full power of all thrusters."""
    shares = [
        sum((abs(row[f"{thruster.name}_force_n"]) / thruster.full_n) ** 1.5 for thruster in thrusters) / len(thrusters)
        for row in sailed.truth
    ]
    return _accumulated(sailed.ticks, shares)


def figures(sailed: PositioningLog, thrusters: Sequence[ThrusterFigures]) -> dict[str, float]:
    """The metrics of a run of dynamic positioning."""
    north, east, yaw = zip(*errors(sailed), strict=True)
    count = len(north)
    return {
        "north_max_m": max(map(abs, north)),
        "east_max_m": max(map(abs, east)),
        "heading_max_deg": math.degrees(max(map(abs, yaw))),
        "position_rms_m": math.sqrt(sum(n * n + e * e for n, e in zip(north, east, strict=True)) / count),
        "heading_rms_deg": math.degrees(math.sqrt(sum(y * y for y in yaw) / count)),
        "iae": iae(sailed)[-1],
        "iadc": iadc(sailed, thrusters)[-1],
        "energy_full_power_s": energy(sailed, thrusters)[-1],
    }


def _accumulated(rows: Track, values: Sequence[float]) -> list[float]:
    total, running = 0.0, [0.0]
    for (a, b), value in zip(itertools.pairwise(rows), values, strict=False):
        total += value * (b["t_s"] - a["t_s"])
        running.append(total)
    return running


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
