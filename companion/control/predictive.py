"""Model-predictive control along a planned path (PATH_CTRL 2).

A linear time-varying MPC in the error frame of the plan (Rawlings, Mayne & Diehl 2017, chapter 1; Fossen 2021 for the
hull). State x = (north, east, yaw, surge, sway, yaw rate, built wrench): the first six as differences from the plan,
velocities through the water. The hull is linearised about the plan at each step, thrust builds up with a first-order
lag, and the wrench is constant over blocks that grow towards the end of the horizon. So the programme has 24 unknowns
with simple bounds:

    minimise  Σ (track error/PRED_ERR_TRACK)² + (heading error/PRED_ERR_YAW)² + … + Σ (change of wrench/PRED_CHANGE)²

daqp solves it (Arnström et al. 2022). What the model leaves out is estimated by an extended state observer, into the
bias force that all laws share.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from companion.config.vessel import VesselConfig
from companion.control.bias import BiasForce
from companion.control.model import coriolis, damping
from companion.control.planned_steps import PlannedSteps, planned_steps
from companion.core.actuation import Wrench
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.core.setpoint import PATH_STEP_S, PathSetpoint
from companion.params.store import Parameters

PREDICTIVE = 2  # PATH_CTRL
_BLOCKS = (1, 1, 1, 2, 2, 3, 3, 3)  # steps over which the wrench is constant
_STEPS = sum(_BLOCKS)
_THRUST_LAG_S = 0.4
_OBSERVER_RADPS = 0.5
_ALONG = 6.0  # an error along the track is worth so many times less
_SPEED_ERROR_MPS, _RATE_ERROR_RADPS = 0.3, 0.2
_SMALL = 1.0e-4  # step of the differences by which the hull is linearised
_OPTIMAL = 1
_BLOCK_OF = [block for block, steps in enumerate(_BLOCKS) for _ in range(steps)]

Floats = NDArray[np.float64]


class PredictiveControl:
    """Law for planned path setpoints that carry the poses ahead.

    Remembers the last wrench, the wrench built up so far, and the velocity that the observer predicts.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._hull = config.hull
        limits = config.limits
        self._most = np.array([limits.surge_n, limits.sway_n, limits.yaw_nm])
        self._parameters = parameters
        h = config.hull
        mass = np.array([[h.m11_kg, 0.0, 0.0], [0.0, h.m22_kg, h.m23_kgm], [0.0, h.yaw_coupling_kgm, h.m33_kgm2]])
        self._inverse_mass: Floats = np.linalg.inv(mass)
        self._inertia = (h.m11_kg, h.m22_kg, h.m33_kgm2)
        self._kept = math.exp(-PATH_STEP_S / _THRUST_LAG_S)
        self.restart()

    def restart(self) -> None:
        """Forget everything, after another law was active."""
        self._last: Floats | None = None
        self._built = np.zeros(3)
        self._predicted: Floats | None = None

    def chosen(self, setpoint: PathSetpoint) -> bool:
        """Whether PATH_CTRL chooses this law, for a setpoint with poses ahead."""
        return self._parameters["PATH_CTRL"] == PREDICTIVE and len(setpoint.ahead) >= _STEPS + 2

    def update(
        self,
        setpoint: PathSetpoint,
        nav: NavState,
        bias: BiasForce,
        wind: tuple[float, float, float],
        achieved: Wrench,
        dt_s: float,
    ) -> Wrench | None:
        """The wrench within the vessel's limits, that against wind and bias included; None where the solver fails.

        `wind`: force and moment of the wind on the hull, in body axes. `achieved`: what the thrusters gave in the last
        cycle.
        """
        water = nav.current_north_mps or 0.0, nav.current_east_mps or 0.0
        stream = ned_to_body(*water, nav.yaw_rad)
        velocity = np.array([nav.surge_mps - stream[0], nav.sway_mps - stream[1], nav.yaw_rate_radps])
        gave = np.array([achieved.surge_n, achieved.sway_n, achieved.yaw_nm])
        if self._last is None:
            self._built = gave
        self._built = self._built + (1.0 - math.exp(-dt_s / _THRUST_LAG_S)) * (gave - self._built)
        self._observe(velocity, bias, wind, nav.yaw_rad, dt_s)
        against = np.array(bias.in_body(nav.yaw_rad)) - np.array(wind)
        plan = planned_steps(self._hull, setpoint.ahead[: _STEPS + 2], water)
        start = setpoint.ahead[0]
        off = np.array([nav.north_m - start.north_m, nav.east_m - start.east_m, wrap_pi(nav.yaw_rad - start.yaw_rad)])
        state = np.concatenate((off, velocity - np.array(plan.velocity[0]), self._built - against))
        last = gave - against if self._last is None else self._last
        wrench = solved(*self.least_squares(plan, state, last), -self._most - against, self._most - against)
        if wrench is None:
            self.restart()
            return None
        self._last = wrench
        total = wrench + against
        return Wrench(float(total[0]), float(total[1]), float(total[2]))

    def _observe(
        self, velocity: Floats, bias: BiasForce, wind: tuple[float, float, float], yaw_rad: float, dt_s: float
    ) -> None:
        """Learn from the velocity what force the model leaves out: ν̂' = M⁻¹(τ + wind − bias − C − D) + 2ω (ν − ν̂),
        bias' = ω² M (ν̂ − ν)."""
        if self._predicted is None:
            self._predicted = velocity
        u, v, r = (float(x) for x in velocity)
        resisting = np.array(coriolis(self._hull, u, v, r)) + np.array(damping(self._hull, u, v, r))
        acting = self._built + np.array(wind) - np.array(bias.in_body(yaw_rad)) - resisting
        ahead = self._predicted - velocity
        rate = self._inverse_mass @ acting - 2.0 * _OBSERVER_RADPS * ahead
        self._predicted = self._predicted + rate * dt_s
        x, y, n = (_OBSERVER_RADPS**2 * m * float(a) for m, a in zip(self._inertia, ahead, strict=True))
        bias.grow(x, y, n, yaw_rad, dt_s)

    def _slopes(self, velocity: tuple[float, float, float]) -> Floats:
        """−∂(C(ν) ν + D(ν) ν)/∂ν, 3×3, by differences."""
        base = self._resisting(*velocity)
        columns = []
        for i in range(3):
            moved = list(velocity)
            moved[i] += _SMALL
            columns.append([(b - a) / _SMALL for a, b in zip(base, self._resisting(*moved), strict=True)])
        return -np.array(columns).T

    def _resisting(self, u: float, v: float, r: float) -> tuple[float, float, float]:
        cx, cy, cn = coriolis(self._hull, u, v, r)
        dx, dy, dn = damping(self._hull, u, v, r)
        return cx + dx, cy + dy, cn + dn

    def _predict(self, plan: PlannedSteps, state: Floats) -> tuple[Floats, Floats]:
        """The states of all steps as `free` + `forced` · wrenches: (steps, 9) and (steps, 9, unknowns)."""
        unknowns = 3 * len(_BLOCKS)
        free, forced = np.empty((_STEPS, 9)), np.zeros((_STEPS, 9, unknowns))
        x, g = state, np.zeros((9, unknowns))
        for k in range(_STEPS):
            a, c = self._step(plan, k)
            x, g = a @ x + c, a @ g
            block = 3 * _BLOCK_OF[k]
            g[6:9, block : block + 3] += (1.0 - self._kept) * np.eye(3)
            free[k], forced[k] = x, g
        return free, forced

    def _step(self, plan: PlannedSteps, k: int) -> tuple[Floats, Floats]:
        """x(k+1) = a x(k) + c, without the part of the wrench."""
        u, v, _ = plan.velocity[k]
        cos, sin = math.cos(plan.yaw_rad[k]), math.sin(plan.yaw_rad[k])
        h, inverse = PATH_STEP_S, self._inverse_mass
        a, c = np.eye(9), np.zeros(9)
        a[0, 2], a[1, 2] = h * (-sin * u - cos * v), h * (cos * u - sin * v)
        a[0, 3], a[0, 4], a[1, 3], a[1, 4] = h * cos, -h * sin, h * sin, h * cos
        a[2, 5] = h
        a[3:6, 3:6] += h * inverse @ self._slopes(plan.velocity[k])
        a[3:6, 6:9] = h * inverse
        a[6:9, 6:9] = self._kept * np.eye(3)
        c[3:6] = -h * inverse @ np.array(plan.wrench[k])
        return a, c

    def least_squares(self, plan: PlannedSteps, state: Floats, last: Floats) -> tuple[Floats, Floats]:
        """Matrix and vector of the programme min ‖matrix · wrenches + vector‖², in units of what errors and changes may
        be. `last`: the wrench before the first block."""
        free, forced = self._predict(plan, state)
        weights, blocks = self._weights(plan), len(_BLOCKS)
        errors = np.einsum("kij,kj->ki", weights, free).ravel()
        effects = np.einsum("kij,kjm->kim", weights, forced).reshape(-1, 3 * blocks)
        per_change = np.tile(1.0 / (self._parameters["PRED_CHANGE"] * self._most), blocks)
        change = np.diag(per_change)
        for i in range(3, 3 * blocks):
            change[i, i - 3] = -per_change[i]
        before = np.zeros(3 * blocks)
        before[:3] = -per_change[:3] * last
        return np.vstack((effects, change)), np.concatenate((errors, before))

    def _weights(self, plan: PlannedSteps) -> Floats:
        """(steps, 6, 9): the errors of each step in units of what they may be: along and across the track, heading,
        speeds, yaw rate."""
        p = self._parameters
        across = 1.0 / p["PRED_ERR_TRACK"]
        weights = np.zeros((_STEPS, 6, 9))
        course = np.array(plan.course_rad[1 : _STEPS + 1])
        cos, sin = np.cos(course), np.sin(course)
        weights[:, 0, 0], weights[:, 0, 1] = across / _ALONG * cos, across / _ALONG * sin
        weights[:, 1, 0], weights[:, 1, 1] = -across * sin, across * cos
        weights[:, 2, 2] = 1.0 / math.radians(p["PRED_ERR_YAW"])
        weights[:, 3, 3] = weights[:, 4, 4] = 1.0 / _SPEED_ERROR_MPS
        weights[:, 5, 5] = 1.0 / _RATE_ERROR_RADPS
        return weights


def solved(matrix: Floats, vector: Floats, lower: Floats, upper: Floats) -> Floats | None:
    """The wrench of the first block that minimises ‖matrix · x + vector‖² with each block's wrench within `lower` and
    `upper` (3,); None where the solver fails. Loads daqp."""
    import daqp

    size = matrix.shape[1]
    x, _, flag, _ = daqp.solve(
        np.ascontiguousarray(matrix.T @ matrix),
        matrix.T @ vector,
        np.zeros((0, size)),
        np.tile(upper, size // 3),
        np.tile(lower, size // 3),
        np.zeros(size, dtype=np.intc),
    )
    return np.asarray(x[:3]) if flag == _OPTIMAL and bool(np.all(np.isfinite(x))) else None
