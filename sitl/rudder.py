"""A propeller with a rudder behind it: thrust with its lag, a blade that turns at its rate, and the force of the flow.

Lift and drag of the blade by Whicker and Fehlner (1958) up to its stall, as a flat plate beyond (Hoerner 1965, ch. 7).
Flow of the race by momentum theory with the share that reaches the blade, and the drift straightened by hull and race,
by the MMG method (Yasukawa and Yoshimura 2015). A propeller that brakes slows the flow by momentum theory, too.
"""

from __future__ import annotations

import math

from companion.config.devices import NozzleConfig, ThrusterConfig
from companion.config.dimensions.form import WATER_KGPM3
from companion.config.rudder import RudderConfig
from sitl.thrusters import ThrusterModel

_STALL_RAD = math.radians(35.0)  # in a race the flow stays on the blade longer than in free water (Molland 1992)
_PLATE_DRAG = 1.2  # of a flat plate across the flow
_BACKWARDS = 0.6  # share of the lift with the flow from the trailing edge
STRAIGHTENED = 0.6
"""Share of a drift angle that the blade sees."""


class Rudder(ThrusterModel):
    """As `ThrusterModel`, for a propeller with a rudder, with the speed through the water as further input. `force_n`
    is the propeller's, ahead; `azimuth_rad` the blade's angle, positive where it pushes to starboard.

    The race speed of the propeller is √(U_A² + 2T/(ρ A_P)), of which the blade feels a share; one that runs hard astern
    leaves the blade behind it in dead water. Going astern there is the speed alone, from the other edge.
    """

    __slots__ = ("_blade", "_disc_m2", "_drive", "_lever_m", "_side_n", "_surge_n")

    def __init__(
        self,
        config: ThrusterConfig,
        lag_s: float,
        rudder: RudderConfig,
        x_m: float | None = None,
        drive: NozzleConfig | None = None,
    ) -> None:
        """`drive`: how the blade really turns; without it at the file's rate, without lag. `x_m`: where the propeller
        really is, and the blade as far behind it as the file says."""
        super().__init__(config, lag_s, x_m)
        self._blade = rudder
        self._drive = drive or NozzleConfig(config.azimuth_rate_radps)
        self._disc_m2 = 0.25 * math.pi * (config.propeller_m or 0.0) ** 2
        self._lever_m = rudder.x_m + (0.0 if x_m is None else x_m - config.x_m)
        self._surge_n = self._side_n = 0.0

    def step(self, dt_s: float, surge_mps: float = 0.0, sway_mps: float = 0.0, yaw_rate_radps: float = 0.0) -> None:
        """Advance by `dt_s` at that velocity through the water."""
        super().step(dt_s, surge_mps)
        drift_mps = STRAIGHTENED * (sway_mps + self._lever_m * yaw_rate_radps)
        race = self._in_flow(self._race_mps(surge_mps), drift_mps)
        beside = self._in_flow((1.0 - self._blade.wake_share) * surge_mps, drift_mps)
        share = self._blade.race_share
        self._surge_n = share * race[0] + (1.0 - share) * beside[0]
        self._side_n = share * race[1] + (1.0 - share) * beside[1]

    def wrench(self) -> tuple[float, float, float]:
        """(surge_n, sway_n, yaw_nm) on the hull, of propeller and blade."""
        force_n = self.given_n
        return force_n + self._surge_n, self._side_n, self._lever_m * self._side_n - self._y_m * force_n

    def _race_mps(self, surge_mps: float) -> float:
        """Speed of the water along the boat behind the propeller."""
        free_mps = (1.0 - self._blade.wake_share) * surge_mps
        ahead_mps = max(0.0, free_mps)
        if self.force_n < 0.0:
            slowed = ahead_mps * ahead_mps + 2.0 * self.given_n / (WATER_KGPM3 * self._disc_m2)
            return math.sqrt(slowed) if slowed > 0.0 else min(0.0, free_mps)
        jet_mps = math.sqrt(ahead_mps * ahead_mps + 2.0 * self.given_n / (WATER_KGPM3 * self._disc_m2))
        raced_mps = ahead_mps + self._blade.race_gain * (jet_mps - ahead_mps)
        return raced_mps if free_mps >= 0.0 or raced_mps > -free_mps else free_mps

    def _in_flow(self, along_mps: float, across_mps: float) -> tuple[float, float]:
        """(surge, sway) of the whole blade in a flow that comes from ahead with `along_mps`, while the blade moves to
        starboard with `across_mps`."""
        speed = math.hypot(along_mps, across_mps)
        if speed == 0.0:
            return 0.0, 0.0
        ahead = along_mps >= 0.0
        drift = math.atan2(across_mps, abs(along_mps))
        angle = (self.azimuth_rad if ahead else -self.azimuth_rad) - drift
        lift, drag = self._coefficients(angle)
        lift *= 1.0 if ahead else _BACKWARDS
        pressure = 0.5 * WATER_KGPM3 * self._blade.area_m2 * self._blade.lift_scale * speed * speed
        c, s = math.cos(drift), math.sin(drift)
        along_n = pressure * (lift * s + drag * c)  # against the way
        return -along_n if ahead else along_n, pressure * (lift * c - drag * s)

    def _coefficients(self, angle_rad: float) -> tuple[float, float]:
        """(C_L, C_D) at an angle to the flow, up to π/2 and a little beyond."""
        size = abs(angle_rad)
        aspect = self._blade.span_m / self._blade.chord_m
        slope = 1.8 * math.pi * aspect / (math.sqrt(aspect * aspect + 4.0) + 1.8)
        at = min(size, _STALL_RAD)
        lift = slope * at + 0.8 / aspect * at * at
        drag = 0.0065 + lift * lift / (0.9 * math.pi * aspect)
        if size > _STALL_RAD:
            lift *= math.cos(size) / math.cos(_STALL_RAD)
            share = (math.sin(min(size, math.pi / 2)) - math.sin(_STALL_RAD)) / (1.0 - math.sin(_STALL_RAD))
            drag += (max(_PLATE_DRAG, drag) - drag) * share
        return lift if angle_rad >= 0.0 else -lift, drag  # beyond a right angle the lift is on the other side

    def _turn(self, dt_s: float) -> None:
        self._turn_with_lag(self._drive, dt_s)
