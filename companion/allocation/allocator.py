"""Thrust allocation: wrench → demands on azimuth and fixed thrusters, and the wrench that they give."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from companion.allocation.astray import Astray
from companion.allocation.foresight import Foresight, ThrusterPlan
from companion.allocation.geometry import Thruster, thrusters_of, wrench_of
from companion.allocation.lone_side import LoneSide
from companion.allocation.pseudo_inverse import PseudoInverse
from companion.allocation.shortfall import LIMITED_SHARE, limited_axes
from companion.allocation.solver import YAW_PRIORITY, AllocationSolver, Problem
from companion.allocation.strong_side import StrongSide
from companion.allocation.sway_reach import sway_reach_n
from companion.allocation.thrift import Thrift
from companion.config.vessel import VesselConfig
from companion.core.actuation import ZERO_WRENCH, Allocation, ThrusterCommand, Wrench
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState, Rig
from companion.core.setpoint import PATH_STEP_S
from companion.params.store import Parameters

_IDLE_SHARE = 0.1  # share of full force below which turning a thruster costs no thrust
_PULL = 0.05  # weight of the preferred azimuth of an idle or limited thruster
# Share of a limit that must be missing before a thruster at its stop turns round without thrust; with less it waits
# longer: 2 s where half of the demand or more is missing.
_WORTH_A_TURN = 0.2
_LEAST_WORTH = 0.02
_HALF_MISSING, _SOON = 0.5, 0.25  # of the demand; of the pace at which it waits with _WORTH_A_TURN
# How long a better azimuth must lie beyond a forbidden sector, or the other way round the stops, before the thruster
# turns there.
_APART_S = 0.5
_AT_STOP_RAD = 0.02
_WORTH_TURNING_ROUND = 0.05  # power wasted, as a share of one thruster's, for which it turns round without thrust
_AGAINST_S = 2.0  # how long it must have pushed against the demand: longer than a corner lasts
_WAY_LENGTHS_PS = 0.1  # speed through the water from which a boat is under way, in its lengths a second
_WORTH_AIMING = 0.05  # share of full force from which a thruster is aimed under way
_MOST_OF_SHARE = 1.1  # of what the unconstrained solution gives it, while a thruster turns there
_NOTHING_N = 1.0e-3
_UNCONSTRAINED = 1  # ALLOC_KIND
_MUCH_SHARE = 0.5  # of the demand
_GIVEN_SHARE = 0.1  # of the demand: less may be missing where thrusters give it
_LEEWAY = 0.01  # share of full force by which a thruster may push harder or less than foreseen
_TURNED_COS = 0.5  # of its demand off the azimuth that a thruster turns to: further off, that is no longer its aim
_AS_GOOD_RAD = math.radians(15.0)  # with ALLOC_ECON: so far off costs less than the way round
_TOE_PULL = 0.01  # weight of the toe angle while the demand is zero


class _AllocatorBase:
    """What both kinds of allocation share. Remembers the last force and azimuth of each thruster (azimuths unwrapped:
    endless ones count their turns) and which thrusters have failed."""

    def __init__(self, config: VesselConfig) -> None:
        self._thrusters = thrusters_of(config)
        self._period_s = 1.0 / config.control_rate_hz
        limits = self._limits = config.limits
        self._scales = (limits.surge_n, limits.sway_n, limits.yaw_nm)
        self._forces = [0.0] * len(self._thrusters)
        self._azimuths = [t.sectors.nearest(t.rest_rad, t.rest_rad) for t in self._thrusters]
        self._failed: frozenset[int] = frozenset()
        self._inverse = PseudoInverse(self._thrusters, self._scales)

    def set_failed(self, index: int, failed: bool) -> None:
        """Mark thruster `index` as failed or not. A failed one gives nothing, and the others make up for it."""
        if failed != (index in self._failed) and 0 <= index < len(self._thrusters):
            self._failed = self._failed | {index} if failed else self._failed - {index}
            self._inverse.refresh(self._failed)

    def set_turn_rate(self, index: int, rate_radps: float) -> None:
        """Turn the azimuth of thruster `index` no faster from now on."""
        if 0 <= index < len(self._thrusters):
            self._thrusters[index].azimuth_rate_radps = rate_radps

    def feel(self, rig: Rig | None, nav: NavState) -> None:
        """Take the wind over ground and the boat's motion. They have no effect on these thrusters."""

    def neutral(self) -> Allocation:
        """Set all forces to zero; azimuths stay where they are."""
        self._forces = [0.0] * len(self._thrusters)
        return self._result(Wrench(0.0, 0.0, 0.0))

    def direct(
        self, thrusters: Sequence[ThrusterCommand], dt_s: float | None = None, surge_mps: float = 0.0
    ) -> Allocation:
        """Take throttles and azimuths as demanded, within limits and rates over `dt_s` (None: one control period): the
        manual path. Missing or non-finite demands count as no thrust. `surge_mps` has no effect on these thrusters."""
        if dt_s is None:
            dt_s = self._period_s
        for i, t in enumerate(self._thrusters):
            command = thrusters[i] if i < len(thrusters) else None
            throttle = command.throttle if command is not None and math.isfinite(command.throttle) else 0.0
            if (
                t.turns
                and command is not None
                and command.azimuth_rad is not None
                and math.isfinite(command.azimuth_rad)
            ):
                self._turn(i, t, command.azimuth_rad, dt_s)
            low, high = self._force_bounds(i, t, dt_s)
            self._forces[i] = min(high, max(low, t.curve.force_n(min(1.0, max(-1.0, throttle)))))
        return self._result(None)

    def _turn(self, i: int, t: Thruster, azimuth_rad: float, dt_s: float) -> None:
        """Turn towards `azimuth_rad`, or the nearest allowed azimuth: the shorter way, unless stops are in between."""
        present = self._azimuths[i]
        reach = t.azimuth_rate_radps * dt_s
        self._azimuths[i] = min(present + reach, max(present - reach, t.sectors.nearest(azimuth_rad, present)))

    def _force_bounds(self, i: int, t: Thruster, dt_s: float) -> tuple[float, float]:
        if i in self._failed or not t.sectors.allowed(self._azimuths[i]):
            return 0.0, 0.0
        reach = t.force_rate_nps * dt_s
        present = min(t.max_n, max(t.min_n, self._forces[i]))
        return max(t.min_n, present - reach), min(t.max_n, present + reach)

    def _result(self, demanded: Wrench | None) -> Allocation:
        """Commands from the remembered forces and azimuths, and the wrench that they give. `demanded` None: no axis
        counts as limited."""
        commands = []
        forces = []
        for t, force, azimuth in zip(self._thrusters, self._forces, self._azimuths, strict=True):
            throttle = t.curve.throttle(force)
            given = t.curve.force_n(throttle)
            forces.append(given)
            shown = None if not t.turns else wrap_pi(azimuth) if t.sectors.endless else azimuth
            commands.append(ThrusterCommand(given, throttle, shown))
        achieved = wrench_of(self._thrusters, forces, self._azimuths)
        return Allocation(tuple(commands), achieved, limited_axes(demanded, achieved, self._limits))

    @staticmethod
    def _finite(wrench: Wrench) -> Wrench:
        if math.isfinite(wrench.surge_n) and math.isfinite(wrench.sway_n) and math.isfinite(wrench.yaw_nm):
            return wrench
        return Wrench(0.0, 0.0, 0.0)


class Allocator(_AllocatorBase):
    """Wrench → Allocation, by the kind that ALLOC_KIND chooses.

    Constrained: the wrench at least power and least turning, within limits and rates of force and azimuth. An idle
    thruster (or every thruster, while an axis falls short) is drawn towards its azimuth in the unconstrained solution,
    or the opposite one where reversing is as good. This leads out of singular layouts, such as all pods ahead without
    thrust. If that azimuth lies beyond a forbidden sector or the other way round the stops, or if an axis falls short
    because the thruster reverses at a stop, the thruster turns there without thrust. One that has long wasted much
    power, or a little with ALLOC_ECON, turns with little. One that has long pushed hard in reverse, where it is weaker,
    turns with thrust. A thruster that is alone turns to its aim on the side, ahead or astern, that `LoneSide` chooses,
    and pushes to no other.

    Unconstrained: the pseudo-inverse, then cut to limits and rates. Remembers the last forces and azimuths, which
    thrusters are turning round, and whether the boat has made way on its planned path.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        super().__init__(config)
        self._parameters = parameters
        self._solver = AllocationSolver(self._thrusters, self._scales)
        self._problem = Problem(len(self._thrusters))
        self._foresight = Foresight(self._thrusters, self._scales, PATH_STEP_S)
        self._foreseen: ThrusterPlan | None = None  # for this cycle
        self._alone = len(self._thrusters) == 1
        self._lone_side = LoneSide(self._thrusters[0], self._scales)
        self._can_waste = not self._alone and any(t.turns for t in self._thrusters)
        self._way_mps = _WAY_LENGTHS_PS * config.length_m
        self._thrifty = False  # in this cycle
        self._begin_anew()

    def _begin_anew(self) -> None:
        """Forget the last demands, and the turns that they began."""
        count = len(self._thrusters)
        self._short = False
        self._beyond_reach = False  # the last demand, before it was limited to what can be given with the moment
        self._wasted = 0.0  # power beyond that of the unconstrained solution, in full thrusters
        self._missing = 0.0  # shortfall of the worst axis, as a share of its limit
        self._asked = 0.0  # demand of the axis that is asked for most, likewise
        self._useful = 0.0  # how much more of the demand would not be given without thrust, in limits
        self._much_missing = False  # of the demand
        self._has_made_way = False  # on the planned path
        self._crossing: list[float | None] = [None] * count  # azimuth to turn to
        self._pushes: set[int] = set()  # those of them that give thrust meanwhile
        self._meanwhile_n = [(0.0, 0.0)] * count  # (x, y) that the others of them may give part of
        self._pushed_n = [0.0] * count  # the last force that was not 0
        self._apart_s = [0.0] * count
        self._against_s = [0.0] * count
        self._strong_side = StrongSide(self._thrusters)
        self._thrift = Thrift(self._thrusters)
        self._astray = Astray(self._thrusters)
        self._lone_side.reset()
        self._foresight.reset()

    def set_failed(self, index: int, failed: bool) -> None:
        """As `_AllocatorBase.set_failed`; one that fails has no turn to end, for which the others would wait."""
        super().set_failed(index, failed)
        if index in self._failed:
            self._end_turn(index)

    def neutral(self) -> Allocation:
        """Set all forces to zero, and begin anew; azimuths stay where they are."""
        self._begin_anew()
        return super().neutral()

    def direct(
        self, thrusters: Sequence[ThrusterCommand], dt_s: float | None = None, surge_mps: float = 0.0
    ) -> Allocation:
        """As `_AllocatorBase.direct`; begin anew."""
        self._begin_anew()
        return super().direct(thrusters, dt_s, surge_mps)

    def update(
        self,
        wrench: Wrench,
        dt_s: float,
        surge_mps: float = 0.0,
        planned: bool = False,
        ahead: Sequence[Wrench] = (),
    ) -> Allocation:
        """The allocation for `wrench`, within `dt_s` of the thrusters' rates from the last. `planned`: the demand
        follows a planned path; until the boat makes way through the water on it (`surge_mps`), and while it does, its
        thrusters stay aimed. `ahead`: the wrenches that the path will demand, PATH_STEP_S apart."""
        asked = self._finite(wrench)
        wrench = self._within_reach(asked, planned)
        ideal = self._inverse.forces_n((wrench.surge_n, wrench.sway_n, wrench.yaw_nm))
        if self._parameters["ALLOC_KIND"] == _UNCONSTRAINED:
            self._cut(ideal, dt_s)
        else:
            self._foreseen = self._foresee(wrench, ahead, dt_s)
            aimed = self._foreseen is not None or (planned and self._stays_aimed(surge_mps))
            self._optimise(wrench, ideal, dt_s, aimed, surge_mps > self._way_mps)
        self._has_made_way = planned and (self._has_made_way or surge_mps > self._way_mps)
        allocation = self._result(asked)
        self._missing = self._largest_share(wrench, allocation.achieved)
        self._short = self._missing > LIMITED_SHARE
        self._beyond_reach = self._largest_share(asked, allocation.achieved) > LIMITED_SHARE
        self._asked = self._largest_share(wrench, ZERO_WRENCH)
        lacking, wanted = self._off(wrench, allocation.achieved), self._off(wrench, ZERO_WRENCH)
        self._useful = max(0.0, wanted - lacking)
        self._much_missing = lacking > max(_MUCH_SHARE * wanted, _LEAST_WORTH)
        return allocation

    def _within_reach(self, wrench: Wrench, planned: bool) -> Wrench:
        """The demand without sideways force that the thrusters cannot give with the moment: after a failure, and on a
        planned path where the last one was more than they give. In a stream the bow has to come round first."""
        if not (self._failed or (planned and self._beyond_reach)) or self._scales[1] <= 0.0:
            return wrench
        least_n, most_n = sway_reach_n(self._thrusters, self._failed, wrench.yaw_nm, wrench.surge_n)
        return replace(wrench, sway_n=min(most_n, max(least_n, wrench.sway_n)))

    def _foresee(self, wrench: Wrench, ahead: Sequence[Wrench], dt_s: float) -> ThrusterPlan | None:
        """Where to point the thrusters for what the planned path will demand; None where that makes no difference, and
        while one turns round."""
        if not ahead or self._alone or any(azimuth is not None for azimuth in self._crossing):
            self._foresight.reset()
            return None
        return self._foresight.update((wrench, *ahead), self._inverse, self._failed, self._forces, self._azimuths, dt_s)

    def _stays_aimed(self, surge_mps: float) -> bool:
        """Whether a boat on a planned path keeps its thrusters aimed: under way, and at first, when wind and current
        carry it aside. A slow boat in a bend may reverse them, as long as they then give what is demanded."""
        return surge_mps > self._way_mps or not self._has_made_way or self._missing > _WORTH_A_TURN

    def _cut(self, ideal: Sequence[tuple[float, float]], dt_s: float) -> None:
        """Set forces and azimuths to the unconstrained solution `ideal`, cut to limits and rates."""
        for i, t in enumerate(self._thrusters):
            x, y = ideal[i]
            force = x
            if t.turns:
                force = math.hypot(x, y)
                azimuth, reversed_ = self._aim(i, t, math.atan2(y, x))
                force = -force if reversed_ else force
                if abs(force) > 1.0e-3 * t.max_n:
                    self._turn(i, t, azimuth, dt_s)
            low, high = self._force_bounds(i, t, dt_s)
            self._forces[i] = min(high, max(low, force))
        self._crossing = [None] * len(self._thrusters)
        self._meanwhile_n = [(0.0, 0.0)] * len(self._thrusters)
        self._pushes.clear()

    def _optimise(
        self, wrench: Wrench, ideal: Sequence[tuple[float, float]], dt_s: float, aimed: bool, makes_way: bool
    ) -> None:
        """Set forces and azimuths to the constrained optimum; `ideal` gives the preferred azimuths, and `aimed` holds
        thrusters there. `makes_way`: ahead through the water."""
        problem, parameters = self._problem, self._parameters
        problem.demand = (wrench.surge_n, wrench.sway_n, wrench.yaw_nm)
        problem.iterations = int(parameters["ALLOC_ITER"])
        problem.w_power = parameters["ALLOC_W_POWER"]
        problem.w_turn = parameters["ALLOC_W_TURN"]
        problem.forces_n, problem.azimuths_rad = self._forces, self._azimuths
        self._wasted = self._power_wasted(ideal)
        self._see_thrift(ideal, dt_s)
        self._strong_side.see(self._forces, dt_s)
        astray = not aimed and self._have_gone_astray(wrench, ideal, dt_s)
        for i, t in enumerate(self._thrusters):
            problem.force_low_n[i], problem.force_high_n[i] = self._force_bounds(i, t, dt_s)
            if t.turns and self._alone:
                self._steer_alone(t, ideal[i], makes_way, dt_s)
            elif t.turns:
                self._prefer(i, t, ideal[i], dt_s)
                if i not in self._failed:
                    self._consider_turning_round(i, t, ideal[i], dt_s)
                    self._consider_thrift(i, t)
                    self._consider_strong_side(i, t, ideal[i])
                self._bound_turn(i, t, ideal[i], dt_s)
                if aimed and self._crossing[i] is None:
                    self._keep_ahead(i, t, ideal[i], dt_s)
                elif astray and self._crossing[i] is None:
                    direction_rad = math.atan2(ideal[i][1], ideal[i][0])
                    self._turn_with_thrust(i, t, ideal[i], self._aim(i, t, direction_rad)[0], dt_s)
        self._forces, self._azimuths = self._solver.solve(problem)
        self._pushed_n = [
            force if abs(force) > _NOTHING_N else last for force, last in zip(self._forces, self._pushed_n, strict=True)
        ]

    def _steer_alone(self, t: Thruster, ideal: tuple[float, float], makes_way: bool, dt_s: float) -> None:
        """Bound turn and force of the only thruster: it pushes to one side, and turns to its aim there. Near that the
        solver weighs force and moment."""
        problem, present, side = self._problem, self._azimuths[0], self._lone_side
        reach = t.azimuth_rate_radps * dt_s
        surge_n, _, yaw_nm = problem.demand
        side.update((surge_n, yaw_nm), ideal, self._forces[0], present, makes_way, dt_s)
        low, high = t.sectors.span(present)
        low, high = max(low, present - reach), min(high, present + reach)
        aim_rad = present if side.aim_rad is None else side.aim_rad
        if abs(aim_rad - present) > reach:
            low = high = present + math.copysign(reach, aim_rad - present)
        problem.turn_low_rad[0], problem.turn_high_rad[0] = low, max(low, high)
        problem.preferred_rad[0], problem.preferred_weight[0] = aim_rad, _PULL
        least, most = problem.force_low_n[0], problem.force_high_n[0]
        if low == high and not t.sectors.allowed(low):
            problem.force_low_n[0] = problem.force_high_n[0] = 0.0
        elif side.ahead:
            problem.force_low_n[0] = min(most, max(least, 0.0))
        else:
            problem.force_high_n[0] = max(least, min(most, 0.0))

    def _bound_turn(self, i: int, t: Thruster, ideal: tuple[float, float], dt_s: float) -> None:
        """Set the azimuth bounds of one thruster. It crosses without thrust, unless it turns to its strong side.
        To save power it turns with no more than it then gives and never against that, or the others drive the boat
        off meanwhile."""
        problem, reach, present = self._problem, t.azimuth_rate_radps * dt_s, self._azimuths[i]
        target = self._crossing[i]
        if target is not None:
            step = min(present + reach, max(present - reach, target))
            if i not in self._pushes:
                self._bound_meanwhile(i, step)
            problem.turn_low_rad[i] = problem.turn_high_rad[i] = step
            if step == target:
                self._end_turn(i)
            return
        low, high = t.sectors.span(present)
        low, high = max(low, present - reach), min(high, present + reach)
        problem.turn_low_rad[i], problem.turn_high_rad[i] = low, max(low, high)
        if (self._pushes or self._helped) and i not in self._pushes and not self._is_to_change(i, t, ideal):
            self._keep_sign(i)

    @property
    def _helped(self) -> bool:
        """Whether a thruster gives thrust while it turns to save power."""
        return any(x != 0.0 or y != 0.0 for x, y in self._meanwhile_n)

    def _bound_meanwhile(self, i: int, azimuth_rad: float) -> None:
        """Bound the force of a thruster that turns: to what it may give meanwhile, and none against that."""
        problem, (x, y) = self._problem, self._meanwhile_n[i]
        most_n = math.copysign(math.hypot(x, y), x * math.cos(azimuth_rad) + y * math.sin(azimuth_rad))
        low_n, high_n = problem.force_low_n[i], problem.force_high_n[i]
        problem.force_low_n[i] = min(high_n, max(low_n, min(0.0, most_n)))
        problem.force_high_n[i] = max(low_n, min(high_n, max(0.0, most_n)))

    def _is_to_change(self, i: int, t: Thruster, ideal: tuple[float, float]) -> bool:
        """Whether the demand has turned, and with it the side to which one thruster is to push."""
        azimuth = self._azimuths[i]
        along_n = ideal[0] * math.cos(azimuth) + ideal[1] * math.sin(azimuth)
        return math.copysign(along_n, along_n * self._pushed_n[i]) < -_IDLE_SHARE * t.max_n

    def _keep_sign(self, i: int) -> None:
        """Let one thruster push only as it does now: beside one that turns with thrust it would turn round, too."""
        problem = self._problem
        if self._pushed_n[i] >= 0.0:
            problem.force_low_n[i] = max(problem.force_low_n[i], min(0.0, problem.force_high_n[i]))
        else:
            problem.force_high_n[i] = min(problem.force_high_n[i], max(0.0, problem.force_low_n[i]))

    def _keep_ahead(self, i: int, t: Thruster, ideal: tuple[float, float], dt_s: float) -> None:
        """Under way on a planned path: turn one thruster to its azimuth in the unconstrained solution, and let it push
        ahead there. Left to itself it would reverse for a moment's demand, and stay on the wrong side of it. While it
        is still more than 90° off, only reverse is of use. On the way it pushes hardly harder than there: two thrusters
        far off their aim would push with full force against each other for a little of the wrench."""
        if self._foreseen is not None:
            self._follow(i, t, self._foreseen)
            return
        if math.hypot(*ideal) >= _WORTH_AIMING * t.max_n:
            aim_rad = t.aim_rad(math.atan2(ideal[1], ideal[0]), self._azimuths[i])
            self._turn_with_thrust(i, t, ideal, aim_rad, dt_s)

    def _turn_with_thrust(self, i: int, t: Thruster, ideal: tuple[float, float], aim_rad: float, dt_s: float) -> None:
        """Turn one thruster to `aim_rad`. On the way it pushes towards `ideal`, and hardly harder than that."""
        problem, reach, present = self._problem, t.azimuth_rate_radps * dt_s, self._azimuths[i]
        direction = math.atan2(ideal[1], ideal[0])
        low, high = problem.turn_low_rad[i], problem.turn_high_rad[i]
        step = min(high, max(low, min(present + reach, max(present - reach, aim_rad))))
        problem.turn_low_rad[i] = problem.turn_high_rad[i] = step
        least, most = problem.force_low_n[i], problem.force_high_n[i]
        useful_n = _MOST_OF_SHARE * math.hypot(*ideal)
        if math.cos(step - direction) < 0.0:
            problem.force_low_n[i] = min(most, max(least, -useful_n))
            problem.force_high_n[i] = max(least, min(most, 0.0))
        else:
            problem.force_low_n[i] = min(most, max(least, 0.0))
            problem.force_high_n[i] = max(least, min(most, useful_n))

    def _follow(self, i: int, t: Thruster, foreseen: ThrusterPlan) -> None:
        """Turn one thruster, and let it push, as foreseen."""
        problem = self._problem
        low, high = problem.turn_low_rad[i], problem.turn_high_rad[i]
        problem.turn_low_rad[i] = problem.turn_high_rad[i] = min(high, max(low, foreseen.azimuths_rad[i]))
        least, most = problem.force_low_n[i], problem.force_high_n[i]
        force, leeway = foreseen.forces_n[i], _LEEWAY * t.max_n
        problem.force_low_n[i] = min(most, max(least, force - leeway))
        problem.force_high_n[i] = max(least, min(most, force + leeway))

    def _prefer(self, i: int, t: Thruster, ideal: tuple[float, float], dt_s: float) -> None:
        """Set the preferred azimuth of one thruster, and its weight."""
        problem, present = self._problem, self._azimuths[i]
        share = math.hypot(*ideal) / t.max_n
        idle = abs(self._forces[i]) < _IDLE_SHARE * t.max_n
        asked = min(1.0, share / _IDLE_SHARE)
        worth = asked > 0.5 or (self._short and self._missing > _LEAST_WORTH)
        if worth and (idle or self._short):
            direction_rad = math.atan2(ideal[1], ideal[0])
            problem.preferred_rad[i], _ = self._aim(i, t, direction_rad)
            problem.preferred_weight[i] = _PULL * asked
            self._consider_crossing(i, t, problem.preferred_rad[i], dt_s)
        elif idle:
            problem.preferred_rad[i] = (
                present + math.remainder(t.toe_rad - present, math.pi) if t.sectors.free else t.toe_rad
            )
            placed = self._thrifty and self._thrift.is_asked(i)
            problem.preferred_weight[i] = 0.0 if placed else _TOE_PULL * (1.0 - asked)
            self._apart_s[i] = 0.0
        else:
            problem.preferred_weight[i] = 0.0
            self._apart_s[i] = 0.0

    def _have_gone_astray(self, wrench: Wrench, ideal: Sequence[tuple[float, float]], dt_s: float) -> bool:
        """Whether to turn the thrusters to their azimuths in the unconstrained solution `ideal`: there they give what
        is demanded."""
        judged = self._much_missing and not self._alone and all(azimuth is None for azimuth in self._crossing)
        if not judged or not self._would_do(wrench, ideal):
            self._astray.reset()
            return False
        shares = [math.hypot(x, y) / t.max_n for t, (x, y) in zip(self._thrusters, ideal, strict=True)]
        aims = [self._aim(i, t, math.atan2(ideal[i][1], ideal[i][0]))[0] for i, t in enumerate(self._thrusters)]
        return self._astray.update(shares, aims, self._azimuths, dt_s)

    def _would_do(self, wrench: Wrench, ideal: Sequence[tuple[float, float]]) -> bool:
        """Whether the forces `ideal` are within the limits and give the demand; after a failure nothing may."""
        pairs = list(zip(self._thrusters, ideal, strict=True))
        forces = [math.hypot(x, y) if t.turns else x for t, (x, y) in pairs]
        if any(abs(force) > t.max_n for t, force in zip(self._thrusters, forces, strict=True)):
            return False
        azimuths = [math.atan2(y, x) if t.turns else t.rest_rad for t, (x, y) in pairs]
        given = wrench_of(self._thrusters, forces, azimuths)
        return self._off(wrench, given) < _GIVEN_SHARE * self._off(wrench, ZERO_WRENCH)

    def _see_thrift(self, ideal: Sequence[tuple[float, float]], dt_s: float) -> None:
        """While every axis is given, the mean demand is taken."""
        judged = self._can_waste and not self._short
        self._thrifty = judged and self._parameters["ALLOC_ECON"] > 0.0
        if judged:
            self._thrift.see(ideal, self._forces, self._azimuths, dt_s)
        else:
            self._thrift.reset()

    def _consider_thrift(self, i: int, t: Thruster) -> None:
        """Begin to turn a thruster to the azimuth of its share of the mean demand, where that pays; with no more thrust
        than that share, and across a forbidden sector with none."""
        if self._crossing[i] is None and self._thrift.pays(i, self._thrifty) and not self._others_cross(i):
            x, y = self._thrift.shares[i]
            target_rad, _ = self._aim(i, t, math.atan2(y, x))
            self._crossing[i] = target_rad
            low_rad, high_rad = t.sectors.span(self._azimuths[i])
            if low_rad <= target_rad <= high_rad:
                self._meanwhile_n[i] = (x, y)
            self._thrift.turned_round(i)

    def _consider_strong_side(self, i: int, t: Thruster, ideal: tuple[float, float]) -> None:
        """Begin to turn a thruster that has long pushed hard astern, with thrust: all of it may be needed. One that
        hardly reverses turns only where an axis falls short. Where the demand has turned meanwhile, the turn ends."""
        target_rad = self._crossing[i]
        if target_rad is not None and i in self._pushes:
            along_n, asked_n = ideal[0] * math.cos(target_rad) + ideal[1] * math.sin(target_rad), math.hypot(*ideal)
            if asked_n > _IDLE_SHARE * t.max_n and along_n < _TURNED_COS * asked_n:
                self._end_turn(i)
            return
        worth = t.reversible or self._short
        if worth and target_rad is None and not self._others_cross(i):
            target_rad = self._strong_side.way_round_rad(i, t, self._forces[i], self._azimuths[i])
            if target_rad is not None:
                self._crossing[i] = target_rad
                self._pushes.add(i)
                self._strong_side.turned(i)

    def _end_turn(self, i: int) -> None:
        self._crossing[i] = None
        self._pushes.discard(i)
        self._meanwhile_n[i] = (0.0, 0.0)

    def _aim(self, i: int, t: Thruster, direction_rad: float) -> tuple[float, bool]:
        """(azimuth that pushes best in that direction, whether in reverse); of two equal ones the nearer."""
        present = self._azimuths[i]
        ahead = t.sectors.nearest(direction_rad, present)
        if not t.reversible:
            return ahead, False
        astern = t.sectors.nearest(direction_rad + math.pi, present)
        miss_ahead = abs(math.remainder(ahead - direction_rad, math.tau))
        miss_astern = abs(math.remainder(astern - direction_rad - math.pi, math.tau))
        if abs(miss_ahead - miss_astern) > (_AS_GOOD_RAD if self._thrifty else 1.0e-6):
            return (ahead, False) if miss_ahead < miss_astern else (astern, True)
        return (ahead, False) if abs(ahead - present) <= abs(astern - present) else (astern, True)

    def _consider_crossing(self, i: int, t: Thruster, wanted_rad: float, dt_s: float) -> None:
        """Begin to turn without thrust to an azimuth that cannot be reached with thrust, or where the thrust
        changes its sign; at once from inside a forbidden sector."""
        present = self._azimuths[i]
        if self._crossing[i] is not None or t.sectors.free:
            return
        low, high = t.sectors.span(present)
        apart = not low - 1.0e-6 <= wanted_rad <= high + 1.0e-6 or abs(wanted_rad - present) > math.pi
        stopped = min(present - low, high - present) < _AT_STOP_RAD
        turned = abs(wanted_rad - present) > 0.5 * math.pi
        pace = 1.0 if apart else self._worth_a_turn() if stopped and turned else 0.0
        apart = pace > 0.0
        self._apart_s[i] = self._apart_s[i] + pace * dt_s if apart else 0.0
        price_s = self._price_s(t, wanted_rad - present)
        waited = self._apart_s[i] >= max(_APART_S, price_s)
        if (waited and not self._others_cross(i)) or (apart and not t.sectors.allowed(present)):
            self._crossing[i] = wanted_rad
            self._apart_s[i] = 0.0

    def _price_s(self, t: Thruster, turn_rad: float) -> float:
        """How long a thruster waits, at full pace, before it turns without thrust: until as much has been missing as
        the way will cost. Without it the others give little of what is demanded: their moment would turn the boat."""
        turn_s = abs(turn_rad) / t.azimuth_rate_radps
        return self._useful * turn_s / max(_WORTH_A_TURN, self._missing)

    def _worth_a_turn(self) -> float:
        """How much is missing: 1 for so much that a thruster at its stop should turn round at once, 0 for nothing."""
        if self._missing < _LEAST_WORTH:
            return 0.0
        soon = _SOON if self._missing > _HALF_MISSING * self._asked else 0.0
        return min(1.0, max(soon, self._missing / _WORTH_A_TURN))

    def _consider_turning_round(self, i: int, t: Thruster, ideal: tuple[float, float], dt_s: float) -> None:
        """Begin to turn a thruster without thrust that has long pushed, weakly, against its share of the demand.

        It stays there by itself, and the others work against it: on the way round with thrust lies a forbidden sector,
        the other way a wrench that is not demanded."""
        force = self._forces[i]
        if t.sectors.free or self._wasted < _WORTH_TURNING_ROUND or abs(force) > _IDLE_SHARE * t.max_n:
            self._against_s[i] = 0.0
            return
        wanted_rad, reverse = self._aim(i, t, math.atan2(ideal[1], ideal[0]))
        push = -1.0 if reverse else 1.0
        against = push * force * math.cos(self._azimuths[i] - wanted_rad) < 0.0
        self._against_s[i] = self._against_s[i] + dt_s if against else 0.0
        if self._against_s[i] >= _AGAINST_S and self._crossing[i] is None and not self._others_cross(i):
            self._crossing[i] = wanted_rad
            self._against_s[i] = 0.0

    def _power_wasted(self, ideal: Sequence[tuple[float, float]]) -> float:
        """Power of the last forces less that of the unconstrained solution, each thruster's as a share of its full
        power."""
        return sum(
            math.pow(abs(force) / t.max_n, 1.5) - math.pow(math.hypot(x, y) / t.max_n, 1.5)
            for t, force, (x, y) in zip(self._thrusters, self._forces, ideal, strict=True)
        )

    def _largest_share(self, demanded: Wrench, achieved: Wrench) -> float:
        """Difference on the axis where it is largest, as a share of its limit."""
        x, y, n = self._scales
        return max(
            abs(demanded.surge_n - achieved.surge_n) / x,
            abs(demanded.sway_n - achieved.sway_n) / y if y > 0.0 else 0.0,
            abs(demanded.yaw_nm - achieved.yaw_nm) / n,
        )

    def _off(self, demanded: Wrench, achieved: Wrench) -> float:
        """Distance of two wrenches, in limits. Yaw counts as in the solver."""
        x, y, n = self._scales
        return math.hypot(
            (demanded.surge_n - achieved.surge_n) / x,
            (demanded.sway_n - achieved.sway_n) / y if y > 0.0 else 0.0,
            math.sqrt(YAW_PRIORITY) * (demanded.yaw_nm - achieved.yaw_nm) / n,
        )

    def _others_cross(self, i: int) -> bool:
        """Whether another thruster is turning round: only one does at a time, so that thrust is left."""
        return any(target is not None and j != i and j not in self._failed for j, target in enumerate(self._crossing))
