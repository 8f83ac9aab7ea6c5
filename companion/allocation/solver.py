"""Thrust allocation as a quadratic programme in forces and azimuths (ReVolt thesis eq. 4.26, iterated as an SQP).

    minimise  (τ − T(α)F)ᵀ Q (τ − T(α)F) + power(F) + ‖F − F₀‖² + ‖α − α₀‖² + pull towards a preferred azimuth
    subject to  bounds on F and α (limits and rates together)

T(α)F is linearised about the present (F, α), solved, and linearised again about the result. The slack is eliminated, so
only simple bounds remain. A last pass with fixed azimuths makes the forces exact. daqp solves the QP (Arnström et al.
2022).
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass

import daqp
import numpy as np

from companion.allocation.geometry import Thruster

_OPTIMAL = 1
_SLACK_SCALE = 1.0e4  # cost of missing an axis by its whole limit, against 1 for one thruster's full force
YAW_PRIORITY = 4.0  # a boat that loses its heading loses the other axes too
_CHANGE_COST = 0.05  # cost of changing the force by its whole range in one cycle
_TURN_COST = 1.0  # cost of one radian of azimuth change in one cycle
_SMALL_SHARE = 0.05  # share of full force below which the cost of power is quadratic
_SETTLED_RAD = 0.01
_SETTLED_SHARE = 0.01


class BoxQuadratic:
    """min ½xᵀHx + fᵀx, lower ≤ x ≤ upper, with H positive definite. The size is fixed, the arrays are allocated
    once."""

    def __init__(self, size: int) -> None:
        self._h = np.zeros((size, size))
        self._f = np.zeros(size)
        self._lower = np.zeros(size)
        self._upper = np.zeros(size)
        self._views = tuple(a.data.cast("B") for a in (self._h, self._f, self._lower, self._upper))
        self._a = np.zeros((0, size))
        self._sense = np.zeros(size, dtype=np.intc)
        self._h_packer = struct.Struct(f"{size * size}d")
        self._packer = struct.Struct(f"{size}d")

    def solve(
        self, h: Sequence[float], f: Sequence[float], lower: Sequence[float], upper: Sequence[float]
    ) -> list[float] | None:
        """The minimum, or None if the solver fails. `h`: H row by row."""
        h_bytes, f_bytes, lower_bytes, upper_bytes = self._views
        pack = self._packer.pack_into
        self._h_packer.pack_into(h_bytes, 0, *h)
        pack(f_bytes, 0, *f)
        pack(lower_bytes, 0, *lower)
        pack(upper_bytes, 0, *upper)
        x, _, flag, _ = daqp.solve(self._h, self._f, self._a, self._upper, self._lower, self._sense)
        if flag != _OPTIMAL:
            return None
        solution: list[float] = x.tolist()
        return solution


class Problem:
    """Allocation problem of one cycle: the demand (surge N, sway N, yaw Nm), the present forces and azimuths, their
    bounds, and preferred azimuths with weights. All lists have one entry for each thruster; azimuth entries of fixed
    thrusters are not used."""

    __slots__ = (
        "azimuths_rad",
        "demand",
        "force_high_n",
        "force_low_n",
        "forces_n",
        "iterations",
        "preferred_rad",
        "preferred_weight",
        "turn_high_rad",
        "turn_low_rad",
        "w_power",
        "w_turn",
    )

    def __init__(self, count: int) -> None:
        self.demand = (0.0, 0.0, 0.0)
        self.forces_n = [0.0] * count
        self.azimuths_rad = [0.0] * count
        self.force_low_n = [0.0] * count
        self.force_high_n = [0.0] * count
        self.turn_low_rad = [0.0] * count
        self.turn_high_rad = [0.0] * count
        self.preferred_rad = [0.0] * count
        self.preferred_weight = [0.0] * count
        self.iterations = 3
        self.w_power = 1.0
        self.w_turn = 1.0


@dataclass(slots=True)
class _Quadratic:
    """Terms of the programme, one entry for each variable: the wrench of its unit (`columns`), the rest of the
    Hessian's diagonal, and the linear term. `curvature` (for each thruster) and `turns` (for each turning one) are for
    `add_turns`."""

    columns: list[tuple[float, float, float]]
    diagonal: list[float]
    linear: list[float]
    curvature: list[float]
    turns: list[tuple[float, float, float]]

    def add_turns(self, problem: Problem, azimuths: list[float], turning: tuple[int, ...]) -> None:
        """Add the azimuth changes of the `turning` thrusters as variables."""
        self.columns += self.turns
        cost = _TURN_COST * problem.w_turn + 1.0e-6
        for i in turning:
            azimuth, pull = azimuths[i], problem.preferred_weight[i]
            self.diagonal.append(cost + pull + self.curvature[i])
            self.linear.append(cost * (azimuth - problem.azimuths_rad[i]) + pull * (azimuth - problem.preferred_rad[i]))

    def hessian_with_shortfall(self, demand: tuple[float, float, float], weights: tuple[float, ...]) -> list[float]:
        """The Hessian row by row, with the cost of missing the demand, which it also adds to `linear`."""
        (dx, dy, dn), (wx, wy, wn) = demand, weights
        columns, linear, diagonal = self.columns, self.linear, self.diagonal
        size = len(columns)
        h = [0.0] * (size * size)
        for i, (x, y, n) in enumerate(columns):
            x, y, n = wx * x, wy * y, wn * n
            linear[i] -= x * dx + y * dy + n * dn
            row = i * size
            for j in range(i, size):
                cx, cy, cn = columns[j]
                h[row + j] = h[j * size + i] = x * cx + y * cy + n * cn
            h[row + i] += diagonal[i]
        return h


def weights_of(scales: tuple[float, float, float], cost: float) -> tuple[float, ...]:
    """Weights of the squared shortfall in surge, sway and yaw: `cost` for that of a whole limit (`scales`), more in
    yaw; 0 for an axis that is not controlled."""
    priority = (1.0, 1.0, YAW_PRIORITY)
    return tuple(p * cost / (scale * scale) if scale > 0.0 else 0.0 for p, scale in zip(priority, scales, strict=True))


class AllocationSolver:
    """Solves a `Problem` for a set of thrusters. `scales`: the wrench limits; an axis with 0 is not controlled.
    Remembers only its arrays."""

    def __init__(self, thrusters: Sequence[Thruster], scales: tuple[float, float, float]) -> None:
        self._thrusters = tuple(thrusters)
        self._turning = tuple(i for i, t in enumerate(thrusters) if t.turns)
        self._weights = weights_of(scales, _SLACK_SCALE)
        self._forces_only = BoxQuadratic(len(thrusters))
        self._full = BoxQuadratic(len(thrusters) + len(self._turning)) if self._turning else None

    def solve(self, problem: Problem) -> tuple[list[float], list[float]]:
        """(forces in N, azimuths in rad) after at most `iterations` programmes, the last with fixed azimuths. If the
        solver fails, the last good iterate counts."""
        forces, azimuths = problem.forces_n, problem.azimuths_rad
        if self._full is not None:
            for _ in range(max(1, problem.iterations - 1)):
                step = self._step(problem, forces, azimuths, self._full, self._turning)
                if step is None:
                    break
                settled = self._settled(forces, azimuths, *step)
                forces, azimuths = step
                if settled:
                    break
        step = self._step(problem, forces, azimuths, self._forces_only, ())
        return step if step is not None else (forces, azimuths)

    def _settled(
        self, forces: list[float], azimuths: list[float], new_forces: list[float], new_azimuths: list[float]
    ) -> bool:
        return all(
            abs(a - b) < _SETTLED_SHARE * t.max_n for a, b, t in zip(forces, new_forces, self._thrusters, strict=True)
        ) and all(abs(azimuths[i] - new_azimuths[i]) < _SETTLED_RAD for i in self._turning)

    def _step(
        self, problem: Problem, forces: list[float], azimuths: list[float], qp: BoxQuadratic, turning: tuple[int, ...]
    ) -> tuple[list[float], list[float]] | None:
        """One quadratic programme about (forces, azimuths): its solution, or None if the solver fails. The variables
        are the forces, then the changes of the azimuths of the `turning` thrusters."""
        quadratic = self._forces_part(problem, forces, azimuths)
        lower, upper = list(problem.force_low_n), list(problem.force_high_n)
        if turning:
            quadratic.add_turns(problem, azimuths, turning)
            lower += [problem.turn_low_rad[i] - azimuths[i] for i in turning]
            upper += [problem.turn_high_rad[i] - azimuths[i] for i in turning]
        solution = qp.solve(
            quadratic.hessian_with_shortfall(problem.demand, self._weights), quadratic.linear, lower, upper
        )
        if solution is None:
            return None
        count = len(self._thrusters)
        new_forces = [
            min(high, max(low, f))
            for f, low, high in zip(solution[:count], problem.force_low_n, problem.force_high_n, strict=True)
        ]
        if not turning:
            return new_forces, azimuths
        new_azimuths = list(azimuths)
        for k, i in enumerate(turning):
            new_azimuths[i] = min(
                problem.turn_high_rad[i], max(problem.turn_low_rad[i], azimuths[i] + solution[count + k])
            )
        return new_forces, new_azimuths

    def _forces_part(self, problem: Problem, forces: list[float], azimuths: list[float]) -> _Quadratic:
        """The programme's terms in the forces: their wrench, power and change."""
        columns: list[tuple[float, float, float]] = []
        diagonal: list[float] = []
        linear: list[float] = []
        curvature: list[float] = []
        turns: list[tuple[float, float, float]] = []
        for i, thruster in enumerate(self._thrusters):
            c, s = math.cos(azimuths[i]), math.sin(azimuths[i])
            columns.append((c, s, thruster.x_m * s - thruster.y_m * c))
            force, limit = forces[i], thruster.max_n if forces[i] >= 0.0 else max(-thruster.min_n, 0.1 * thruster.max_n)
            full = 1.0 / (limit * limit)
            power = problem.w_power * full / math.sqrt(max(abs(force) / limit, _SMALL_SHARE))
            change = _CHANGE_COST * full
            diagonal.append(power + change + 1.0e-9)
            curvature.append(
                power * force * force
            )  # the second-order term that linearising T(α)F loses, at the optimum
            linear.append(-change * problem.forces_n[i])
            if thruster.turns:
                turns.append((-s * force, c * force, (thruster.x_m * c + thruster.y_m * s) * force))
        return _Quadratic(columns, diagonal, linear, curvature, turns)
