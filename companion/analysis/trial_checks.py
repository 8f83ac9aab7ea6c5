"""What a Trial's log says of the boat beside its hull: dead band of the thrusters, heading of each source, lever arms
of receiver and inertial sensor, and the accelerometer's offset.

Each comes with a 95 % interval, or with the manoeuvre that would tell it. Intervals count correlated residuals once: of
n residuals whose neighbours correlate by ρ, n (1 − ρ)/(1 + ρ) count. Dead band and antenna are judged by the whitened
residuals of `hull_fit`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from companion.analysis.disturbance import Noise, most_likely
from companion.analysis.hull_fit import HullFit
from companion.analysis.hull_model import ANTENNA, HEADING, HullModel
from companion.analysis.hull_search import SMALLEST
from companion.analysis.log_reader import Log, read_table
from companion.analysis.manoeuvre import Array, Manoeuvre
from companion.analysis.trial_log import Ran
from companion.core.readings import Heading, Imu, Reading
from companion.nav.lever_arms import normal_gravity_mps2
from companion.record.readings import path_in, read_kind

DEAD_BAND = "dead band of the thrusters"
PLACE_AHEAD, PLACE_ASIDE = "place ahead", "place to starboard"
_NINETY_FIVE = 1.96
_LEAST_COUNT = 4.0  # residuals that count, at least
_BANDS = np.arange(0.0, 0.25, 0.005)
_LEAST_BANDS = 10  # that are tried
_TURNS = ("spin", "turning circle")
_SPINS = "spins at 80 % to both sides"
_SMOOTH_S = 0.7
_LEVER_TOLD = 0.15  # of the boat's length: a wider interval says nothing of a lever arm
_PIVOT = (0.1, 0.04)  # of the boat's length: by how much a hull may turn round a point ahead or abeam of its middle
_MODELLED = 0.07  # of the boat's length: lever arm that errors of the model's motion in a turn amount to
_BAND_TOLD = 0.06
_HEADING_TOLD = math.radians(3.0)
_BIAS_TOLD = 0.15  # m/s²


@dataclass(frozen=True, slots=True)
class Check:
    """One quantity: `value` ± `interval` (95 %) in `unit`; `file`: what the vessel's file says. `would`: the manoeuvre
    that would tell it, where the log does not. `against`: what `file` is, for people."""

    name: str
    value: float
    interval: float
    unit: str
    file: float
    would: str = ""
    against: str = "the file has"

    @property
    def told(self) -> bool:
        """Whether the log tells it."""
        return not self.would

    @property
    def differs(self) -> bool:
        """Whether the file's value lies outside the interval."""
        return self.told and abs(self.value - self.file) > self.interval

    @property
    def text(self) -> str:
        """One line for people."""
        if not self.told:
            return f"{self.name}: the log does not tell it (± {self.interval:.2g} {self.unit}); {self.would} would"
        file = f"{self.against} {self.file:.3g}" + (", which is outside" if self.differs else "")
        return f"{self.name}: {self.value:.3g} ± {self.interval:.2g} {self.unit}; {file}"


def checks(model: HullModel, fit: HullFit, ran: Sequence[Ran], warnings: list[str]) -> tuple[Check, ...]:
    """All checks that the vessel's equipment allows. Raises LogError, OSError."""
    log, evidence = model.log, _Evidence(model, fit)
    values = {estimate.name: estimate.value for estimate in fit.estimates}
    path = path_in(log.folder)
    inertial = _by_source(read_kind(path, "imu", warnings)) if path.exists() else {}
    bearings = _by_source(read_kind(path, "heading", warnings)) if path.exists() else {}
    turns = _turning(model, values, ran)
    found = [
        dead_band_check(evidence, log),
        *_receiver(fit, log, _by_source(read_kind(path, "gnss", warnings)) if path.exists() else ()),
        *(check for sensor, seen in inertial.items() for check in inertial_checks(log, turns, sensor, seen)),
        _heading(fit),
        *_headings(model, values, bearings),
    ]
    return tuple(found)


def _by_source(readings: Sequence[Reading]) -> dict[str, list[Reading]]:
    found: dict[str, list[Reading]] = {}
    for reading in readings:
        found.setdefault(reading.source, []).append(reading)
    return found


# --- least squares with correlated residuals -----------------------------------------------------------------------


def _counting(residuals: Array) -> float:
    """How many of the residuals count."""
    n = len(residuals)
    centred = residuals - residuals.mean()
    power = float(centred @ centred)
    rho = float(centred[1:] @ centred[:-1]) / power if power > 0.0 and n > 2 else 0.0
    return max(_LEAST_COUNT, n * (1.0 - max(0.0, rho)) / (1.0 + max(0.0, rho)))


def _free(residuals: Array, quantities: int) -> float:
    """Degrees of freedom that are left beside so many quantities."""
    return max(1.0, _counting(residuals) - quantities)


def _fitted(columns: Array, seen: Array) -> tuple[Array, Array]:
    """(solution, half 95 % intervals) of least squares."""
    solution, *_ = np.linalg.lstsq(columns, seen, rcond=None)
    rest = seen - columns @ solution
    inflated = float(rest @ rest) / _free(rest, columns.shape[1])
    covariance = np.linalg.pinv(columns.T @ columns) * inflated
    half = _NINETY_FIVE * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return np.asarray(solution, dtype=np.float64), np.asarray(half, dtype=np.float64)


# --- beside the fit of the hull ------------------------------------------------------------------------------------


class _Evidence:
    """The whitened residuals of the fit (`hull_fit`), as they change with a dead band, which it does not have. All that
    was fitted may change with it, to first order, at its prior's price."""

    def __init__(self, model: HullModel, found: HullFit) -> None:
        self._model = model
        self._values = {estimate.name: estimate.value for estimate in found.estimates}
        self._names = [estimate.name for estimate in found.estimates if estimate.sigma is not None]
        band = model.band
        left = band.sampled(model.imbalance(self._values))
        axes = [most_likely(left[:, k], band.stretches, band.period_s, SMALLEST[k]) for k in range(3)]
        self._noise = Noise(axes, band.period_s, band.stretches, left)
        self._throttle = _throttles(model.log, model.manoeuvre.t_s)
        doubts = np.array([model.doubt(name) for name in self._names])
        here = self.residuals()
        step = 1e-3
        slopes = [
            (self.residuals({name: self._values[name] + step * doubt}) - here) / step
            for name, doubt in zip(self._names, doubts.tolist(), strict=True)
        ]
        self._slopes = np.concatenate([np.stack(slopes, axis=1), np.eye(len(doubts))])
        prior = [(self._values[name] - model.model[name]) / model.doubt(name) for name in self._names]
        self._prior = np.array(prior)

    def residuals(self, changed: Mapping[str, float] | None = None, band: float = 0.0) -> Array:
        """In sigmas. `changed`: quantities of the fit; `band`: the thrusters give nothing below that throttle."""
        manoeuvre = self._model.manoeuvre
        force_n = np.where(np.abs(self._throttle) < band, 0.0, manoeuvre.force_n)
        model = HullModel(self._model.log, replace(manoeuvre, force_n=force_n), mounting=True)
        left = model.imbalance({**self._values, **(changed or {})})
        return np.asarray(self._noise(self._model.band.sampled(left)).ravel(), dtype=np.float64)

    def squares(self, band: float) -> float:
        """The least sum of squares with that dead band."""
        seen = np.concatenate([self.residuals(band=band), self._prior])
        step, *_ = np.linalg.lstsq(self._slopes, -seen, rcond=None)
        rest = seen + self._slopes @ step
        return float(rest @ rest)


def dead_band_check(evidence: _Evidence, log: Log) -> Check:
    """Throttle below which the thrusters give nothing: the one that explains the log best."""
    file = max(thruster.dead_band for thruster in log.config.thrusters)
    bands = _BANDS[file - 1e-9 <= _BANDS] if file < _BANDS[-_LEAST_BANDS] else file + _BANDS[:_LEAST_BANDS]
    squares = np.array([evidence.squares(float(band)) for band in bands])
    likely = bands[squares <= squares.min() + _NINETY_FIVE**2]
    value = 0.5 * float(likely.max() + likely.min())
    half = 0.5 * float(likely.max() - likely.min()) + 0.5 * float(_BANDS[1])
    would = "" if half <= _BAND_TOLD else "the manoeuvre dead band in calm water, or a time in Hold,"
    return Check(DEAD_BAND, value, half, "of full throttle", file, would)


def _throttles(log: Log, t_s: Array) -> Array:
    """(n, thrusters): throttle commanded."""
    names = [f"{thruster.name}_throttle" for thruster in log.config.thrusters]
    table = read_table(log.folder / "ticks.csv", ("t_s", *names), [])
    at = np.searchsorted(np.array(table["t_s"]), t_s - 1e-6)
    return np.asarray(np.nan_to_num(np.stack([np.array(table[name])[at] for name in names], axis=1)), dtype=np.float64)


def _receiver(fit: HullFit, log: Log, receivers: Collection[str]) -> list[Check]:
    """Where the antenna is: its turning round the middle of the boat shows as speed, −r y ahead and r x to starboard. A
    hull that turns round another point (`_PIVOT`) looks the same."""
    row = next((sensor for sensor in log.config.sensors if sensor.name in receivers), None)
    if row is None:
        return []
    length_m = log.config.length_m
    by = {estimate.name: estimate for estimate in fit.estimates}
    checks = []
    places = (PLACE_AHEAD, row.x_m), (PLACE_ASIDE, row.y_m)
    for (where, file), name, pivot in zip(places, ANTENNA, _PIVOT, strict=True):
        sigma = by[name].sigma
        interval = math.inf if sigma is None else math.hypot(_NINETY_FIVE * sigma, pivot * length_m)
        would = "" if interval <= _LEVER_TOLD * length_m else f"{_SPINS}, in calm water,"
        checks.append(Check(f"{row.name}: {where}", file + by[name].value, interval, "m", file, would))
    return checks


def _turning(model: HullModel, values: Mapping[str, float], ran: Sequence[Ran]) -> Manoeuvre:
    """The turns alone, with the velocities that the forces explain: the estimate follows the inertial sensor itself."""
    manoeuvre = model.manoeuvre
    stretches = []
    for first, end in manoeuvre.stretches:
        for one in ran:
            if one.name.startswith(_TURNS):
                a, b = np.searchsorted(manoeuvre.t_s[first:end], (one.from_s, one.to_s)).tolist()
                stretches.append((first + a, first + b))
    part = replace(manoeuvre, stretches=tuple(stretches))
    velocity = HullModel(model.log, part, mounting=True).simulate(values)
    velocity[:, 2] = manoeuvre.velocity[:, 2]
    return replace(part, velocity=velocity)


# --- inertial sensor -----------------------------------------------------------------------------------------------


def inertial_checks(log: Log, manoeuvre: Manoeuvre, source: str, readings: Sequence[Reading]) -> list[Check]:
    """Lever arm by what a turn adds to the acceleration (−r² l and ṙ l), the offset of the horizontal axes, and gravity
    against the normal one. The boat's tilt is the sensor's own, where it gives one."""
    row = next((sensor for sensor in log.config.sensors if sensor.name == source), None)
    seen = [reading for reading in readings if isinstance(reading, Imu)]
    if row is None or len(seen) < 100:
        return []
    gravity = normal_gravity_mps2(log.config.home.lat_deg)
    motion = _accelerations(manoeuvre)
    if motion is None:
        return []
    t_s, body, rate, turn = motion
    force = _smoothed_force(seen, t_s, gravity)
    zero, one = np.zeros_like(rate), np.ones_like(rate)
    columns = np.concatenate(
        [
            np.stack([one, zero, -(rate**2), -turn], axis=1),
            np.stack([zero, one, turn, -(rate**2)], axis=1),
        ]
    )
    solution, half = _fitted(columns, np.concatenate([force[:, 0] - body[:, 0], force[:, 1] - body[:, 1]]))
    rows = (
        (PLACE_AHEAD, 2, "m", row.x_m, _LEVER_TOLD * log.config.length_m, _SPINS),
        (PLACE_ASIDE, 3, "m", row.y_m, _LEVER_TOLD * log.config.length_m, _SPINS),
        ("offset ahead", 0, "m/s²", 0.0, _BIAS_TOLD, "drifting for a minute in calm water"),
        ("offset to starboard", 1, "m/s²", 0.0, _BIAS_TOLD, "drifting for a minute in calm water"),
    )
    found = []
    for what, k, unit, file, told_below, would in rows:
        interval = math.hypot(float(half[k]), _MODELLED * log.config.length_m) if unit == "m" else float(half[k])
        told = interval <= told_below
        against = "the file has" if unit == "m" else "expected"
        value = float(solution[k])
        found.append(Check(f"{source}: {what}", value, interval, unit, file, "" if told else would, against))
    size = np.array([math.hypot(one.x_mps2, one.y_mps2, one.z_mps2) for one in seen])
    spread = _NINETY_FIVE * float(size.std()) / math.sqrt(_counting(size))
    found.append(Check(f"{source}: gravity", float(size.mean()), max(spread, 0.01), "m/s²", gravity, "", "expected"))
    return found


def _accelerations(manoeuvre: Manoeuvre) -> tuple[Array, Array, Array, Array] | None:
    """(times, (n, 2) acceleration of the middle of the boat in body axes, yaw rate, yaw acceleration), smoothed; None
    for a log without a long stretch."""
    from scipy.signal import savgol_filter

    window = max(5, int(_SMOOTH_S / manoeuvre.period_s) | 1)
    parts = []
    for first, end in manoeuvre.stretches:
        if end - first > 3 * window:
            v = manoeuvre.velocity[first:end]
            smooth = savgol_filter(v, window, 2, axis=0)
            slope = savgol_filter(v, window, 2, deriv=1, delta=manoeuvre.period_s, axis=0)
            u, s, r = smooth.T
            body = np.stack([slope[:, 0] - s * r, slope[:, 1] + u * r], axis=1)
            parts.append((manoeuvre.t_s[first:end], body, r, slope[:, 2]))
    if not parts:
        return None
    t_s, body, rate, turn = (np.concatenate(column) for column in zip(*parts, strict=True))
    return t_s, body, rate, turn


def _smoothed_force(readings: Sequence[Imu], t_s: Array, gravity: float) -> Array:
    """(n, 2): specific force ahead and to starboard at `t_s` without gravity's share, averaged over `_SMOOTH_S`."""
    times = np.array([one.t_s for one in readings])
    pitch = np.array([one.pitch_rad or 0.0 for one in readings])
    roll = np.array([one.roll_rad or 0.0 for one in readings])
    x = np.array([one.x_mps2 for one in readings]) - gravity * np.sin(pitch)
    y = np.array([one.y_mps2 for one in readings]) + gravity * np.sin(roll) * np.cos(pitch)
    first = np.searchsorted(times, t_s - 0.5 * _SMOOTH_S)
    end = np.maximum(first + 1, np.searchsorted(times, t_s + 0.5 * _SMOOTH_S))
    found = []
    for column in (x, y):
        total = np.concatenate([[0.0], np.cumsum(column)])
        end_in, first_in = np.minimum(end, len(column)), np.minimum(first, len(column) - 1)
        found.append((total[end_in] - total[first_in]) / np.maximum(1, end_in - first_in))
    return np.stack(found, axis=1)


# --- headings ------------------------------------------------------------------------------------------------------


def _heading(fit: HullFit) -> Check:
    """By how much the boat's heading reads too much, as the fit of the hull found it."""
    one = next(estimate for estimate in fit.estimates if estimate.name == HEADING)
    half = math.inf if one.sigma is None else math.degrees(_NINETY_FIVE * one.sigma)
    would = "" if one.sigma is not None else "surge steps ahead and astern at 60 %"
    return Check("heading: reads too much by", math.degrees(one.value), half, "deg", 0.0, would, "expected")


def _headings(model: HullModel, values: dict[str, float], readings: dict[str, list[Reading]]) -> list[Check]:
    """By how much each source of heading reads too much, beside what the fit found for the boat's own heading."""
    if len(readings) < 2:
        return []  # one source: it is the boat's heading
    t_s, yaw = model.manoeuvre.t_s, np.unwrap(model.manoeuvre.yaw_rad)
    found = []
    for source, rows in readings.items():
        seen = [one for one in rows if isinstance(one, Heading) and t_s[0] <= one.t_s <= t_s[-1]]
        if len(seen) < 20:
            continue
        own = np.interp([one.t_s for one in seen], t_s, yaw)
        off = np.array([math.remainder(one.yaw_rad - at, math.tau) for one, at in zip(seen, own.tolist(), strict=True)])
        half = _NINETY_FIVE * float(off.std()) / math.sqrt(_counting(off))
        value = float(off.mean()) + values.get("heading_error_rad", 0.0)
        would = "" if half <= _HEADING_TOLD else "two slow circles to each side"
        found.append(
            Check(
                f"{source}: reads too much by", math.degrees(value), math.degrees(half), "deg", 0.0, would, "expected"
            )
        )
    return found
