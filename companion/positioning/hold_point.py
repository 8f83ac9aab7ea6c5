"""Going to a point and holding it, shared by Hold, RTL, Dock, Offboard and the mission's stops."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

from companion.baselines.path_choice import ChosenPathTracker
from companion.baselines.reference_choice import ChosenReference
from companion.config.reversing import can_reverse, turns_on_the_spot
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.control.manual import beyond_deadband
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import body_to_ned
from companion.core.readings import ManualInput
from companion.core.setpoint import PathSetpoint, Point, Progress, Setpoint
from companion.fence.allowed import Way
from companion.fence.guard import FenceGuard
from companion.guidance.path_laying import FromBoat, LaidTrack, TrackShape
from companion.guidance.stopping import BRAKE_SHARE, SMOOTHING_S, stopping_point
from companion.guidance.turning import turning_of
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from companion.positioning.bow_keeper import BowKeeper
from companion.positioning.drift import DriftKeeper
from companion.positioning.sail_keeper import SailKeeper

_HURRIES_SHARE = 0.95  # of the speed: a boat that must be slower to stop inside brakes first, else by the feedback
_REST_SHARE = 0.5  # of DP_SPEED_AHEAD: so slow, the reference takes over from braking
# Lengths by which a reference leads its boat: from the first on it goes slower, at the second at its slowest. A boat
# shorter than a position is sure counts as that long.
_LEADS, _LEADS_MOST, _SLOWEST = 0.03, 0.09, 0.3
_LEAST_LENGTH_M = 2.0
_BEYOND_LENGTHS = 2.0  # that a reference may lead a boat beyond the end of its way
_GOES_MPS = 0.005  # a slower reference has no direction
_BESIDE_M = 15.0  # from a point in an obstacle: the boat goes so near instead


class Keeper(Protocol):
    """Keeps the boat at a point, as well as its thrusters allow."""

    @property
    def arrived(self) -> bool:
        """Whether the keeper has reached its point, as far as its reference goes."""
        ...

    @property
    def target(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad) that is held or led to."""
        ...

    def start(self, nav: NavState, fitted: NavState | None = None) -> None:
        """Begin from the boat's present motion and come to rest. `fitted`: the same, no faster than the boat can stop
        inside its fence as gently as a reference does; None where it can."""
        ...

    def hold(
        self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None, hurries: bool = False
    ) -> None:
        """Hold another pose, reached at `speed_mps` at most (None: at the keeper's own limits). `hurries`: turn to it
        faster than usual."""
        ...

    def update(self, nav: NavState, stick: ManualInput | None, speed_mps: float, dt_s: float) -> Setpoint:
        """One step. `stick`: the operator's sticks, None where they do not count."""
        ...


class PoseKeeper:
    """A `Keeper` for a boat with sideways thrust: dynamic positioning, with position and heading from the reference
    generator. Deflected sticks move the held pose, inside the fence.

    Started faster than positioning moves the boat, it first brakes with all its thrust astern, on its heading: the
    reference would brake as gently as it speeds up. At the end of a way it does so as well, where the reference would
    lead it far beyond (`come_to`). Sideways the reference begins no faster than positioning moves the
    boat: a light boat that weather had carried off would be led on with it, by tens of lengths.

    Where wind and current leave the thrusters too little to keep up with it, the reference goes slower."""

    def __init__(self, parameters: Parameters, length_m: float, fence: FenceGuard | None = None) -> None:
        self._parameters = parameters
        self._length_m = max(_LEAST_LENGTH_M, length_m)
        self._fence = fence
        self._reference = ChosenReference(parameters)
        self._pose = (0.0, 0.0, 0.0)  # of the reference
        self._velocity = (0.0, 0.0)  # of the reference (north, east)
        self._from = self._planned = (0.0, 0.0)  # of the stop: where it began, and the last place to come to rest
        self._hurries = False  # a fence is too near for the stop
        self._braking: NavState | None = None  # the last state while the boat brakes
        self._brakes_rad = 0.0  # the heading meanwhile
        self._comes = False  # to its target, after the braking

    @property
    def arrived(self) -> bool:
        """Whether the reference is at its target."""
        return self._braking is None and self._reference.arrived

    @property
    def target(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad) that the reference leads to."""
        return self._reference.target

    def start(self, nav: NavState, fitted: NavState | None = None) -> None:
        """Begin from the boat's present motion and come to rest on the shortest way, with the present heading. Where
        the fence asks for the stop, the boat then holds with FENCE_MARGIN to spare: waves move it to and fro."""
        begun = fitted or nav
        self._hurries = fitted is not None and abs(fitted.surge_mps) < _HURRIES_SHARE * abs(nav.surge_mps)
        self._from, self._planned = (nav.north_m, nav.east_m), stopping_point(self._led(begun), self._parameters)
        by_fence = None if self._fence is None or self._fence.cause is None else self._fence
        # the fence asks for a stop where the reference still comes to rest inside
        self._braking = nav if self._is_fast(nav) and (by_fence is None or self._hurries) else None
        self._brakes_rad, self._comes = nav.yaw_rad, False
        self._begin(begun, self._planned if by_fence is None else by_fence.held_place(self._planned), nav.yaw_rad)

    def _led(self, nav: NavState) -> NavState:
        """With the sideways speed that the reference begins with."""
        most_mps = self._parameters["DP_SPEED_SWAY"]
        return nav if abs(nav.sway_mps) <= most_mps else replace(nav, sway_mps=math.copysign(most_mps, nav.sway_mps))

    def _is_fast(self, nav: NavState) -> bool:
        """Whether it moves faster than positioning moves it."""
        return abs(nav.surge_mps) > self._parameters["DP_SPEED_AHEAD"]

    def _begin(self, nav: NavState, place: tuple[float, float], yaw_rad: float) -> None:
        """Lead the reference from the boat's motion to a place."""
        nav = self._led(nav)
        self._pose, self._velocity = (nav.north_m, nav.east_m, nav.yaw_rad), (0.0, 0.0)
        self._reference.start(*self._pose, nav.surge_mps, nav.sway_mps, nav.yaw_rate_radps)
        self._reference.retarget(*place, yaw_rad)

    def hold(
        self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None, hurries: bool = False
    ) -> None:
        """Lead the reference to another pose."""
        if self._braking is not None:
            self._begin(self._braking, (north_m, east_m), yaw_rad)
        self._braking, self._comes = None, False
        self._reference.retarget(north_m, east_m, yaw_rad, speed_mps, hurries)

    def come_to(self, north_m: float, east_m: float, yaw_rad: float) -> None:
        """`hold` at the end of a way, right after `start`: a boat that the reference would lead far beyond brakes until
        that comes to rest in time."""
        before = self._braking
        self.hold(north_m, east_m, yaw_rad, None)
        if before is not None and self._goes_beyond_m(before) > _BEYOND_LENGTHS * self._length_m:
            self._braking, self._comes = before, True

    def _goes_beyond_m(self, nav: NavState) -> float:
        """How far beyond its target the reference would lead the boat."""
        north_m, east_m, _ = self.target
        left_m = math.hypot(north_m - nav.north_m, east_m - nav.east_m)
        return _way_to_rest(abs(nav.surge_mps), self._parameters["DP_ACC_SURGE"]) - left_m

    def update(self, nav: NavState, stick: ManualInput | None, speed_mps: float, dt_s: float) -> Setpoint:
        """The reference `dt_s` later, or a path setpoint at rest while the boat brakes; `speed_mps` is not used."""
        if self._braking is not None:
            self._braking = nav
            self._see_rest(nav)
        if self._braking is not None:
            return PathSetpoint(self._brakes_rad, 0.0, progress=self._progress(nav))
        if stick is not None:
            self._nudge(stick)
        setpoint = self._reference.update(dt_s, self._pace(nav))
        self._pose = (setpoint.north_m, setpoint.east_m, setpoint.yaw_rad)
        self._velocity = body_to_ned(setpoint.surge_mps, setpoint.sway_mps, setpoint.yaw_rad)
        return setpoint

    def _pace(self, nav: NavState) -> float:
        """Share of the reference's speeds that the boat keeps up with, by how far it lies behind."""
        speed_mps = math.hypot(*self._velocity)
        if speed_mps < _GOES_MPS:
            return 1.0
        north_m, east_m = self._pose[0] - nav.north_m, self._pose[1] - nav.east_m
        leads_m = (north_m * self._velocity[0] + east_m * self._velocity[1]) / speed_mps
        too_far = (leads_m / self._length_m - _LEADS) / (_LEADS_MOST - _LEADS)
        return max(_SLOWEST, 1.0 - max(0.0, too_far))

    def _see_rest(self, nav: NavState) -> None:
        """End the braking where the boat is slow, or beyond the place planned; a fence may lie behind that. Where a
        fence was too near for the stop, only a boat that is no longer fast ends it there."""
        slow = abs(nav.surge_mps) <= _REST_SHARE * self._parameters["DP_SPEED_AHEAD"]
        if self._comes:
            if slow or self._goes_beyond_m(nav) <= 0.0:
                self._braking = nav
                self.hold(*self.target, None)
            return
        planned_m = math.dist(self._planned, self._from)
        past = math.dist((nav.north_m, nav.east_m), self._from) >= planned_m
        if not slow and (not past or (self._hurries and self._is_fast(nav))):
            return
        self._braking = None
        begun = replace(nav, surge_mps=0.0, sway_mps=0.0) if past else nav  # from there it leads back
        near = stopping_point(begun, self._parameters)
        self._begin(begun, near if math.dist(near, self._from) <= planned_m else self._planned, self.target[2])

    def _progress(self, nav: NavState) -> Progress:
        north_m, east_m, _ = self.target
        place = Point(north_m, east_m)
        left_m = math.hypot(north_m - nav.north_m, east_m - nav.east_m)
        return Progress(place=place, target=place, distance_to_go_m=left_m)

    def _nudge(self, stick: ManualInput) -> None:
        """Put the target so far ahead that the reference moves at the stick's speed. When the stick is released, the
        reference comes to rest there."""
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
    """Distance (or angle) that the reference covers from `speed` to rest, smoothing included; signed as `speed`."""
    return speed * (abs(speed) / (2.0 * BRAKE_SHARE * acceleration) + SMOOTHING_S)


@dataclass(frozen=True, slots=True)
class WayLaying:
    """Lays the track along a way, for `HoldPoint.go_along`. It never changes, so that can be done beside the control
    thread. `transit_m`: to a point so near the boat does not sail along a track."""

    shape: TrackShape
    transit_m: float

    def lay(self, way: Way) -> LaidTrack | None:
        """The track along a way from its begin; None where it needs none."""
        if len(way.points) == 2 and math.dist(*way.points) <= self.transit_m:
            return None
        return self.shape.lay(FromBoat(way.points[0]), _waypoints_of(way), (), True)


def _waypoints_of(way: Way) -> list[Waypoint]:
    if len(way.points) == 2:
        return [Waypoint(*way.points[1])]
    return [Waypoint(*point, radius_m=way.radius_m, straight=True) for point in way.points[1:]]


class _Transit(NamedTuple):
    """A point that is sailed to bow first. `yaw_rad` None: the heading of arrival. `speed_mps` None: the speed that
    `update` is given."""

    north_m: float
    east_m: float
    yaw_rad: float | None
    speed_mps: float | None

    def distance_m(self, nav: NavState) -> float:
        """Straight from the boat."""
        return math.hypot(self.north_m - nav.north_m, self.east_m - nav.east_m)


class HoldPoint:
    """`stop_here`, `go_to` or `go_along`, then `update` every tick → Setpoint.

    Within DP_TRANSIT_DIST the keeper moves the boat to the point in any direction. A point further off is sailed to bow
    first along a straight line (transit); the keeper takes over a boat's length before it.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, fence: FenceGuard | None = None) -> None:
        """`fence`: stops and motion by stick stay inside it. The caller checks points and ways."""
        self._parameters = parameters
        self._fence = fence
        self._can_sway = config.limits.sway_n > 0.0
        self._handover_m = config.length_m
        self._keepers = self._suitable_keepers(config, parameters, fence)
        self._keeper = self._keepers[0]
        self._path_tracker = ChosenPathTracker(
            parameters,
            self._can_sway,
            top_speed_mps(config),
            turning=turning_of(config, turns_on_the_spot(config.thrusters)),
            sails=config.has_sail,
        )
        self._way_m: float | None = None
        self._transit: _Transit | None = None
        self._bends = 0  # number of them on the way in transit
        self._going = False

    @staticmethod
    def _suitable_keepers(
        config: VesselConfig, parameters: Parameters, fence: FenceGuard | None
    ) -> tuple[Keeper, Keeper]:
        """The keeper for each value of DP_UNDER, as far as the boat has a choice."""
        if config.limits.sway_n > 0.0:
            keeper = PoseKeeper(parameters, config.length_m, fence)
            return keeper, keeper
        if config.has_sail:
            sailing = SailKeeper(config, parameters)
            return sailing, sailing
        drifting = DriftKeeper(config, parameters, fence)
        return (BowKeeper(config, parameters, fence) if can_reverse(config.thrusters) else drifting), drifting

    @property
    def going(self) -> bool:
        """Whether the boat is still on its way to a point that was asked for."""
        return self._going

    @property
    def in_transit(self) -> bool:
        """Whether the boat sails bow first to a point further off."""
        return self._transit is not None

    @property
    def way_m(self) -> float | None:
        """Progress in m: grows as the boat nears the point asked for. None where it cannot be measured: the boat is
        there, or is led by a reference that is still on its way."""
        return self._way_m

    @property
    def arrived(self) -> bool:
        """Whether the point is reached, as far as the reference goes."""
        return self._transit is None and self._keeper.arrived

    @property
    def target(self) -> tuple[float, float]:
        """(north_m, east_m) that is held or on the way to."""
        return (self._transit.north_m, self._transit.east_m) if self._transit is not None else self._keeper.target[:2]

    @property
    def held(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad) that the keeper holds or leads to; meaningless in transit."""
        return self._keeper.target

    @property
    def way_ahead(self) -> list[tuple[float, float]]:
        """The path in transit, from the boat's place on it; empty otherwise."""
        return [] if self._transit is None else [point for leg in self._path_tracker.legs for point in leg]

    def way_speed_mps(self, speed_mps: float) -> float:
        """Speed in transit: the one given to `go_to`, else `speed_mps`."""
        asked_mps = None if self._transit is None else self._transit.speed_mps
        return speed_mps if asked_mps is None else asked_mps

    def stop_here(self, nav: NavState) -> None:
        """Come to rest on the shortest way and hold there, with the present heading."""
        self._start_keeper(nav)
        self._transit = None
        self._going = False

    def go_to(
        self,
        nav: NavState,
        north_m: float,
        east_m: float,
        yaw_rad: float | None,
        speed_mps: float | None,
        fresh: bool = True,
        sideways: bool = False,
    ) -> None:
        """Go to a point from the present motion. `yaw_rad` None: the heading held, or that of arrival. `fresh` False:
        the reference goes on instead of restarting at the boat. `sideways`: by dynamic positioning at any distance,
        where the boat has sideways thrust.
        """
        self._going = True
        if (
            not (sideways and self._can_sway)
            and math.hypot(north_m - nav.north_m, east_m - nav.east_m) > self._parameters["DP_TRANSIT_DIST"]
        ):
            lay = self._path_tracker.start if fresh or self._transit is None else self._path_tracker.replace
            self._transit = _Transit(north_m, east_m, yaw_rad, speed_mps)
            self._bends = 0
            lay((Waypoint(north_m, east_m, speed_mps=speed_mps),), nav)
            return
        if fresh or self._transit is not None:
            self._start_keeper(nav)
        self._transit = None
        self._keeper.hold(north_m, east_m, self._keeper.target[2] if yaw_rad is None else yaw_rad, speed_mps)

    def laying(self) -> WayLaying | None:
        """What lays tracks for `go_along` now; None where the law of the thesis sails, which lays its own."""
        if not self._path_tracker.is_own:
            return None
        return WayLaying(self._path_tracker.shape(), self._parameters["DP_TRANSIT_DIST"])

    def go_along(self, nav: NavState, way: Way, laid: LaidTrack | None = None) -> None:
        """Go from the present motion along a way that begins here, to its end. `laid`: its track, where there is one
        already."""
        if len(way.points) == 2 and (laid is None or not self._path_tracker.is_own):
            self.go_to(nav, *way.points[1], None, None)
            return
        self._going = True
        self._transit = _Transit(*way.points[-1], None, None)
        self._bends = len(way.points) - 2
        if laid is None or not self._path_tracker.is_own:
            self._path_tracker.start(_waypoints_of(way), nav)
        else:
            self._path_tracker.take(laid, nav)

    def go_round(self, nav: NavState, way: Way | None) -> str | None:
        """In transit: go on along another way to the same point, or to the nearest place beside it; None: there is no
        such way. Return why that is impossible, or None."""
        transit = self._transit
        if transit is None:
            return "not under way"
        end = (transit.north_m, transit.east_m)
        if way is None:
            return "no open water to the point"
        if math.dist(way.points[-1], end) > _BESIDE_M:
            return "the point lies in an obstacle"
        self.go_along(nav, way)
        if self._transit is not None:
            self._transit = self._transit._replace(yaw_rad=transit.yaw_rad, speed_mps=transit.speed_mps)
        return None

    def _start_keeper(self, nav: NavState) -> None:
        self._keeper = self._keepers[int(self._parameters["DP_UNDER"])]
        fitted = nav if self._fence is None else self._fence.slowed(nav)
        self._keeper.start(nav, None if fitted == nav else fitted)

    def drop_speed(self) -> None:
        """Forget the speed given to `go_to`: go on at the speed that `update` is given."""
        if self._transit is not None:
            self._transit = self._transit._replace(speed_mps=None)

    def shift(self, north_m: float, east_m: float, yaw_rad: float) -> None:
        """Hold another pose, from the reference's present motion. Not in transit."""
        self._keeper.hold(north_m, east_m, yaw_rad, None)

    def turn_to(self, yaw_rad: float, hurries: bool = False) -> None:
        """Hold another heading at the same point. `hurries`: turn faster than DP_YAW_RATE."""
        north_m, east_m, _ = self._keeper.target
        self._keeper.hold(north_m, east_m, yaw_rad, None, hurries)

    def rejoin(self, nav: NavState) -> None:
        """Go back to the same point from the present motion."""
        if self._transit is not None:
            self.go_to(nav, *self._transit)
            return
        going = self._going
        north_m, east_m, held_rad = self._keeper.target
        self.go_to(nav, north_m, east_m, held_rad, None)
        self._going = going

    def update(self, nav: NavState, stick: ManualInput | None, speed_mps: float, dt_s: float) -> Setpoint:
        """One step. `stick`: moves the held pose once the boat is there. `speed_mps`: in transit, where `go_to` gave
        none."""
        transit = self._transit
        if transit is not None:
            progress = self._path_tracker.update(nav, self.way_speed_mps(speed_mps), dt_s)
            near = progress.passed >= self._bends and transit.distance_m(nav) <= self._handover_m
            if not progress.finished and not near:
                self._way_m = progress.way_m
                return progress.setpoint
            self._transit = None
            self._start_keeper(nav)
            yaw_rad = nav.yaw_rad if transit.yaw_rad is None else transit.yaw_rad
            if isinstance(self._keeper, PoseKeeper):
                self._keeper.come_to(transit.north_m, transit.east_m, yaw_rad)
            else:
                self._keeper.hold(transit.north_m, transit.east_m, yaw_rad, None)
        setpoint = self._keeper.update(nav, None if self._going else stick, speed_mps, dt_s)
        self._going = self._going and not (self._keeper.arrived and self._is_there(nav))
        north_m, east_m, _ = self._keeper.target
        # with sideways thrust the reference leads there; without, a boat inside its watch circle may lie as it likes
        led = not self._keeper.arrived if self._can_sway else self._is_there(nav)
        self._way_m = -math.hypot(north_m - nav.north_m, east_m - nav.east_m) if self._going and not led else None
        return setpoint

    def _is_there(self, nav: NavState) -> bool:
        """Whether the boat itself is at the point: wind may have kept it from following its reference."""
        north_m, east_m, _ = self._keeper.target
        off_m = math.hypot(north_m - nav.north_m, east_m - nav.east_m)
        return off_m <= max(self._parameters["NAV_ACC_RAD"], 0.0 if self._can_sway else self._parameters["DP_WATCH_R"])
