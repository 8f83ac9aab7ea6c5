"""Fit inertia, damping, thruster scales and lever arms of a hull to a recorded manoeuvre.

Prediction errors (Ljung 1999): the velocity residuals of `hull_model` are whitened by `disturbance`, whose numbers are
fitted to the same log, alternately. So a lasting gust is no evidence against a damping, even if a control loop answers
it.

The sum of squares includes the distances from the known model, each over its doubt. A quantity of which the log says no
more than that counts as not determined and keeps the model's value. Its doubt counts in the uncertainty of all others.
Multiplying all of inertia, damping and thrust by one number changes no motion, so the scale of the strongest group is
held; for a boat from dimensions the mass that was weighed sets it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from companion.analysis.disturbance import Disturbance, Whitener, most_likely
from companion.analysis.hull_model import CURRENT, INERTIA, HullModel, axis_drag
from companion.analysis.log_reader import Log
from companion.analysis.manoeuvre import Array, Manoeuvre
from companion.config.devices import ThrusterConfig
from companion.config.hull import HullConfig
from companion.core.progress import Told, Work, tell_nobody

SMALLEST = (2e-3, 2e-3, 5e-4)
"""m/s, m/s, rad/s: the best that an estimate can be."""
_INFORMED = 0.5  # share of the doubt: above it, the log adds nothing
_DRAG_INFORMED = 0.5  # relative uncertainty of an axis' damping above which its terms are not determined
_USUAL = 20  # evaluations of a fit, by quantity, about
_SHORTLY = 0.04  # share of the motion: what lags, dead bands and samples leave unexplained from one moment to the next
_TURNS = 8  # alternations of hull and disturbance
_SETTLED = 0.05  # change of the logarithm of a gust's size that counts as none
_SMOOTH_S = 1.5  # window of the derivative in the equation error
_UNMODELLED = 0.01  # share of the thrust: error of equations, forces and estimates, the least uncertainty of any result
_AXIS_TERMS = (("x_u", "x_uu", "x_uuu"), ("y_v", "y_vv"), ("n_r", "n_rr"))


@dataclass(frozen=True, slots=True)
class Estimate:
    """One quantity. `sigma` is None where it was held at `value`; `held` says why."""

    name: str
    value: float
    sigma: float | None
    model: float
    held: str = ""


@dataclass(frozen=True, slots=True)
class Drag:
    """Damping of one axis at `speed`, the RMS of the speeds in the log: force in N or Nm, its one sigma, and the old
    model's force. `determined`: whether this log determines it."""

    speed: float
    force: float
    sigma: float
    model: float
    determined: bool


@dataclass(frozen=True, slots=True)
class HullFit:
    """The result. `simulated`: (n, 3) velocities of the fitted model; `residual_rms`: of what it does not explain.
    `gusts`: one sigma of the disturbance in N, N and Nm."""

    estimates: tuple[Estimate, ...]
    drags: tuple[Drag, Drag, Drag]
    hull: HullConfig
    thrusters: tuple[ThrusterConfig, ...]
    simulated: Array
    residual_rms: tuple[float, float, float]
    explained: tuple[float, float, float]  # share of the variance, at most 1
    gusts: tuple[float, float, float]


def fit(
    log: Log, manoeuvre: Manoeuvre, hold: Sequence[str] = (), mounting: bool = False, told: Told = tell_nobody
) -> HullFit:
    """Fit the hull to the manoeuvre. `hold`: quantities to leave at the model's value (`Estimate.name`). `mounting`:
    as in `HullModel`."""
    model = HullModel(log, manoeuvre, mounting)
    work = Work(told, "fitting the hull", _USUAL * len(model.model))
    strongest = f"scale {model.groups[0].name}"
    held = {strongest: "sets the scale of all forces and inertias"} if model.scale_known else {}
    held |= {name: "as asked" for name in hold if name in model.model}
    values, noise = settled(model, equation_error(model, held), held, work)
    undetermined: dict[str, str] = {}
    for _ in range(len(model.model)):
        names, covariance = _covariance(model, values, held, noise)
        new = set(_undetermined(model, values, names, covariance)) - set(undetermined)
        if not new:
            break
        undetermined |= dict.fromkeys(new, "not determined by this manoeuvre")
        start = {**values, **{name: model.model[name] for name in new}}
        values, noise = settled(model, start, held | undetermined, work)
    return _result(model, values, held | undetermined, names, covariance, noise)


def settled(
    model: HullModel, start: Mapping[str, float], held: Mapping[str, str], work: Work
) -> tuple[dict[str, float], list[Disturbance]]:
    """(values, disturbances): hull and disturbance, fitted alternately until the gusts no longer change.

    The white part is at least a share of the motion. Without it the fit would trade what the boat does over seconds for
    what it does from tick to tick, where the equations lack the most.
    """
    manoeuvre, values = model.manoeuvre, dict(start)
    least = (_SHORTLY * np.sqrt((manoeuvre.velocity**2).mean(axis=0))).tolist()
    noise: list[Disturbance] = []
    for _ in range(_TURNS):
        left, before = model.imbalance(values), noise
        starts = before or (None, None, None)
        noise = [
            most_likely(left[:, i], manoeuvre.stretches, manoeuvre.period_s, SMALLEST[i], starts[i]) for i in range(3)
        ]
        if before and all(
            abs(math.log(now.gust / then.gust)) < _SETTLED for now, then in zip(noise, before, strict=True)
        ):
            break
        noise = [replace(one, white=math.hypot(one.white, most)) for one, most in zip(noise, least, strict=True)]
        values = prediction_error(model, values, held, noise, work)
    return values, noise


def prediction_error(
    model: HullModel,
    start: Mapping[str, float],
    held: Mapping[str, str],
    noise: Sequence[Disturbance],
    work: Work,
) -> dict[str, float]:
    """Quantities with the least squares of the innovations and of the distances from what was known."""
    from scipy.optimize import least_squares

    problem = _Problem(model, start, held, noise)
    low, high = np.array([model.bounds(name) for name in problem.names]).T / problem.doubts
    first = np.clip(problem.at(start), low + 1e-9, high - 1e-9)

    def residuals(x: Array) -> Array:
        work.step()
        return problem.residuals(x)

    solution = least_squares(residuals, first, bounds=(low, high), xtol=1e-5, ftol=1e-6, max_nfev=30)
    return problem.values(solution.x)


class _Problem:
    """The squares to minimise, over the free quantities in units of their doubts."""

    def __init__(
        self, model: HullModel, start: Mapping[str, float], held: Mapping[str, str], noise: Sequence[Disturbance]
    ) -> None:
        self._model, self._start = model, dict(start)
        self._whiteners = [Whitener(one, model.manoeuvre.period_s) for one in noise]
        self.names = [name for name in start if name not in held]
        self.doubts = np.array([model.doubt(name) for name in self.names])
        self._known = self.at(model.model)

    def at(self, values: Mapping[str, float]) -> Array:
        """`values` as an array of the free quantities."""
        return np.asarray(np.array([values[name] for name in self.names]) / self.doubts, dtype=np.float64)

    def values(self, x: Array) -> dict[str, float]:
        """All quantities for an array of the free ones."""
        return {**self._start, **dict(zip(self.names, (x * self.doubts).tolist(), strict=True))}

    def residuals(self, x: Array) -> Array:
        """What is squared: innovations, then distances from what was known."""
        left = self._model.imbalance(self.values(x))
        stretches = self._model.manoeuvre.stretches
        return np.concatenate(
            [*(whitener(left[:, i], stretches) for i, whitener in enumerate(self._whiteners)), x - self._known]
        )


def _covariance(
    model: HullModel, values: Mapping[str, float], held: Mapping[str, str], noise: Sequence[Disturbance]
) -> tuple[list[str], Array]:
    """(names, covariance) of all quantities not in `held`, at `values`. It includes the effect of a force of
    `_UNMODELLED` on each axis."""
    problem = _Problem(model, values, held, noise)
    x = problem.at(values)
    here, step = problem.residuals(x), 1e-4
    slopes = np.stack([(problem.residuals(x + step * unit) - here) / step for unit in np.eye(len(x))], axis=1)
    covariance = np.linalg.inv(slopes.T @ slopes) * np.outer(problem.doubts, problem.doubts)
    return problem.names, np.asarray(
        covariance + np.diag(_unmodelled(model, values, problem.names) ** 2), dtype=np.float64
    )


def _unmodelled(model: HullModel, values: Mapping[str, float], names: Sequence[str]) -> Array:
    """(quantities,): change of each that is equivalent to a force of `_UNMODELLED`, on the axis where it shows most."""
    smooth, slope = _smoothed(model.manoeuvre)
    base = _unbalanced(model, values, smooth, slope)
    least = _UNMODELLED * np.sqrt((model.thrust(values) ** 2).mean(axis=0))
    changes = []
    for name in names:
        step = 1e-3 * model.doubt(name)
        effect = (_unbalanced(model, {**values, name: values[name] + step}, smooth, slope) - base) / step
        size = np.sqrt((effect**2).mean(axis=0))
        shows = size > 1e-9
        changes.append(min(float((least[shows] / size[shows]).min()), model.doubt(name)) if shows.any() else 0.0)
    return np.array(changes)


def _undetermined(model: HullModel, values: Mapping[str, float], names: Sequence[str], covariance: Array) -> list[str]:
    """Quantities that the log hardly determines. Linear and quadratic damping of an axis can replace each other, so
    they are judged together."""
    sigmas = dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    found = [
        name
        for name, sigma in sigmas.items()
        if name not in (*CURRENT, *model.weather) and sigma > _INFORMED * model.doubt(name)
    ]
    for drag, terms in zip(_drags(model, values, names, covariance), _AXIS_TERMS, strict=True):
        if not drag.determined:
            found += [term for term in terms if term in names]
    return found


def _drags(
    model: HullModel, values: Mapping[str, float], names: Sequence[str], covariance: Array
) -> tuple[Drag, Drag, Drag]:
    speeds = np.sqrt((model.manoeuvre.velocity**2).mean(axis=0)).tolist()
    hull = model.hull(values)
    found = []
    for axis, (speed, terms) in enumerate(zip(speeds, _AXIS_TERMS, strict=True)):
        slopes = np.array([speed ** (terms.index(name) + 1) if name in terms else 0.0 for name in names])
        force, sigma = axis_drag(hull, axis, speed), math.sqrt(max(float(slopes @ covariance @ slopes), 0.0))
        held = sigma == 0.0
        found.append(
            Drag(
                speed,
                force,
                sigma,
                axis_drag(model.log.config.hull, axis, speed),
                held or sigma <= _DRAG_INFORMED * abs(force),
            )
        )
    return found[0], found[1], found[2]


def _result(
    model: HullModel,
    values: Mapping[str, float],
    held: Mapping[str, str],
    names: Sequence[str],
    covariance: Array,
    noise: Sequence[Disturbance],
) -> HullFit:
    sigmas = dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    estimates = tuple(
        Estimate(name, values[name], None if name in held else sigmas[name], model.model[name], held.get(name, ""))
        for name in model.model
    )
    measured, simulated = model.manoeuvre.velocity, model.simulate(values)
    rows = np.concatenate([np.arange(first, end) for first, end in model.manoeuvre.stretches])
    rest = (measured - simulated)[rows]
    explained = 1.0 - rest.var(axis=0) / np.maximum(measured[rows].var(axis=0), 1e-12)
    rms = np.sqrt((rest**2).mean(axis=0))
    masses = [values[name] for name in INERTIA]
    return HullFit(
        estimates=estimates,
        drags=_drags(model, values, names, covariance),
        hull=model.hull(values),
        thrusters=model.thrusters(values),
        simulated=simulated,
        residual_rms=tuple(rms.tolist()),
        explained=tuple(explained.tolist()),
        gusts=(masses[0] * noise[0].gust, masses[1] * noise[1].gust, masses[2] * noise[2].gust),
    )


def equation_error(model: HullModel, held: Mapping[str, str]) -> dict[str, float]:
    """Least squares of the force balance, with accelerations from a smoothing derivative: the start for the prediction
    error."""
    from scipy.optimize import lsq_linear

    manoeuvre, values = model.manoeuvre, dict(model.model)
    smooth, slope = _smoothed(manoeuvre)
    keep = np.concatenate([np.arange(a, b) for a, b in manoeuvre.stretches])
    # m33 keeps the model's value here: the yaw balance determines only its ratio to the arms
    names = [name for name in values if name not in held and name not in ("lag_s", "m33_kgm2")]
    limits = model.log.config.limits
    weights = np.repeat(1.0 / np.array([limits.surge_n, max(limits.sway_n, 1.0), limits.yaw_nm]), len(keep))
    for _ in range(3):  # not linear (scale times arm, wind force): repeat from the last result
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
