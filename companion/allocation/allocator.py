"""Wrench → what each thruster should do, and what that gives."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.allocation.geometry import Thruster, thrusters_of, wrench_of
from companion.allocation.pseudo_inverse import PseudoInverse
from companion.allocation.solver import AllocationSolver, Problem
from companion.config import VesselConfig
from companion.core.angles import nearest_turn, wrap_pi
from companion.core.types import Allocation, ThrusterCommand, Wrench
from companion.params import Parameters

_LIMITED_SHARE = 0.01  # shortfall, as a share of the axis's limit, from which an axis counts as limited
_IDLE_SHARE = 0.06  # share of full force below which a thruster may be turned for free
_PULL = 0.5  # weight of the preferred azimuth of an idle or limited thruster
_TOE_PULL = 0.1  # weight of the toe angle while nothing is asked


class _Base:
    """What every allocation shares: it remembers the last force and azimuth of each thruster (azimuths unwrapped: endless ones count
    their turns) and which thrusters have failed."""

    def __init__(self, config: VesselConfig) -> None:
        self._thrusters = thrusters_of(config)
        self._period_s = 1.0 / config.control_rate_hz
        limits = config.limits
        self._scales = (limits.surge_n, limits.sway_n, limits.yaw_nm)
        self._forces = [0.0] * len(self._thrusters)
        self._azimuths = [t.in_sector(t.rest_rad) for t in self._thrusters]
        self._failed: frozenset[int] = frozenset()
        self._inverse = PseudoInverse(self._thrusters, self._scales)

    def set_failed(self, index: int, failed: bool) -> None:
        """From now on a failed thruster is counted as giving nothing, and the others make up for it."""
        if failed != (index in self._failed) and 0 <= index < len(self._thrusters):
            self._failed = self._failed | {index} if failed else self._failed - {index}
            self._inverse.refresh(self._failed)

    def neutral(self) -> Allocation:
        """No thrust; azimuths stay where they are."""
        self._forces = [0.0] * len(self._thrusters)
        return self._result(Wrench(0.0, 0.0, 0.0))

    def direct(self, thrusters: Sequence[ThrusterCommand], dt_s: float | None = None) -> Allocation:
        """Thrusters as demanded by throttle and azimuth, within their limits and rates over `dt_s` (None: one control period): the
        manual path. Missing or non-finite demands count as no thrust."""
        if dt_s is None:
            dt_s = self._period_s
        for i, t in enumerate(self._thrusters):
            command = thrusters[i] if i < len(thrusters) else None
            throttle = command.throttle if command is not None and math.isfinite(command.throttle) else 0.0
            low, high = self._force_bounds(i, t, dt_s)
            self._forces[i] = min(high, max(low, t.curve.force_n(min(1.0, max(-1.0, throttle)))))
            if t.turns and command is not None and command.azimuth_rad is not None and math.isfinite(command.azimuth_rad):
                self._turn(i, t, command.azimuth_rad, dt_s)
        return self._result(None)

    def _turn(self, i: int, t: Thruster, azimuth_rad: float, dt_s: float) -> None:
        """Turn towards `azimuth_rad` the short way, or through the sector where that is barred."""
        present = self._azimuths[i]
        wanted = t.in_sector(azimuth_rad) if t.sector is not None else nearest_turn(azimuth_rad, present)
        reach = t.azimuth_rate_radps * dt_s
        self._azimuths[i] = min(present + reach, max(present - reach, wanted))

    def _force_bounds(self, i: int, t: Thruster, dt_s: float) -> tuple[float, float]:
        if i in self._failed:
            return 0.0, 0.0
        reach = t.force_rate_nps * dt_s
        present = min(t.max_n, max(t.min_n, self._forces[i]))
        return max(t.min_n, present - reach), min(t.max_n, present + reach)

    def _result(self, demanded: Wrench | None) -> Allocation:
        """Commands from the remembered forces and azimuths, and what they give; `demanded` None: nothing falls short."""
        commands = []
        forces = []
        for t, force, azimuth in zip(self._thrusters, self._forces, self._azimuths, strict=True):
            throttle = t.curve.throttle(force)
            given = t.curve.force_n(throttle)
            forces.append(given)
            shown = None if not t.turns else azimuth if t.sector is not None else wrap_pi(azimuth)
            commands.append(ThrusterCommand(given, throttle, shown))
        achieved = wrench_of(self._thrusters, forces, self._azimuths)
        if demanded is None:
            return Allocation(tuple(commands), achieved, (False, False, False))
        x, y, n = self._scales
        limited = (
            abs(demanded.surge_n - achieved.surge_n) > _LIMITED_SHARE * x,
            y > 0.0 and abs(demanded.sway_n - achieved.sway_n) > _LIMITED_SHARE * y,
            abs(demanded.yaw_nm - achieved.yaw_nm) > _LIMITED_SHARE * n,
        )
        return Allocation(tuple(commands), achieved, limited)

    @staticmethod
    def _finite(wrench: Wrench) -> Wrench:
        if math.isfinite(wrench.surge_n) and math.isfinite(wrench.sway_n) and math.isfinite(wrench.yaw_nm):
            return wrench
        return Wrench(0.0, 0.0, 0.0)


class Allocator(_Base):
    """Constrained allocation: least power and least turning that gives the wrench, within force and azimuth limits and rates.

    `update(wrench, dt_s)` → Allocation with the wrench that the thrusters will give. Remembers the last forces and azimuths. An idle
    thruster, or all of them while an axis falls short, is drawn towards the azimuth of the unconstrained solution, turned about where
    reversing does as well: this is what leads out of singular layouts such as all pods ahead with no thrust.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        super().__init__(config)
        self._parameters = parameters
        self._solver = AllocationSolver(self._thrusters, self._scales)
        self._problem = Problem(len(self._thrusters))
        self._short = False

    def update(self, wrench: Wrench, dt_s: float) -> Allocation:
        """Thrusters for `wrench`, at most `dt_s` of their rates away from the last."""
        wrench = self._finite(wrench)
        problem, parameters = self._problem, self._parameters
        problem.demand = (wrench.surge_n, wrench.sway_n, wrench.yaw_nm)
        problem.iterations = int(parameters["ALLOC_ITER"])
        problem.w_power = parameters["ALLOC_W_POWER"]
        problem.w_turn = parameters["ALLOC_W_TURN"]
        problem.forces_n, problem.azimuths_rad = self._forces, self._azimuths
        ideal = self._inverse.forces_n(problem.demand)
        for i, t in enumerate(self._thrusters):
            problem.force_low_n[i], problem.force_high_n[i] = self._force_bounds(i, t, dt_s)
            if t.turns:
                self._bound_turn(i, t, dt_s)
                self._prefer(i, t, ideal[i])
        self._forces, self._azimuths = self._solver.solve(problem)
        allocation = self._result(wrench)
        self._short = any(allocation.limited)
        return allocation

    def _bound_turn(self, i: int, t: Thruster, dt_s: float) -> None:
        reach, present = t.azimuth_rate_radps * dt_s, self._azimuths[i]
        low, high = present - reach, present + reach
        if t.sector is not None:
            low, high = max(low, t.sector[0]), min(high, t.sector[1])
        self._problem.turn_low_rad[i], self._problem.turn_high_rad[i] = low, max(low, high)

    def _prefer(self, i: int, t: Thruster, ideal: tuple[float, float]) -> None:
        """Where this azimuth should drift to, and how strongly."""
        problem, present = self._problem, self._azimuths[i]
        share = math.hypot(*ideal) / t.max_n
        idle = abs(self._forces[i]) < _IDLE_SHARE * t.max_n
        asked = min(1.0, share / _IDLE_SHARE)
        if (idle or self._short) and asked > 0.5:
            azimuth = nearest_turn(math.atan2(ideal[1], ideal[0]), present)
            if t.reversible:
                azimuth = present + math.remainder(azimuth - present, math.pi)
            problem.preferred_rad[i] = t.in_sector(azimuth)
            problem.preferred_weight[i] = _PULL * asked
        elif idle:
            problem.preferred_rad[i] = t.toe_rad if t.sector is not None else present + math.remainder(t.toe_rad - present, math.pi)
            problem.preferred_weight[i] = _TOE_PULL * (1.0 - asked)
        else:
            problem.preferred_weight[i] = 0.0


class PseudoInverseAllocator(_Base):
    """The unconstrained alternative: pseudo-inverse, then cut to the limits. Same interface as `Allocator`."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        super().__init__(config)

    def update(self, wrench: Wrench, dt_s: float) -> Allocation:
        """Thrusters for `wrench`, cut to limits and rates afterwards."""
        wrench = self._finite(wrench)
        ideal = self._inverse.forces_n((wrench.surge_n, wrench.sway_n, wrench.yaw_nm))
        for i, t in enumerate(self._thrusters):
            x, y = ideal[i]
            low, high = self._force_bounds(i, t, dt_s)
            force = x
            if t.turns:
                force = math.hypot(x, y)
                azimuth = nearest_turn(math.atan2(y, x), self._azimuths[i])
                turn = azimuth - self._azimuths[i]
                if t.reversible and abs(turn) > 0.5 * math.pi:
                    azimuth, force = azimuth - math.copysign(math.pi, turn), -force
                if abs(force) > 1.0e-3 * t.max_n:
                    self._turn(i, t, azimuth, dt_s)
            self._forces[i] = min(high, max(low, force))
        return self._result(wrench)
