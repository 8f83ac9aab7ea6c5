"""The hull in three degrees of freedom: surge, sway, yaw.

M ν̇_r + C(ν_r) ν_r + D(ν_r) ν_r = τ, with ν_r the velocity through the water. This form holds for a current that is
constant and irrotational (Fossen, Handbook of Marine Craft Hydrodynamics, 2nd ed., property 10.1).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from companion.config.hull import HullConfig
from companion.core.angles import wrap_pi

_CARRIED_S = 60.0  # after which a hull that waves have carried along is where it is

Flow = Callable[[float, float, float], tuple[float, float]]
"""(surge, sway, rate of yaw) through the water → (sway_n, yaw_nm) on the hull."""
Dynamics = Callable[[float, float, float, float, float, float], tuple[float, float, float]]


def dynamics(config: HullConfig) -> Dynamics:
    """The function (u, v, r, surge_n, sway_n, yaw_nm) → (u̇, v̇, ṙ), velocities through the water, all in body axes.

    C follows from M: [[0, 0, −(m22 v + m23 r)], [0, 0, m11 u], [m22 v + m23 r, −m11 u, 0]]. The mean of m23 and m32
    stands for m23, so that C does no work. Damping as in `DampingConfig`, resistance as in `HullConfig`.
    """
    m11, m22, m33, m23 = config.m11_kg, config.m22_kg, config.m33_kgm2, config.m23_kgm
    m32 = config.yaw_coupling_kgm
    coupling = 0.5 * (m23 + m32)
    determinant = m22 * m33 - m23 * m32
    i11, i22, i23, i32, i33 = 1.0 / m11, m33 / determinant, -m23 / determinant, -m32 / determinant, m22 / determinant
    d = config.damping
    x_u, x_uu, x_uuu = d.x_u, d.x_uu, d.x_uuu
    y_v, y_vv, y_rv, y_r, y_vr, y_rr = d.y_v, d.y_vv, d.y_rv, d.y_r, d.y_vr, d.y_rr
    n_v, n_vv, n_rv, n_r, n_vr, n_rr = d.n_v, d.n_vv, d.n_rv, d.n_r, d.n_vr, d.n_rr
    y_uv, n_uv, n_ur = d.y_uv, d.n_uv, d.n_ur
    planing = resistance_of(config.resistance)
    under_way = bool(config.resistance) or y_uv != 0.0 or n_uv != 0.0 or n_ur != 0.0

    def derivative(
        u: float, v: float, r: float, surge_n: float, sway_n: float, yaw_nm: float
    ) -> tuple[float, float, float]:
        abs_u, abs_v, abs_r = abs(u), abs(v), abs(r)
        sway_momentum = m22 * v + coupling * r
        surge_momentum = m11 * u
        x = surge_n + sway_momentum * r - u * (x_u + abs_u * (x_uu + abs_u * x_uuu))
        y = (
            sway_n
            - surge_momentum * r
            - v * (y_v + y_vv * abs_v + y_rv * abs_r)
            - r * (y_r + y_vr * abs_v + y_rr * abs_r)
        )
        n = yaw_nm - sway_momentum * u + surge_momentum * v
        n -= v * (n_v + n_vv * abs_v + n_rv * abs_r) + r * (n_r + n_vr * abs_v + n_rr * abs_r)
        if under_way:
            x -= planing(abs_u) if u >= 0.0 else -planing(abs_u)
            y -= y_uv * abs_u * v
            n -= n_uv * abs_u * v + n_ur * abs_u * r
        return i11 * x, i22 * y + i23 * n, i32 * y + i33 * n

    return derivative


def with_flows(derivative: Dynamics, flows: Sequence[Flow]) -> Dynamics:
    """The dynamics with further forces of the water on the hull."""
    if not flows:
        return derivative

    def moved(u: float, v: float, r: float, surge_n: float, sway_n: float, yaw_nm: float) -> tuple[float, float, float]:
        for flow in flows:
            y, n = flow(u, v, r)
            sway_n, yaw_nm = sway_n + y, yaw_nm + n
        return derivative(u, v, r, surge_n, sway_n, yaw_nm)

    return moved


def resistance_of(points: Sequence[tuple[float, float]]) -> Callable[[float], float]:
    """The function from speed ahead to force: straight lines between points and beyond the last; 0 without points."""
    pieces = [
        (speed, force, (high_force - force) / (high - speed)) for (speed, force), (high, high_force) in pairwise(points)
    ]

    def force_n(speed_mps: float) -> float:
        for speed, force, slope in reversed(pieces):
            if speed_mps >= speed:
                return force + slope * (speed_mps - speed)
        return 0.0

    return force_n


class Hull:
    """State of the hull. In: force on it in body axes; out: pose, velocity, and mean acceleration and turn of the last
    step.

    Positions are NED from home, velocities over ground; `water_*` are through the water, in body axes. `surge_mps2`,
    `sway_mps2` (acceleration over ground) and `turn_radps` are means of the last step: their integral ends where the
    hull is. `carried_*` is the part of the position that the waves' orbital motion has to and fro.
    """

    __slots__ = (
        "_derivative",
        "_orbit",
        "carried_east_m",
        "carried_north_m",
        "current_east_mps",
        "current_north_mps",
        "east_m",
        "east_mps",
        "north_m",
        "north_mps",
        "surge_mps2",
        "sway_mps2",
        "turn_radps",
        "water_surge_mps",
        "water_sway_mps",
        "yaw_rad",
        "yaw_rate_radps",
    )

    def __init__(self, config: HullConfig, flows: Sequence[Flow] = ()) -> None:
        self._derivative = with_flows(dynamics(config), flows)
        self.current_north_mps = self.current_east_mps = 0.0
        self._orbit: tuple[float, float, float] | None = None  # of the waves, at the last step
        self.place(0.0, 0.0, 0.0)

    def place(
        self,
        north_m: float,
        east_m: float,
        yaw_rad: float,
        surge_mps: float = 0.0,
        sway_mps: float = 0.0,
        yaw_rate_radps: float = 0.0,
    ) -> None:
        """Put the boat at a place, with velocities over ground in body axes."""
        self.north_m, self.east_m, self.yaw_rad = north_m, east_m, wrap_pi(yaw_rad)
        self.yaw_rate_radps = self.turn_radps = yaw_rate_radps
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        self.north_mps, self.east_mps = c * surge_mps - s * sway_mps, s * surge_mps + c * sway_mps
        self.surge_mps2 = self.sway_mps2 = 0.0
        self._orbit = None
        self.carried_north_m = self.carried_east_m = 0.0
        self.set_current(self.current_north_mps, self.current_east_mps)

    def set_current(self, north_mps: float, east_mps: float) -> None:
        """Change the water's velocity; the boat's velocity over ground stays."""
        self.current_north_mps, self.current_east_mps = north_mps, east_mps
        orbit_north, orbit_east, _ = self._orbit or (0.0, 0.0, 0.0)
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        north, east = self.north_mps - orbit_north - north_mps, self.east_mps - orbit_east - east_mps
        self.water_surge_mps, self.water_sway_mps = c * north + s * east, c * east - s * north

    @property
    def surge_mps(self) -> float:
        """Speed ahead over ground."""
        return math.cos(self.yaw_rad) * self.north_mps + math.sin(self.yaw_rad) * self.east_mps

    @property
    def sway_mps(self) -> float:
        """Speed to starboard over ground."""
        return math.cos(self.yaw_rad) * self.east_mps - math.sin(self.yaw_rad) * self.north_mps

    def step(self, surge_n: float, sway_n: float, yaw_nm: float, dt_s: float) -> None:
        """Advance by `dt_s` under a constant force, second order in `dt_s` (midpoint rule)."""
        u, v, r = self.water_surge_mps, self.water_sway_mps, self.yaw_rate_radps
        half_s = 0.5 * dt_s
        du, dv, dr = self._derivative(u, v, r, surge_n, sway_n, yaw_nm)
        mid_u, mid_v, mid_r = u + half_s * du, v + half_s * dv, r + half_s * dr
        du, dv, dr = self._derivative(mid_u, mid_v, mid_r, surge_n, sway_n, yaw_nm)
        u, v, r = u + dt_s * du, v + dt_s * dv, r + dt_s * dr
        mid_yaw = self.yaw_rad + half_s * mid_r
        c, s = math.cos(mid_yaw), math.sin(mid_yaw)
        self.north_m += dt_s * (c * mid_u - s * mid_v + self.current_north_mps)
        self.east_m += dt_s * (s * mid_u + c * mid_v + self.current_east_mps)
        yaw_rad = self.yaw_rad = wrap_pi(self.yaw_rad + dt_s * mid_r)
        self.turn_radps = mid_r
        self.water_surge_mps, self.water_sway_mps, self.yaw_rate_radps = u, v, r
        c_end, s_end = math.cos(yaw_rad), math.sin(yaw_rad)
        north_mps = c_end * u - s_end * v + self.current_north_mps
        east_mps = s_end * u + c_end * v + self.current_east_mps
        north_mps2, east_mps2 = (north_mps - self.north_mps) / dt_s, (east_mps - self.east_mps) / dt_s
        self.surge_mps2, self.sway_mps2 = c * north_mps2 + s * east_mps2, c * east_mps2 - s * north_mps2
        self.north_mps, self.east_mps = north_mps, east_mps

    def step_in_waves(
        self, surge_n: float, sway_n: float, yaw_nm: float, dt_s: float, orbit: tuple[float, float, float]
    ) -> None:
        """As `step`, in water whose orbital motion carries the hull along: velocity to north and east and rate of yaw
        at the end of the step.

        It displaces and accelerates the hull as its own motion does, but not through the water: mass and added mass
        follow an accelerated water without a force of the thrusters. Where it begins, the hull has it already.
        """
        before = self._orbit or orbit
        if self._orbit is not None:
            self.north_mps, self.east_mps = self.north_mps - before[0], self.east_mps - before[1]
            self.yaw_rate_radps -= before[2]
        north_mps, east_mps = self.north_mps + before[0], self.east_mps + before[1]
        self.step(surge_n, sway_n, yaw_nm, dt_s)
        self.north_mps, self.east_mps = self.north_mps + orbit[0], self.east_mps + orbit[1]
        north_m, east_m = 0.5 * dt_s * (before[0] + orbit[0]), 0.5 * dt_s * (before[1] + orbit[1])
        self.north_m, self.east_m = self.north_m + north_m, self.east_m + east_m
        keep = 1.0 - dt_s / _CARRIED_S
        self.carried_north_m, self.carried_east_m = (
            keep * self.carried_north_m + north_m,
            keep * self.carried_east_m + east_m,
        )
        turned_radps = 0.5 * (before[2] + orbit[2])
        self.turn_radps += turned_radps
        self.yaw_rate_radps += orbit[2]
        self.yaw_rad = wrap_pi(self.yaw_rad + dt_s * turned_radps)
        middle = self.yaw_rad - 0.5 * dt_s * self.turn_radps
        c, s = math.cos(middle), math.sin(middle)
        north_mps2, east_mps2 = (self.north_mps - north_mps) / dt_s, (self.east_mps - east_mps) / dt_s
        self.surge_mps2, self.sway_mps2 = c * north_mps2 + s * east_mps2, c * east_mps2 - s * north_mps2
        self._orbit = orbit
        self.set_current(self.current_north_mps, self.current_east_mps)  # in the axes of the turned hull
