"""Staying near a point with a boat that can neither push itself sideways nor go astern: it drifts, and sails back up against the drift."""

from __future__ import annotations

import math

from companion.config import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.types import ZERO_WRENCH, ManualInput, NavState, Setpoint, SetpointKind
from companion.guidance.coasting import Coasting
from companion.guidance.stopping import stopping_point
from companion.params import Parameters

_OUT_SHARE = 0.75  # of the watch circle: where the drift would have the boat in _WARNING_S, it turns back
_WARNING_S = 4.0  # to start the impeller and come round
_ABOVE_SHARE = 0.45  # of the watch circle: how far above the point the way back leads
_DRIFT_TAU_S = 8.0
_SLOW_MPS = 1.5  # faster than this the boat is still coasting, whatever drifts it
_LEAST_DRIFT_MPS = 0.05
_STEERAGE_SHARE = 0.5  # of the speed, kept while the bow points elsewhere: a jet steers by its thrust
_LONGEST_RETURN_S = 90.0  # after which the aim is taken anew


class DriftKeeper:
    """Inside the watch circle it drifts without thrust; before the drift takes it out it sails to a point above the one held, bow into the drift,
    stops the impeller where it will come to rest there, and drifts again.

    Remembers the point, whether it is on the way back and since when, and the drift over ground that it has seen.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._parameters = parameters
        self._coasting = Coasting(config.hull, 10.0)
        self._point = self._aim = (0.0, 0.0)
        self._heading_rad = 0.0
        self._returning = self._arrived = False
        self._returning_s = 0.0
        self._drift = (0.0, 0.0)

    @property
    def arrived(self) -> bool:
        return self._arrived

    @property
    def target(self) -> tuple[float, float, float]:
        return (*self._point, self._heading_rad)

    def start(self, nav: NavState) -> None:
        self._point = stopping_point(nav, self._parameters)
        self._heading_rad = nav.yaw_rad
        self._returning = self._arrived = False

    def hold(self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None) -> None:
        """Another point; a heading cannot be held."""
        self._point = (north_m, east_m)
        self._arrived = self._returning = False

    def update(self, nav: NavState, stick: ManualInput | None, speed_mps: float, dt_s: float) -> Setpoint:
        self._see_drift(nav, dt_s)
        north_m, east_m = self._point[0] - nav.north_m, self._point[1] - nav.east_m
        distance_m = math.hypot(north_m, east_m)
        if self._returning:
            self._returning_s += dt_s
            self._returning = not self._will_rest_there(nav)
            if self._returning_s > _LONGEST_RETURN_S:
                self._turn_back()
        elif distance_m + _WARNING_S * _outward_mps(nav, north_m, east_m) > _OUT_SHARE * self._parameters["DP_WATCH_R"]:
            self._turn_back()
        self._arrived = self._arrived or not self._returning
        if not self._returning:
            return self._setpoint(SetpointKind.WRENCH, 0.0, distance_m)
        self._heading_rad = math.atan2(self._aim[1] - nav.east_m, self._aim[0] - nav.north_m)
        fastest = min(speed_mps, self._parameters["DP_SPEED_AHEAD"])
        surge_mps = fastest * max(_STEERAGE_SHARE, math.cos(wrap_pi(self._heading_rad - nav.yaw_rad)))
        return self._setpoint(SetpointKind.PATH, surge_mps, distance_m)

    def _setpoint(self, kind: SetpointKind, surge_mps: float, distance_m: float) -> Setpoint:
        return Setpoint(
            kind,
            north_m=self._point[0],
            east_m=self._point[1],
            yaw_rad=self._heading_rad,
            surge_mps=surge_mps,
            wrench=ZERO_WRENCH,
            target_north_m=self._point[0],
            target_east_m=self._point[1],
            distance_to_go_m=distance_m,
        )

    def _turn_back(self) -> None:
        """To a point above the one held, as far as the drift deserves it."""
        drift_mps = math.hypot(*self._drift)
        above_m = 0.0
        if drift_mps >= _LEAST_DRIFT_MPS:
            above_m = _ABOVE_SHARE * self._parameters["DP_WATCH_R"] / drift_mps
        self._aim = self._point[0] - above_m * self._drift[0], self._point[1] - above_m * self._drift[1]
        self._returning, self._returning_s = True, 0.0

    def _will_rest_there(self, nav: NavState) -> bool:
        """Whether the way that is left is run without thrust; a boat that points elsewhere has still to come round."""
        north_m, east_m = self._aim[0] - nav.north_m, self._aim[1] - nav.east_m
        left_m = math.hypot(north_m, east_m)
        towards_mps = -_outward_mps(nav, north_m, east_m)
        return left_m <= max(0.5 * self._parameters["NAV_ACC_RAD"], self._coasting.way_m(max(0.0, towards_mps)))

    def _see_drift(self, nav: NavState, dt_s: float) -> None:
        """Over ground, while nothing drives the boat and it does not coast any more."""
        if self._returning or math.hypot(nav.north_mps, nav.east_mps) > _SLOW_MPS:
            return
        share = dt_s / (dt_s + _DRIFT_TAU_S)
        north, east = self._drift
        self._drift = north + share * (nav.north_mps - north), east + share * (nav.east_mps - east)


def _outward_mps(nav: NavState, north_m: float, east_m: float) -> float:
    """Speed over ground away from what lies at (north_m, east_m) from the boat."""
    distance_m = math.hypot(north_m, east_m)
    return -(nav.north_mps * north_m + nav.east_mps * east_m) / distance_m if distance_m > 0.0 else 0.0
