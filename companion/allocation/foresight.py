"""Where turning thrusters should point under way, and how hard they push, by the wrenches that the planned path will
demand: an azimuth takes seconds to turn, a corner turns the demand round in less.

    minimise  Σ_k ‖τ_k − T(α_k) F_k‖²_Q + power(F_k) + ‖F_k − F_k−1‖² + ‖α_k − α_k−1‖² + ‖α_k − preferred‖²
    subject to  α_k within its stops, |α_k − α_k−1| within the rate, F_k towards the side where it is wanted

over the next seconds: one quadratic programme a cycle, linearised about the last cycle's solution moved on in time
(receding horizon; Rawlings, Mayne & Diehl 2017, chapter 1). The preferred azimuths are those of the unconstrained
solution: without thrust nothing else says where to turn. daqp solves it (Arnström et al. 2022).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import daqp
import numpy as np
from numpy.typing import NDArray

from companion.allocation.geometry import Thruster
from companion.allocation.pseudo_inverse import PseudoInverse
from companion.allocation.solver import weights_of
from companion.core.actuation import Wrench

_OPTIMAL = 1
_MISSED = 120.0  # cost of missing an axis by its whole limit, against 1 for the power of one thruster's full force
_CHANGED = 100.0  # cost of changing a force by the whole of it from one step to the next
_TURNED, _OFF = 0.05, 5.0  # cost of one radian of turn from step to step, and off the preferred azimuth
_BENT = 0.2  # of the power: what linearising T(α)F loses of it off the optimum
_SMALL_SHARE = 0.05  # share of full force below which the cost of power is quadratic
_ASKED_SHARE = 0.1  # share of full force from which the preferred azimuth counts in full
_WORTH_RAD = 0.3  # the demand turns round by more, or a thruster is off by more: else there is nothing to foresee
_WORTH_SHARE = 0.05  # share of full force from which a direction counts

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ThrusterPlan:
    """What to do in this cycle: forces in N and azimuths in rad, one for each thruster."""

    forces_n: tuple[float, ...]
    azimuths_rad: tuple[float, ...]


class Foresight:
    """Call `update` in every cycle on a planned path, `reset` in others. `scales`: the wrench limits; an axis with 0 is
    not controlled. `step_s`: between the demands that are known. Remembers the last solution."""

    def __init__(self, thrusters: Sequence[Thruster], scales: tuple[float, float, float], step_s: float) -> None:
        self._thrusters = tuple(thrusters)
        self._turning = [i for i, t in enumerate(thrusters) if t.turns]
        self._step_s = step_s
        self._weights = np.array(weights_of(scales, _MISSED))
        self._full = np.array([t.max_n for t in thrusters])
        self._least = np.array([t.min_n for t in thrusters])
        self._x, self._y = np.array([t.x_m for t in thrusters]), np.array([t.y_m for t in thrusters])
        self._frame: _Frame | None = None
        self.reset()

    def reset(self) -> None:
        """Forget the last solution."""
        self._forces = self._azimuths = np.zeros((0, len(self._thrusters)))

    def update(
        self,
        demands: Sequence[Wrench],
        inverse: PseudoInverse,
        failed: Collection[int],
        forces_n: Sequence[float],
        azimuths_rad: Sequence[float],
        dt_s: float,
    ) -> ThrusterPlan | None:
        """Forces and azimuths to go to within `dt_s`; None where there is nothing to foresee, or no solution.
        `demands`: wrenches, the first now. `inverse`: the unconstrained solution of the thrusters that work. `failed`:
        the others."""
        ideals = [inverse.forces_n((w.surge_n, w.sway_n, w.yaw_nm)) for w in demands]
        if not self._turning or not self._worth(ideals, azimuths_rad):
            self.reset()
            return None
        aim = self._aim(ideals, azimuths_rad)
        now, there = np.array(forces_n), np.array(azimuths_rad)
        self._move_on(aim.azimuths, now, there, dt_s)
        working = np.array([0.0 if i in failed else 1.0 for i in range(len(forces_n))])
        wanted = np.array([(w.surge_n, w.sway_n, w.yaw_nm) for w in demands])
        if not self._solve(_Cycle(wanted, aim, now, there, working, dt_s)):
            self.reset()
            return None
        return ThrusterPlan(tuple(self._forces[0].tolist()), tuple(self._azimuths[0].tolist()))

    @property
    def _rates(self) -> Floats:
        """Of the turning thrusters; they change as rates are learnt."""
        return np.array([self._thrusters[i].azimuth_rate_radps for i in self._turning])

    def _worth(self, ideals: Sequence[Sequence[tuple[float, float]]], azimuths_rad: Sequence[float]) -> bool:
        """Whether the direction of some turning thruster's force lies off its azimuth, now or later."""
        for i in self._turning:
            least_n = _WORTH_SHARE * self._thrusters[i].max_n
            for ideal in ideals:
                x, y = ideal[i]
                off_rad = abs(math.remainder(math.atan2(y, x) - azimuths_rad[i], math.tau))
                if off_rad > _WORTH_RAD and math.hypot(x, y) > least_n:
                    return True
        return False

    def _aim(self, ideals: Sequence[Sequence[tuple[float, float]]], azimuths_rad: Sequence[float]) -> _Aim:
        """Where each thruster should point at each step."""
        shape = len(ideals), len(azimuths_rad)
        aim = _Aim(np.tile(np.array(azimuths_rad), (len(ideals), 1)), np.zeros(shape), np.zeros(shape))
        for i in self._turning:
            t, last_rad = self._thrusters[i], azimuths_rad[i]
            for k, ideal in enumerate(ideals):
                x, y = ideal[i]
                direction_rad = math.atan2(y, x)
                last_rad = t.aim_rad(direction_rad, last_rad)
                aim.azimuths[k, i], aim.directions[k, i] = last_rad, direction_rad
                aim.pull[k, i] = _OFF * min(1.0, math.hypot(x, y) / (_ASKED_SHARE * t.max_n))
        return aim

    def _move_on(self, preferred: Floats, forces: Floats, azimuths: Floats, dt_s: float) -> None:
        """Take the last solution `dt_s` later as the first guess; without one, the present forces, and azimuths that
        turn to the preferred ones."""
        steps = len(preferred)
        if len(self._forces) != steps:
            reach = np.zeros_like(preferred)
            reach[:, self._turning] = np.outer(dt_s + self._step_s * np.arange(steps), self._rates)
            self._forces = np.tile(forces, (steps, 1))
            self._azimuths = azimuths + np.clip(preferred - azimuths, -reach, reach)
            return
        part = min(1.0, dt_s / self._step_s)
        for values in (self._forces, self._azimuths):
            values[:-1] += part * (values[1:] - values[:-1])

    def _solve(self, cycle: _Cycle) -> bool:
        """One quadratic programme about the guess; replaces it. False if the solver fails."""
        (steps, count), turning = self._forces.shape, self._turning
        width = count + len(turning)
        frame = self._frame
        if frame is None or frame.steps != steps:
            frame = self._frame = _Frame(steps, count, len(turning))
        blocks, linear = self._shortfall(cycle.wanted)
        change = np.concatenate((_CHANGED / self._full**2, np.full(len(turning), _TURNED)))
        linear[0] -= change * np.concatenate((cycle.forces, cycle.azimuths[turning]))
        diagonal = self._costs(cycle.aim, linear)
        low, high = self._limits(cycle)
        reach = np.tile(self._rates * self._step_s, steps - 1)
        x, _, flag, _ = daqp.solve(
            frame.hessian(blocks, diagonal, change),
            linear.ravel(),
            frame.rows,
            np.concatenate((high.ravel(), reach)),
            np.concatenate((low.ravel(), -reach)),
            frame.sense,
        )
        if flag != _OPTIMAL:
            return False
        solution = np.clip(np.asarray(x).reshape(steps, width), low, high)
        self._forces = solution[:, :count]
        self._azimuths[:, turning] = solution[:, count:]
        return True

    def _shortfall(self, wanted: Floats) -> tuple[Floats, Floats]:
        """Hessian (step, variable, variable) and linear term (step, variable) of the cost of missing `wanted`."""
        turning = self._turning
        c, s = np.cos(self._azimuths), np.sin(self._azimuths)
        by_force = np.stack((c, s, self._x * s - self._y * c), axis=1)
        c, s, force, about = c[:, turning], s[:, turning], self._forces[:, turning], self._azimuths[:, turning]
        lever = self._x[turning] * c + self._y[turning] * s
        by_azimuth = np.stack((-s * force, c * force, lever * force), axis=1)
        slopes = np.concatenate((by_force, by_azimuth), axis=2)
        target = wanted + np.einsum("kij,kj->ki", by_azimuth, about)
        weighted = slopes * self._weights[:, None]
        return np.einsum("kia,kib->kab", weighted, slopes), -np.einsum("kia,ki->ka", weighted, target)

    def _costs(self, aim: _Aim, linear: Floats) -> Floats:
        """What the other costs add to the Hessian's diagonal (step, variable); they are added to `linear` here."""
        turning, count = self._turning, len(self._thrusters)
        power = 1.0 / (self._full**2 * np.sqrt(np.maximum(np.abs(self._forces) / self._full, _SMALL_SHARE)))
        bent = _BENT * power[:, turning] * self._forces[:, turning] ** 2
        off = aim.pull[:, turning]
        linear[:, count:] -= bent * self._azimuths[:, turning] + off * aim.azimuths[:, turning]
        return np.concatenate((power, bent + off), axis=1)

    def _limits(self, cycle: _Cycle) -> tuple[Floats, Floats]:
        """Bounds of the variables (step, variable): a turning thruster pushes to the side where its force should be."""
        steps, turning, aim = len(self._forces), self._turning, cycle.aim
        least, most = np.tile(cycle.working * self._least, (steps, 1)), np.tile(cycle.working * self._full, (steps, 1))
        astern = np.cos(self._azimuths[:, turning] - aim.directions[:, turning]) < 0.0
        least[:, turning] = np.where(astern, least[:, turning], 0.0)
        most[:, turning] = np.where(astern, 0.0, most[:, turning])
        there = cycle.azimuths[turning]
        spans = np.array([self._thrusters[i].sectors.span(float(cycle.azimuths[i])) for i in turning])
        left, right = np.tile(spans[:, 0], (steps, 1)), np.tile(spans[:, 1], (steps, 1))
        left[0] = np.maximum(left[0], there - self._rates * cycle.dt_s)
        right[0] = np.minimum(right[0], there + self._rates * cycle.dt_s)
        return np.concatenate((least, left), axis=1), np.concatenate((most, right), axis=1)


@dataclass(frozen=True, slots=True)
class _Aim:
    """At each step, for each thruster: the preferred azimuth, not wrapped, how much it counts, and the direction that
    its force should have."""

    azimuths: Floats
    pull: Floats
    directions: Floats


@dataclass(frozen=True, slots=True)
class _Cycle:
    """The demands (step, axis), the aim, the present forces and azimuths, 1 for each thruster that works and 0 for one
    that has failed, and the time until the next cycle."""

    wanted: Floats
    aim: _Aim
    forces: Floats
    azimuths: Floats
    working: Floats
    dt_s: float


class _Frame:
    """The arrays of the programme whose shape does not change. The variables are, step by step, all forces and then
    the azimuths of the turning thrusters."""

    def __init__(self, steps: int, count: int, turning: int) -> None:
        width = count + turning
        self.steps, self._width = steps, width
        self.rows = np.zeros(((steps - 1) * turning, steps * width))  # turn from each step to the next
        for k in range(steps - 1):
            for j in range(turning):
                row = k * turning + j
                self.rows[row, k * width + count + j], self.rows[row, (k + 1) * width + count + j] = -1.0, 1.0
        self.sense = np.zeros(steps * width + len(self.rows), dtype=np.intc)

    def hessian(self, blocks: Floats, diagonal: Floats, change: Floats) -> Floats:
        """The Hessian: a block for each step, more on its diagonal, and the cost of a change from the step before."""
        steps, width = self.steps, self._width
        result = np.zeros((steps, width, steps, width))
        k, j = np.arange(steps), np.arange(width)
        result[k, :, k, :] = blocks
        result[k[:, None], j, k[:, None], j] += diagonal + change
        result[k[:-1, None], j, k[:-1, None], j] += change
        result[k[1:, None], j, k[:-1, None], j] -= change
        result[k[:-1, None], j, k[1:, None], j] -= change
        return result.reshape(steps * width, steps * width)
