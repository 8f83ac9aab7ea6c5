"""Thrust allocation of a propeller with a rudder: surge and yaw → throttle and rudder angle.

The blade gives a side force by the flow over it (`RudderCurve`), at x behind the middle of the boat: N = x Y. Thrust
ahead serves surge and makes flow; where it makes too little for the yaw moment, it is raised to at most RUD_STEER of
the largest thrust; to more where that has long been too little, because wind holds the bow. Thrust astern leaves the
blade without a race: the boat brakes or steers, whichever is asked for more, as a share of its limit.
"""

from __future__ import annotations

from companion.allocation.rudder_curve import RudderCurve
from companion.allocation.steered import SteeredAllocator
from companion.allocation.thrust_curve import ThrustCurve
from companion.config.vessel import VesselConfig
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.core.estimate import NavState, Rig
from companion.params.store import Parameters

_WORTH_SHARE = 0.08  # of the moment at rest with the thrust for steering: a smaller one is not worth thrust of its own
# For the first time thrust stays at RUD_STEER, which suffices for turns; within the second it grows to all of it.
# Slower, wind carries the boat off before its bow comes round.
_TURN_S, _MORE_S = 3.0, 3.0
_STAYS = 1.5  # factor on what is being done: the boat does not change between braking and steering in every tick


class RudderAllocator(SteeredAllocator):
    """Wrench → Allocation, by the inverse of propeller and rudder at the present speed.

    Thrust keeps its rate, the blade its rate and its stops. Remembers the thrust, the angle, whether the boat brakes
    rather than steers, how long the thrust for steering has been too little, and whether the thruster has failed.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        super().__init__(config, parameters)
        self._blade, self._curve = RudderCurve(self._thruster), ThrustCurve(self._thruster)
        self._thrust_n = 0.0
        self._brakes = False
        self._short_s = 0.0

    def feel(self, rig: Rig | None, nav: NavState) -> None:
        """No effect."""

    def neutral(self) -> Allocation:
        """Stop the propeller; the blade stays where it is."""
        self._thrust_n, self._brakes, self._short_s = 0.0, False, 0.0
        return self._result(None, 0.0)

    def _take_throttle(self, throttle: float, dt_s: float) -> None:
        self._push(self._curve.force_n(min(1.0, max(-1.0, throttle))), dt_s)

    def _serve(self, wrench: Wrench, dt_s: float, surge_mps: float) -> None:
        side_n = wrench.yaw_nm / self._blade.lever_m
        self._push(self._wanted_n(wrench, side_n, surge_mps, dt_s), dt_s)
        self._steer(self._blade.angle_rad(side_n, self._thrust_n, surge_mps), dt_s)

    def _wanted_n(self, wrench: Wrench, side_n: float, surge_mps: float, dt_s: float) -> float:
        """The thrust for surge, or more of it where the blade needs flow."""
        usual_n = self._parameters["RUD_STEER"] * self._curve.max_n
        most_n = self._most_n(usual_n, self._blade.thrust_n(side_n, surge_mps), dt_s)
        full_nm = abs(self._blade.lever_m * self._blade.force_n(usual_n, self._high_rad, 0.0)[1])
        turn = abs(wrench.yaw_nm) / full_nm if full_nm > 0.0 else 0.0
        steering_n = min(most_n, self._blade.thrust_n(side_n, surge_mps)) if turn > _WORTH_SHARE else 0.0
        if wrench.surge_n >= 0.0 or steering_n <= 0.0:
            self._brakes = False
            return max(wrench.surge_n, steering_n) if wrench.surge_n >= 0.0 else wrench.surge_n
        brake = -wrench.surge_n / self._limits.surge_n
        self._brakes = brake * (_STAYS if self._brakes else 1.0 / _STAYS) > turn
        return wrench.surge_n if self._brakes else steering_n

    def _most_n(self, usual_n: float, needed_n: float, dt_s: float) -> float:
        """The most thrust for steering: the usual one, and what has been added to it since it has not sufficed."""
        short = needed_n > usual_n > 0.0
        self._short_s = min(_TURN_S + _MORE_S, max(0.0, self._short_s + (dt_s if short else -dt_s)))
        share = max(0.0, self._short_s - _TURN_S) / _MORE_S
        return usual_n + share * max(0.0, self._curve.max_n - usual_n)

    def _push(self, thrust_n: float, dt_s: float) -> None:
        """Move towards that thrust at its rate; a failed propeller stands."""
        reach = self._thruster.force_rate_nps * max(0.0, dt_s)
        low, high = self._thrust_n - reach, self._thrust_n + reach
        held = min(self._curve.max_n, max(self._curve.min_n, min(high, max(low, thrust_n))))
        self._thrust_n = 0.0 if self._failed else held

    def _result(self, demanded: Wrench | None, surge_mps: float) -> Allocation:
        throttle = self._curve.throttle(self._thrust_n)
        thrust_n = self._curve.force_n(throttle)
        x, y = self._blade.force_n(thrust_n, self._angle_rad, surge_mps)
        command = ThrusterCommand(thrust_n, throttle, self._angle_rad)
        return self._given(demanded, (command,), Wrench(x, y, self._blade.lever_m * y))
