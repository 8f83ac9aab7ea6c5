"""Dynamic positioning: PID on the pose error in body axes, with feed-forward from the model and the wind (ReVolt thesis
4.1…4.17, corrected).

τ = share·(M ν̇_d + C(ν_d) ν_d + D(ν_d − c) (ν_d − c)) − Kp e − Kd (ν − ν_d) + bias − wind, with c the mean current. Pole
placement gives the gains from bandwidth ω and damping ζ of each axis and the model's inertia: Kp = m ω², Kd = 2 ζ ω m −
d; the bias grows by −Ki e, with Ki = share·ω Kp, and less while the reference moves. Inside the circle of DP_ECON the
bandwidths are smaller (`companion.control.economy`).
"""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.control.bias import BiasForce
from companion.control.economy import WHOLE, Economy, Firmness
from companion.control.feedforward import feedforward
from companion.control.model import drift_moment_nm
from companion.control.steady_current import SteadyCurrent
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.core.setpoint import PoseSetpoint
from companion.params.store import Parameters

_FULL = 3  # DP_FF_KIND
_BOW_ON = 2.0  # times DP_BW_YAW, up to the bandwidth under way, while the bow is in weather that drove the boat off
_LEARNS_SHARE = 0.4  # of DP_SPEED_AHEAD: of a reference as fast as that the bias learns half of the error


class DynamicPositioning:
    """PID with feed-forward. The `bias` given to `update` is its integral. Remembers the feedback of the last cycle,
    which it smooths over DP_SMOOTH_T, and the heading while the bow turns to the weather."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        self._hull = config.hull
        self._parameters = parameters
        self._economy = Economy(config)
        self._current = SteadyCurrent(config.hull)
        self.restart()

    @property
    def firmness(self) -> Firmness:
        """The share of its bandwidths that the law used in the last cycle."""
        return self._firmness

    def update(self, setpoint: PoseSetpoint, nav: NavState, bias: BiasForce, dt_s: float) -> Wrench:
        """The wrench before saturation, without the part against the wind."""
        ex, ey, eyaw = pose_errors(setpoint, nav)
        turn = wrap_pi(nav.yaw_rad - setpoint.yaw_rad)
        u, v = ned_to_body(setpoint.surge_mps, setpoint.sway_mps, turn)
        forward = feedforward(int(self._parameters["DP_FF_KIND"]), self._config, setpoint, turn)
        share = self._parameters["DP_FEEDFORWARD"]
        steady = self._against_current(setpoint, u, v, nav, dt_s)
        bandwidth_radps = min(self._parameters["DP_BW_SURGE"], self._parameters["DP_BW_SWAY"])
        self._see_turn(setpoint, nav, bias)
        bx, by, bn = bias.in_body(nav.yaw_rad)
        mean = (bx + share * steady.surge_n, by + share * steady.sway_n, bn + share * steady.yaw_nm)
        self._firmness = self._economy.update(setpoint, nav, mean, bandwidth_radps, dt_s)
        (px, ix, dx), (py, iy, dy), (pn, i_n, dn) = self._gains(self._firmness, setpoint.bow_on)
        rests = self._resting(setpoint)
        bias.grow(-rests * ix * ex, -rests * iy * ey, -i_n * eyaw, nav.yaw_rad, dt_s)
        bx, by, bn = bias.in_body(nav.yaw_rad)
        given = self._given_share(px * ex, py * ey)
        x, y, n = self._smoothed(
            -given * px * ex - dx * (nav.surge_mps - u),
            -given * py * ey - dy * (nav.sway_mps - v),
            -pn * eyaw - dn * (nav.yaw_rate_radps - setpoint.yaw_rate_radps),
            dt_s,
        )
        return Wrench(
            share * (forward.surge_n + steady.surge_n) + x + bx,
            share * (forward.sway_n + steady.sway_n) + y + by,
            share * (forward.yaw_nm + steady.yaw_nm) + n + bn,
        )

    def _given_share(self, x_n: float, y_n: float) -> float:
        """Share of the force towards the point that is within the limits on both axes. Cut on each axis by itself it
        would point elsewhere, mostly ahead, and drive a boat that is far off past its point."""
        limits = self._config.limits
        shares = [most / abs(n) for n, most in ((x_n, limits.surge_n), (y_n, limits.sway_n)) if abs(n) > most > 0.0]
        return min(shares, default=1.0)

    def _resting(self, setpoint: PoseSetpoint) -> float:
        """Share of its error that the bias learns: less, the faster the reference moves. A boat that has fallen behind
        it comes after it without a lasting force, and would be carried past it by what it learnt."""
        moving = math.hypot(setpoint.surge_mps, setpoint.sway_mps)
        share = moving / (_LEARNS_SHARE * self._parameters["DP_SPEED_AHEAD"])
        return 1.0 / (1.0 + share * share)

    def _against_current(self, setpoint: PoseSetpoint, u: float, v: float, nav: NavState, dt_s: float) -> Wrench:
        """Feed-forward against the current, where the whole model feeds forward; (u, v): velocity of the reference.

        Force and moment are those of the mean current, which adds no noise. Under way the moment of the drift changes
        sign as the boat turns: there it is that of the boat's own velocity in the present estimate."""
        if int(self._parameters["DP_FF_KIND"]) != _FULL:
            return ZERO_WRENCH
        self._current.update(nav, dt_s)
        slow = self._current.demand(u, v, setpoint.yaw_rate_radps, nav.yaw_rad)
        weight = min(1.0, max(0.0, 2.0 * (abs(setpoint.surge_mps) / self._parameters["DP_SPEED_AHEAD"] - 1.0)))
        if weight == 0.0 or nav.current_north_mps is None or nav.current_east_mps is None:
            return slow
        x, y = ned_to_body(nav.current_north_mps, nav.current_east_mps, nav.yaw_rad)
        actual_nm = drift_moment_nm(self._hull, nav.surge_mps - x, nav.sway_mps - y)
        planned_nm = drift_moment_nm(self._hull, u, v)
        return Wrench(slow.surge_n, slow.sway_n, slow.yaw_nm + weight * (actual_nm - planned_nm - slow.yaw_nm))

    def restart(self) -> None:
        """Forget the smoothed feedback, after another law was active."""
        self._bow_rad: float | None = None
        self._feedback: tuple[float, float, float] | None = None
        self._economy.restart()
        self._current.restart()
        self._firmness = WHOLE

    def _see_turn(self, setpoint: PoseSetpoint, nav: NavState, bias: BiasForce) -> None:
        """Tell the bias that the bow has turned to the weather."""
        if setpoint.bow_on and self._bow_rad is not None:
            bias.turn(self._bow_rad, nav.yaw_rad)
        self._bow_rad = nav.yaw_rad if setpoint.bow_on else None

    def _smoothed(self, x: float, y: float, n: float, dt_s: float) -> tuple[float, float, float]:
        """The feedback, low-pass filtered: thrusters should not answer the noise of the estimate. A softer law is
        slower, and smooths as much more."""
        if self._feedback is not None:
            smooth_s = self._parameters["DP_SMOOTH_T"]
            place = dt_s / (dt_s + smooth_s / self._firmness.place)
            yaw = dt_s / (dt_s + smooth_s / self._firmness.yaw)
            fx, fy, fn = self._feedback
            x, y, n = fx + place * (x - fx), fy + place * (y - fy), fn + yaw * (n - fn)
        self._feedback = (x, y, n)
        return x, y, n

    def _gains(self, firmness: Firmness, bow_on: bool) -> tuple[tuple[float, float, float], ...]:
        """(Kp, Ki, Kd) of surge, sway and yaw. `bow_on`: a bow in strong weather wants to fall off to either side."""
        hull, parameters = self._hull, self._parameters
        damping, share = parameters["DP_DAMPING"], parameters["DP_INTEGRAL"]
        yaw = parameters["DP_BW_YAW"]
        if bow_on:
            yaw = max(yaw, min(_BOW_ON * yaw, parameters["PATH_BW_YAW"]))
        surge, sway = firmness.place * parameters["DP_BW_SURGE"], firmness.place * parameters["DP_BW_SWAY"]
        return (
            pole_placement(hull.m11_kg, hull.damping.x_u, surge, damping, share),
            pole_placement(hull.m22_kg, hull.damping.y_v, sway, damping, share),
            pole_placement(hull.m33_kgm2, hull.damping.n_r, firmness.yaw * yaw, damping, share),
        )


def pole_placement(
    inertia: float, drag: float, bandwidth_radps: float, damping: float, integral: float
) -> tuple[float, float, float]:
    """(Kp, Ki, Kd) that give m s² + (d + Kd) s + Kp the bandwidth and relative damping; `integral` is Ki/(ω Kp).

    The controller always provides at least a quarter of the damping, since the model's drag is uncertain at low
    speed."""
    kp = inertia * bandwidth_radps * bandwidth_radps
    whole = 2.0 * damping * bandwidth_radps * inertia
    return kp, integral * bandwidth_radps * kp, max(0.25 * whole, whole - max(0.0, drag))


def pose_errors(setpoint: PoseSetpoint, nav: NavState) -> tuple[float, float, float]:
    """(surge m, sway m, yaw rad): the boat's pose minus the setpoint's, in the boat's axes."""
    ex, ey = ned_to_body(nav.north_m - setpoint.north_m, nav.east_m - setpoint.east_m, nav.yaw_rad)
    return ex, ey, wrap_pi(nav.yaw_rad - setpoint.yaw_rad)


def finite(wrench: Wrench) -> bool:
    """Whether all three axes are finite."""
    return math.isfinite(wrench.surge_n) and math.isfinite(wrench.sway_n) and math.isfinite(wrench.yaw_nm)
