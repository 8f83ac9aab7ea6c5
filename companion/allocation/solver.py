"""Thrust allocation as a quadratic programme over forces and azimuths (ReVolt thesis eq. 4.26, iterated as an SQP).

    minimise  (τ − T(α)F)ᵀ Q (τ − T(α)F) + power(F) + ‖F − F₀‖² + ‖α − α₀‖² + pull towards a preferred azimuth
    subject to  bounds on F and α (limits and rates together)

T(α)F is linearised about the present (F, α) and solved again about the result. Slack is eliminated, so only simple bounds are left. A
last pass with the azimuths held makes the forces exact for them. The QP is solved by daqp (Arnström et al. 2022).
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

import daqp
import numpy as np

from companion.allocation.geometry import Thruster

_OPTIMAL = 1
_SLACK_SCALE = 1.0e4  # cost of missing an axis by its whole limit, against 1 for one thruster's full force
_YAW_PRIORITY = 4.0  # a boat that loses its heading loses the other axes with it
_CHANGE_COST = 0.05  # cost of changing the force by its whole range in one cycle
_TURN_COST = 1.0  # cost of one radian of azimuth change in one cycle
_SMALL_SHARE = 0.05  # share of full force below which power no longer falls off steeply
_SETTLED_RAD = 0.01
_SETTLED_SHARE = 0.01


class BoxQuadratic:
    """min ½xᵀHx + fᵀx, lower ≤ x ≤ upper, for a fixed size, in arrays laid out once. H positive definite."""

    def __init__(self, size: int) -> None:
        self._h = np.zeros((size, size))
        self._f = np.zeros(size)
        self._lower = np.zeros(size)
        self._upper = np.zeros(size)
        self._views = tuple(memoryview(a).cast("B") for a in (self._h, self._f, self._lower, self._upper))  # type: ignore[arg-type]
        self._a = np.zeros((0, size))
        self._sense = np.zeros(size, dtype=np.intc)
        self._h_packer = struct.Struct(f"{size * size}d")
        self._packer = struct.Struct(f"{size}d")

    def solve(self, h: Sequence[float], f: Sequence[float], lower: Sequence[float], upper: Sequence[float]) -> list[float] | None:
        """The minimum, or None where the solver gives up. `h` row by row."""
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
    """One cycle's allocation: demand, where the thrusters are, how far they may go. Lists run over all thrusters; azimuth lists too,
    their entries for fixed thrusters are never moved."""

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


class AllocationSolver:
    """Solves one `Problem` after another for a set of thrusters. `scales` are the wrench limits; an axis with 0 is not controlled."""

    def __init__(self, thrusters: Sequence[Thruster], scales: tuple[float, float, float]) -> None:
        self._thrusters = tuple(thrusters)
        self._turning = tuple(i for i, t in enumerate(thrusters) if t.turns)
        priority = (1.0, 1.0, _YAW_PRIORITY)
        self._weights = tuple(p * _SLACK_SCALE / (scale * scale) if scale > 0.0 else 0.0 for p, scale in zip(priority, scales, strict=True))
        self._forces_only = BoxQuadratic(len(thrusters))
        self._full = BoxQuadratic(len(thrusters) + len(self._turning)) if self._turning else None

    def solve(self, problem: Problem) -> tuple[list[float], list[float]]:
        """Forces and azimuths, after at most `iterations` programmes, the last with the azimuths held. Where the solver gives up the last
        good iterate stands."""
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

    def _settled(self, forces: list[float], azimuths: list[float], new_forces: list[float], new_azimuths: list[float]) -> bool:
        return all(
            abs(a - b) < _SETTLED_SHARE * t.max_n for a, b, t in zip(forces, new_forces, self._thrusters, strict=True)
        ) and all(abs(azimuths[i] - new_azimuths[i]) < _SETTLED_RAD for i in self._turning)

    def _step(
        self, problem: Problem, forces: list[float], azimuths: list[float], qp: BoxQuadratic, turning: tuple[int, ...]
    ) -> tuple[list[float], list[float]] | None:
        """One quadratic programme about (forces, azimuths); variables are the forces, then the azimuth changes."""
        wx, wy, wn = self._weights
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
            curvature.append(power * force * force)  # what the linearised T(α)F leaves out, as it is at the optimum
            linear.append(-change * problem.forces_n[i])
            if thruster.turns:
                turns.append((-s * force, c * force, (thruster.x_m * c + thruster.y_m * s) * force))
        lower, upper = list(problem.force_low_n), list(problem.force_high_n)
        if turning:
            columns += turns
            cost = _TURN_COST * problem.w_turn + 1.0e-6
            for i in turning:
                azimuth, pull = azimuths[i], problem.preferred_weight[i]
                diagonal.append(cost + pull + curvature[i])
                linear.append(cost * (azimuth - problem.azimuths_rad[i]) + pull * (azimuth - problem.preferred_rad[i]))
                lower.append(problem.turn_low_rad[i] - azimuth)
                upper.append(problem.turn_high_rad[i] - azimuth)
        dx, dy, dn = problem.demand
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
        solution = qp.solve(h, linear, lower, upper)
        if solution is None:
            return None
        count = len(self._thrusters)
        new_forces = [min(high, max(low, f)) for f, low, high in zip(solution[:count], problem.force_low_n, problem.force_high_n, strict=True)]
        if not turning:
            return new_forces, azimuths
        new_azimuths = list(azimuths)
        for k, i in enumerate(turning):
            new_azimuths[i] = min(problem.turn_high_rad[i], max(problem.turn_low_rad[i], azimuths[i] + solution[count + k]))
        return new_forces, new_azimuths
