"""A towed hull: it moves along given legs, whatever its propulsion, for scenarios in which only the motion counts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.config.hull import HullConfig
from companion.core.angles import wrap_pi
from sitl.hull import Hull

_SPEED_TIME_S = 2.0
_TURN_TIME_S = 0.4
_SLIP_S = 0.2  # drift angle over rate of turn: the bow points into the turn
_GRAVITY_MPS2 = 9.81
_SLOWEST_MPS = 1.0


@dataclass(frozen=True, slots=True)
class TowLeg:
    """For `duration_s` at `speed_mps`, with `sideways_g` of acceleration to starboard."""

    duration_s: float
    speed_mps: float
    sideways_g: float = 0.0


class TowedHull(Hull):
    """A `Hull` that moves along `legs` from rest, then straight on at the last speed. Forces have no effect. Speed and
    rate of turn follow with a lag."""

    __slots__ = ("_course_rad", "_legs", "_rate_radps", "_speed_mps", "_t_s")

    def __init__(self, config: HullConfig, legs: Sequence[TowLeg]) -> None:
        self._legs = tuple(legs)
        self._t_s = self._speed_mps = self._rate_radps = self._course_rad = 0.0
        super().__init__(config)

    def place(
        self,
        north_m: float,
        east_m: float,
        yaw_rad: float,
        surge_mps: float = 0.0,
        sway_mps: float = 0.0,
        yaw_rate_radps: float = 0.0,
    ) -> None:
        """As `Hull.place`; the course is the heading."""
        super().place(north_m, east_m, yaw_rad, surge_mps, sway_mps, yaw_rate_radps)
        self._course_rad, self._speed_mps, self._rate_radps = yaw_rad, surge_mps, 0.0

    def step(self, surge_n: float, sway_n: float, yaw_nm: float, dt_s: float) -> None:
        """Advance by `dt_s`; the forces are ignored."""
        leg = self._leg()
        self._t_s += dt_s
        self._speed_mps += dt_s / _SPEED_TIME_S * (leg.speed_mps - self._speed_mps)
        wanted = leg.sideways_g * _GRAVITY_MPS2 / max(self._speed_mps, _SLOWEST_MPS)
        self._rate_radps += dt_s / _TURN_TIME_S * (wanted - self._rate_radps)
        self._course_rad += dt_s * self._rate_radps
        north = self._speed_mps * math.cos(self._course_rad) + self.current_north_mps
        east = self._speed_mps * math.sin(self._course_rad) + self.current_east_mps
        yaw = self._course_rad + _SLIP_S * self._rate_radps
        turned = wrap_pi(yaw - self.yaw_rad)
        middle = self.yaw_rad + 0.5 * turned
        c, s = math.cos(middle), math.sin(middle)
        north_mps2, east_mps2 = (north - self.north_mps) / dt_s, (east - self.east_mps) / dt_s
        self.surge_mps2, self.sway_mps2 = c * north_mps2 + s * east_mps2, c * east_mps2 - s * north_mps2
        self.turn_radps = self.yaw_rate_radps = turned / dt_s
        self.north_m += dt_s * 0.5 * (north + self.north_mps)
        self.east_m += dt_s * 0.5 * (east + self.east_mps)
        self.north_mps, self.east_mps, self.yaw_rad = north, east, wrap_pi(yaw)
        c, s = math.cos(yaw), math.sin(yaw)
        through_n, through_e = north - self.current_north_mps, east - self.current_east_mps
        self.water_surge_mps, self.water_sway_mps = c * through_n + s * through_e, c * through_e - s * through_n

    def _leg(self) -> TowLeg:
        left_s = self._t_s
        for leg in self._legs:
            if left_s < leg.duration_s:
                return leg
            left_s -= leg.duration_s
        return TowLeg(math.inf, self._legs[-1].speed_mps)
