"""What the allocations of a thruster that steers alone share: a water jet, a propeller with a rudder, and a sail.

They give surge and yaw by one force and one angle, within the angle's stops and its rate, and no sway of their own.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence

from companion.allocation.shortfall import limited_axes
from companion.config.vessel import VesselConfig
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.core.estimate import NavState, Rig
from companion.params.store import Parameters


class SteeredAllocator(ABC):
    """Wrench → Allocation. Remembers the angle, and whether the thruster has failed."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        thruster = config.thrusters[0]
        self._thruster = thruster
        self._parameters = parameters
        self._low_rad, self._high_rad = thruster.azimuth_min_rad or 0.0, thruster.azimuth_max_rad or 0.0
        self._limits = config.limits
        self._period_s = 1.0 / config.control_rate_hz
        self._angle_rad = 0.0
        self._rate_radps = thruster.azimuth_rate_radps
        self._failed = False

    def set_failed(self, index: int, failed: bool) -> None:
        """Mark the thruster (index 0) as failed or not. A failed one gives no thrust; its angle still follows."""
        if index == 0:
            self._failed = failed

    def set_turn_rate(self, index: int, rate_radps: float) -> None:
        """Turn the nozzle or rudder (index 0) no faster from now on."""
        if index == 0:
            self._rate_radps = rate_radps

    @abstractmethod
    def feel(self, rig: Rig | None, nav: NavState) -> None:
        """Take what drives a boat with a sail (None: it has none) and the boat's motion."""

    def direct(
        self, thrusters: Sequence[ThrusterCommand], dt_s: float | None = None, surge_mps: float = 0.0
    ) -> Allocation:
        """Take throttle and angle as demanded, within limits and rates over `dt_s` (None: one control period): the
        manual path."""
        dt_s = self._period_s if dt_s is None else dt_s
        command = thrusters[0] if thrusters else None
        throttle = command.throttle if command is not None and math.isfinite(command.throttle) else 0.0
        if command is not None and command.azimuth_rad is not None and math.isfinite(command.azimuth_rad):
            self._steer(command.azimuth_rad, dt_s)
        self._take_throttle(throttle, dt_s)
        return self._result(None, surge_mps)

    def update(
        self,
        wrench: Wrench,
        dt_s: float,
        surge_mps: float = 0.0,
        planned: bool = False,
        ahead: Sequence[Wrench] = (),
    ) -> Allocation:
        """Throttle and angle for surge and yaw; sway is not given. `surge_mps`: speed ahead through the water. A
        non-finite input counts as no demand. `planned` and `ahead` have no effect here."""
        if not all(map(math.isfinite, (wrench.surge_n, wrench.sway_n, wrench.yaw_nm, surge_mps))):
            wrench, surge_mps = Wrench(0.0, 0.0, 0.0), 0.0
        self._serve(wrench, dt_s, surge_mps)
        return self._result(wrench, surge_mps)

    @abstractmethod
    def neutral(self) -> Allocation:
        """No thrust; the angle stays where it is."""

    @abstractmethod
    def _take_throttle(self, throttle: float, dt_s: float) -> None:
        """Move towards that throttle, −1 to 1."""

    @abstractmethod
    def _serve(self, wrench: Wrench, dt_s: float, surge_mps: float) -> None:
        """Move thrust and angle towards those that give the wrench."""

    @abstractmethod
    def _result(self, demanded: Wrench | None, surge_mps: float) -> Allocation:
        """What thrust and angle give now."""

    def _steer(self, angle_rad: float, dt_s: float) -> None:
        reach = self._rate_radps * max(0.0, dt_s)
        held = min(self._high_rad, max(self._low_rad, math.remainder(angle_rad, math.tau)))
        self._angle_rad = min(self._angle_rad + reach, max(self._angle_rad - reach, held))

    def _given(self, demanded: Wrench | None, commands: tuple[ThrusterCommand, ...], achieved: Wrench) -> Allocation:
        """The allocation, with the axes that fall short of what is demanded."""
        return Allocation(commands, achieved, limited_axes(demanded, achieved, self._limits))
