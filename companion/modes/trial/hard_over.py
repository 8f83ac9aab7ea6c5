"""Helm hard over with full thrust, for a boat that turns only with way on.

A stream carries it out of its circle as long as it turns. The width of its turn hardly depends on its speed, the time
does; and with less thrust the wind may hold its bow.
"""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.core.actuation import ThrusterCommand
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.setpoint import Setpoint, ThrusterSetpoint
from companion.modes.trial.circle import TrialCircle
from companion.modes.trial.manoeuvres.manoeuvre import pushed

_BEGINS_RAD, _ENDS_RAD = math.radians(60.0), math.radians(30.0)  # off the heading that is asked for
_EITHER_RAD = math.radians(160.0)  # off it: the boat turns on to the side to which it turns already
_TURNS_RADPS = math.radians(6.0)


class HardOver:
    """`update` every tick → 1 or −1 for helm hard over to starboard or port, 0 for none. A turn goes on to the side to
    which it began. Remembers the side, and when and how far the boat has turned; the circle learns how fast it was."""

    def __init__(self, circle: TrialCircle) -> None:
        self._circle = circle
        self.ease()

    def ease(self) -> None:
        """No helm, for the next turn to begin anew."""
        self._side = self._turned_rad = self._yaw_rad = self._begun_s = 0.0

    def update(self, nav: NavState, yaw_rad: float, now_s: float) -> float:
        """`yaw_rad`: the heading to turn to."""
        off_rad = wrap_pi(yaw_rad - nav.yaw_rad)
        if self._side == 0.0:
            if abs(off_rad) > _BEGINS_RAD:
                turns = abs(off_rad) > _EITHER_RAD and abs(nav.yaw_rate_radps) > _TURNS_RADPS
                self._side = math.copysign(1.0, nav.yaw_rate_radps if turns else off_rad)
                self._turned_rad, self._yaw_rad, self._begun_s = 0.0, nav.yaw_rad, now_s
            return self._side
        self._turned_rad += self._side * wrap_pi(nav.yaw_rad - self._yaw_rad)
        self._yaw_rad = nav.yaw_rad
        if abs(off_rad) < _ENDS_RAD:
            self._circle.learn_turn(self._turned_rad, now_s - self._begun_s)
            self.ease()
        return self._side


def hard_over(config: VesselConfig, surge_n: float, side: float) -> Setpoint:
    """That force ahead, with the rudder at its stop: `side` 1 to starboard, −1 to port. Of a moment the controller asks
    for no more than the blade gives at rest; under way it gives several times that. For a boat that has more than a
    rudder, the largest moment."""
    thruster = config.thrusters[0]
    if not config.has_rudder:
        return pushed(surge_n, 0.0, side * config.limits.yaw_nm)
    throttle = math.sqrt(min(1.0, max(0.0, surge_n / thruster.ahead_n)))
    stop_rad = thruster.azimuth_min_rad if side > 0.0 else thruster.azimuth_max_rad  # the stern goes to the other side
    return ThrusterSetpoint((ThrusterCommand(0.0, throttle, stop_rad),))
