"""All that a mission's ways depend on, at one moment: where they lead, whether fence and chart allow that, and their
tracks. It never changes, so what takes long is done beside the control thread."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

from companion.baselines.waypoints import thesis_legs
from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState
from companion.core.geodesy import LocalFrame
from companion.core.work import Lane
from companion.fence.allowed import Place
from companion.guidance.orbit import Circle, chosen_circle, whole_line
from companion.guidance.path_laying import FromBoat, Joint, LaidTrack, TrackShape
from companion.guidance.sail_track import straight_legs
from companion.guidance.waypoint import Waypoint
from companion.mission.commands import Command
from companion.mission.plan import PlanItem, item_number
from companion.mission.tasks import Dock, Orbit, ReturnHome, RoutePoint, Sail, Task
from companion.modes.parts.berth import berth_at
from companion.modes.parts.return_point import Return
from companion.modes.parts.rounding import Rounded, rounded, unchanged
from companion.obstacles.charted_fence import Allowance
from companion.params.store import Parameters

# Before the start, the first route is checked by the smooth path and the rest by straight legs.
# Each path is checked again when it is laid.
_MOST_POINTS = 2_000
_PLACES = (Sail, ReturnHome, Dock, Orbit)  # tasks after which it does not matter where the boat was before


def orbit_circle(task: Orbit, frame: LocalFrame, parameters: Parameters) -> Circle:
    """The circle of a mission's orbit, in the local plane."""
    return chosen_circle(frame.to_ned(task.lat_deg, task.lon_deg), task.radius_m, task.clockwise, parameters)


def unfenced(items: Sequence[PlanItem]) -> frozenset[int]:
    """The items before which the mission has switched the fence off (DO_FENCE_ENABLE), in the order of the plan."""
    found, off = [], False
    for item in items:
        if item.command == Command.DO_FENCE_ENABLE and item.param1 <= 1.0:
            off = item.param1 == 0.0
        if off:
            found.append(item.seq)
    return frozenset(found)


@dataclass(frozen=True, slots=True)
class Route:
    """A route to sail: its waypoints and their items, and the first waypoints beyond it. `astern`: stern first."""

    waypoints: tuple[Waypoint, ...]
    seqs: tuple[int, ...]
    beyond: tuple[Waypoint, ...]
    stop: bool
    astern: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class LaidRoute:
    """A route led round fence and chart, its track (None where the law of the thesis sails, which lays its own), and
    which leg crosses the fence nevertheless, or None."""

    route: Route
    rounded: Rounded
    laid: LaidTrack | None
    refusal: str | None


@dataclass(frozen=True, slots=True, eq=False)
class MissionTerms:
    """`own_law`: False where the law of the thesis sails. `unfenced`: items before which the mission has switched the
    fence off: the ways to them are checked by the chart alone. `fenced`: there is a fence or a chart."""

    config: VesselConfig
    parameters: Parameters
    frame: LocalFrame
    allowance: Allowance
    unfenced: frozenset[int]
    returning: Return
    shape: TrackShape
    own_law: bool
    fenced: bool

    @property
    def rounds(self) -> bool:
        """Whether routes are led round."""
        return self.fenced and bool(self.parameters["MIS_ROUND"])

    def in_lane(self, lane: Lane) -> MissionTerms:
        """The same for another thread (`FenceArea.in_lane`)."""
        allowance, returning = self.allowance.in_lane(lane), self.returning.in_lane(lane)
        return replace(self, allowance=allowance, returning=returning)

    # --- a route to sail now ---------------------------------------------------------------------------------------

    def lay(self, route: Route, joint: Joint, nav: NavState) -> LaidRoute:
        """Lead a route round what it would cross, lay it, and check it. `joint`: how its track begins; `nav`: the boat
        there."""
        here = (nav.north_m, nav.east_m)
        found = self.rounded(route.waypoints, here)
        if self._sails:
            legs, laid = straight_legs(here, found.waypoints), None
        elif not self.own_law:
            legs, laid = thesis_legs(found.waypoints, nav, self.parameters), None
        else:
            laid = self.shape.lay(joint, found.waypoints, route.beyond, route.stop)
            legs = laid.legs(laid.begin_s_m)
        seqs = [route.seqs[found.own_index(i)] for i in range(len(found.waypoints))]
        return LaidRoute(route, found, laid, self.track_refusal(legs, seqs))

    def rounded(self, waypoints: Sequence[Waypoint], here: Place) -> Rounded:
        """The route from `here` with legs led round fence and chart, where MIS_ROUND asks for that and a way exists."""
        if not self.rounds:
            return unchanged(waypoints)
        found = rounded(waypoints, here, self.allowance.is_open, self.allowance.way, math.inf)
        return unchanged(waypoints) if isinstance(found, int) else found

    def track_refusal(self, legs: Sequence[Sequence[Place]], seqs: Iterable[int]) -> str | None:
        """Return which leg crosses the fence, or None. `legs` are the lines to a route's points, `seqs` their items."""
        if not self.fenced:
            return None
        clear = self.allowance.clear(legs)  # leg by leg: shapely takes minutes for many laps as one line
        for seq, leg, is_clear in zip(seqs, legs, clear, strict=False):
            if not is_clear:
                found = self.allowance.line_refusal(leg, seq not in self.unfenced)
                if found is not None:
                    return f"item {item_number(seq)}: {found}"
        return None

    def waypoints(self, route: Iterable[RoutePoint]) -> tuple[Waypoint, ...]:
        """The points of a route in the local plane."""
        frame, surveys = self.frame, bool(self.parameters["PATH_SURVEY"])
        return tuple(
            Waypoint(*frame.to_ned(p.lat_deg, p.lon_deg), p.radius_m, p.speed_mps, surveys and p.straight)
            for p in route
        )

    # --- the rest of a mission -------------------------------------------------------------------------------------

    def first_refusal(self, tasks: Iterator[Task], place: Place) -> str | None:
        """Why the mission cannot be sailed from the boat to its first place: which item leads out of the fence."""
        for task in islice(tasks, _MOST_POINTS):
            refusal, place = self._check(task, place, smooth=True)
            if refusal is not None or isinstance(task, _PLACES):
                return refusal
        return None

    def rest_refusal(self, tasks: Iterator[Task], place: Place) -> str | None:
        """Why it cannot be sailed from its first place on, as far as the first 2,000 points tell."""
        points, is_rest = 0, False
        for task in tasks:
            refusal, place = self._check(task, place, smooth=False)
            if refusal is not None and is_rest:
                return refusal
            is_rest = is_rest or isinstance(task, _PLACES)
            points += len(task.route) if isinstance(task, Sail) else 1
            if points > _MOST_POINTS:
                return None
        return None

    def _check(self, task: Task, place: Place, smooth: bool) -> tuple[str | None, Place]:
        """Why the task leads out of the fence, and where the boat is afterwards."""
        if isinstance(task, Orbit | Dock) and task.seq in self.unfenced:
            return None, self.frame.to_ned(task.lat_deg, task.lon_deg)
        match task:
            case Sail():
                return self._sail(task, place, smooth)
            case ReturnHome():
                found = self.returning.find(place)
                if isinstance(found, str):
                    return f"item {item_number(task.seq)}: {found}", place
                return None, found.way.points[-1]
            case Dock():
                return self._dock(task, place)
            case Orbit():
                return self.orbit_refusal(task, place)
        return None, place

    def berth_heading_rad(self, task: Dock) -> float | None:
        """The heading at the berth of a NAV_LAND item; None where the boat holds there instead (MIS_LAND_ACT)."""
        docks = self._can_sway and self.parameters["MIS_LAND_ACT"]
        return task.yaw_rad if docks else None

    def _dock(self, task: Dock, place: Place) -> tuple[str | None, Place]:
        yaw_rad = self.berth_heading_rad(task)
        if yaw_rad is None:
            end = self.frame.to_ned(task.lat_deg, task.lon_deg)
            found = self.allowance.point_refusal(*end) or self.allowance.line_refusal((place, end))
            return None if found is None else f"item {item_number(task.seq)}: {found}", end
        berth = berth_at(self.config, self.frame, task.lat_deg, task.lon_deg, yaw_rad)
        line = (place, berth.pose(berth.standoff_m)[:2], berth.pose(0.0)[:2])
        text = f"item {item_number(task.seq)}: way to the berth crosses the fence"
        return None if self.allowance.allows_berth(line) else text, line[-1]

    def orbit_refusal(self, task: Orbit, place: Place) -> tuple[str | None, Place]:
        """Why the boat may not orbit there from `place`, and where it is then."""
        line = whole_line(orbit_circle(task, self.frame, self.parameters), place, None, self.parameters)
        found = self.allowance.line_refusal(line)
        return None if found is None else f"item {item_number(task.seq)}: {found}", line[-1]

    def _sail(self, task: Sail, place: Place, smooth: bool) -> tuple[str | None, Place]:
        route, waypoints = task.route, self.waypoints(task.route)
        ends = [(w.north_m, w.east_m) for w in waypoints]
        for point, end, inside in zip(route, ends, self.allowance.inside(ends), strict=True):
            if inside:
                continue
            if (refusal := self.allowance.point_refusal(*end, fenced=point.seq not in self.unfenced)) is not None:
                return f"item {item_number(point.seq)}: {refusal}", place
        found = self.rounded(waypoints, place)
        seqs = [route[found.own_index(i)].seq for i in range(len(found.waypoints))]
        if self.is_sideways(route) or not smooth or self._sails:
            legs = straight_legs(place, found.waypoints)
        else:
            shape = replace(self.shape, terms=None)
            laid = shape.lay(FromBoat(place), found.waypoints, self.waypoints(task.beyond), task.stop)
            legs = laid.legs(0.0)
        return self.track_refusal(legs, seqs), ends[-1]

    def is_sideways(self, route: Sequence[RoutePoint]) -> bool:
        """Whether a route of one point is sailed sideways."""
        return len(route) == 1 and self.ends_sideways(route)

    def ends_sideways(self, route: Sequence[RoutePoint]) -> bool:
        """Whether the last leg of the route is sailed sideways."""
        return route[-1].yaw_rad is not None and self._can_sway and bool(self.parameters["WP_YAW_MODE"])

    @property
    def _sails(self) -> bool:
        return self.config.has_sail

    @property
    def _can_sway(self) -> bool:
        return self.config.limits.sway_n > 0.0
