"""A recorded manoeuvre for `identify`: the estimated velocities, and the forces commanded from each thruster."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.analysis.band import wave_period_s
from companion.analysis.blade import Blade, blade_of
from companion.analysis.log_reader import Log, LogError, read_table
from companion.config.devices import ThrusterConfig
from companion.core.readings import Wind
from companion.record import readings

Array = NDArray[np.float64]

_LEAST_S = 30.0
_SLOPE_S = 0.7  # window of the yaw acceleration
_LONGEST_DELAY_S = 0.3
_WIND_S = 2.0  # window in which the measured wind is averaged
_WIND_SHARE = 0.9  # share of ticks with a measured wind from which it is used
_GAP_PERIODS = 1.6  # a longer pause between two ticks begins a new stretch
_STRETCH_S = 2.0  # the shortest stretch that is used


@dataclass(frozen=True, slots=True)
class Group:
    """Thrusters that share a scale and a lever arm: of the same kind, at the same place along the hull."""

    name: str
    members: tuple[int, ...]
    x_m: float
    max_n: float
    blade: Blade | None = None  # of a propeller with a rudder, whose place `x_m` then is


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """Arrays over the ticks.

    `velocity`: (n, 3) surge, sway, yaw rate. `force_n`, (n, thrusters): commanded until the next tick; `azimuth_rad`,
    (n, thrusters): its mean until then. `stretches`: (first, end) of rows without a gap. `wind_mps`, (n, 2): the air's
    velocity towards north and east over ground, None without a wind sensor. `wave_s`: period of the waves that were
    met, None without. `commanded`: times and forces of the whole log, of which the ticks are a part; None: of no more.
    """

    t_s: Array
    yaw_rad: Array
    velocity: Array
    force_n: Array
    azimuth_rad: Array
    stretches: tuple[tuple[int, int], ...]
    period_s: float
    wind_mps: Array | None = None
    wave_s: float | None = None
    commanded: tuple[Array, Array] | None = None


def groups_of(thrusters: tuple[ThrusterConfig, ...], apart: bool = False) -> tuple[Group, ...]:
    """Groups of thrusters, the strongest first. `apart`: those side by side are groups of their own, since two motors
    of one kind differ by some percent, which turns a boat."""
    found: dict[tuple[float, ...], list[int]] = {}
    for i, thruster in enumerate(thrusters):
        side = (thruster.y_m,) if apart else ()
        found.setdefault((thruster.x_m, thruster.ahead_n, thruster.astern_n, *side), []).append(i)
    groups = [
        Group(
            "+".join(thrusters[i].name for i in members),
            tuple(members),
            x_m if (rudder := thrusters[members[0]].rudder) is None else rudder.x_m,
            sum(thrusters[i].max_n for i in members),
            blade_of(thrusters[members[0]]),
        )
        for (x_m, *_), members in found.items()
    ]
    return tuple(sorted(groups, key=lambda group: -group.max_n))


def read_manoeuvre(log: Log, warnings: list[str], from_s: float = 0.0, to_s: float = math.inf) -> Manoeuvre:
    """The armed part of ticks.csv between two times. Raises LogError where it is too short, OSError."""
    if any(thruster.kind == "jet" for thruster in log.config.thrusters) or log.config.hull.resistance:
        raise LogError(
            f"{log.folder}: thrust of a jet and resistance of a planing hull depend on speed by curves, "
            "which this fit does not have"
        )
    if log.config.has_sail:
        raise LogError(f"{log.folder}: the force of a sail depends on the wind by curves, which this fit does not have")
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
        raise LogError(
            f"{log.folder}: {use.sum() * period_s:.0f} s armed with a position; "
            f"identifying a hull needs at least {_LEAST_S:.0f} s"
        )
    stretches = _stretches(t_s[use], period_s)
    if (whole_s := sum(b - a for a, b in stretches) * period_s) < _LEAST_S:
        raise LogError(
            f"{log.folder}: of {use.sum() * period_s:.0f} s armed with a position only {whole_s:.0f} s have no gap for "
            f"{_STRETCH_S:.0f} s; identifying a hull needs at least {_LEAST_S:.0f} s of such stretches"
        )
    azimuth = np.stack([values[f"{name}_azimuth_rad"] for name in names], axis=1)
    rest = np.array([thruster.azimuth_rad for thruster in log.config.thrusters])
    yaw_rad = values["yaw_rad"][use]
    velocity = np.stack([values[name][use] for name in ("surge_mps", "sway_mps", "yaw_rate_radps")], axis=1)
    velocity[:, 2] = timely(velocity[:, 2], yaw_rad, stretches, period_s)
    force = np.nan_to_num(np.stack([values[f"{name}_force_n"] for name in names], axis=1))
    timed = np.isfinite(t_s)
    return Manoeuvre(
        t_s=t_s[use],
        yaw_rad=yaw_rad,
        velocity=velocity,
        force_n=force[use],
        azimuth_rad=_mean_azimuth(np.where(np.isnan(azimuth), rest, azimuth), log, period_s)[use],
        stretches=stretches,
        period_s=period_s,
        wind_mps=measured_wind(log, warnings, t_s[use], yaw_rad, velocity),
        wave_s=wave_period_s(velocity, stretches, period_s),
        commanded=(t_s[timed], force[timed]),
    )


def timely(yaw_rate: Array, yaw_rad: Array, stretches: tuple[tuple[int, int], ...], period_s: float) -> Array:
    """The yaw rate without the delay of the estimate's low-pass: 50 ms would change the yaw damping by a tenth."""
    from scipy.signal import savgol_filter

    window = max(5, int(_SLOPE_S / period_s) | 1)
    slope, late, weight = np.zeros_like(yaw_rate), 0.0, 0.0
    for first, end in stretches:
        if end - first > window:
            rate, heading = yaw_rate[first:end], np.unwrap(yaw_rad[first:end])
            slope[first:end] = savgol_filter(rate, window, 2, deriv=1, delta=period_s)
            turned = (heading[2:] - heading[:-2]) / (2.0 * period_s)
            mean = 0.25 * (rate[2:] + 2.0 * rate[1:-1] + rate[:-2])
            late += float(slope[first + 1 : end - 1] @ (turned - mean))
            weight += float(slope[first + 1 : end - 1] @ slope[first + 1 : end - 1])
    delay_s = min(max(late / weight, 0.0), _LONGEST_DELAY_S) if weight > 0.0 else 0.0
    return np.asarray(yaw_rate + delay_s * slope, dtype=np.float64)


def measured_wind(log: Log, warnings: list[str], t_s: Array, yaw_rad: Array, velocity: Array) -> Array | None:
    """(n, 2) from the wind readings, with their noise averaged; None where they are missing most of the time."""
    path = readings.path_in(log.folder)
    if not path.exists():
        return None
    found = [reading for reading in readings.read_kind(path, "wind", warnings) if isinstance(reading, Wind)]
    if not found:
        return None
    when = np.array([reading.t_s for reading in found])
    size, towards = (
        np.array([reading.speed_mps for reading in found]),
        np.array([reading.from_rad for reading in found]) + math.pi,
    )
    yaw = np.interp(when, t_s, np.unwrap(yaw_rad))
    surge, sway = (np.interp(when, t_s, velocity[:, axis]) for axis in (0, 1))
    x, y = size * np.cos(towards) + surge, size * np.sin(towards) + sway
    north, east = x * np.cos(yaw) - y * np.sin(yaw), x * np.sin(yaw) + y * np.cos(yaw)
    first, end = (np.searchsorted(when, t_s + side * 0.5 * _WIND_S) for side in (-1.0, 1.0))
    if np.mean(end > first) < _WIND_SHARE:
        warnings.append("the wind sensor was silent for too long: its wind is not used")
        return None
    sums = [np.concatenate([[0.0], np.cumsum(part)]) for part in (north, east)]
    means = [np.where(end > first, (total[end] - total[first]) / np.maximum(end - first, 1), np.nan) for total in sums]
    whole = np.isfinite(means[0])
    return np.stack([np.interp(t_s, t_s[whole], mean[whole]) for mean in means], axis=1)


def _mean_azimuth(command: Array, log: Log, period_s: float) -> Array:
    """Mean azimuth in a tick, of a drive that turns at its rate from the last command to this one."""
    rate = np.array([max(t.azimuth_rate_radps, 1e-6) for t in log.config.thrusters])
    turn = np.zeros_like(command)
    turn[1:] = np.remainder(np.diff(command, axis=0) + math.pi, 2.0 * math.pi) - math.pi
    share = np.minimum(0.5 * np.abs(turn) / (rate * period_s), 0.5)
    return np.asarray(command - share * turn, dtype=np.float64)


def _between_gaps(t_s: Array, period_s: float) -> list[tuple[int, int]]:
    breaks = np.flatnonzero(np.diff(t_s) > _GAP_PERIODS * period_s) + 1
    return list(itertools.pairwise([0, *breaks.tolist(), len(t_s)]))


def _stretches(t_s: Array, period_s: float) -> tuple[tuple[int, int], ...]:
    return tuple((a, b) for a, b in _between_gaps(t_s, period_s) if (b - a) * period_s >= _STRETCH_S)


def lagged(manoeuvre: Manoeuvre, lag_s: float) -> Array:
    """Mean force of each thruster between a tick and the next, (n, thrusters), with a first-order lag. A stretch that
    begins within the log begins with what the commands of before have left."""
    if lag_s <= 1e-3:
        return manoeuvre.force_n
    from scipy.signal import lfilter

    decay = math.exp(-manoeuvre.period_s / lag_s)
    mean_share = lag_s / manoeuvre.period_s * (1.0 - decay)
    t_s, force = manoeuvre.commanded or (manoeuvre.t_s, manoeuvre.force_n)
    ticks = np.searchsorted(t_s, manoeuvre.t_s)
    force = force.copy()
    force[ticks] = manoeuvre.force_n
    result = np.zeros_like(force)
    for first, end in _between_gaps(t_s, manoeuvre.period_s):
        command = force[first:end]
        start = command[:1]
        begin, _ = lfilter([0.0, 1.0 - decay], [1.0, -decay], command, axis=0, zi=start.copy())
        result[first:end] = command + (begin - command) * mean_share
    return np.asarray(result[ticks], dtype=np.float64)


def group_wrenches(
    manoeuvre: Manoeuvre, log: Log, groups: tuple[Group, ...], lag_s: float
) -> list[tuple[Array, Array, Array]]:
    """(surge_n, sway_n, yaw_nm about the group's own place on the centre line) of each group; of a propeller with a
    rudder without its blade."""
    force = lagged(manoeuvre, lag_s)
    ahead, aside = force * np.cos(manoeuvre.azimuth_rad), force * np.sin(manoeuvre.azimuth_rad)
    y_m: Any = np.array([thruster.y_m for thruster in log.config.thrusters])
    wrenches = []
    for group in groups:
        i = list(group.members)
        x, y = (force, np.zeros_like(force)) if group.blade is not None else (ahead, aside)
        wrenches.append((x[:, i].sum(axis=1), y[:, i].sum(axis=1), -(x[:, i] * y_m[i]).sum(axis=1)))
    return wrenches
