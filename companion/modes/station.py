"""Going to a point and staying there, shared by Hold, RTL and the mission's stops."""

from __future__ import annotations

import math
from typing import Protocol

from companion.config import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.frames import body_to_ned
from companion.core.types import ManualInput, NavState, Setpoint, SetpointKind
from companion.guidance.crab import top_speed_mps
from companion.guidance.follower_choice import ChosenFollower
from companion.guidance.path_following import Waypoint
from companion.guidance.reference_choice import ChosenReference
from companion.guidance.stopping import BRAKE_SHARE, SMOOTHING_S, stopping_point
from companion.modes.drift import DriftKeeper
from companion.modes.fence_guard import FenceGuard, Way
from companion.modes.propulsion import can_reverse
from companion.modes.sticks import beyond_deadband
from companion.params import Parameters

_LEEWAY = 0.03  # share of the wind's speed at which wind alone moves a small boat
_LEAST_DRIFT_MPS = 0.05
_STEERAGE_SHARE = 0.3  # of the speed, kept while the bow points elsewhere: a jet steers by its thrust
_RETURN_RATE_1PS = 0.25


class Keeper(Protocol):
    """Stays at a point."""

    @property
    def arrived(self) -> bool: ...

    @property
    def target(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad) held or on the way to."""
        ...

    def start(self, nav: NavState) -> None:
        """Begin from the boat's present motion, to rest."""
        ...

    def hold(self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None) -> None: ...

    def update(self, nav: NavState, stick: ManualInput | None, speed_mps: float, dt_s: float) -> Setpoint: ...


class PoseKeeper:
    """Dynamic positioning: position and heading by the reference generator. A deflected stick pushes the held pose along, inside the fence."""

    def __init__(self, parameters: Parameters, fence: FenceGuard | None = None) -> None:
        self._parameters = parameters
        self._fence = fence
        self._reference = ChosenReference(parameters)
        self._pose = (0.0, 0.0, 0.0)  # of the reference

    @property
    def arrived(self) -> bool:
        return self._reference.arrived

    @property
    def target(self) -> tuple[float, float, float]:
        return self._reference.target

    def start(self, nav: NavState) -> None:
        self._pose = (nav.north_m, nav.east_m, nav.yaw_rad)
        self._reference.start(*self._pose, nav.surge_mps, nav.sway_mps, nav.yaw_rate_radps)
        self._reference.retarget(*stopping_point(nav, self._parameters), nav.yaw_rad)

    def hold(self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None) -> None:
        self._reference.retarget(north_m, east_m, yaw_rad, speed_mps)

    def update(self, nav: NavState, stick: ManualInput | None, speed_mps: float, dt_s: float) -> Setpoint:
        if stick is not None:
            self._nudge(stick)
        setpoint = self._reference.update(dt_s)
        if setpoint.north_m is not None and setpoint.east_m is not None and setpoint.yaw_rad is not None:
            self._pose = (setpoint.north_m, setpoint.east_m, setpoint.yaw_rad)
        return setpoint

    def _nudge(self, stick: ManualInput) -> None:
        """Put the target so far ahead of the reference that it runs at the stick's speed; let go, it comes to rest there."""
        parameters = self._parameters
        deadband = parameters["MAN_DEADBAND"]
        surge, sway, yaw = (beyond_deadband(axis, deadband) for axis in (stick.surge, stick.sway, stick.yaw))
        if surge == sway == yaw == 0.0:
            return
        ahead = parameters["DP_SPEED_AHEAD"] if surge > 0.0 else parameters["DP_SPEED_ASTERN"]
        x = _way_to_rest(surge * ahead, parameters["DP_ACC_SURGE"])
        y = _way_to_rest(sway * parameters["DP_SPEED_SWAY"], parameters["DP_ACC_SWAY"])
        turn_radps = yaw * math.radians(min(parameters["MAN_YAW_RATE"], parameters["DP_YAW_RATE"]))
        turn = _way_to_rest(turn_radps, math.radians(parameters["DP_ACC_YAW"]))
        north, east, heading = self._pose
        north_m, east_m = body_to_ned(x, y, heading)
        held_north, held_east, held_yaw = self._reference.target
        moved = surge != 0.0 or sway != 0.0
        if moved and self._fence is not None:
            moved = self._fence.may_move_to((north, east), (north + north_m, east + east_m))
        self._reference.retarget(
            north + north_m if moved else held_north,
            east + east_m if moved else held_east,
            wrap_pi(heading + min(3.0, max(-3.0, turn))) if turn != 0.0 else held_yaw,
        )


def _way_to_rest(speed: float, acceleration: float) -> float:
    """What the reference covers from `speed` to rest, with the lag of its smoothing; signed as `speed`."""
    return speed * (abs(speed) / (2.0 * BRAKE_SHARE * acceleration) + SMOOTHING_S)


class CircleKeeper:
    """For a boat without sideways thrust: inside the watch circle lie bow into the resultant of wind and current, outside it sail back.

    It holds no heading and no exact point: with the bow into the stream, ahead and astern thrust keep the place along the bow only.
    Remembers the point, whether it is on the way back, and the heading to lie at. The resultant is a drift: the current, and 3 % of the wind.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._point = (0.0, 0.0)
        self._lie_rad = 0.0
        self._returning = False
        self._arrived = False

    @property
    def arrived(self) -> bool:
        return self._arrived

    @property
    def target(self) -> tuple[float, float, float]:
        return (*self._point, self._lie_rad)

    def start(self, nav: NavState) -> None:
        self._point = stopping_point(nav, self._parameters)
        self._lie_rad = nav.yaw_rad
        self._returning = False
        self._arrived = False

    def hold(self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None) -> None:
        self._point = (north_m, east_m)
        self._arrived = False

    def update(self, nav: NavState, stick: ManualInput | None, speed_mps: float, dt_s: float) -> Setpoint:
        north_m, east_m = self._point[0] - nav.north_m, self._point[1] - nav.east_m
        distance_m = math.hypot(north_m, east_m)
        circle_m = self._parameters["DP_WATCH_R"]
        if distance_m > 0.7 * circle_m:
            self._returning = True
        elif distance_m < 0.35 * circle_m:
            self._returning = False
        self._arrived = self._arrived or not self._returning
        if self._returning:
            self._lie_rad = math.atan2(east_m, north_m)
            fastest = min(speed_mps, self._parameters["DP_SPEED_AHEAD"], _RETURN_RATE_1PS * distance_m)
            surge_mps = fastest * max(_STEERAGE_SHARE, math.cos(wrap_pi(self._lie_rad - nav.yaw_rad)))
        else:
            self._lie_rad = self._upstream_rad(nav)
            along_m = north_m * math.cos(nav.yaw_rad) + east_m * math.sin(nav.yaw_rad)
            astern, ahead = self._parameters["DP_SPEED_ASTERN"], self._parameters["DP_SPEED_AHEAD"]
            surge_mps = min(ahead, max(-astern, _RETURN_RATE_1PS * along_m))
        return Setpoint(
            SetpointKind.PATH,
            north_m=self._point[0],
            east_m=self._point[1],
            yaw_rad=self._lie_rad,
            surge_mps=surge_mps,
            target_north_m=self._point[0],
            target_east_m=self._point[1],
            distance_to_go_m=distance_m,
        )

    def _upstream_rad(self, nav: NavState) -> float:
        """Against the drift; the heading held so far where too little of it is known."""
        north, east = nav.current_north_mps or 0.0, nav.current_east_mps or 0.0
        if nav.wind_speed_mps is not None and nav.wind_from_rad is not None:
            north -= _LEEWAY * nav.wind_speed_mps * math.cos(nav.wind_from_rad)
            east -= _LEEWAY * nav.wind_speed_mps * math.sin(nav.wind_from_rad)
        return math.atan2(-east, -north) if math.hypot(north, east) >= _LEAST_DRIFT_MPS else self._lie_rad


class Station:
    """`stop_here` or `go_to`, then `update` every tick → Setpoint.

    Points within DP_TRANSIT_DIST are taken in any direction by the keeper; further ones are sailed to bow first along a straight line
    and handed to the keeper a boat's length short of them.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, fence: FenceGuard | None = None) -> None:
        """`fence`: stops and pushes by stick are kept inside it; ways are the business of who asks for them."""
        self._parameters = parameters
        self._fence = fence
        self._can_sway = config.limits.sway_n > 0.0
        self._handover_m = config.length_m
        self._keeper = self._suitable_keeper(config, parameters, fence)
        self._follower = ChosenFollower(parameters, self._can_sway, top_speed_mps(config))
        self._way_m: float | None = None
        self._transit: tuple[float, float, float | None, float | None] | None = None  # north, east, yaw, speed
        self._bends = 0  # of the way in transit
        self._going = False

    @staticmethod
    def _suitable_keeper(config: VesselConfig, parameters: Parameters, fence: FenceGuard | None) -> Keeper:
        if config.limits.sway_n > 0.0:
            return PoseKeeper(parameters, fence)
        return CircleKeeper(parameters) if can_reverse(config.thrusters) else DriftKeeper(config, parameters)

    @property
    def going(self) -> bool:
        """On the way to a point that was asked for."""
        return self._going

    @property
    def in_transit(self) -> bool:
        """Sailing bow first to a point further off."""
        return self._transit is not None

    @property
    def way_m(self) -> float | None:
        """Grows as the boat comes nearer to the point that was asked for; None while nothing tells (it is there, or the reference is on its
        way)."""
        return self._way_m

    @property
    def arrived(self) -> bool:
        """The point is reached, as far as the reference goes."""
        return self._transit is None and self._keeper.arrived

    @property
    def target(self) -> tuple[float, float]:
        """(north_m, east_m) held or on the way to."""
        return self._transit[:2] if self._transit is not None else self._keeper.target[:2]

    @property
    def held(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad) that the keeper holds or leads to; of no meaning in transit."""
        return self._keeper.target

    @property
    def way_ahead(self) -> list[tuple[float, float]]:
        """The path in transit, from where the boat is on it; empty elsewhere."""
        return [] if self._transit is None else [point for leg in self._follower.legs for point in leg]

    def way_speed_mps(self, speed_mps: float) -> float:
        """At which it sails there: as `go_to` was told, else `speed_mps`."""
        asked_mps = None if self._transit is None else self._transit[3]
        return speed_mps if asked_mps is None else asked_mps

    def stop_here(self, nav: NavState) -> None:
        """Come to rest on the shortest way and stay, with the present heading."""
        self._start_keeper(nav)
        self._transit = None
        self._going = False

    def go_to(
        self, nav: NavState, north_m: float, east_m: float, yaw_rad: float | None, speed_mps: float | None, fresh: bool = True, sideways: bool = False
    ) -> None:
        """From the present motion to a point. `yaw_rad` None: the heading held, or that of arrival. `fresh` False: the reference goes on.
        `sideways`: by dynamic positioning however far it is, where the boat can.
        """
        self._going = True
        if not (sideways and self._can_sway) and math.hypot(north_m - nav.north_m, east_m - nav.east_m) > self._parameters["DP_TRANSIT_DIST"]:
            lay = self._follower.start if fresh or self._transit is None else self._follower.replace
            self._transit = (north_m, east_m, yaw_rad, speed_mps)
            self._bends = 0
            lay((Waypoint(north_m, east_m, speed_mps=speed_mps),), nav)
            return
        if fresh or self._transit is not None:
            self._start_keeper(nav)
        self._transit = None
        self._keeper.hold(north_m, east_m, self._keeper.target[2] if yaw_rad is None else yaw_rad, speed_mps)

    def go_along(self, nav: NavState, way: Way) -> None:
        """From the present motion along a way that begins here, to its end."""
        if len(way.points) == 2:
            self.go_to(nav, *way.points[1], None, None)
            return
        self._going = True
        self._transit = (*way.points[-1], None, None)
        self._bends = len(way.points) - 2
        self._follower.start([Waypoint(*point, radius_m=way.radius_m, straight=True) for point in way.points[1:]], nav)

    def _start_keeper(self, nav: NavState) -> None:
        self._keeper.start(nav if self._fence is None else self._fence.slowed(nav))

    def drop_speed(self) -> None:
        """Go on at the speed that `update` is given."""
        if self._transit is not None:
            self._transit = (*self._transit[:3], None)

    def shift(self, north_m: float, east_m: float, yaw_rad: float) -> None:
        """Another pose for the keeper, from its present motion; not in transit."""
        self._keeper.hold(north_m, east_m, yaw_rad, None)

    def turn_to(self, yaw_rad: float) -> None:
        """Another heading at the point held."""
        north_m, east_m, _ = self._keeper.target
        self._keeper.hold(north_m, east_m, yaw_rad, None)

    def rejoin(self, nav: NavState) -> None:
        """From the present motion back to the same point."""
        if self._transit is not None:
            north_m, east_m, yaw_rad, speed_mps = self._transit
            self.go_to(nav, north_m, east_m, yaw_rad, speed_mps)
            return
        going = self._going
        north_m, east_m, held_rad = self._keeper.target
        self.go_to(nav, north_m, east_m, held_rad, None)
        self._going = going

    def update(self, nav: NavState, stick: ManualInput | None, speed_mps: float, dt_s: float) -> Setpoint:
        """`stick`: deflection moves the held pose, once there; `speed_mps`: at which to sail, where `go_to` gave none."""
        if self._transit is not None:
            north_m, east_m, yaw_rad, asked_mps = self._transit
            progress = self._follower.update(nav, asked_mps if asked_mps is not None else speed_mps, dt_s)
            near = progress.passed >= self._bends and math.hypot(north_m - nav.north_m, east_m - nav.east_m) <= self._handover_m
            if not progress.finished and not near:
                self._way_m = progress.way_m
                return progress.setpoint
            self._transit = None
            self._start_keeper(nav)
            self._keeper.hold(north_m, east_m, nav.yaw_rad if yaw_rad is None else yaw_rad, None)
        setpoint = self._keeper.update(nav, None if self._going else stick, speed_mps, dt_s)
        self._going = self._going and not (self._keeper.arrived and self._is_there(nav))
        north_m, east_m, _ = self._keeper.target
        self._way_m = -math.hypot(north_m - nav.north_m, east_m - nav.east_m) if self._going and self._keeper.arrived else None
        return setpoint

    def _is_there(self, nav: NavState) -> bool:
        """The boat itself, and not only its reference: wind may have kept it from following."""
        north_m, east_m, _ = self._keeper.target
        off_m = math.hypot(north_m - nav.north_m, east_m - nav.east_m)
        return off_m <= max(self._parameters["NAV_ACC_RAD"], 0.0 if self._can_sway else self._parameters["DP_WATCH_R"])
