"""Control under way along a path: speed by surge, heading by yaw, and some sway force if the boat has it."""

from __future__ import annotations

from companion.config.vessel import VesselConfig
from companion.control.bias import BiasForce
from companion.control.heading import YawLoop
from companion.control.model import coriolis, damping
from companion.control.speed_stall import SpeedStall
from companion.core.actuation import Wrench
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.core.setpoint import PathSetpoint
from companion.params.store import Parameters

_INTEGRAL_SHARE = 0.25
_OVER_GROUND_SHARE = 0.5  # the same where no track corrects a speed that wind and stream change as the boat turns
_SWAY_SHARE = 0.5  # bandwidth of sway as a share of that of surge
_SWAY_LIMIT_SHARE = 0.75  # of the vessel's sway limit: the thrusters must give speed and heading too
_YAW_RESERVE = 0.4  # share of the yaw limit that must be spare for full sway
_LARGE_ERROR_MPS = 0.3  # a larger speed error is an acceleration (`SpeedStall`), not an offset to learn
_LARGE_ERROR_SHARE = 0.25  # the same as a share of WP_SPEED; the larger of both applies
_STREAM_S = 10.0  # about the time of the speed's integral
_THRUST_LAG_S = 0.4  # from a command to its thrust


class PathControl:
    """Law for path setpoints. The `bias` given to `update` is the integral of speed and heading. Remembers the smoothed
    feedback and current, and whether the boat does not reach its speed.

    τ_x = m11 u̇_d + D(u_d) + m11 ω (u_d − u) + bias; τ_y controls the sideways speed and gives the centripetal force of
    bends (m11 u r); τ_n is that of `YawLoop`.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, yaw: YawLoop) -> None:
        self._hull = config.hull
        self._limits = config.limits
        self._parameters = parameters
        self._yaw = yaw
        self._stall = SpeedStall()
        self.restart()

    def restart(self) -> None:
        """Forget what it remembers, after another law was active."""
        self._feedback: tuple[float, float] | None = None
        self._stream = (0.0, 0.0)
        self._stall.restart()

    def update(self, setpoint: PathSetpoint, nav: NavState, bias: BiasForce, dt_s: float) -> Wrench:
        """The wrench for the setpoint, before saturation, without the part against the wind."""
        if setpoint.exact:
            return self._exact(setpoint, nav, bias, dt_s)
        self._feedback = None
        hull = self._hull
        bandwidth = self._parameters["PATH_BW_SURGE"]
        u, v, r = setpoint.surge_mps, setpoint.sway_mps, setpoint.yaw_rate_radps
        slow = u - nav.surge_mps
        gain = hull.m11_kg * bandwidth
        over_ground = setpoint.over_ground
        share = _OVER_GROUND_SHARE if over_ground else _INTEGRAL_SHARE
        stream_mps = self._slow_stream(nav, dt_s) if over_ground else 0.0
        drag_x, _, _ = damping(hull, u - stream_mps, v, 0.0)
        _, drag_y, _ = damping(hull, u, self._through_water(v, nav), nav.yaw_rate_radps)
        large_mps = max(_LARGE_ERROR_MPS, _LARGE_ERROR_SHARE * self._parameters["WP_SPEED"])
        offset = self._stall.offset_mps(slow, nav.surge_mps, large_mps, dt_s)
        bias.grow(share * bandwidth * gain * offset, 0.0, 0.0, nav.yaw_rad, dt_s)
        moment = self._yaw.moment_nm(setpoint, nav, bias, dt_s)
        bias_x, bias_y, _ = bias.in_body(nav.yaw_rad)
        surge = hull.m11_kg * setpoint.surge_mps2 + drag_x + gain * slow + bias_x
        if self._limits.sway_n <= 0.0:
            return Wrench(surge, 0.0, moment)
        _, turning, _ = coriolis(hull, max(0.0, nav.surge_mps), 0.0, r)
        sway = turning + drag_y + hull.m22_kg * _SWAY_SHARE * bandwidth * (v - nav.sway_mps) + bias_y
        return Wrench(surge, self._gentle(sway, moment), moment)

    def _exact(self, setpoint: PathSetpoint, nav: NavState, bias: BiasForce, dt_s: float) -> Wrench:
        """All three axes by the model, and the errors of speed in both directions with an integral: the bias is fixed
        in NED, so that wind which it knows on one leg is known on the next."""
        hull, parameters = self._hull, self._parameters
        u, v, r = setpoint.surge_mps, setpoint.sway_mps, setpoint.yaw_rate_radps
        bandwidth = parameters["PATH_BW_SURGE"]
        gain_x, gain_y = hull.m11_kg * bandwidth, hull.m22_kg * parameters["PATH_BW_SWAY"]
        slow_x, slow_y = u - nav.surge_mps, v - nav.sway_mps
        large_mps = max(_LARGE_ERROR_MPS, _LARGE_ERROR_SHARE * parameters["WP_SPEED"])
        offset = self._stall.offset_mps(slow_x, nav.surge_mps, large_mps, dt_s)
        bias.grow(
            _INTEGRAL_SHARE * bandwidth * gain_x * offset,
            _INTEGRAL_SHARE * parameters["PATH_BW_SWAY"] * gain_y * slow_y if abs(slow_y) < large_mps else 0.0,
            0.0,
            nav.yaw_rad,
            dt_s,
        )
        water_x, water_y = self._water(nav, nav.yaw_rad)
        moment = self._yaw.moment_nm(setpoint, nav, bias, dt_s, (nav.surge_mps - water_x, nav.sway_mps - water_y))
        # Without a measured wind its push is in the estimated current, and takes no added mass round with it.
        stream_x, stream_y = (0.0, 0.0) if nav.wind_speed_mps is None else (water_x, water_y)
        turning_x, turning_y, _ = coriolis(hull, u - stream_x, v - stream_y, r)
        rise_x, rise_y = setpoint.surge_mps2 - r * stream_y, setpoint.sway_mps2 + r * stream_x  # through the water
        soon_rad = nav.yaw_rad + turned_soon_rad(setpoint)
        soon_x, soon_y = self._water(nav, soon_rad)
        soon_u, soon_v = u + _THRUST_LAG_S * setpoint.surge_mps2, v + _THRUST_LAG_S * setpoint.sway_mps2
        drag_x, drag_y, _ = damping(hull, soon_u - soon_x, soon_v - soon_y, 0.0)
        back_x, back_y = self._smoothed(gain_x * slow_x, gain_y * slow_y, dt_s)
        bias_x, bias_y, _ = bias.in_body(soon_rad)
        return Wrench(
            hull.m11_kg * rise_x + turning_x + drag_x + back_x + bias_x,
            hull.m22_kg * rise_y + turning_y + drag_y + back_y + bias_y,
            moment + hull.m33_kgm2 * setpoint.yaw_radps2,
        )

    def _smoothed(self, x: float, y: float, dt_s: float) -> tuple[float, float]:
        """The feedback, low-pass filtered: thrusters should not answer the noise of the estimate."""
        if self._feedback is not None:
            share = dt_s / (dt_s + self._parameters["DP_SMOOTH_T"])
            fx, fy = self._feedback
            x, y = fx + share * (x - fx), fy + share * (y - fy)
        self._feedback = (x, y)
        return x, y

    def _slow_stream(self, nav: NavState, dt_s: float) -> float:
        """The current along the hull, low-pass filtered in NED from none: the bias hands over what it has learnt of it.
        One that is known at times only is remembered; thrust must not answer that."""
        north, east = self._stream
        if nav.current_north_mps is not None and nav.current_east_mps is not None:
            share = dt_s / (dt_s + _STREAM_S)
            north, east = north + share * (nav.current_north_mps - north), east + share * (nav.current_east_mps - east)
            self._stream = north, east
        return ned_to_body(north, east, nav.yaw_rad)[0]

    def _water(self, nav: NavState, yaw_rad: float) -> tuple[float, float]:
        """The current in the axes of a boat on that heading; zeros while it is not known."""
        if nav.current_north_mps is None or nav.current_east_mps is None:
            return 0.0, 0.0
        return ned_to_body(nav.current_north_mps, nav.current_east_mps, yaw_rad)

    def _through_water(self, sway_mps: float, nav: NavState) -> float:
        """The sideways speed through the water, which costs force; within DP_SPEED_SWAY if no current is known."""
        if nav.current_north_mps is not None and nav.current_east_mps is not None:
            return sway_mps - ned_to_body(nav.current_north_mps, nav.current_east_mps, nav.yaw_rad)[1]
        bound = self._parameters["DP_SPEED_SWAY"]
        return min(bound, max(-bound, sway_mps))

    def _gentle(self, sway_n: float, moment_nm: float) -> float:
        """The sway force within a share of its limit, reduced as the yaw moment needs the same thrusters."""
        spare = min(1.0, max(0.0, (1.0 - abs(moment_nm) / self._limits.yaw_nm) / _YAW_RESERVE))
        bound = _SWAY_LIMIT_SHARE * self._limits.sway_n * spare
        return min(bound, max(-bound, sway_n))


def turned_soon_rad(setpoint: PathSetpoint) -> float:
    """By how much an exact setpoint turns the boat until a command is thrust: what wind and water do to it comes from
    there then."""
    return setpoint.yaw_rate_radps * _THRUST_LAG_S if setpoint.exact else 0.0
