"""`companion identify`: inertia, damping, thruster scales and lever arms of a hull, fitted to a recorded manoeuvre.

M ν̇ + C(ν) ν + D(ν) ν = Σ scale·wrench(thruster group, lever arm, lag) + weather, with ν through the water of a steady current, and the weather a
steady wind on the vessel's windage or, for a vessel without, a force constant in NED. Gusts and waves stay unexplained.
First the equation error, which is linear in all unknowns but the lag; from there the output error: the model is run from the forces alone and
its velocities are compared with the estimated ones. All of inertia, damping and thrust may be multiplied by one number without any motion
telling: the scale of the strongest group is therefore held. So is every other quantity that the manoeuvre does not tell.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from companion.config import DampingConfig, HullConfig, ThrusterConfig
from companion.record.log_reader import Log
from companion.record.manoeuvre import Array, Group, Manoeuvre, group_wrenches, groups_of

_LAG_S = 0.3  # where the fit of the thrusters' lag begins
_CURRENT = ("current_north_mps", "current_east_mps")
_WIND = ("wind_north_m2ps2", "wind_east_m2ps2")  # velocity of the air times its speed
_FORCE = ("north_n", "east_n")
_AIR_KGPM3 = 1.225
_STANDARD = ("x_u", "x_uu", "y_v", "y_vv", "n_r", "n_rr")  # fitted whatever the model has
_RESISTING = frozenset({*_STANDARD, "x_uuu"})  # these cannot drive the boat
_INERTIA = ("m11_kg", "m22_kg", "m33_kgm2")
_DOUBTFUL = 0.2  # relative uncertainty beyond which an inertia, scale or arm counts as not told by the manoeuvre
_DOUBTFUL_CURRENT_MPS = 0.15
_MOST = 50.0  # times the scale of a quantity: no boat is beyond
_SMOOTH_S = 1.5  # window of the derivative in the equation error
_SMALLEST_SIGMA = (2e-3, 2e-3, 5e-4)


@dataclass(frozen=True, slots=True)
class Estimate:
    """One quantity. `sigma` is None where it was held at `value`, for the reason in `held`."""

    name: str
    value: float
    sigma: float | None
    model: float
    held: str = ""


@dataclass(frozen=True, slots=True)
class HullFit:
    """What came of it. `simulated` (n, 3) are the fitted model's velocities, `residual_rms` those of what it leaves unexplained."""

    estimates: tuple[Estimate, ...]
    hull: HullConfig
    thrusters: tuple[ThrusterConfig, ...]
    simulated: Array
    residual_rms: tuple[float, float, float]
    explained: tuple[float, float, float]  # share of the variance, 1 is all


class HullModel:
    """The equations over one manoeuvre, by named quantities. Remembers the manoeuvre and the wrenches of the last lag."""

    def __init__(self, log: Log, manoeuvre: Manoeuvre) -> None:
        self.log, self.manoeuvre = log, manoeuvre
        self.groups: tuple[Group, ...] = groups_of(log.config.thrusters)
        hull, damping, windage = log.config.hull, log.config.hull.damping, log.config.windage
        self._windy = windage.lateral_m2 > 0.0 and windage.frontal_m2 > 0.0
        terms = [name for name in DampingConfig.__slots__ if name in _STANDARD or getattr(damping, name) != 0.0]
        self.model: dict[str, float] = {
            **{name: getattr(hull, name) for name in _INERTIA},
            **{name: getattr(damping, name) for name in terms},
            **{f"scale {group.name}": 1.0 for group in self.groups},
            **{f"x_m {group.name}": group.x_m for group in self.groups},
            "lag_s": _LAG_S,
            **dict.fromkeys((*_CURRENT, *(_WIND if self._windy else _FORCE)), 0.0),
        }
        self.terms = tuple(terms)
        self._coupling = (hull.m23_kgm, hull.m23_kgm if hull.m32_kgm is None else hull.m32_kgm)
        self._lag_s = math.nan
        self._wrenches: list[tuple[Array, Array, Array]] = []

    def scale(self, name: str) -> float:
        """A size to count in."""
        length_m, hull = self.log.config.length_m, self.log.config.hull
        axis = {"x": hull.m11_kg, "y": hull.m22_kg, "n": hull.m33_kgm2}
        if name in _INERTIA or name.startswith("scale"):
            return self.model[name]
        if name.startswith("x_m"):
            return max(abs(self.model[name]), 0.1 * length_m)
        if name in self.terms:
            quadratic = len(name.split("_")[1]) > 1
            return axis[name[0]] * (1.0 if quadratic else 0.1)
        return {"lag_s": _LAG_S, **dict.fromkeys(_WIND, 1.0), **dict.fromkeys(_CURRENT, 0.05)}.get(name, 0.02 * self.log.config.limits.surge_n)

    def bounds(self, name: str) -> tuple[float, float]:
        model = self.model[name]
        if name in _INERTIA:
            return 0.3 * model, 3.0 * model
        if name.startswith("scale"):
            return 0.2, 5.0
        if name == "lag_s":
            return 0.0, 2.0
        most = _MOST * self.scale(name)  # beyond, the equations would be too stiff for the steps of a tick
        return (0.0 if name in _RESISTING else -most), most

    def wrench(self, values: Mapping[str, float]) -> Array:
        """(n, 3) of thrusters and constant force together."""
        if values["lag_s"] != self._lag_s:
            self._lag_s = values["lag_s"]
            self._wrenches = group_wrenches(self.manoeuvre, self.log, self.groups, self._lag_s)
        total = self._weather(values)
        for group, (x, y, n) in zip(self.groups, self._wrenches, strict=True):
            k, arm_m = values[f"scale {group.name}"], values[f"x_m {group.name}"]
            total += k * np.stack([x, y, n + arm_m * y], axis=1)
        return total

    def _weather(self, values: Mapping[str, float]) -> Array:
        """(n, 3); the wind as `companion.config.WindageConfig` has it, the boat's own speed left out of it."""
        c, s = np.cos(self.manoeuvre.yaw_rad), np.sin(self.manoeuvre.yaw_rad)
        north, east = (values[name] for name in (_WIND if self._windy else _FORCE))
        x, y = north * c + east * s, east * c - north * s
        if not self._windy:
            return np.stack([x, y, np.zeros_like(x)], axis=1)
        w, length_m = self.log.config.windage, self.log.config.length_m
        pressure = 0.5 * _AIR_KGPM3
        twist = -2.0 * pressure * w.cn * w.lateral_m2 * length_m * x * y / max(math.hypot(north, east), 1e-6)
        return np.stack([pressure * w.cx * w.frontal_m2 * x, pressure * w.cy * w.lateral_m2 * y, twist], axis=1)

    def simulate(self, values: Mapping[str, float]) -> Array:
        """Velocities (n, 3) from the forces alone, each stretch begun at the estimated velocity. Midpoint rule, a step for each two ticks."""
        force = self.wrench(values)
        force[:-1] = 0.5 * (force[:-1] + force[1:])
        forces = force.tolist()
        measured = self.manoeuvre.velocity
        result = np.empty_like(measured)
        half_s = self.manoeuvre.period_s
        step_s = 2.0 * half_s
        derivative = self._derivative(values)
        stream = self.stream(values)
        for first, end in self.manoeuvre.stretches:
            u, v, r = (measured[first : first + 5] - stream[first : first + 5]).mean(axis=0).tolist()
            rows = []
            for x, y, n in forces[first:end:2]:
                rows.append((u, v, r))
                du, dv, dr = derivative(u, v, r, x, y, n)
                half = (u + half_s * du, v + half_s * dv, r + half_s * dr)
                rows.append(half)
                du, dv, dr = derivative(*half, x, y, n)
                u, v, r = _held_in(u + step_s * du), _held_in(v + step_s * dv), _held_in(r + step_s * dr)
            result[first:end] = rows[: end - first]
        return np.add(result, stream, dtype=np.float64)

    def stream(self, values: Mapping[str, float]) -> Array:
        """(n, 3): the current's velocity in body axes."""
        c, s = np.cos(self.manoeuvre.yaw_rad), np.sin(self.manoeuvre.yaw_rad)
        north, east = (values[name] for name in _CURRENT)
        return np.stack([north * c + east * s, east * c - north * s, np.zeros_like(c)], axis=1)

    def _derivative(self, values: Mapping[str, float]) -> Any:
        m11, m22, m33 = (values[name] for name in _INERTIA)
        m23, m32 = self._coupling
        coupling, determinant = 0.5 * (m23 + m32), m22 * m33 - m23 * m32
        i22, i23, i32, i33 = m33 / determinant, -m23 / determinant, -m32 / determinant, m22 / determinant
        d = [values.get(name, 0.0) for name in DampingConfig.__slots__]
        xu, xuu, xuuu, yv, yvv, yrv, yr, yvr, yrr, nv, nvv, nrv, nr, nvr, nrr = d

        def derivative(u: float, v: float, r: float, x: float, y: float, n: float) -> tuple[float, float, float]:
            au, av, ar = abs(u), abs(v), abs(r)
            lateral = m22 * v + coupling * r
            x += lateral * r - u * (xu + au * (xuu + au * xuuu))
            y -= m11 * u * r + v * (yv + yvv * av + yrv * ar) + r * (yr + yvr * av + yrr * ar)
            n -= lateral * u - m11 * u * v + v * (nv + nvv * av + nrv * ar) + r * (nr + nvr * av + nrr * ar)
            return x / m11, i22 * y + i23 * n, i32 * y + i33 * n

        return derivative

    def hull(self, values: Mapping[str, float]) -> HullConfig:
        return replace(
            self.log.config.hull,
            **{name: float(values[name]) for name in _INERTIA},
            damping=DampingConfig(**{name: float(values[name]) for name in self.terms}),
        )

    def thrusters(self, values: Mapping[str, float]) -> tuple[ThrusterConfig, ...]:
        """With the fitted scale in their curves, and at the fitted arms."""
        thrusters = list(self.log.config.thrusters)
        for group in self.groups:
            k, arm_m = float(values[f"scale {group.name}"]), float(values[f"x_m {group.name}"])
            for i in group.members:
                t = thrusters[i]
                thrusters[i] = replace(t, x_m=arm_m, ahead_n=k * t.ahead_n, astern_n=k * t.astern_n, max_n=k * t.max_n, min_n=k * t.min_n)
        return tuple(thrusters)


def _held_in(value: float) -> float:
    """A model that runs away under a trial value stays a number."""
    return min(50.0, max(-50.0, value))


def fit(log: Log, manoeuvre: Manoeuvre, hold: Sequence[str] = ()) -> HullFit:
    """Fit the hull to the manoeuvre. `hold`: quantities to leave at the model's value (`Estimate.name`)."""
    model = HullModel(log, manoeuvre)
    held = {f"scale {model.groups[0].name}": "sets the scale of all forces and inertias"}
    held |= {name: "as asked" for name in hold if name in model.model}
    values = equation_error(model, held)
    sigmas = _sigmas(model, values)
    for _ in range(len(model.model)):
        values, deviations = output_error(model, values, held, sigmas)
        sigmas = _sigmas(model, values)
        doubtful = _most_doubtful(model, values, deviations)
        if not doubtful:
            break
        held |= dict.fromkeys(doubtful, "not told by this manoeuvre")
        values |= {name: model.model[name] for name in doubtful}
    values, deviations = output_error(model, values, held, sigmas)
    simulated = model.simulate(values)
    rest = manoeuvre.velocity - simulated
    estimates = tuple(Estimate(name, values[name], deviations.get(name), model.model[name], held.get(name, "")) for name in model.model)
    explained = 1.0 - rest.var(axis=0) / manoeuvre.velocity.var(axis=0)
    rms = np.sqrt((rest**2).mean(axis=0))
    return HullFit(estimates, model.hull(values), model.thrusters(values), simulated, tuple(rms.tolist()), tuple(explained.tolist()))


def _sigmas(model: HullModel, values: Mapping[str, float]) -> Array:
    """What each velocity counts for: the RMS that the present values leave unexplained."""
    rest = model.manoeuvre.velocity - model.simulate(values)
    return np.asarray(np.maximum(np.sqrt((rest**2).mean(axis=0)), _SMALLEST_SIGMA), dtype=np.float64)


def _most_doubtful(model: HullModel, values: Mapping[str, float], deviations: Mapping[str, float]) -> list[str]:
    """What to hold next: all that changes nothing, else the worst of the first kind that is in doubt. Yaw inertia goes
    before lever arms, since the two are told by the yaw equation only as a ratio."""
    silent = [name for name, deviation in deviations.items() if math.isinf(deviation)]
    if silent:
        return silent
    arms = [f"x_m {group.name}" for group in model.groups]
    scales = [f"scale {group.name}" for group in model.groups]
    for names in (_CURRENT, ("m33_kgm2",), (*arms, *scales), ("m22_kg", "m11_kg"), model.terms):
        limit = {name: _DOUBTFUL * _size(model, values, name) for name in names}
        worst = max((name for name in names if name in deviations), key=lambda name: deviations[name] / limit[name], default=None)
        if worst is not None and deviations[worst] > limit[worst]:
            return [worst]
    return []


def _size(model: HullModel, values: Mapping[str, float], name: str) -> float:
    """What a quantity's uncertainty is held against. A damping term may be doubtful, as long as it is none of no effect at all: linear and
    quadratic damping make up for each other. A current is told from a force by turning only."""
    if name in model.terms:
        return _MOST * model.scale(name)
    return _DOUBTFUL_CURRENT_MPS if name in _CURRENT else max(abs(values[name]), model.scale(name))


def equation_error(model: HullModel, held: Mapping[str, str]) -> dict[str, float]:
    """Least squares of the force balance, with accelerations from a smoothing derivative: where the output error begins."""
    from scipy.optimize import lsq_linear

    manoeuvre, values = model.manoeuvre, dict(model.model)
    smooth, slope = _smoothed(manoeuvre)
    keep = np.concatenate([np.arange(a, b) for a, b in manoeuvre.stretches])
    names = [name for name in values if name not in held and name != "lag_s" and not name.startswith("x_m")]
    free_arms = [f"x_m {g.name}" for g in model.groups if f"x_m {g.name}" not in held]
    limits = model.log.config.limits
    weights = np.repeat(1.0 / np.array([limits.surge_n, max(limits.sway_n, 1.0), limits.yaw_nm]), len(keep))
    # with m33 at the model's value here: the yaw balance tells only its ratio to the arms
    names = [name for name in names if name != "m33_kgm2"]
    for _ in range(3):  # scale and arm multiply: in turns
        base = _imbalance(model, values, smooth, slope)
        columns = {name: _imbalance(model, {**values, name: values[name] + 1.0}, smooth, slope) - base for name in (*names, *free_arms)}
        active = [name for name, column in columns.items() if np.any(np.abs(column[keep]) > 1e-9)]
        scales = np.array([model.scale(name) for name in active])
        matrix = np.stack([columns[name][keep].T.ravel() for name in active], axis=1) * weights[:, None] * scales
        low, high = np.array([model.bounds(name) for name in active]).T
        start = np.array([values[name] for name in active])
        low, high = (low - start) / scales, (high - start) / scales
        step = lsq_linear(matrix, -base[keep].T.ravel() * weights, (low - 1e-9, high + 1e-9)).x * scales
        for name, change in zip(active, step.tolist(), strict=True):
            lowest, highest = model.bounds(name)
            values[name] = min(highest, max(lowest, values[name] + change))
    return values


def _imbalance(model: HullModel, values: Mapping[str, float], velocity: Array, slope: Array) -> Array:
    """(n, 3): M ν̇ + C(ν) ν + D(ν) ν − τ."""
    stream = model.stream(values)
    u, v, r = (velocity - stream).T
    du, dv, dr = slope.T
    du, dv = du - r * stream[:, 1], dv + r * stream[:, 0]
    m11, m22, m33 = (values[name] for name in _INERTIA)
    m23, m32 = model._coupling
    lateral = m22 * v + 0.5 * (m23 + m32) * r
    d = {name: values.get(name, 0.0) for name in DampingConfig.__slots__}
    au, av, ar = np.abs(u), np.abs(v), np.abs(r)
    x = m11 * du - lateral * r + u * (d["x_u"] + d["x_uu"] * au + d["x_uuu"] * au * au)
    y = m22 * dv + m23 * dr + m11 * u * r + v * (d["y_v"] + d["y_vv"] * av + d["y_rv"] * ar)
    y = y + r * (d["y_r"] + d["y_vr"] * av + d["y_rr"] * ar)
    n = m32 * dv + m33 * dr + lateral * u - m11 * u * v + v * (d["n_v"] + d["n_vv"] * av + d["n_rv"] * ar)
    n = n + r * (d["n_r"] + d["n_vr"] * av + d["n_rr"] * ar)
    return np.stack([x, y, n], axis=1) - model.wrench(values)


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


def output_error(
    model: HullModel, start: Mapping[str, float], held: Mapping[str, str], sigmas: Array
) -> tuple[dict[str, float], dict[str, float]]:
    """(values, one-sigma uncertainties of the free ones). The uncertainty counts residuals that resemble their neighbours as fewer."""
    from scipy.optimize import least_squares

    names = [name for name in start if name not in held]
    scales = np.array([model.scale(name) for name in names])
    bounds = np.array([model.bounds(name) for name in names]).T / scales
    measured = model.manoeuvre.velocity

    def residuals(x: Array) -> Array:
        values = {**start, **dict(zip(names, (x * scales).tolist(), strict=True))}
        return np.asarray(((model.simulate(values) - measured) / sigmas).ravel(), dtype=np.float64)

    first = np.clip([start[name] / scale for name, scale in zip(names, scales.tolist(), strict=True)], bounds[0] + 1e-9, bounds[1] - 1e-9)
    solution = least_squares(residuals, first, bounds=(bounds[0], bounds[1]), xtol=1e-5, ftol=1e-6, max_nfev=25, x_scale="jac")
    values = {**start, **dict(zip(names, (solution.x * scales).tolist(), strict=True))}
    weights = np.tile(_effective(solution.fun.reshape(-1, 3)), len(measured))
    jacobian: Array = np.asarray(solution.jac, dtype=np.float64)
    deviations = _deviations(jacobian.T @ (jacobian * weights[:, None])) * scales
    return values, dict(zip(names, deviations.tolist(), strict=True))


def _deviations(information: Array) -> Array:
    """One sigma of each unknown, infinite for one that changes nothing."""
    size = np.sqrt(np.diag(information))
    told = size > 1e-6 * size.max()
    correlation = information[np.ix_(told, told)] / np.outer(size[told], size[told])
    deviations = np.full(len(size), np.inf)
    deviations[told] = np.sqrt(np.diag(np.linalg.inv(correlation + 1e-9 * np.eye(len(correlation))))) / size[told]
    return deviations


def _effective(rest: Array) -> Array:
    """Weight of one residual of each velocity: one over its variance, and less where it follows its predecessor."""
    variance = np.maximum((rest**2).mean(axis=0), 1e-12)
    correlation = np.clip((rest[1:] * rest[:-1]).mean(axis=0) / variance, 0.0, 0.995)
    return np.asarray((1.0 - correlation) / (1.0 + correlation) / variance, dtype=np.float64)
