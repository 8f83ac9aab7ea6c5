"""Checks that the rest of a mission, as the boat would sail it, stays inside the fence and clear of the chart's
obstacles; else names the item."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

from companion.config.vessel import VesselConfig
from companion.core.decision import ModeInputs
from companion.core.geodesy import LocalFrame
from companion.fence.allowed import Place
from companion.fence.guard import FenceGuard
from companion.guidance.agility import agility_of
from companion.guidance.orbit import Circle, chosen_circle, whole_line
from companion.guidance.path_tracking import PathTracker, Waypoint
from companion.mission.commands import Command
from companion.mission.executor import MissionExecutor
from companion.mission.plan import PlanItem, PlanKind, Plans, item_number
from companion.mission.tasks import Dock, Orbit, ReturnHome, RoutePoint, Sail, Task
from companion.modes.parts.berth import BerthChoice
from companion.modes.parts.rounding import Rounded, rounded, unchanged
from companion.modes.parts.search import Search
from companion.modes.rtl import ReturnPoint
from companion.obstacles.charted_fence import ChartedFence
from companion.params.store import Parameters

# Before the start, the first route is checked by the smooth path and the rest by straight legs.
# Each path is checked again when it is laid.
_POINTS_A_STEP = 40
_MOST_POINTS = 2_000
_PLACES = (Sail, ReturnHome, Dock, Orbit)  # tasks after which it does not matter where the boat was before
_SAME_PLACE_M = 1.0
_NEAR_M = 50.0  # within which a route found from another place serves, where its first leg is open
_SHAPE = (
    "PATH_KIND",
    "NAV_ACC_RAD",
    "WP_CORNER",
    "PATH_EFFORT",
    "PATH_SURVEY",
    "WP_YAW_MODE",
    "MPC_XY_VEL_MAX",
    "PATH_YAW_RATE",
    "PATH_ACC_LAT",
    "RTL_USE_RALLY",
    "CIRC_RADIUS",
    "CIRC_DIR",
    "MIS_ROUND",
)


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
class _Sought:
    """A route to lead round, what that depends on, and where the boat was."""

    key: tuple[object, ...]
    waypoints: tuple[Waypoint, ...]
    here: Place

    def serves(self, other: _Sought) -> bool:
        """Whether the answer is one to `other` too, as far as that can be told without the first leg."""
        same = self.key == other.key and self.waypoints == other.waypoints
        return same and math.dist(self.here, other.here) <= _NEAR_M


class MissionFence:
    """`refusal(inputs)` checks the rest of the mission; `track_refusal(legs, seqs)` checks a path just laid.

    The ways to items before which the mission switches the fence off are checked by the chart alone.
    A long mission is checked in steps, one a tick: until the last one, it is refused only for what was found by then.
    The check has two parts: from the boat to the first place of the mission, anew whenever the boat has moved, and from
    there on. Remembers the answer of the first part with its position, and how far the second part is.

    Round a chart or a large fence, the present route is led by a search beside the control thread: `ready` asks for it,
    `rounded` gives what it found. Remembers the route looked for, and the one found last.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        plans: Plans,
        executor: MissionExecutor,
        point: ReturnPoint,
        berths: BerthChoice,
        frame: Callable[[], LocalFrame],
        fence: ChartedFence,
    ) -> None:
        self._parameters = parameters
        self._plans = plans
        self._executor = executor
        self._point = point
        self._berths = berths
        self._frame = frame
        self._fence = fence
        self._can_sway = config.limits.sway_n > 0.0
        self._scratch = PathTracker(parameters, self._can_sway, agility=agility_of(config))
        self._key: object = ()
        self._from_here: tuple[Place, str | None] | None = None
        self._rest: Iterator[str | None] | None = None  # the second part, while it goes on
        self._rest_refusal: str | None = None
        self._stepped_s: float | None = None  # time of the last step
        self._search: Search[Rounded | int] = Search(fence.submit)
        self._sought: _Sought | None = None
        self._found: tuple[_Sought, Rounded | int] | None = None
        self._waits = False  # for the search, with the first part
        self._unfenced_of: tuple[int, frozenset[int]] = (0, frozenset())  # of the mission with that id

    @property
    def guard(self) -> FenceGuard:
        """The fence guard that checks single points and lines."""
        return self._fence.guard

    def rounded(self, waypoints: Sequence[Waypoint], here: Place) -> Rounded:
        """The route from `here` with legs led round fence and chart, where MIS_ROUND asks for that and a way exists."""
        if not self._fence.key or not self._parameters["MIS_ROUND"]:
            return unchanged(waypoints)

        known = self._known(self._asked(waypoints, here))
        found = rounded(waypoints, here, self._fence.is_open, self._fence.way, math.inf) if known is None else known
        return unchanged(waypoints) if isinstance(found, int) else found

    def ready(self, waypoints: Sequence[Waypoint], here: Place) -> bool:
        """Whether `rounded` takes no time now. Otherwise the way is looked for from here; ask again."""
        fence = self._fence
        needless = not fence.key or not self._parameters["MIS_ROUND"] or not waypoints
        if fence.worker is None or needless or fence.is_small:
            return True
        asked = self._asked(waypoints, here)
        if self._search.done and self._sought is not None:
            self._found = self._sought, self._search.take()
        if self._known(asked) is not None:
            return True
        if not self._search.pending or self._sought is None or not self._sought.serves(asked):
            self._sought = asked
            water = fence.water
            self._search.begin(partial(rounded, asked.waypoints, here, water.is_open, water.way, math.inf))
        return False

    def _asked(self, waypoints: Sequence[Waypoint], here: Place) -> _Sought:
        return _Sought((self._fence.key, self._parameters["NAV_ACC_RAD"]), tuple(waypoints), here)

    def _known(self, asked: _Sought) -> Rounded | int | None:
        """The route as found, where it can be sailed from here."""
        if self._found is None or not self._found[0].serves(asked):
            return None
        sought, found = self._found
        if asked.here == sought.here or isinstance(found, int):
            return found if math.dist(asked.here, sought.here) <= _SAME_PLACE_M else None
        first = found.waypoints[0]
        return found if self._fence.is_open(asked.here, (first.north_m, first.east_m)) else None

    def refusal(self, inputs: ModeInputs, at_once: bool = False) -> str | None:
        """Return which item leads out of the fence or into a chart obstacle, and why; None if none does as far as that
        is checked. Callers ask every tick while disarmed, so the answer is kept while the boat stays within 1 m.

        What takes long is looked for first, unless `at_once`: nothing is refused until then."""
        nav = inputs.nav
        if not self._fence.key or not nav.position_valid:
            return None
        progress, ids = self._executor.progress, [self._plans.plan_id(kind) for kind in PlanKind]
        shape = [self._parameters[name] for name in _SHAPE]
        key = (self._fence.key, tuple(ids), progress.state, progress.seq, inputs.home, tuple(shape))
        place = (nav.north_m, nav.east_m)
        if key != self._key:
            self._key, self._from_here = key, None
        stale = self._from_here is None or math.dist(place, self._from_here[0]) > _SAME_PLACE_M
        self._waits = stale and not at_once and not self._first_ready(place)
        if stale and not self._waits:
            anew = self._from_here is None or self._from_here[1] is not None
            self._begin(place, inputs, anew)
            self._stepped_s = None if anew else inputs.now_s
        if self._rest is not None and inputs.now_s != self._stepped_s:
            self._stepped_s = inputs.now_s
            self._go_on(self._rest)
        if self._from_here is None:
            return None
        return self._from_here[1] or self._rest_refusal

    def _first_ready(self, place: Place) -> bool:
        """Whether the first part can be checked in a tick."""
        first = next((task for task in self._executor.ahead() if isinstance(task, _PLACES)), None)
        return not isinstance(first, Sail) or self.ready(self._waypoints(first.route), place)

    @property
    def checked(self) -> bool:
        """Whether the check of the mission asked for last is complete."""
        return self._rest is None and not self._waits

    @property
    def _unfenced(self) -> frozenset[int]:
        """See `unfenced`, of the mission in force."""
        if self._unfenced_of[0] != (mission := self._plans.plan_id(PlanKind.MISSION)):
            self._unfenced_of = mission, unfenced(self._plans.items(PlanKind.MISSION))
        return self._unfenced_of[1]

    def track_refusal(self, legs: Sequence[Sequence[Place]], seqs: Iterable[int]) -> str | None:
        """Return which leg crosses the fence, or None. `legs` are the lines to a route's points, `seqs` their items."""
        clear = self._fence.clear(legs)  # leg by leg: shapely takes minutes for many laps as one line
        for seq, leg, is_clear in zip(seqs, legs, clear, strict=False):
            if not is_clear and (found := self._fence.line_refusal(leg, seq not in self._unfenced)) is not None:
                return f"item {item_number(seq)}: {found}"
        return None

    def _begin(self, place: Place, inputs: ModeInputs, anew: bool) -> None:
        """Check from the boat to the first place of the mission. `anew`: prepare the check of the rest too."""
        tasks = self._executor.ahead()
        refusal, there = None, place
        for task in tasks:
            refusal, there = self._check(task, place, inputs, smooth=True)
            if refusal is not None or isinstance(task, _PLACES):
                break
        self._from_here = place, refusal
        if anew:
            self._rest, self._rest_refusal = self._look_ahead(tasks, there, inputs), None

    def _go_on(self, rest: Iterator[str | None]) -> None:
        """One step of the rest."""
        try:
            self._rest_refusal = next(rest)
        except StopIteration:
            self._rest = None
        if self._rest_refusal is not None:
            self._rest = None

    def _look_ahead(self, tasks: Iterator[Task], place: Place, inputs: ModeInputs) -> Iterator[str | None]:
        """The answer after each step, as long as it is None."""
        points = since = 0
        for task in tasks:
            refusal, place = self._check(task, place, inputs, smooth=False)
            count = len(task.route) if isinstance(task, Sail) else 1
            points, since = points + count, since + count
            if refusal is not None:
                yield refusal
            if refusal is not None or points > _MOST_POINTS:
                return
            if since >= _POINTS_A_STEP:
                since = 0
                yield None

    def _check(self, task: Task, place: Place, inputs: ModeInputs, smooth: bool) -> tuple[str | None, Place]:
        """Why the task leads out of the fence, and where the boat is afterwards."""
        if isinstance(task, Orbit | Dock) and task.seq in self._unfenced:
            return None, self._frame().to_ned(task.lat_deg, task.lon_deg)
        match task:
            case Sail():
                return self._sail(task, place, inputs, smooth)
            case ReturnHome():
                found = self._point.way(place, inputs.home)
                if isinstance(found, str):
                    return f"item {item_number(task.seq)}: {found}", place
                return None, found[1].points[-1]
            case Dock():
                return self._dock(task, place)
            case Orbit():
                return self._orbit(task, place)
        return None, place

    def berth_heading_rad(self, task: Dock) -> float | None:
        """The heading at the berth of a NAV_LAND item; None where the boat holds there instead (MIS_LAND_ACT)."""
        docks = self._can_sway and self._parameters["MIS_LAND_ACT"]
        return task.yaw_rad if docks else None

    def _dock(self, task: Dock, place: Place) -> tuple[str | None, Place]:
        yaw_rad = self.berth_heading_rad(task)
        if yaw_rad is None:
            end = self._frame().to_ned(task.lat_deg, task.lon_deg)
            found = self._fence.point_refusal(*end) or self._fence.line_refusal((place, end))
            return None if found is None else f"item {item_number(task.seq)}: {found}", end
        berth = self._berths.at(task.lat_deg, task.lon_deg, yaw_rad)
        line = (place, berth.pose(berth.standoff_m)[:2], berth.pose(0.0)[:2])
        text = f"item {item_number(task.seq)}: way to the berth crosses the fence"
        return None if self._fence.allows_berth(line) else text, line[-1]

    def _orbit(self, task: Orbit, place: Place) -> tuple[str | None, Place]:
        line = whole_line(orbit_circle(task, self._frame(), self._parameters), place, None, self._parameters)
        found = self._fence.line_refusal(line)
        return None if found is None else f"item {item_number(task.seq)}: {found}", line[-1]

    def _waypoints(self, route: Sequence[RoutePoint]) -> list[Waypoint]:
        frame, surveys = self._frame(), bool(self._parameters["PATH_SURVEY"])
        return [Waypoint(*frame.to_ned(p.lat_deg, p.lon_deg), p.radius_m, None, surveys and p.straight) for p in route]

    def _sail(self, task: Sail, place: Place, inputs: ModeInputs, smooth: bool) -> tuple[str | None, Place]:
        route, waypoints = task.route, self._waypoints(task.route)
        ends = [(w.north_m, w.east_m) for w in waypoints]
        for point, end, inside in zip(route, ends, self._fence.inside(ends), strict=True):
            if inside:
                continue
            if (refusal := self._fence.point_refusal(*end, fenced=point.seq not in self._unfenced)) is not None:
                return f"item {item_number(point.seq)}: {refusal}", place
        found = self.rounded(waypoints, place)
        seqs = [route[found.own_index(i)].seq for i in range(len(found.waypoints))]
        if self._sideways(route) or not smooth:
            legs = [list(leg) for leg in pairwise((place, *((w.north_m, w.east_m) for w in found.waypoints)))]
        else:
            at_rest = replace(inputs.nav, north_m=place[0], east_m=place[1], north_mps=0.0, east_mps=0.0)
            self._scratch.start(found.waypoints, at_rest, task.stop, beyond=self._waypoints(task.beyond))
            legs = self._scratch.legs
        return self.track_refusal(legs, seqs), ends[-1]

    def _sideways(self, route: Sequence[RoutePoint]) -> bool:
        return (
            len(route) == 1
            and route[0].yaw_rad is not None
            and self._can_sway
            and bool(self._parameters["WP_YAW_MODE"])
        )
