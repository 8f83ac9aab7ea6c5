"""Holding near a point with a boat that has neither sideways thrust nor reverse: it drifts, and sails back upstream."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.core.actuation import ZERO_WRENCH
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.readings import ManualInput
from companion.core.setpoint import PathSetpoint, Point, Progress, Setpoint, WrenchSetpoint
from companion.fence.guard import FenceGuard
from companion.guidance.coasting import Coasting
from companion.guidance.stopping import SMOOTHING_S, stopping_point
from companion.params.store import Parameters
from companion.positioning.stop import Stop

_OUT_SHARE = 0.75  # of the watch circle: the boat turns back when it would drift past this within _WARNING_S
_WARNING_S = 4.0  # to start the impeller and turn
_ABOVE_SHARE = 0.45  # of the watch circle: how far upstream of the hold point the boat sails back to
_LEAST_CIRCLE_SHARE = 0.3  # of the watch circle: a boat that turns back sooner would never drift
_DRIFT_TAU_S = 8.0
_SLOW_MPS = 1.5  # a faster boat is still coasting, so its motion is not drift
_LEAST_DRIFT_MPS = 0.05
_STEERAGE_SHARE = 0.5  # of the speed, kept while the bow points elsewhere: a jet steers by its thrust
_LONGEST_RETURN_S = 90.0  # after which it aims anew
_LEAST_TABLE_MPS, _MOST_TABLE_MPS = 10.0, 30.0  # of the table of the ways that it coasts
_ROUND_COS = 0.5  # of the angle from the bow to the aim: with it a boat that turns back at once has come round


class DriftKeeper:
    """A `Keeper`. Inside the watch circle the boat drifts without thrust. Before it drifts out, it sails to a point
    upstream of the hold point, bow into the drift. It stops the impeller early enough to come to rest there, and drifts
    again. Under way, it first coasts, and holds where it will have coasted to. Where that is too near to a fence for
    its watch circle, it turns back at once, to a place further inside; one that has then come round short of it holds
    where it coasts to. In a fence without room for that circle it drifts no further than to the line, but 0.3 of that
    circle in any case.

    Remembers the hold point, whether the boat is stopping, turning back at once, or sailing back and since when, and
    the measured drift over ground.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, fence: FenceGuard | None = None) -> None:
        """`fence`: the boat holds so far inside that its watch circle is."""
        self._parameters = parameters
        self._fence = fence
        fastest_mps = min(_MOST_TABLE_MPS, max(_LEAST_TABLE_MPS, top_speed_mps(config)))
        self._coasting = Coasting(config.hull, fastest_mps)
        self._point = self._aim = (0.0, 0.0)
        self._heading_rad = 0.0
        self._returning = self._arrived = self._turning = False
        self._returning_s = 0.0
        self._drift = (0.0, 0.0)
        self._stop = Stop(_SLOW_MPS)

    @property
    def arrived(self) -> bool:
        """Whether the boat has drifted, or come to rest upstream, since the point was set."""
        return self._arrived

    @property
    def target(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad): the hold point and the last heading steered."""
        return (*self._point, self._heading_rad)

    @property
    def aim(self) -> tuple[float, float]:
        """(north_m, east_m) that it sails to on its way back."""
        return self._aim

    def start(self, nav: NavState, fitted: NavState | None = None) -> None:
        """Coast, and hold the point where the boat is slow."""
        rest = self._rest(nav, fitted)
        self._point = rest if self._fence is None else self._fence.held_place(rest)
        self._stop.begin(nav, self._point)
        self._heading_rad = nav.yaw_rad
        self._returning = self._arrived = self._turning = False
        if self._point != rest:  # nothing but a turn stops it: back, until the bow has come round
            self._stop.end()
            self._turn_back()
            self._turning = True
            self._aim = 2.0 * nav.north_m - rest[0], 2.0 * nav.east_m - rest[1]

    def hold(
        self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None, hurries: bool = False
    ) -> None:
        """Hold another point. Heading, speed and hurry are ignored: this boat cannot hold a heading."""
        self._point = (north_m, east_m)
        self._stop.end()
        self._arrived = self._returning = self._turning = False

    def update(self, nav: NavState, stick: ManualInput | None, speed_mps: float, dt_s: float) -> Setpoint:
        """Zero thrust while drifting, else a path setpoint for the way back at `speed_mps` at most."""
        self._see_drift(nav, dt_s)
        if self._stop.lasts and (place := self._stop.place(nav)) is not None:
            self._point = self._coasted(nav, place)
        north_m, east_m = self._point[0] - nav.north_m, self._point[1] - nav.east_m
        distance_m = math.hypot(north_m, east_m)
        if self._stop.lasts:
            return self._drifts(distance_m)
        if self._turning and self._has_come_round(nav):
            self._end_turn(nav, behind=_outward_mps(nav, north_m, east_m) > 0.0)
        if self._returning:
            self._returning_s += dt_s
            self._returning = not self._will_rest_there(nav)
            if self._returning_s > _LONGEST_RETURN_S:
                self._turn_back()
        elif distance_m + _WARNING_S * _outward_mps(nav, north_m, east_m) > _OUT_SHARE * self._circle_m():
            self._turn_back()
        self._arrived = self._arrived or not self._returning
        if not self._returning:
            return self._drifts(distance_m)
        self._heading_rad = math.atan2(self._aim[1] - nav.east_m, self._aim[0] - nav.north_m)
        fastest = min(speed_mps, self._parameters["DP_SPEED_AHEAD"])
        surge_mps = fastest * max(_STEERAGE_SHARE, math.cos(wrap_pi(self._heading_rad - nav.yaw_rad)))
        return PathSetpoint(self._heading_rad, surge_mps, progress=self._progress(distance_m))

    def _rest(self, nav: NavState, fitted: NavState | None) -> tuple[float, float]:
        """Where the boat will have coasted to, or where the reference of a stop does. `fitted`: see `start`; it counts
        where the boat cannot coast straight ahead to rest."""
        speed_mps = math.hypot(nav.north_mps, nav.east_mps)
        planned = stopping_point(nav, self._parameters)
        way_m = min(
            math.dist(planned, (nav.north_m, nav.east_m)), SMOOTHING_S * speed_mps + self._coasting.way_m(speed_mps)
        )
        course_rad = math.atan2(nav.east_mps, nav.north_mps)
        if (
            fitted is not None
            and self._fence is not None
            and way_m > self._fence.room_m((nav.north_m, nav.east_m), course_rad)
        ):
            return stopping_point(fitted, self._parameters)
        return nav.north_m + way_m * math.cos(course_rad), nav.east_m + way_m * math.sin(course_rad)

    def _coasted(self, nav: NavState, place: tuple[float, float]) -> tuple[float, float]:
        """Where a boat that is slow at `place` will come to rest: no way back has to bring it there. The place itself
        where that is beyond the planned one, or too near to a fence."""
        if place != (nav.north_m, nav.east_m):
            return place
        speed_mps = math.hypot(nav.north_mps, nav.east_mps)
        share_s = self._coasting.way_m(speed_mps) / max(_LEAST_DRIFT_MPS, speed_mps)
        rest = nav.north_m + share_s * nav.north_mps, nav.east_m + share_s * nav.east_mps
        return rest if self._fence is None or self._fence.held_place(rest) == rest else place

    def _circle_m(self) -> float:
        """Radius about the hold point in which it drifts: the watch circle, or the room that a fence leaves."""
        watch_m = self._parameters["DP_WATCH_R"]
        room_m = math.inf if self._fence is None else self._fence.room_about_m(self._point)
        return min(watch_m, max(_LEAST_CIRCLE_SHARE * watch_m, room_m))

    def _drifts(self, distance_m: float) -> WrenchSetpoint:
        return WrenchSetpoint(ZERO_WRENCH, replace(self._progress(distance_m), yaw_rad=self._heading_rad))

    def _progress(self, distance_m: float) -> Progress:
        point = Point(*self._point)
        return Progress(place=point, target=point, distance_to_go_m=distance_m)

    def _has_come_round(self, nav: NavState) -> bool:
        """Whether a boat that turned back at once has its bow towards its aim."""
        bearing = math.atan2(self._aim[1] - nav.east_m, self._aim[0] - nav.north_m)
        return math.cos(wrap_pi(bearing - nav.yaw_rad)) > _ROUND_COS

    def _end_turn(self, nav: NavState, behind: bool) -> None:
        """The bow has come round. `behind`: the hold point lies there; the boat holds where it coasts to."""
        if behind:
            self._point = self._coasted(nav, (nav.north_m, nav.east_m))
        self._turn_back()

    def _turn_back(self) -> None:
        """Aim at a point upstream of the hold point; at the hold point itself where there is no drift."""
        drift_mps = math.hypot(*self._drift)
        above_m = 0.0
        if drift_mps >= _LEAST_DRIFT_MPS:
            above_m = _ABOVE_SHARE * self._circle_m() / drift_mps
        self._aim = self._point[0] - above_m * self._drift[0], self._point[1] - above_m * self._drift[1]
        self._returning, self._returning_s, self._turning = True, 0.0, False

    def _will_rest_there(self, nav: NavState) -> bool:
        """Whether the boat would coast as far as the aim. A boat that does not move towards it has still to turn."""
        north_m, east_m = self._aim[0] - nav.north_m, self._aim[1] - nav.east_m
        left_m = math.hypot(north_m, east_m)
        towards_mps = -_outward_mps(nav, north_m, east_m)
        return left_m <= max(0.5 * self._parameters["NAV_ACC_RAD"], self._coasting.way_m(max(0.0, towards_mps)))

    def _see_drift(self, nav: NavState, dt_s: float) -> None:
        """Measure the drift over ground, while the boat neither pushes nor coasts."""
        if self._returning or math.hypot(nav.north_mps, nav.east_mps) > _SLOW_MPS:
            return
        share = dt_s / (dt_s + _DRIFT_TAU_S)
        north, east = self._drift
        self._drift = north + share * (nav.north_mps - north), east + share * (nav.east_mps - east)


def _outward_mps(nav: NavState, north_m: float, east_m: float) -> float:
    """Speed over ground away from a point at (north_m, east_m) from the boat."""
    distance_m = math.hypot(north_m, east_m)
    return -(nav.north_mps * north_m + nav.east_mps * east_m) / distance_m if distance_m > 0.0 else 0.0
