"""Estimated current: the velocity of the water over ground, from the boat's motion under known thrust.

No sensor measures speed through the water, so the model of the hull gives it: M ν̇_r + C(ν_r) ν_r + D(ν_r) ν_r = τ +
τ_wind in surge and sway (Fossen 2021, 10.3), with ν_r through the water. Damping makes ν_r follow the known forces; the
rest of the measured velocity over ground is the current. A Kalman filter with the state (u_r, v_r, V_north, V_east)
solves these equations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.config.hull import AIR_KGPM3
from companion.config.vessel import VesselConfig
from companion.core.actuation import Wrench
from companion.core.frames import body_to_ned

_UNKNOWN_WIND_MPS = 2.0  # assumed uncertainty without a wind sensor
_WIND_SHARE = 0.2  # uncertain share of a measured wind's force
_THRUST_SHARE = 0.05  # uncertain share of the thrust
_LIMIT_SHARE = 0.01  # uncertainty of any thrust, as a share of the limits
_DAMPING_SHARE = 0.15  # uncertain share of the damping
_FORCE_TIME_S = 4.0  # how long an error of force lasts
_CURRENT_MPS_RTS = 0.004  # wander of the current
_FIRST_SIGMA_MPS = 0.5
_VELOCITY_SIGMA_MPS = 0.1  # of a measured velocity: represents correlated errors of about half that
# One sigma within which an estimate is given, and within which it still is: about one of them it came and went with
# every tick, and the thrust with it.
_USABLE_MPS, _STILL_USABLE_MPS = 0.2, 0.21
_LONGEST_STEP_S = 0.5
_LONGEST_HOLD_S = 120.0


@dataclass(frozen=True, slots=True)
class GroundMotion:
    """Motion of the boat and of the air over ground, in NED; `air_*` None without wind readings."""

    north_mps: float
    east_mps: float
    yaw_rad: float
    yaw_rate_radps: float
    air_north_mps: float | None
    air_east_mps: float | None


class CurrentObserver:
    """Thrust and motion → velocity of the water over ground, with its accuracy.

    The current is observable while the thrust on the hull is known (armed) and the velocity is measured. An estimate is
    given then and for two minutes longer, from one sigma of 0.2 m/s to one of 0.21 m/s. The weaker the damping, the
    slower the estimate; a hull model without damping gives none. Without a wind sensor the estimate includes the push
    of the mean wind, and its accuracy allows for 2 m/s of wind. Remembers the velocity through the water, the current,
    their covariance; and `carried` and `carried_turn_radps`, the velocity over ground (NED) and the rate of turn that
    the model alone has added up to. `run` changes when that begins anew. `pushed`: what thrust alone has added to the
    velocity along the hull (surge, sway).
    """

    def __init__(self, config: VesselConfig) -> None:
        self._hull, self._windage, self._limits = config.hull, config.windage, config.limits
        self._state = [0.0, 0.0, 0.0, 0.0]
        self._p = [[_FIRST_SIGMA_MPS**2 if i == j else 0.0 for j in range(4)] for i in range(4)]
        self._systematic_mps = math.inf
        self._usable = False
        self._last_s = self._seen_s = -math.inf
        self.carried = (0.0, 0.0)
        self.carried_turn_radps = 0.0
        self.pushed = (0.0, 0.0)
        self.run = 0
        self._yaw_rad: float | None = None
        self._unbroken = False  # thrust known in every call since the velocity was last measured

    def update(self, now_s: float, thrust: Wrench | None, passage: GroundMotion | None, measured: bool = True) -> None:
        """One tick. `thrust`: on the hull since the last call, None if unknown; `passage`: None if unknown. `measured`:
        whether its velocity is measured; if not, the model alone predicts."""
        self._update(now_s, thrust, passage, measured)
        self._usable = self._sigma_mps <= self._most_mps

    def _update(self, now_s: float, thrust: Wrench | None, passage: GroundMotion | None, measured: bool) -> None:
        dt_s, self._last_s = now_s - self._last_s, now_s
        if thrust is None or passage is None or not 0.0 < dt_s <= _LONGEST_STEP_S:
            self._p[2][2] += _CURRENT_MPS_RTS**2 * min(max(dt_s, 0.0), 10.0)
            self._p[3][3] += _CURRENT_MPS_RTS**2 * min(max(dt_s, 0.0), 10.0)
            self._unbroken, self._yaw_rad = False, None
            if passage is not None and measured:
                self._begin(passage)
            return
        hull, (surge_mps, sway_mps) = self._hull, self.pushed
        surge_mps, sway_mps = (
            surge_mps + dt_s * thrust.surge_n / hull.m11_kg,
            sway_mps + dt_s * thrust.sway_n / hull.m22_kg,
        )
        self.pushed = surge_mps, sway_mps
        before = self._water_ned(self._yaw_rad)
        self._predict(thrust, passage, dt_s)
        self._carry(before, passage.yaw_rad)
        self.carried_turn_radps += dt_s * self._turn_radps2(thrust, passage.yaw_rate_radps)
        if measured:
            self._correct(passage)
            self._seen_s, self._unbroken = now_s, True

    def _water_ned(self, yaw_rad: float | None) -> tuple[float, float] | None:
        return None if yaw_rad is None else body_to_ned(self._state[0], self._state[1], yaw_rad)

    def _carry(self, before: tuple[float, float] | None, yaw_rad: float) -> None:
        """Add the change of velocity that the model predicts."""
        after = body_to_ned(self._state[0], self._state[1], yaw_rad)
        if before is None:
            self.run += 1
        else:
            self.carried = self.carried[0] + after[0] - before[0], self.carried[1] + after[1] - before[1]
        self._yaw_rad = yaw_rad

    def _turn_radps2(self, thrust: Wrench, rate_radps: float) -> float:
        """Angular acceleration by the moments of thrust, damping and the hull in the flow."""
        hull, d, (u, v, _, _) = self._hull, self._hull.damping, self._state
        damping_nm = (d.n_r + d.n_rr * abs(rate_radps)) * rate_radps + (d.n_v + d.n_vv * abs(v)) * v
        return (thrust.yaw_nm - damping_nm - (hull.m22_kg - hull.m11_kg) * u * v) / hull.m33_kgm2

    def can_predict(self, now_s: float) -> bool:
        """Whether thrust has been known without a break since the velocity was last measured."""
        return self._unbroken and now_s - self._seen_s <= _LONGEST_HOLD_S

    @property
    def through_water(self) -> tuple[float, float]:
        """(surge_mps, sway_mps) of the boat relative to the water."""
        return self._state[0], self._state[1]

    def over_ground(self, yaw_rad: float) -> tuple[float, float, float]:
        """(north_mps, east_mps, one sigma of the worse axis): velocity of the boat over ground by the model."""
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        u, v, north, east = self._state
        variances = []
        for row in ((c, -s, 1.0, 0.0), (s, c, 0.0, 1.0)):
            variance = 0.0
            for a, line in zip(row, self._p, strict=True):
                for b, value in zip(row, line, strict=True):
                    variance += a * b * value
            variances.append(variance)
        return c * u - s * v + north, s * u + c * v + east, math.sqrt(max(*variances, 0.0))

    def estimate(self, now_s: float) -> tuple[float, float, float] | None:
        """(north_mps, east_mps, one sigma of the worse axis) of the current; None if it is too uncertain or too old."""
        sigma_mps = self._sigma_mps
        if sigma_mps > self._most_mps or now_s - self._seen_s > _LONGEST_HOLD_S:
            return None
        return self._state[2], self._state[3], sigma_mps

    @property
    def _sigma_mps(self) -> float:
        return math.sqrt(max(self._p[2][2], self._p[3][3]) + self._systematic_mps**2)

    @property
    def _most_mps(self) -> float:
        return _STILL_USABLE_MPS if self._usable else _USABLE_MPS

    def _begin(self, passage: GroundMotion) -> None:
        """Set the velocity through the water to the velocity over ground less the estimated current."""
        c, s = math.cos(passage.yaw_rad), math.sin(passage.yaw_rad)
        north, east = passage.north_mps - self._state[2], passage.east_mps - self._state[3]
        self._state[0], self._state[1] = c * north + s * east, c * east - s * north
        own = _FIRST_SIGMA_MPS**2
        self._p[:2] = [own, 0.0, 0.0, 0.0], [0.0, own, 0.0, 0.0]
        for row in self._p[2:]:
            row[0] = row[1] = 0.0

    def _predict(self, thrust: Wrench, passage: GroundMotion, dt_s: float) -> None:
        """Propagate state and covariance by `dt_s`."""
        hull, d, r = self._hull, self._hull.damping, passage.yaw_rate_radps
        u, v = self._state[0], self._state[1]
        au, av, ar = abs(u), abs(v), abs(r)
        drag_x = _at_most(hull.drag_n(u), hull.m11_kg * au / dt_s)
        drag_y = _at_most((d.y_v + d.y_vv * av + d.y_rv * ar + d.y_uv * au) * v, hull.m22_kg * av / dt_s)
        drag_y += (d.y_r + d.y_vr * av + d.y_rr * ar) * r
        slope_x = hull.drag_slope(u)
        slope_y = d.y_v + 2.0 * d.y_vv * av + d.y_rv * ar + d.y_uv * au
        wind_x, wind_y, sigma_x, sigma_y = self._wind(passage)
        x_n = thrust.surge_n + wind_x + (hull.m22_kg * v + hull.m23_kgm * r) * r - drag_x
        y_n = thrust.sway_n + wind_y - hull.m11_kg * u * r - drag_y
        self._state[0] = u + dt_s * x_n / hull.m11_kg
        self._state[1] = v + dt_s * y_n / hull.m22_kg
        f_uu = 1.0 - dt_s * min(slope_x / hull.m11_kg, 1.0 / dt_s)
        f_vv = 1.0 - dt_s * min(slope_y / hull.m22_kg, 1.0 / dt_s)
        f_uv, f_vu = dt_s * hull.m22_kg * r / hull.m11_kg, -dt_s * hull.m11_kg * r / hull.m22_kg
        sigma_x = _force_sigma_n(sigma_x, thrust.surge_n, self._limits.surge_n, drag_x)
        sigma_y = _force_sigma_n(sigma_y, thrust.sway_n, max(self._limits.sway_n, 0.2 * self._limits.surge_n), drag_y)
        p = self._p
        p[0], p[1] = (  # F changes the first two states only: first the rows of F P, then the columns
            [f_uu * a + f_uv * b for a, b in zip(p[0], p[1], strict=True)],
            [f_vu * a + f_vv * b for a, b in zip(p[0], p[1], strict=True)],
        )
        for row in p:
            row[0], row[1] = f_uu * row[0] + f_uv * row[1], f_vu * row[0] + f_vv * row[1]
        p[0][0] += 2.0 * _FORCE_TIME_S * (sigma_x / hull.m11_kg) ** 2 * dt_s
        p[1][1] += 2.0 * _FORCE_TIME_S * (sigma_y / hull.m22_kg) ** 2 * dt_s
        p[2][2] += _CURRENT_MPS_RTS**2 * dt_s
        p[3][3] += _CURRENT_MPS_RTS**2 * dt_s
        self._systematic_mps = max(_speed_for(sigma_x, slope_x, d.x_uu), _speed_for(sigma_y, slope_y, d.y_vv))

    def _wind(self, passage: GroundMotion) -> tuple[float, float, float, float]:
        """(surge_n, sway_n) of the wind, and one sigma of each."""
        w = self._windage
        x_area, y_area = 0.5 * AIR_KGPM3 * w.cx * w.frontal_m2, 0.5 * AIR_KGPM3 * w.cy * w.lateral_m2
        if passage.air_north_mps is None or passage.air_east_mps is None:
            return 0.0, 0.0, x_area * _UNKNOWN_WIND_MPS**2, y_area * _UNKNOWN_WIND_MPS**2
        c, s = math.cos(passage.yaw_rad), math.sin(passage.yaw_rad)
        north, east = passage.air_north_mps - passage.north_mps, passage.air_east_mps - passage.east_mps
        x, y = c * north + s * east, c * east - s * north
        speed = math.hypot(x, y)
        x_n, y_n = x_area * speed * x, y_area * speed * y
        return x_n, y_n, _WIND_SHARE * abs(x_n), _WIND_SHARE * abs(y_n)

    def _correct(self, passage: GroundMotion) -> None:
        """Fuse the measured velocity over ground = R(ψ) ν_r + V, one axis after the other."""
        c, s = math.cos(passage.yaw_rad), math.sin(passage.yaw_rad)
        for measured, (a, b, d, e) in ((passage.north_mps, (c, -s, 1.0, 0.0)), (passage.east_mps, (s, c, 0.0, 1.0))):
            ph = [a * row[0] + b * row[1] + d * row[2] + e * row[3] for row in self._p]
            variance = a * ph[0] + b * ph[1] + d * ph[2] + e * ph[3] + _VELOCITY_SIGMA_MPS**2
            u, v, north, east = self._state
            innovation = (measured - (a * u + b * v + d * north + e * east)) / variance
            self._state = [value + k * innovation for value, k in zip(self._state, ph, strict=True)]
            self._p = [
                [value - k * other / variance for value, other in zip(row, ph, strict=True)]
                for row, k in zip(self._p, ph, strict=True)
            ]


def _at_most(drag_n: float, stopping_n: float) -> float:
    """Drag that stops a motion within the step, and does not turn it round."""
    return max(-stopping_n, min(stopping_n, drag_n))


def _force_sigma_n(wind_n: float, thrust_n: float, limit_n: float, drag_n: float) -> float:
    """One sigma of the force on an axis; `wind_n` is that of the wind."""
    return math.hypot(wind_n, _THRUST_SHARE * thrust_n + _LIMIT_SHARE * limit_n, _DAMPING_SHARE * drag_n)


def _speed_for(force_n: float, slope: float, square: float) -> float:
    """The change of speed e that raises the damping by `force_n`: slope·e + square·e² = force."""
    if square <= 0.0:
        return force_n / slope if slope > 0.0 else math.inf
    return (math.sqrt(slope * slope + 4.0 * square * force_n) - slope) / (2.0 * square)
