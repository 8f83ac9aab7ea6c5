"""Estimated current: the velocity of the water, from how the boat moves under the thrust that it is given.

Nothing on board measures speed through the water, so the hull's own model stands in: M ν̇_r + C(ν_r) ν_r + D(ν_r) ν_r = τ + τ_wind in surge
and sway (Fossen 2021, 10.3), with ν_r through the water. Damping makes ν_r follow the known forces; what the measured velocity over ground
has more than that is the current. Source: a Kalman filter for (u_r, v_r, V_north, V_east) around these equations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.config import VesselConfig
from companion.core.records import quick
from companion.core.types import Wrench

_AIR_KGPM3 = 1.225
_UNKNOWN_WIND_MPS = 2.0  # without a wind sensor: what may blow unseen
_WIND_SHARE = 0.2  # of a measured wind's force that is doubted
_THRUST_SHARE = 0.05
_LIMIT_SHARE = 0.01  # of the thrust limits, always doubted
_DAMPING_SHARE = 0.15
_FORCE_TIME_S = 4.0  # how long an error of force lasts
_CURRENT_MPS_RTS = 0.004  # wander of the current
_FIRST_SIGMA_MPS = 0.5
_VELOCITY_SIGMA_MPS = 0.1  # of a measured velocity: it stands for correlated errors of about half that
_USABLE_MPS = 0.2
_LONGEST_STEP_S = 0.5
_LONGEST_HOLD_S = 120.0


@quick
@dataclass(frozen=True, slots=True)
class Passage:
    """How the boat moves over ground, and the air over it: NED m/s; `air_*` None where no wind sensor is heard."""

    north_mps: float
    east_mps: float
    yaw_rad: float
    yaw_rate_radps: float
    air_north_mps: float | None
    air_east_mps: float | None


class CurrentObserver:
    """Thrust and motion → velocity of the water over ground, with its doubt.

    Observable while the thrust on the hull is known (armed) and the velocity is measured: the estimate is given then, and for two minutes
    longer, and only while one sigma is within 0.2 m/s. Surge and sway are seen alike on any heading, the slower the weaker the damping;
    a hull whose model has no damping gives no estimate. Without a wind sensor the mean wind's push is part of what is estimated, and the
    doubt allows for 2 m/s of it. Remembers the velocity through the water, the current, and their covariance.
    """

    def __init__(self, config: VesselConfig) -> None:
        self._hull, self._windage, self._limits = config.hull, config.windage, config.limits
        self._state = [0.0, 0.0, 0.0, 0.0]
        self._p = [[_FIRST_SIGMA_MPS**2 if i == j else 0.0 for j in range(4)] for i in range(4)]
        self._systematic_mps = math.inf
        self._last_s = self._seen_s = -math.inf
        self._alone = False

    def update(self, now_s: float, thrust: Wrench | None, passage: Passage | None, measured: bool = True) -> None:
        """`thrust`: on the hull since the last call, None where nobody knows; `passage` None where there is none. `measured`: its velocity
        is; else the model goes on alone."""
        dt_s, self._last_s = now_s - self._last_s, now_s
        if thrust is None or passage is None or not 0.0 < dt_s <= _LONGEST_STEP_S:
            self._p[2][2] += _CURRENT_MPS_RTS**2 * min(max(dt_s, 0.0), 10.0)
            self._p[3][3] += _CURRENT_MPS_RTS**2 * min(max(dt_s, 0.0), 10.0)
            self._alone = False
            if passage is not None and measured:
                self._begin(passage)
            return
        self._predict(thrust, passage, dt_s)
        if measured:
            self._correct(passage)
            self._seen_s, self._alone = now_s, True

    def knows(self, now_s: float) -> bool:
        """Whether thrust has been known without a break since the velocity was last measured."""
        return self._alone and now_s - self._seen_s <= _LONGEST_HOLD_S

    @property
    def through_water(self) -> tuple[float, float]:
        """(surge_mps, sway_mps)"""
        return self._state[0], self._state[1]

    def over_ground(self, yaw_rad: float) -> tuple[float, float, float]:
        """(north_mps, east_mps, one sigma on the worse axis) of the boat by the model."""
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        u, v, north, east = self._state
        variances = []
        for row in ((c, -s, 1.0, 0.0), (s, c, 0.0, 1.0)):
            variances.append(sum(a * b * value for a, line in zip(row, self._p, strict=True) for b, value in zip(row, line, strict=True)))
        return c * u - s * v + north, s * u + c * v + east, math.sqrt(max(*variances, 0.0))

    def estimate(self, now_s: float) -> tuple[float, float, float] | None:
        """(north_mps, east_mps, one sigma on the worse axis); None where it is worth nothing."""
        sigma = math.sqrt(max(self._p[2][2], self._p[3][3]) + self._systematic_mps**2)
        if sigma > _USABLE_MPS or now_s - self._seen_s > _LONGEST_HOLD_S:
            return None
        return self._state[2], self._state[3], sigma

    def _begin(self, passage: Passage) -> None:
        """The velocity through the water anew: what the current so far leaves of the velocity over ground."""
        c, s = math.cos(passage.yaw_rad), math.sin(passage.yaw_rad)
        north, east = passage.north_mps - self._state[2], passage.east_mps - self._state[3]
        self._state[0], self._state[1] = c * north + s * east, c * east - s * north
        own = _FIRST_SIGMA_MPS**2
        self._p[:2] = [own, 0.0, 0.0, 0.0], [0.0, own, 0.0, 0.0]
        for row in self._p[2:]:
            row[0] = row[1] = 0.0

    def _predict(self, thrust: Wrench, passage: Passage, dt_s: float) -> None:
        hull, d, r = self._hull, self._hull.damping, passage.yaw_rate_radps
        u, v = self._state[0], self._state[1]
        au, av, ar = abs(u), abs(v), abs(r)
        drag_x = hull.drag_n(u)
        drag_y = (d.y_v + d.y_vv * av + d.y_rv * ar + d.y_uv * au) * v + (d.y_r + d.y_vr * av + d.y_rr * ar) * r
        slope_x = hull.drag_slope(u)
        slope_y = d.y_v + 2.0 * d.y_vv * av + d.y_rv * ar + d.y_uv * au
        wind_x, wind_y, doubt_x, doubt_y = self._wind(passage)
        x_n = thrust.surge_n + wind_x + (hull.m22_kg * v + hull.m23_kgm * r) * r - drag_x
        y_n = thrust.sway_n + wind_y - hull.m11_kg * u * r - drag_y
        self._state[0] = u + dt_s * x_n / hull.m11_kg
        self._state[1] = v + dt_s * y_n / hull.m22_kg
        f_uu = 1.0 - dt_s * min(slope_x / hull.m11_kg, 1.0 / dt_s)
        f_vv = 1.0 - dt_s * min(slope_y / hull.m22_kg, 1.0 / dt_s)
        f_uv, f_vu = dt_s * hull.m22_kg * r / hull.m11_kg, -dt_s * hull.m11_kg * r / hull.m22_kg
        doubt_x = _doubt(doubt_x, thrust.surge_n, self._limits.surge_n, drag_x)
        doubt_y = _doubt(doubt_y, thrust.sway_n, max(self._limits.sway_n, 0.2 * self._limits.surge_n), drag_y)
        p = self._p
        p[0], p[1] = (  # F moves the first two states only: first the rows of F P, then the columns
            [f_uu * a + f_uv * b for a, b in zip(p[0], p[1], strict=True)],
            [f_vu * a + f_vv * b for a, b in zip(p[0], p[1], strict=True)],
        )
        for row in p:
            row[0], row[1] = f_uu * row[0] + f_uv * row[1], f_vu * row[0] + f_vv * row[1]
        p[0][0] += 2.0 * _FORCE_TIME_S * (doubt_x / hull.m11_kg) ** 2 * dt_s
        p[1][1] += 2.0 * _FORCE_TIME_S * (doubt_y / hull.m22_kg) ** 2 * dt_s
        p[2][2] += _CURRENT_MPS_RTS**2 * dt_s
        p[3][3] += _CURRENT_MPS_RTS**2 * dt_s
        self._systematic_mps = max(_speed_for(doubt_x, slope_x, d.x_uu), _speed_for(doubt_y, slope_y, d.y_vv))

    def _wind(self, passage: Passage) -> tuple[float, float, float, float]:
        """(surge_n, sway_n) of the wind, and how much of each is doubted."""
        w = self._windage
        x_area, y_area = 0.5 * _AIR_KGPM3 * w.cx * w.frontal_m2, 0.5 * _AIR_KGPM3 * w.cy * w.lateral_m2
        if passage.air_north_mps is None or passage.air_east_mps is None:
            return 0.0, 0.0, x_area * _UNKNOWN_WIND_MPS**2, y_area * _UNKNOWN_WIND_MPS**2
        c, s = math.cos(passage.yaw_rad), math.sin(passage.yaw_rad)
        north, east = passage.air_north_mps - passage.north_mps, passage.air_east_mps - passage.east_mps
        x, y = c * north + s * east, c * east - s * north
        speed = math.hypot(x, y)
        x_n, y_n = x_area * speed * x, y_area * speed * y
        return x_n, y_n, _WIND_SHARE * abs(x_n), _WIND_SHARE * abs(y_n)

    def _correct(self, passage: Passage) -> None:
        """Velocity over ground = R(ψ) ν_r + V, one axis after the other."""
        c, s = math.cos(passage.yaw_rad), math.sin(passage.yaw_rad)
        for measured, (a, b, d, e) in ((passage.north_mps, (c, -s, 1.0, 0.0)), (passage.east_mps, (s, c, 0.0, 1.0))):
            ph = [a * row[0] + b * row[1] + d * row[2] + e * row[3] for row in self._p]
            variance = a * ph[0] + b * ph[1] + d * ph[2] + e * ph[3] + _VELOCITY_SIGMA_MPS**2
            u, v, north, east = self._state
            missing = (measured - (a * u + b * v + d * north + e * east)) / variance
            self._state = [value + k * missing for value, k in zip(self._state, ph, strict=True)]
            self._p = [[value - k * other / variance for value, other in zip(row, ph, strict=True)] for row, k in zip(self._p, ph, strict=True)]


def _doubt(wind_n: float, thrust_n: float, limit_n: float, drag_n: float) -> float:
    return math.hypot(wind_n, _THRUST_SHARE * thrust_n + _LIMIT_SHARE * limit_n, _DAMPING_SHARE * drag_n)


def _speed_for(force_n: float, slope: float, square: float) -> float:
    """The change of speed whose damping is `force_n` more: slope·e + square·e² = force."""
    if square <= 0.0:
        return force_n / slope if slope > 0.0 else math.inf
    return (math.sqrt(slope * slope + 4.0 * square * force_n) - slope) / (2.0 * square)
