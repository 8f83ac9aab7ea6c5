"""Following by the RescueRunner thesis: pursuit (Hallhagen & Persson 2016, chapter 4; FOLL_LAW 1).

Nozzle: PIDf on the angle from the own heading to the lead boat. Throttle: PID on v_leader + y_d − v_own, y_d a PID on the distance error, which is held to 20 m.
At 20 Hz. The thesis works with west positive and prints arctan of a quotient, which cannot tell ahead from astern; here angles are clockwise and from atan2. It
knows neither track nor keep-out, and takes thrust and steering for independent of each other: its faults are its own.
"""

from __future__ import annotations

import math

from companion.config import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.types import Leader, NavState, Setpoint, SetpointKind, ThrusterCommand, Wrench
from companion.guidance.pidf import Gains, Pidf
from companion.params import Parameters

PERIOD_S = 0.05
_MOST_ERROR_M = 20.0


class ThesisFollowing:
    """`start`, then `update(nav, leader, gap_m, dt_s)` → Setpoint: throttle and nozzle of a jet, on another boat the same shares of its surge and yaw limits.

    Remembers its three controllers, the last nozzle (−1 full left … 1 full right) and throttle, and the time since they were computed.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        self._parameters = parameters
        self._nozzle, self._speed, self._distance = Pidf(-1.0, 1.0), Pidf(0.0, 1.0), Pidf()
        self.start()

    def start(self) -> None:
        for controller in (self._nozzle, self._speed, self._distance):
            controller.start()
        self.nozzle = self.throttle = 0.0
        self._since_s = PERIOD_S

    def update(self, nav: NavState, leader: Leader, gap_m: float, dt_s: float) -> Setpoint:
        """New commands every PERIOD_S, or each tick where ticks are rarer."""
        north_m = leader.north_m - leader.age_s * leader.north_mps - nav.north_m  # "the last known location of the lead boat"
        east_m = leader.east_m - leader.age_s * leader.east_mps - nav.east_m
        off_m = math.hypot(north_m, east_m) - gap_m
        self._since_s += dt_s
        if self._since_s >= PERIOD_S - 1e-6:
            h_s, self._since_s = min(self._since_s, max(PERIOD_S, dt_s)), 0.0
            angle = wrap_pi(math.atan2(east_m, north_m) - nav.yaw_rad)
            self.nozzle = min(1.0, max(-1.0, self._nozzle.update(angle, self._gains(""), h_s)))
            bound = min(_MOST_ERROR_M, max(-_MOST_ERROR_M, off_m))
            pull = self._distance.update(bound, self._gains("_DST"), h_s)
            wanted = math.hypot(leader.north_mps, leader.east_mps) + pull
            error = wanted - math.hypot(nav.north_mps, nav.east_mps)
            self.throttle = min(1.0, max(0.0, self._speed.update(error, self._gains("_SPD"), h_s)))
        return self._setpoint(nav, leader, off_m)

    def _gains(self, which: str) -> Gains:
        p = self._parameters
        return Gains(p[f"FOLT_KP{which}"], p[f"FOLT_KI{which}"], p[f"FOLT_KD{which}"], p["FOLT_TF"])

    def _setpoint(self, nav: NavState, leader: Leader, off_m: float) -> Setpoint:
        first, limits = self._config.thrusters[0], self._config.limits
        thrusters: tuple[ThrusterCommand, ...] | None = None
        if first.kind == "jet":
            full = (first.azimuth_max_rad or 0.0) if self.nozzle * first.x_m >= 0.0 else -(first.azimuth_min_rad or 0.0)
            thrusters = (ThrusterCommand(first.ahead_n * self.throttle, self.throttle, math.copysign(1.0, first.x_m) * self.nozzle * full),)
        return Setpoint(
            SetpointKind.WRENCH if thrusters is None else SetpointKind.THRUSTERS,
            north_m=nav.north_m,
            east_m=nav.east_m,
            wrench=Wrench(self.throttle * limits.surge_n, 0.0, self.nozzle * limits.yaw_nm) if thrusters is None else None,
            thrusters=thrusters,
            target_north_m=leader.north_m,
            target_east_m=leader.east_m,
            distance_to_go_m=off_m,
        )
