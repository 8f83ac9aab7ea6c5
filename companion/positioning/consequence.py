"""Consequence check: would the boat still hold here if any one thruster failed?

Each thruster is a convex set of forces: a disc if it turns all round, a line if it is fixed. Whether the sets together
can give a wrench is a convex problem, solved by projected gradients with momentum (FISTA; Beck & Teboulle 2009). The
residual of a step is also a direction. If even the largest forces along it fall short, a plane separates the wrench
from all that can be given (Boyd & Vandenberghe 2004, 2.5): the answer is no, without further steps. How fast thrusters
change is ignored.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.allocation.geometry import Thruster, thrusters_of
from companion.config.vessel import VesselConfig
from companion.core.actuation import Wrench
from companion.core.decision import ModeInputs, TextKind
from companion.core.events import EventLog
from companion.params.store import Parameters

_MOST_STEPS = 400
_MET = 0.01  # of the wrench limits: a smaller residual counts as met
_MEAN_S = 20.0
_SETTLE_S = 15.0
_PERIOD_S = 1.0
_LASTING_S = 30.0  # a thruster must not be needed for so long before the all-clear is announced
_NOTCH_RAD = math.radians(10.0)  # between the stops: a force into a narrower one is as good as given
_MARGIN = 1.15  # on the demand, before a bad answer turns good again

Vector = tuple[float, float]
Columns = tuple[tuple[float, float, float], tuple[float, float, float]]


def is_met(
    thrusters: Sequence[Thruster], limits: tuple[float, float, float], demand: Wrench, out: frozenset[int]
) -> bool:
    """Whether the thrusters can give `demand` within their forces, without those whose index is in `out`.

    `limits`: the vessel's largest surge and sway force in N and yaw moment in N·m. They scale the three axes; an axis
    with limit 0 does not count.
    """
    scales = tuple(1.0 / limit if limit > 0.0 else 0.0 for limit in limits)
    target = (demand.surge_n * scales[0], demand.sway_n * scales[1], demand.yaw_nm * scales[2])
    used = [t for i, t in enumerate(thrusters) if i not in out]
    columns = [_columns(t, scales) for t in used]
    sets = [_forces_of(t) for t in used]
    lipschitz = sum(a * a for pair in columns for column in pair for a in column)
    if lipschitz == 0.0:
        return max(abs(a) for a in target) <= _MET
    forces: list[Vector] = [(0.0, 0.0)] * len(used)
    ahead, momentum = forces, 1.0
    for _ in range(_MOST_STEPS):
        error = _error(columns, ahead, target)
        if max(abs(a) for a in error) <= _MET:
            return True
        slopes = [(_dot(cx, error), _dot(cy, error)) for cx, cy in columns]
        most = sum(forces_of.most(-gx, -gy) for forces_of, (gx, gy) in zip(sets, slopes, strict=True))
        if -_dot(error, target) - most > _MET * sum(abs(a) for a in error):
            return False
        new = [
            forces_of.nearest(x - gx / lipschitz, y - gy / lipschitz)
            for (x, y), (gx, gy), forces_of in zip(ahead, slopes, sets, strict=True)
        ]
        grown = 0.5 * (1.0 + math.sqrt(1.0 + 4.0 * momentum * momentum))
        share = (momentum - 1.0) / grown
        ahead = [(x + share * (x - a), y + share * (y - b)) for (x, y), (a, b) in zip(new, forces, strict=True)]
        forces, momentum = new, grown
    return max(abs(a) for a in _error(columns, forces, target)) <= _MET


def most_n(config: VesselConfig, x: float, y: float) -> float:
    """The largest steady force in N along the unit vector (x, y) in body axes, with no yaw moment. Respects the wrench
    limits and the thrusters; to 1 %."""
    limits = (config.limits.surge_n, config.limits.sway_n, config.limits.yaw_nm)
    thrusters = thrusters_of(config)
    low, high = (
        0.0,
        min((limit / abs(part) for limit, part in zip(limits, (x, y), strict=False) if part != 0.0), default=0.0),
    )
    if is_met(thrusters, limits, Wrench(high * x, high * y, 0.0), frozenset()):
        return high
    for _ in range(7):
        middle = 0.5 * (low + high)
        if is_met(thrusters, limits, Wrench(middle * x, middle * y, 0.0), frozenset()):
            low = middle
        else:
            high = middle
    return low


def _columns(thruster: Thruster, scales: tuple[float, ...]) -> Columns:
    """Scaled wrenches of one newton ahead and of one newton to starboard. For a fixed thruster: of one newton along it,
    and zero."""
    if not thruster.turns:
        c, s = math.cos(thruster.rest_rad), math.sin(thruster.rest_rad)
        return (c * scales[0], s * scales[1], (thruster.x_m * s - thruster.y_m * c) * scales[2]), (0.0, 0.0, 0.0)
    return (scales[0], 0.0, -thruster.y_m * scales[2]), (0.0, scales[1], thruster.x_m * scales[2])


class _Line:
    """Forces of a fixed thruster, along its axis."""

    def __init__(self, low_n: float, high_n: float) -> None:
        self._low_n, self._high_n = low_n, high_n

    def nearest(self, x: float, y: float) -> Vector:
        """The possible force nearest to (x, y)."""
        return min(self._high_n, max(self._low_n, x)), 0.0

    def most(self, x: float, y: float) -> float:
        """The largest dot product of a possible force with (x, y)."""
        return max(self._low_n * x, self._high_n * x)


class _Disc:
    """Forces of a thruster that gives as much in every direction."""

    def __init__(self, radius_n: float) -> None:
        self._radius_n = radius_n

    def nearest(self, x: float, y: float) -> Vector:
        """The possible force nearest to (x, y)."""
        length, radius = math.hypot(x, y), self._radius_n
        return (x, y) if length <= radius else (x * radius / length, y * radius / length)

    def most(self, x: float, y: float) -> float:
        """The largest dot product of a possible force with (x, y)."""
        return self._radius_n * math.hypot(x, y)


class _Cone:
    """Forces of a thruster that turns within half a turn, ahead thrust only; of one that turns further, those within
    half a turn, since all of them are no convex set. Reverse thrust is left out. Both err on the safe side."""

    def __init__(self, sector: tuple[float, float], most_n: float) -> None:
        self._middle, self._most_n = 0.5 * (sector[0] + sector[1]), most_n
        self._half = min(0.5 * math.pi, 0.5 * (sector[1] - sector[0]))

    def nearest(self, x: float, y: float) -> Vector:
        """The possible force nearest to (x, y)."""
        angle = math.remainder(math.atan2(y, x) - self._middle, math.tau)
        length = min(self._most_n, self._share(angle) * math.hypot(x, y))
        angle = math.copysign(min(abs(angle), self._half), angle)
        return length * math.cos(self._middle + angle), length * math.sin(self._middle + angle)

    def most(self, x: float, y: float) -> float:
        """The largest dot product of a possible force with (x, y)."""
        angle = math.remainder(math.atan2(y, x) - self._middle, math.tau)
        return self._most_n * self._share(angle) * math.hypot(x, y)

    def _share(self, angle: float) -> float:
        """Cosine of the angle by which a direction lies outside the sector; 0 where the sector's tip is nearest."""
        beyond = abs(angle) - self._half
        return 1.0 if beyond <= 0.0 else math.cos(beyond) if beyond < 0.5 * math.pi else 0.0


def _forces_of(thruster: Thruster) -> _Line | _Disc | _Cone:
    """What the thruster can give. `nearest`: the force in the set that is nearest to a given one. `most`: the largest
    scalar product with a direction."""
    low, high = thruster.min_n, thruster.max_n
    if not thruster.turns:
        return _Line(low, high)
    sectors = thruster.sectors
    sector = None if sectors.free else sectors.span(thruster.rest_rad)  # of several sectors, the one it rests in
    if sector is None:
        return _Disc(high)
    span_rad = sector[1] - sector[0]
    if span_rad > math.tau - _NOTCH_RAD:
        return _Disc(min(high, -low) if thruster.reversible and span_rad < math.tau else high)
    half_turn = span_rad > math.pi or math.isclose(span_rad, math.pi)
    return _Disc(min(high, -low)) if thruster.reversible and half_turn else _Cone(sector, high)


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
    """`update(inputs)` every tick while holding; announces when the answer changes.

    Once a second it asks whether the mean achieved wrench could be held without each single thruster. It tries one
    thruster a tick, which keeps the longest tick short.

    Remembers the mean and for how long it was taken, the time of the next round, the thrusters that this round has
    still to try, and the needed thrusters: those without which the boat would not hold, each with the time when that
    was last found.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog) -> None:
        self._thrusters = thrusters_of(config)
        self._limits = (config.limits.surge_n, config.limits.sway_n, config.limits.yaw_nm)
        self._parameters = parameters
        self._events = events
        self._needed: frozenset[int] = frozenset()
        self._out: frozenset[int] = frozenset()
        self.reset()

    def reset(self) -> None:
        """Restart the mean. The answer that was announced stands until it changes."""
        self._mean = self._asked = (0.0, 0.0, 0.0)
        self._taken_s = 0.0
        self._next_s = _SETTLE_S
        self._found_s = dict.fromkeys(self._needed, 0.0)
        self._left: list[int] = []  # thrusters that this round has still to try
        self._found: set[int] = set()

    def update(self, inputs: ModeInputs) -> None:
        """One tick of holding."""
        if not self._parameters["DP_CONSEQ"] or self._limits[1] <= 0.0:
            return
        self._taken_s += inputs.dt_s
        share = inputs.dt_s / min(_MEAN_S, max(self._taken_s, inputs.dt_s)) if inputs.dt_s > 0.0 else 0.0
        given = (inputs.achieved.surge_n, inputs.achieved.sway_n, inputs.achieved.yaw_nm)
        x, y, n = (mean + share * (new - mean) for mean, new in zip(self._mean, given, strict=True))
        self._mean = (x, y, n)
        if not self._left and self._taken_s < self._next_s:
            return
        if not self._left or inputs.failed | inputs.up != self._out:
            self._begin_round(inputs)
        if self._left:
            self._look(self._left.pop())
        if not self._left:
            self._conclude(inputs)

    def _begin_round(self, inputs: ModeInputs) -> None:
        self._next_s = self._taken_s + _PERIOD_S
        self._asked, self._out = self._mean, inputs.failed | inputs.up
        self._left = [i for i in range(len(self._thrusters)) if i not in self._out]
        self._found = set()

    def _look(self, i: int) -> None:
        """Try whether the boat would hold without this thruster."""
        x, y, n = self._asked
        margin = _MARGIN if i in self._needed else 1.0
        demand = Wrench(margin * x, margin * y, margin * n)
        if not is_met(self._thrusters, self._limits, demand, self._out | {i}):
            self._found.add(i)

    def _conclude(self, inputs: ModeInputs) -> None:
        """Announce a changed answer. A worse one counts at once, a better one only when it lasts: near the limit it
        would change every few seconds."""
        self._found_s |= dict.fromkeys(self._found, self._taken_s)
        needed = frozenset(
            i for i, found_s in self._found_s.items() if i not in self._out and self._taken_s - found_s <= _LASTING_S
        )
        if needed == self._needed:
            return
        self._needed = needed
        if self._needed:
            names = " or ".join(self._thrusters[i].name for i in sorted(self._needed))
            self._events.say(inputs.now_s, TextKind.ATTENTION, "consequence", f"Would not hold if {names} failed")
        else:
            self._events.say(
                inputs.now_s, TextKind.ROUTINE, "consequence_over", "Would hold with any one thruster failed"
            )
