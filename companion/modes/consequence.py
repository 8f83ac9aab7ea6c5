"""Consequence check: would the boat still hold here if any one thruster failed?

Every thruster is a convex set of forces: a disc for one that turns all round, a line for a fixed one. Whether some choice out of them meets
a wrench is a convex problem, solved by projected gradients with momentum (FISTA; Beck & Teboulle 2009). Rates are left aside.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from companion.allocation.geometry import Thruster, thrusters_of
from companion.config import VesselConfig
from companion.core.types import Severity, Wrench
from companion.modes.events import EventLog
from companion.modes.mode import ModeInputs
from companion.params import Parameters

_MOST_STEPS = 400
_MET = 0.01  # of the wrench limits: what is left over then does not matter
_MEAN_S = 20.0
_SETTLE_S = 15.0
_PERIOD_S = 1.0
_MARGIN = 1.15  # by which the demand must be met before an answer turns good again

Vector = tuple[float, float]
Columns = tuple[tuple[float, float, float], tuple[float, float, float]]


def is_met(thrusters: Sequence[Thruster], limits: tuple[float, float, float], demand: Wrench, out: frozenset[int]) -> bool:
    """Whether the thrusters, without those whose index is in `out`, can give `demand` within their forces.

    `limits`: the vessel's largest wrench, by which the three axes are weighed; an axis with limit 0 does not count.
    """
    scales = tuple(1.0 / limit if limit > 0.0 else 0.0 for limit in limits)
    target = (demand.surge_n * scales[0], demand.sway_n * scales[1], demand.yaw_nm * scales[2])
    used = [t for i, t in enumerate(thrusters) if i not in out]
    columns = [_columns(t, scales) for t in used]
    projections = [_projection(t) for t in used]
    lipschitz = sum(a * a for pair in columns for column in pair for a in column)
    if lipschitz == 0.0:
        return max(abs(a) for a in target) <= _MET
    forces: list[Vector] = [(0.0, 0.0)] * len(used)
    ahead, momentum = forces, 1.0
    for _ in range(_MOST_STEPS):
        error = _error(columns, ahead, target)
        if max(abs(a) for a in error) <= _MET:
            return True
        new = [
            project(x - _dot(cx, error) / lipschitz, y - _dot(cy, error) / lipschitz)
            for (x, y), (cx, cy), project in zip(ahead, columns, projections, strict=True)
        ]
        grown = 0.5 * (1.0 + math.sqrt(1.0 + 4.0 * momentum * momentum))
        share = (momentum - 1.0) / grown
        ahead = [(x + share * (x - a), y + share * (y - b)) for (x, y), (a, b) in zip(new, forces, strict=True)]
        forces, momentum = new, grown
    return max(abs(a) for a in _error(columns, forces, target)) <= _MET


def _columns(thruster: Thruster, scales: tuple[float, ...]) -> Columns:
    """Scaled wrench of one newton ahead and of one to starboard; of a fixed thruster, of one newton along it and nothing."""
    if not thruster.turns:
        c, s = math.cos(thruster.rest_rad), math.sin(thruster.rest_rad)
        return (c * scales[0], s * scales[1], (thruster.x_m * s - thruster.y_m * c) * scales[2]), (0.0, 0.0, 0.0)
    return (scales[0], 0.0, -thruster.y_m * scales[2]), (0.0, scales[1], thruster.x_m * scales[2])


def _projection(thruster: Thruster) -> Callable[[float, float], Vector]:
    """The nearest force that the thruster can give."""
    low, high = thruster.min_n, thruster.max_n
    if not thruster.turns:
        return lambda x, y: (min(high, max(low, x)), 0.0)
    all_round_n, sectors = high, thruster.sectors
    sector = None if sectors.free else sectors.span(thruster.rest_rad)  # of several, the one that it rests in
    if sector is not None:
        span_rad = sector[1] - sector[0]
        if span_rad < math.pi and not (thruster.reversible and math.isclose(span_rad, math.pi)):
            return _in_cone(sector, high)
        all_round_n = high if span_rad >= 2.0 * math.pi else min(high, -low) if thruster.reversible else high

    def in_disc(x: float, y: float) -> Vector:
        length = math.hypot(x, y)
        return (x, y) if length <= all_round_n else (x * all_round_n / length, y * all_round_n / length)

    return in_disc


def _in_cone(sector: tuple[float, float], most_n: float) -> Callable[[float, float], Vector]:
    """Ahead thrust only, within a sector of less than half a turn: what reversing would add is left out, to be on the safe side."""
    middle, half = 0.5 * (sector[0] + sector[1]), 0.5 * (sector[1] - sector[0])

    def project(x: float, y: float) -> Vector:
        angle = math.remainder(math.atan2(y, x) - middle, 2.0 * math.pi)
        length = math.hypot(x, y)
        if abs(angle) > half:
            length *= max(0.0, math.cos(abs(angle) - half)) if abs(angle) - half < 0.5 * math.pi else 0.0
            angle = math.copysign(half, angle)
        length = min(length, most_n)
        return length * math.cos(middle + angle), length * math.sin(middle + angle)

    return project


def _dot(a: tuple[float, float, float], b: tuple[float, float, float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _error(
    columns: Sequence[Columns], forces: Sequence[Vector], target: tuple[float, float, float]
) -> tuple[float, float, float]:
    x, y, n = -target[0], -target[1], -target[2]
    for (a, b), (f, g) in zip(columns, forces, strict=True):
        x, y, n = x + a[0] * f + b[0] * g, y + a[1] * f + b[1] * g, n + a[2] * f + b[2] * g
    return x, y, n


class ConsequenceCheck:
    """`update(inputs)` every tick while holding; says so when the answer changes.

    Remembers the mean of the achieved wrench, for how long it has been taken, when it looked last, and the thrusters without which the boat
    would not hold.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog) -> None:
        self._thrusters = thrusters_of(config)
        self._limits = (config.limits.surge_n, config.limits.sway_n, config.limits.yaw_nm)
        self._parameters = parameters
        self._events = events
        self._needed: frozenset[int] = frozenset()
        self.reset()

    def reset(self) -> None:
        """Begin the mean anew; what was said stands until it changes."""
        self._mean = (0.0, 0.0, 0.0)
        self._taken_s = 0.0
        self._next_s = _SETTLE_S

    def update(self, inputs: ModeInputs) -> None:
        if not self._parameters["DP_CONSEQ"] or self._limits[1] <= 0.0:
            return
        self._taken_s += inputs.dt_s
        share = inputs.dt_s / min(_MEAN_S, max(self._taken_s, inputs.dt_s)) if inputs.dt_s > 0.0 else 0.0
        given = (inputs.achieved.surge_n, inputs.achieved.sway_n, inputs.achieved.yaw_nm)
        x, y, n = (mean + share * (new - mean) for mean, new in zip(self._mean, given, strict=True))
        self._mean = (x, y, n)
        if self._taken_s >= self._next_s:
            self._next_s = self._taken_s + _PERIOD_S
            self._look(inputs)

    def _look(self, inputs: ModeInputs) -> None:
        x, y, n = self._mean
        needed, out = set(), inputs.failed | inputs.up
        for i in range(len(self._thrusters)):
            margin = _MARGIN if i in self._needed else 1.0
            demand = Wrench(margin * x, margin * y, margin * n)
            if i not in out and not is_met(self._thrusters, self._limits, demand, out | {i}):
                needed.add(i)
        if needed == self._needed:
            return
        self._needed = frozenset(needed)
        if needed:
            names = " or ".join(self._thrusters[i].name for i in sorted(needed))
            self._events.say(inputs.now_s, Severity.WARNING, "consequence", f"Would not hold if {names} failed")
        else:
            self._events.say(inputs.now_s, Severity.NOTICE, "consequence_over", "Would hold with any one thruster failed")
