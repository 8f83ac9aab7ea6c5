"""The sideways speed that a boat's own turns give its hull: it is no drift, and gone a few seconds after the turn.

What steers the boat pushes at x_s, so that its moment N comes with the force Y = N/x_s. N leaves the equations of sway
and yaw (Fossen 2021, with C and D as in `companion.control.model`) by

a v̇ + b ṙ = −(C + D)_y + (C + D)_n/x_s, with a = m22 − m32/x_s, b = m23 − m33/x_s

and the yaw acceleration, which is noise, leaves them by v + (b/a) r. A boat that steers by the difference of its
thrusters has no Y: 1/x_s is 0.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.config.hull import HullConfig
from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState

_STEADY_STEPS = 12  # halvings of what is missing to the steady sideslip
_LEAST_DECAY = 0.5  # of what the sway's damping alone gives: the model may be of a hull that does not go straight


@dataclass(frozen=True, slots=True)
class SteeredHull:
    """A hull without sideways thrust. `steers_1pm`: 1/x_s of what steers it, x_s in m ahead of the middle; 0: a
    difference of thrusters."""

    hull: HullConfig
    steers_1pm: float = 0.0

    @property
    def inertia_kg(self) -> float:
        """a: the mass that a sideways force at x_s moves."""
        return self.hull.m22_kg - self.hull.yaw_coupling_kgm * self.steers_1pm

    @property
    def lever_m(self) -> float:
        """b/a: the sideways speed at once with a yaw rate of 1 rad/s, negative."""
        return (self.hull.m23_kgm - self.hull.m33_kgm2 * self.steers_1pm) / self.inertia_kg


def steered_hull_of(config: VesselConfig) -> SteeredHull | None:
    """None for a boat that pushes itself sideways."""
    if config.limits.sway_n > 0.0:
        return None
    places_m = [t.x_m if t.rudder is None else t.rudder.x_m for t in config.thrusters if t.turns]
    return SteeredHull(config.hull, 1.0 / places_m[0] if places_m and places_m[0] else 0.0)


class Sideslip:
    """`update` every tick → sideways speed in m/s; 0 without a hull. Remembers v + (b/a) r."""

    def __init__(self, steered: SteeredHull | None) -> None:
        self._steered = steered
        self.reset()

    def reset(self) -> None:
        """Begin with a boat that does not slip."""
        self._sum: float | None = None

    def update(self, nav: NavState, dt_s: float) -> float:
        """The sideways speed at the surge and yaw rate of `nav`, to starboard, as far as turns explain it."""
        if self._steered is None:
            return 0.0
        r = nav.yaw_rate_radps
        lever = self._steered.lever_m
        total = lever * r if self._sum is None else self._sum
        decay_1ps, forced = _decay_and_forcing(self._steered, nav.surge_mps, total - lever * r, r)
        self._sum = (total + dt_s * (forced + decay_1ps * lever * r)) / (1.0 + dt_s * decay_1ps)
        return self._sum - lever * r


def steady_slip_mps(steered: SteeredHull | None, surge_mps: float, turn_radps: float) -> float:
    """The sideways speed of a steady turn, to starboard; 0 without a hull."""
    slip = 0.0
    if steered is None or turn_radps == 0.0:
        return slip
    for _ in range(_STEADY_STEPS):
        decay_1ps, forced = _decay_and_forcing(steered, surge_mps, slip, turn_radps)
        slip += 0.5 * (forced / decay_1ps - slip) if decay_1ps > 0.0 else 0.0
    return slip


def _decay_and_forcing(
    steered: SteeredHull, surge_mps: float, slip_mps: float, turn_radps: float
) -> tuple[float, float]:
    """(1/s at which the sideslip decays, m/s² at which the turn brings it)."""
    hull, at = steered.hull, steered.steers_1pm
    d, u, r = hull.damping, surge_mps, turn_radps
    au, av, ar = abs(u), abs(slip_mps), abs(r)
    inertia = steered.inertia_kg
    munk = (hull.m22_kg - hull.m11_kg) * u
    y_v = d.y_v + d.y_vv * av + d.y_rv * ar + d.y_uv * au
    n_v = munk + d.n_v + d.n_vv * av + d.n_rv * ar + d.n_uv * au
    y_r = hull.m11_kg * u + d.y_r + d.y_vr * av + d.y_rr * ar
    n_r = hull.m23_kgm * u + d.n_r + d.n_vr * av + d.n_rr * ar + d.n_ur * au
    decay_1ps = max(_LEAST_DECAY * y_v, y_v - at * n_v) / inertia
    return decay_1ps, (at * n_r - y_r) / inertia * r
