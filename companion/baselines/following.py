"""Following law of the RescueRunner thesis: pursuit (Hallhagen & Persson 2016, chapter 4; FOLL_LAW 1).

Nozzle: a PIDf on the angle from the own heading to the lead boat. Throttle: a PID on v_leader + y_d − v_own, where y_d
is a PID on the distance error, limited to 20 m. Both run at 20 Hz. The thesis has west positive and prints the arctan
of a quotient, which cannot tell ahead from astern; here angles are clockwise and from atan2. The law has neither a
track nor a keep-out circle, and treats thrust and steering as independent. These faults are kept: it is a baseline.
"""

from __future__ import annotations

import math

from companion.baselines.pidf import Gains, Pidf
from companion.config.vessel import VesselConfig
from companion.core.actuation import ThrusterCommand, Wrench
from companion.core.angles import wrap_pi
from companion.core.estimate import Leader, NavState
from companion.core.setpoint import Point, Progress, Setpoint, ThrusterSetpoint, WrenchSetpoint
from companion.params.store import Parameters

PERIOD_S = 0.05
_MOST_ERROR_M = 20.0


class ThesisFollowing:
    """`start`, then `update(nav, leader, gap_m, dt_s)` → Setpoint: throttle and nozzle of a jet; on another boat, the
    same shares of its surge and yaw limits.

    Remembers its three controllers, the last nozzle (−1 full left … 1 full right) and throttle (0 … 1), and the time
    since they were computed.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        self._parameters = parameters
        self._nozzle, self._speed, self._distance = Pidf(-1.0, 1.0), Pidf(0.0, 1.0), Pidf()
        self.start()

    def start(self) -> None:
        """Reset the three controllers."""
        for controller in (self._nozzle, self._speed, self._distance):
            controller.start()
        self.nozzle = self.throttle = 0.0
        self._since_s = PERIOD_S

    def update(self, nav: NavState, leader: Leader, gap_m: float, dt_s: float) -> Setpoint:
        """One step; new commands every PERIOD_S, or each tick where ticks are rarer. `gap_m`: distance to keep."""
        # "the last known location of the lead boat", which is older than the leader's predicted position
        north_m = leader.north_m - leader.age_s * leader.north_mps - nav.north_m
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
        progress = Progress(
            place=Point(nav.north_m, nav.east_m), target=Point(leader.north_m, leader.east_m), distance_to_go_m=off_m
        )
        if first.kind == "jet":
            full = (first.azimuth_max_rad or 0.0) if self.nozzle * first.x_m >= 0.0 else -(first.azimuth_min_rad or 0.0)
            azimuth_rad = math.copysign(1.0, first.x_m) * self.nozzle * full
            return ThrusterSetpoint(
                (ThrusterCommand(first.ahead_n * self.throttle, self.throttle, azimuth_rad),), progress
            )
        return WrenchSetpoint(Wrench(self.throttle * limits.surge_n, 0.0, self.nozzle * limits.yaw_nm), progress)
