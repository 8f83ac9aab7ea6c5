"""How a boat that needs way to turn comes round: which bends it can sail, and the arc on which it turns to a way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from companion.config.reversing import turns_on_the_spot
from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.fence.allowed import Place
from companion.guidance.bend_speed import TURN_SHARE, steady_turn_radps
from companion.obstacles.clear_way import reach_m, stop_m
from companion.params.store import Parameters

_WIDER = 1.5  # than a steady turn: the boat has to begin and to end it
_ARC_STEP_RAD, _ARC_STEPS = math.radians(15.0), 24


@dataclass(frozen=True, slots=True)
class Circling:
    """A boat that needs way to turn. `radius_m`: of its turn. `keep_m`: distance that its middle keeps from obstacles
    while it turns to a way. `here`, `yaw_rad`: where it lies, and its heading."""

    radius_m: float
    keep_m: float
    here: Place
    yaw_rad: float

    def follows(self, points: Sequence[Place], radius_m: float) -> bool:
        """Whether it can sail bends at those points that begin `radius_m` before each: an arc in a corner by θ has the
        radius `radius_m` / tan(θ/2)."""
        steps = np.diff(np.asarray(points, dtype=float), axis=0)
        courses = np.arctan2(steps[:, 1], steps[:, 0])
        corners = np.abs(np.remainder(np.diff(courses) + math.pi, math.tau) - math.pi)
        return bool(np.all(self.radius_m * np.tan(0.5 * np.minimum(corners, 0.9 * math.pi)) <= radius_m + 1e-6))

    def arc_to(self, place: Place) -> list[Place] | None:
        """Points of its turn until it heads for a place; None where that lies within its turn."""
        way, yaw_rad, step_m = [self.here], self.yaw_rad, self.radius_m * _ARC_STEP_RAD
        step_rad = math.copysign(_ARC_STEP_RAD, self._off_rad(self.here, yaw_rad, place))
        for _ in range(_ARC_STEPS):
            if abs(self._off_rad(way[-1], yaw_rad, place)) <= _ARC_STEP_RAD:
                return way
            middle_rad = yaw_rad + 0.5 * step_rad
            way.append((way[-1][0] + step_m * math.cos(middle_rad), way[-1][1] + step_m * math.sin(middle_rad)))
            yaw_rad += step_rad
        return None

    @staticmethod
    def _off_rad(here: Place, yaw_rad: float, place: Place) -> float:
        return wrap_pi(math.atan2(place[1] - here[1], place[0] - here[0]) - yaw_rad)


def circling_at(config: VesselConfig, parameters: Parameters, nav: NavState, speed_mps: float) -> Circling | None:
    """How the boat turns at that speed from where it lies; None for one that turns without way."""
    if turns_on_the_spot(config.thrusters):
        return None
    turn_radps = steady_turn_radps(config.hull, speed_mps, TURN_SHARE * config.limits.yaw_nm)
    radius_m = min(parameters["NAV_ACC_RAD"], _WIDER * speed_mps / turn_radps)
    return Circling(radius_m, reach_m(config) + stop_m(parameters), (nav.north_m, nav.east_m), nav.yaw_rad)
