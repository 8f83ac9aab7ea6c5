"""A recorded manoeuvre as `identify` sees it: the velocities that were estimated and the forces that each thruster was told to give."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.config import ThrusterConfig
from companion.record.log_reader import Log, LogError, read_table

Array = NDArray[np.float64]

_LEAST_S = 30.0
_GAP_PERIODS = 1.6  # a longer pause between two ticks begins a new stretch


@dataclass(frozen=True, slots=True)
class Group:
    """Thrusters of one make in one place along the hull: they share a scale and a lever arm."""

    name: str
    members: tuple[int, ...]
    x_m: float
    max_n: float


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """Arrays over the ticks. `velocity` (n, 3) surge, sway, yaw rate; `force_n` (n, thrusters) as commanded until
    the next tick, `azimuth_rad` (n, thrusters) as its mean until then; `stretches` are (first, end) of rows without a gap."""

    t_s: Array
    yaw_rad: Array
    velocity: Array
    force_n: Array
    azimuth_rad: Array
    stretches: tuple[tuple[int, int], ...]
    period_s: float


def groups_of(thrusters: tuple[ThrusterConfig, ...]) -> tuple[Group, ...]:
    """The strongest group first."""
    found: dict[tuple[float, float, float], list[int]] = {}
    for i, thruster in enumerate(thrusters):
        found.setdefault((thruster.x_m, thruster.ahead_n, thruster.astern_n), []).append(i)
    groups = [
        Group("+".join(thrusters[i].name for i in members), tuple(members), x_m, sum(thrusters[i].max_n for i in members))
        for (x_m, _, _), members in found.items()
    ]
    return tuple(sorted(groups, key=lambda group: -group.max_n))


def read_manoeuvre(log: Log, warnings: list[str], from_s: float = 0.0, to_s: float = math.inf) -> Manoeuvre:
    """The armed part of ticks.csv between two times. Raises LogError where there is too little of it, OSError without the file."""
    names = [thruster.name for thruster in log.config.thrusters]
    columns = ("t_s", "armed", "position_valid", "yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps")
    parts = tuple(f"{name}_{part}" for part in ("force_n", "azimuth_rad") for name in names)
    table = read_table(log.folder / "ticks.csv", (*columns, *parts), warnings)
    values = {name: np.array(column) for name, column in table.items()}
    t_s = values["t_s"]
    use = (values["armed"] == 1.0) & (values["position_valid"] == 1.0) & (t_s >= from_s) & (t_s <= to_s)
    use &= np.isfinite(np.stack([values[name] for name in columns])).all(axis=0)
    period_s = 1.0 / log.config.control_rate_hz
    if use.sum() * period_s < _LEAST_S:
        raise LogError(f"{log.folder}: {use.sum() * period_s:.0f} s armed with a position; to identify a hull takes {_LEAST_S:.0f} s at least")
    azimuth = np.stack([values[f"{name}_azimuth_rad"] for name in names], axis=1)
    rest = np.array([thruster.azimuth_rad for thruster in log.config.thrusters])
    return Manoeuvre(
        t_s=t_s[use],
        yaw_rad=values["yaw_rad"][use],
        velocity=np.stack([values[name][use] for name in ("surge_mps", "sway_mps", "yaw_rate_radps")], axis=1),
        force_n=np.nan_to_num(np.stack([values[f"{name}_force_n"] for name in names], axis=1)[use]),
        azimuth_rad=_mean_azimuth(np.where(np.isnan(azimuth), rest, azimuth), log, period_s)[use],
        stretches=_stretches(t_s[use], period_s),
        period_s=period_s,
    )


def _mean_azimuth(command: Array, log: Log, period_s: float) -> Array:
    """Mean direction in a tick of a drive that turns at its rate from the command before to this one, and gets there within the tick."""
    rate = np.array([max(t.azimuth_rate_radps, 1e-6) for t in log.config.thrusters])
    turn = np.zeros_like(command)
    turn[1:] = np.remainder(np.diff(command, axis=0) + math.pi, 2.0 * math.pi) - math.pi
    share = np.minimum(0.5 * np.abs(turn) / (rate * period_s), 0.5)
    return np.asarray(command - share * turn, dtype=np.float64)


def _stretches(t_s: Array, period_s: float) -> tuple[tuple[int, int], ...]:
    breaks = np.flatnonzero(np.diff(t_s) > _GAP_PERIODS * period_s) + 1
    edges = [0, *breaks.tolist(), len(t_s)]
    return tuple((a, b) for a, b in itertools.pairwise(edges) if (b - a) * period_s >= 2.0)


def lagged(manoeuvre: Manoeuvre, lag_s: float) -> Array:
    """Mean force of each thruster between a tick and the next, (n, thrusters), when the force follows the command with a first-order lag."""
    if lag_s <= 1e-3:
        return manoeuvre.force_n
    from scipy.signal import lfilter

    decay = math.exp(-manoeuvre.period_s / lag_s)
    mean_share = lag_s / manoeuvre.period_s * (1.0 - decay)
    result = np.empty_like(manoeuvre.force_n)
    for first, end in manoeuvre.stretches:
        command = manoeuvre.force_n[first:end]
        start = command[:1]
        begin, _ = lfilter([0.0, 1.0 - decay], [1.0, -decay], command, axis=0, zi=start.copy())
        result[first:end] = command + (begin - command) * mean_share
    return result


def group_wrenches(manoeuvre: Manoeuvre, log: Log, groups: tuple[Group, ...], lag_s: float) -> list[tuple[Array, Array, Array]]:
    """For each group (surge_n, sway_n, yaw_nm about the group's own place on the centre line)."""
    force = lagged(manoeuvre, lag_s)
    ahead, aside = force * np.cos(manoeuvre.azimuth_rad), force * np.sin(manoeuvre.azimuth_rad)
    y_m: Any = np.array([thruster.y_m for thruster in log.config.thrusters])
    wrenches = []
    for group in groups:
        i = list(group.members)
        wrenches.append((ahead[:, i].sum(axis=1), aside[:, i].sum(axis=1), -(ahead[:, i] * y_m[i]).sum(axis=1)))
    return wrenches
