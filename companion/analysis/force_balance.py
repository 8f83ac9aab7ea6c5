"""The force balance of a hull at each moment of a log, with accelerations from a smoothing derivative: where a fit
starts, and how far an error of the forces moves its quantities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from companion.analysis.hull_model import HullModel
from companion.analysis.manoeuvre import Array, Manoeuvre

_SMOOTH_S = 1.5  # window of the derivative
_ROUNDS = 3  # of linear least squares


def equation_error(model: HullModel, held: Mapping[str, str]) -> dict[str, float]:
    """Quantities with the least squares of the force balance."""
    from scipy.optimize import lsq_linear

    manoeuvre, values = model.manoeuvre, dict(model.model)
    smooth, slope = _smoothed(manoeuvre)
    keep = np.concatenate([np.arange(a, b) for a, b in manoeuvre.stretches])
    # m33 keeps the model's value here: the yaw balance determines only its ratio to the arms
    names = [name for name in values if name not in held and name not in ("lag_s", "m33_kgm2")]
    limits = model.log.config.limits
    weights = np.repeat(1.0 / np.array([limits.surge_n, max(limits.sway_n, 1.0), limits.yaw_nm]), len(keep))
    for _ in range(_ROUNDS):  # not linear (scale times arm, wind force): repeat from the last result
        base = _unbalanced(model, values, smooth, slope)
        columns = {
            name: _unbalanced(model, {**values, name: values[name] + 1e-3}, smooth, slope) - base for name in names
        }
        active = [name for name, column in columns.items() if np.any(np.abs(column[keep]) > 1e-12)]
        scales = np.array([model.doubt(name) for name in active])
        matrix = np.stack([columns[name][keep].T.ravel() * 1e3 for name in active], axis=1) * weights[:, None] * scales
        low, high = np.array([model.bounds(name) for name in active]).T
        start = np.array([values[name] for name in active])
        low, high = (low - start) / scales, (high - start) / scales
        step = lsq_linear(matrix, -base[keep].T.ravel() * weights, (low - 1e-9, high + 1e-9)).x * scales
        for name, change in zip(active, step.tolist(), strict=True):
            lowest, highest = model.bounds(name)
            values[name] = min(highest, max(lowest, values[name] + change))
    return values


def _unbalanced(model: HullModel, values: Mapping[str, float], velocity: Array, slope: Array) -> Array:
    """(n, 3): M ν̇ + C(ν) ν + D(ν) ν − τ."""
    velocity, slope = model.turned(velocity, values), model.turned(slope, values)
    stream = model.stream(values)
    turning = np.stack([-velocity[:, 2] * stream[:, 1], velocity[:, 2] * stream[:, 0], np.zeros(len(stream))], axis=1)
    force = model.reaction(values, velocity - stream) - model.weather_force(values) - model.thrust(values)
    return np.asarray((slope + turning) @ model.inertia(values).T + force, dtype=np.float64)


def _smoothed(manoeuvre: Manoeuvre) -> tuple[Array, Array]:
    """Velocity and acceleration by a Savitzky-Golay filter over each stretch."""
    from scipy.signal import savgol_filter

    smooth, slope = manoeuvre.velocity.copy(), np.zeros_like(manoeuvre.velocity)
    window = max(5, int(_SMOOTH_S / manoeuvre.period_s) | 1)
    for first, end in manoeuvre.stretches:
        if end - first > window:
            part = manoeuvre.velocity[first:end]
            smooth[first:end] = savgol_filter(part, window, 2, axis=0)
            slope[first:end] = savgol_filter(part, window, 2, deriv=1, delta=manoeuvre.period_s, axis=0)
    return smooth, slope


def equivalents(model: HullModel, values: Mapping[str, float], names: Sequence[str], share: float) -> Array:
    """(quantities,): change of each that is equivalent to a force of `share` of the thrust, on the axis where it shows
    most."""
    smooth, slope = _smoothed(model.manoeuvre)
    base = _unbalanced(model, values, smooth, slope)
    least = share * np.sqrt((model.thrust(values) ** 2).mean(axis=0))
    changes = []
    for name in names:
        step = 1e-3 * model.doubt(name)
        effect = (_unbalanced(model, {**values, name: values[name] + step}, smooth, slope) - base) / step
        size = np.sqrt((effect**2).mean(axis=0))
        shows = size > 1e-9
        changes.append(min(float((least[shows] / size[shows]).min()), model.doubt(name)) if shows.any() else 0.0)
    return np.array(changes)
