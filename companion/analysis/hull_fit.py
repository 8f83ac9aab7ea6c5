"""Fit inertia, damping, thruster scales and lever arms of a hull to a recorded manoeuvre.

`hull_search` finds the likeliest values, `intervals` says how far the log leaves them open. A quantity of which the log
says little stays near the known model's value and counts as not determined. Its doubt counts in the uncertainty of all
others. Terms that the file lacks (`hull_model.CANDIDATES`) are among the quantities, so they grow as the log's evidence
does.

Multiplying all of inertia, damping and thrust by one number changes no motion, so the scale of the strongest group is
held; for a boat from dimensions the mass that was weighed sets it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from companion.analysis.hull_model import CURRENT, INERTIA, HullModel, axis_drag
from companion.analysis.hull_search import Search, likeliest
from companion.analysis.intervals import covariance
from companion.analysis.log_reader import Log
from companion.analysis.manoeuvre import Array, Manoeuvre
from companion.config.devices import ThrusterConfig
from companion.config.dimensions.fins import with_fins
from companion.config.hull import HullConfig
from companion.core.progress import Told, Work, tell_nobody

_INFORMED = 0.5  # share of the doubt: above it, the log adds nothing
_DRAG_INFORMED = 0.5  # relative uncertainty of an axis' damping above which its terms are not determined
_USUAL = 2  # steps of a fit, by quantity, about
NOT_DETERMINED = "hardly determined by this manoeuvre"
_AXIS_TERMS = (("x_u", "x_uu", "x_uuu"), ("y_v", "y_vv"), ("n_r", "n_rr"))


@dataclass(frozen=True, slots=True)
class Estimate:
    """One quantity. `sigma` is None where it was held, or where the log says little of it; `held` says why."""

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
    `gusts`: one sigma of the disturbance in N, N and Nm. `hull` has the fins that rudders are (`blade`)."""

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
    search = likeliest(model, held, work)
    search.renew()
    spread = covariance(search)
    undetermined = dict.fromkeys(_undetermined(search, spread), NOT_DETERMINED)
    return _result(search, held | undetermined, spread)


def _undetermined(search: Search, spread: Array) -> list[str]:
    """Quantities that the log hardly determines. Linear and quadratic damping of an axis can replace each other, so
    they are judged together."""
    model, names = search.model, search.names
    sigmas = dict(zip(names, np.sqrt(np.diag(spread)).tolist(), strict=True))
    found = [
        name
        for name, sigma in sigmas.items()
        if name not in (*CURRENT, *model.weather) and sigma > _INFORMED * model.doubt(name)
    ]
    for drag, terms in zip(_drags(search, spread), _AXIS_TERMS, strict=True):
        if not drag.determined:
            found += [term for term in terms if term in names]
    return found


def _drags(search: Search, spread: Array) -> tuple[Drag, Drag, Drag]:
    model, names = search.model, search.names
    speeds = np.sqrt((model.manoeuvre.velocity**2).mean(axis=0)).tolist()
    hull = model.hull(search.values)
    found = []
    for axis, (speed, terms) in enumerate(zip(speeds, _AXIS_TERMS, strict=True)):
        slopes = np.array([speed ** (terms.index(name) + 1) if name in terms else 0.0 for name in names])
        force, sigma = axis_drag(hull, axis, speed), math.sqrt(max(float(slopes @ spread @ slopes), 0.0))
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


def _result(search: Search, held: Mapping[str, str], spread: Array) -> HullFit:
    model, values = search.model, search.values
    sigmas = dict(zip(search.names, np.sqrt(np.diag(spread)).tolist(), strict=True))
    estimates = tuple(
        Estimate(name, values[name], None if name in held else sigmas[name], model.model[name], held.get(name, ""))
        for name in model.model
    )
    measured, simulated = model.manoeuvre.velocity, model.simulate(values)
    rows = np.concatenate([np.arange(first, end) for first, end in model.manoeuvre.stretches])
    rest = (measured - simulated)[rows]
    explained = 1.0 - rest.var(axis=0) / np.maximum(measured[rows].var(axis=0), 1e-12)
    rms = np.sqrt((rest**2).mean(axis=0))
    hull, thrusters = model.hull(values), model.thrusters(values)
    gusts = [values[name] * axis.gust for name, axis in zip(INERTIA, search.noise.axes, strict=True)]
    return HullFit(
        estimates=estimates,
        drags=_drags(search, spread),
        hull=with_fins(hull, thrusters, model.log.config.limits.surge_n),
        thrusters=thrusters,
        simulated=simulated,
        residual_rms=tuple(rms.tolist()),
        explained=tuple(explained.tolist()),
        gusts=(gusts[0], gusts[1], gusts[2]),
    )
