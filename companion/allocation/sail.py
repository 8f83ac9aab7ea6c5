"""Allocation of a sailing rig: drive and yaw moment → sheet, or angle of the wing, rudder angle, and motors beside it.

The sheet gives the drive that is wanted, at most what the wind has (`SailTrim`, of a wing `WingTrim`); the rudder gives
the moment. That of the sail is left to the yaw loop: keel and hull as fins balance most of it, and none of both is
known well. Motors, where they are used, give the drive that the sail does not. In a turn the stern swings out, and the
flow with it: the rudder's angle counts from there. A boat that gathers sternway has its rudder put over the other way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.allocation.rudder_curve import RudderCurve
from companion.allocation.sail_motors import SailMotors
from companion.allocation.sail_trim import SailForce, SailTrim
from companion.allocation.steered import SteeredAllocator
from companion.allocation.wing_trim import WingTrim
from companion.config.vessel import VesselConfig
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.core.estimate import NavState, Rig
from companion.params.store import Parameters

_IDLE_RAD = math.radians(2.0)  # the winch does not follow smaller changes of the boom
_WING_IDLE_RAD = math.radians(0.3)  # nor the tail of the wing's angle
_STERNWAY_MPS = 0.05
_STRAIGHTENED = 0.7  # share of the drift at the stern that the rudder sees behind the keel
_LEAST_WAY_MPS = 0.3  # slower, a drift is no angle of the flow
_WHOLE_SHEET_S = 2.0  # from free to hauled in


class SailAllocator(SteeredAllocator):
    """Wrench → Allocation. `feel` gives the wind first. Throttle: the sheet, 0 free to 1 hauled in; of a wing −1 to 1.

    Remembers the sheet, the apparent wind, the drift at the rudder, the motors, and the rudder as every boat that
    steers with one force.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        super().__init__(config, parameters)
        sail = self._thruster.sail
        if sail is None:
            raise ValueError(f"thruster {self._thruster.name} has no sail")
        self._wing = sail.attack_max_rad is not None
        self._trim = SailTrim(sail) if sail.attack_max_rad is None else WingTrim(sail, sail.attack_max_rad)
        self._idle_rad = _WING_IDLE_RAD if self._wing else _IDLE_RAD
        self._blade = RudderCurve(self._thruster)
        self._sheet = 0.0
        self._off_rad, self._side, self._wind_mps = math.pi, 1.0, 0.0
        self._drift_rad = 0.0
        self._motors = SailMotors(config.thrusters[1:])
        self._sails, self._drives = True, False

    def set_failed(self, index: int, failed: bool) -> None:
        """Mark the rig (index 0) or a motor as failed or not. A failed one gives no thrust; the rudder still turns."""
        super().set_failed(index, failed)
        if index > 0:
            self._motors.set_failed(index - 1, failed)

    def feel(self, rig: Rig | None, nav: NavState) -> None:
        """What drives the boat (a wind that is None: as before), and its motion."""
        if rig is not None:
            self._sails, self._drives = rig.sails, rig.motors
        air = None if rig is None else rig.air
        across_mps = nav.sway_mps + self._blade.lever_m * nav.yaw_rate_radps
        has_way = nav.surge_mps > _LEAST_WAY_MPS
        self._drift_rad = _STRAIGHTENED * math.atan2(across_mps, nav.surge_mps) if has_way else 0.0
        if air is None:
            return
        c, s = math.cos(nav.yaw_rad), math.sin(nav.yaw_rad)
        ahead = c * air[0] + s * air[1] - nav.surge_mps
        across = c * air[1] - s * air[0] - nav.sway_mps
        self._wind_mps = math.hypot(ahead, across)
        self._off_rad = abs(math.atan2(across, -ahead))
        self._side = 1.0 if across > 0.0 else -1.0  # leeward: to starboard

    def direct(
        self, thrusters: Sequence[ThrusterCommand], dt_s: float | None = None, surge_mps: float = 0.0
    ) -> Allocation:
        """As `SteeredAllocator.direct`, and the motors."""
        self._motors.direct(thrusters[1:], self._period_s if dt_s is None else dt_s)
        return super().direct(thrusters, dt_s, surge_mps)

    def neutral(self) -> Allocation:
        """The sheet free or the wing in the wind, the rudder amidships, the motors off."""
        self._sheet = 0.0
        self._motors.stop()
        self._steer(0.0, self._period_s)
        return self._result(None, 0.0)

    def _take_throttle(self, throttle: float, dt_s: float) -> None:
        """The stick of a wing says how much: which way, the wind says."""
        self._haul(self._side * max(0.0, throttle) if self._wing else throttle, dt_s)

    def _serve(self, wrench: Wrench, dt_s: float, surge_mps: float) -> None:
        heel_max_rad = math.radians(self._parameters["SAIL_HEEL_MAX"])
        wanted_n = wrench.surge_n if self._sails else 0.0
        best_rad = self._trim.best(wanted_n, self._off_rad, self._wind_mps, heel_max_rad)
        if abs(best_rad - self._trim.setting_rad(self._sheet, self._side)) > self._idle_rad:
            self._haul(self._trim.throttle(best_rad, self._side), dt_s)
        self._motors.push(wrench.surge_n - self._force().drive_n if self._drives else 0.0, dt_s)
        side_n = wrench.yaw_nm / self._blade.lever_m
        astern = surge_mps < -_STERNWAY_MPS
        angle_rad = self._blade.angle_rad(-side_n if astern else side_n, 0.0, abs(surge_mps))
        self._steer(angle_rad + self._drift_rad, dt_s)

    def _haul(self, sheet: float, dt_s: float) -> None:
        reach = max(0.0, dt_s) / _WHOLE_SHEET_S
        least = -1.0 if self._wing else 0.0
        held = min(self._sheet + reach, max(self._sheet - reach, min(1.0, max(least, sheet))))
        self._sheet = 0.0 if self._failed else held

    def _force(self) -> SailForce:
        setting_rad = self._trim.setting_rad(self._sheet, self._side)
        return self._trim.force(setting_rad, self._off_rad, self._wind_mps)

    def _result(self, demanded: Wrench | None, surge_mps: float) -> Allocation:
        given = self._force()
        x_n, y_n = self._blade.force_n(0.0, self._angle_rad - self._drift_rad, surge_mps)
        thrust_n = self._thruster.ahead_n * self._sheet * abs(self._sheet)
        command = ThrusterCommand(thrust_n, self._sheet, self._angle_rad)
        drive_n, side_n = given.drive_n + self._motors.thrust_n + x_n, self._side * given.leeward_n + y_n
        commands = (command, *self._motors.commands())
        return self._given(demanded, commands, Wrench(drive_n, side_n, self._blade.lever_m * y_n))
