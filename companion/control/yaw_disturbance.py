"""The moment on the hull that model, thrust and measured wind do not explain, by the gyro: gusts, wind from another
side as the boat turns, the model's error.

The loop would answer it when the heading is off already, and softly, since the lag of the thrust bounds its bandwidth.
An observer of the momentum h = M33 r + M32 v that is told the thrusters' moment knows it within a second or two:
ĥ' = N_known + d̂ + 2ω (h − ĥ), d̂' = ω² (h − ĥ). What lasts is left to the integral (`companion.control.bias`).
"""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.control.model import force_for
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.params.store import Parameters

_FASTER = 2.0  # the observer's bandwidth, times DP_BW_YAW
_MOST_SHARE = 0.3  # of the yaw limit: more is a quay, or a rope


class YawDisturbance:
    """Call `update` every cycle. Remembers the observer's momentum and moment, and the mean of the moment."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._hull, self._parameters = config.hull, parameters
        self._most_nm = _MOST_SHARE * config.limits.yaw_nm
        self.restart()

    def restart(self) -> None:
        """Begin with the next update."""
        self._momentum_nms: float | None = None
        self._moment_nm = self._mean_nm = 0.0

    def hand_over(self, nav: NavState, gone_nm: float, lasting_nm: float, came: bool | None) -> None:
        """Less is known of the wind by `gone_nm`, of which the integral has taken over `lasting_nm`; negative where
        more is known. The rest is for the observer from now on. `came`: the wind is measured now, or no longer; None:
        as before."""
        less_nm = 0.0
        if came is not None:
            through, over_ground = self._resisting_nm(nav, True), self._resisting_nm(nav, False)
            less_nm = over_ground - through if came else through - over_ground
        self._moment_nm = self._bounded(self._moment_nm + gone_nm - less_nm)
        self._mean_nm += lasting_nm - less_nm

    def update(self, nav: NavState, known_nm: float, dt_s: float) -> float:
        """The moment in Nm, beyond its mean over as long as the integral takes. `known_nm`: of thrusters and wind in
        the last cycle; one that is not finite begins anew."""
        hull, before = self._hull, self._momentum_nms
        now = hull.m33_kgm2 * nav.yaw_rate_radps + hull.yaw_coupling_kgm * nav.sway_mps
        if not math.isfinite(known_nm + now):
            self.restart()
            return 0.0
        if before is None or dt_s <= 0.0:
            self._momentum_nms = now
            return 0.0
        loop_radps = self._parameters["DP_BW_YAW"]
        follows, error = min(_FASTER * loop_radps, 0.5 / dt_s), now - before
        gained_nm = known_nm - self._resisting_nm(nav, nav.wind_speed_mps is not None) + self._moment_nm
        self._momentum_nms = before + (gained_nm + 2.0 * follows * error) * dt_s
        self._moment_nm = self._bounded(self._moment_nm + follows * follows * error * dt_s)
        learns = self._parameters["DP_INTEGRAL"] * loop_radps * dt_s
        self._mean_nm += learns / (1.0 + learns) * (self._moment_nm - self._mean_nm)
        return self._moment_nm - self._mean_nm

    def _bounded(self, moment_nm: float) -> float:
        return min(self._most_nm, max(-self._most_nm, moment_nm))

    def _resisting_nm(self, nav: NavState, measured: bool) -> float:
        """What the water takes, by the model, in the current as far as it is known: where no wind is `measured`, the
        estimate has the wind's push in it."""
        u, v, r = nav.surge_mps, nav.sway_mps, nav.yaw_rate_radps
        if measured and nav.current_north_mps is not None and nav.current_east_mps is not None:
            x, y = ned_to_body(nav.current_north_mps, nav.current_east_mps, nav.yaw_rad)
            u, v = u - x, v - y
        return force_for(self._hull, u, v, r, 0.0, 0.0, 0.0).yaw_nm
