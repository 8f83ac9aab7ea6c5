"""The path of a mission's route. It is led round the fence, laid and checked beside the control thread, while the boat
sails on or holds; the next part of a long mission is laid ahead of time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from companion.allocation.astern import astern_n, stern_first_mps
from companion.baselines.path_choice import ChosenPathTracker
from companion.config.reversing import stern_first_refusal, turns_on_the_spot
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.core.decision import ModeInputs
from companion.core.estimate import NavState
from companion.core.work import Lane
from companion.fence.allowed import Place
from companion.guidance.agility import agility_of
from companion.guidance.path_laying import FromBoat, FromTrack, Joint, LaidTrack, Onward
from companion.guidance.path_tracking import PathProgress
from companion.guidance.turning import turning_of
from companion.mission.executor import MissionExecutor
from companion.mission.tasks import RoutePoint, Sail
from companion.modes.parts.mission_fence import MissionFence
from companion.modes.parts.mission_terms import LaidRoute, MissionTerms, Route
from companion.modes.parts.rounding import Rounded, rounded, unchanged
from companion.modes.parts.search import SAME_PLACE_M, Key, Search
from companion.obstacles.open_water import Water
from companion.params.store import Parameters

_NEAR_SHARE = 0.5  # of NAV_ACC_RAD: a track that begins no further off can be sailed from here


@dataclass(frozen=True, slots=True, eq=False)
class _Question:
    """A route to lay: what that depends on, and the place that its track begins at."""

    key: Key
    here: Place
    near_m: float
    work: Callable[[], LaidRoute]


@dataclass(frozen=True, slots=True, eq=False)
class RoundObstacles:
    """The rest of a route led round obstacles from `here`, with its track; None where the law of the thesis sails."""

    here: Place
    rounded: Rounded
    laid: LaidTrack | None


class RouteSailing:
    """`ready(task, …)` until it is True, then `take_up`, then `update` each tick.

    Remembers the route under way, whether it is sailed `astern`, how many points of it are `reported` as passed, the
    points added to lead it round the fence, and the search for the next one. A boat that cannot sail stern first sails
    every route bow first.
    """

    def __init__(
        self, config: VesselConfig, parameters: Parameters, executor: MissionExecutor, fence: MissionFence
    ) -> None:
        self._parameters = parameters
        self._executor = executor
        self._fence = fence
        can_sway = config.limits.sway_n > 0.0
        submit = fence.submit_urgent
        agility = agility_of(config)
        turning = turning_of(config, turns_on_the_spot(config.thrusters))
        top_mps, sails = top_speed_mps(config), config.has_sail
        self._ahead = ChosenPathTracker(parameters, can_sway, top_mps, agility, submit, turning=turning, sails=sails)
        self._sternward = self._ahead
        self.astern_mps = stern_first_mps(config)
        if stern_first_refusal(config.thrusters) is None:
            agility = None if agility is None else replace(agility, surge_n=astern_n(config))
            self._sternward = ChosenPathTracker(parameters, can_sway, self.astern_mps, agility, submit, True, turning)
        self.astern = False
        self._search: Search[LaidRoute] = Search(submit)
        self._next: LaidRoute | None = None  # to be taken up
        self._foreseen: tuple[Sail, Onward, Key] | None = None
        self.route: tuple[RoutePoint, ...] = ()
        self.reported = 0
        self.sideways = False  # the last leg of the route is not sailed along the path
        self._rounded: Rounded = unchanged(())  # the points of the path, with those that lead round the fence

    @property
    def rest(self) -> tuple[RoutePoint, ...]:
        """Points of the present route ahead, but for a last one that is reached sideways."""
        return self.route[self.reported : len(self.route) - self.sideways]

    @property
    def asked_mps(self) -> float | None:
        """The speed on the present leg, where the mission gives one."""
        return self.route[self.reported].speed_mps if self.reported < len(self.route) else None

    @property
    def tracker(self) -> ChosenPathTracker:
        """What tracks the route under way."""
        return self._tracker(self.astern)

    def _tracker(self, astern: bool) -> ChosenPathTracker:
        return self._sternward if astern else self._ahead

    def speed_mps(self, inputs: ModeInputs) -> float:
        """The speed to sail at, as far as thrust astern allows it."""
        return min(inputs.speed_mps, self.astern_mps) if self.astern else inputs.speed_mps

    def drop(self) -> None:
        """Lay nothing any longer."""
        self._search.drop()
        self._next = self._foreseen = None

    def terms(self, inputs: ModeInputs, astern: bool | None = None) -> MissionTerms:
        """What the ways of the mission depend on now. `astern`: of a route that is sailed stern first; None: as the
        present one."""
        tracker = self.tracker if astern is None else self._tracker(astern)
        return self._fence.terms(inputs, tracker.shape(inputs.nav), tracker.is_own)

    # --- the next route --------------------------------------------------------------------------------------------

    def ready(self, task: Sail, before: Sail | None, inputs: ModeInputs) -> bool:
        """Whether the route can be taken up in this tick; else it is being laid. `before`: the one that the boat sails
        now."""
        terms = self.terms(inputs, task.astern)
        route = self._route_of(task, terms)
        if not route.waypoints:  # it is one sideways leg
            self._next = LaidRoute(route, unchanged(()), None, None)
            return True
        joint: Joint | None = None
        if before is not None and before.astern is task.astern:
            joint = self.tracker.onward() if self._goes_on(task, before) else self.tracker.from_track()
        return self._laid(self._question(route, joint or self._from_boat(inputs.nav), terms, inputs.nav))

    def _goes_on(self, task: Sail, before: Sail) -> bool:
        """Whether the route goes on from the present one, which is over."""
        return self.reported == len(self.route) and before.beyond[:1] == task.route[:1]

    def _laid(self, question: _Question) -> bool:
        answer = self._search.look(question.key, question.here, question.work, question.near_m)
        self._next = None if answer is None else answer.found
        return answer is not None

    def take_up(self, task: Sail, before: Sail | None, inputs: ModeInputs) -> str | None:
        """Sail the route that is ready. Returns why its path is refused, or None."""
        laid, self._next = self._next, None
        if laid is None:
            raise RuntimeError("RouteSailing.take_up before it is ready")
        joins = before is not None and before.astern is task.astern
        goes_on = before is not None and joins and self._goes_on(task, before)
        self.route, self.reported, self.astern = task.route, 0, task.astern
        self.sideways = len(laid.route.seqs) < len(task.route)
        self._rounded = laid.rounded
        route, waypoints = laid.route, laid.rounded.waypoints
        if laid.laid is not None:
            self.tracker.take(laid.laid, inputs.nav)
        elif waypoints and joins:
            go = self.tracker.go_on if goes_on else self.tracker.replace
            go(waypoints, inputs.nav, route.stop, route.beyond)
        elif waypoints:
            self.tracker.start(waypoints, inputs.nav, route.stop, beyond=route.beyond)
        return laid.refusal

    def foresee(self, task: Sail, inputs: ModeInputs) -> None:
        """Lay the route that goes on from the present one, once it is under way."""
        joint = self.tracker.onward()
        if not task.beyond or joint is None or not self.tracker.is_own:
            return
        seen = task, joint, self._fence.key
        if self._foreseen == seen:
            return
        self._foreseen = seen
        following = self._executor.following
        if isinstance(following, Sail) and following.route[:1] == task.beyond[:1]:
            terms = self.terms(inputs)
            route = self._route_of(following, terms)
            if route.waypoints:
                self._laid(self._question(route, joint, terms, inputs.nav))
                self._next = None

    def _question(self, route: Route, joint: Joint, terms: MissionTerms, nav: NavState) -> _Question:
        """How to lay a route. The work takes the boat to be where its track begins."""
        here, near_m = (nav.north_m, nav.east_m), max(SAME_PLACE_M, _NEAR_SHARE * self._parameters["NAV_ACC_RAD"])
        begins: tuple[object, ...] = ("boat",)
        if isinstance(joint, FromTrack):
            begins, here, near_m = ("track",), (joint.here.north_m, joint.here.east_m), joint.radius_m
        elif isinstance(joint, Onward):
            begins, here = ("onward", joint), (joint.last[-1].north_m, joint.last[-1].east_m)
            nav = replace(nav, north_m=here[0], east_m=here[1])
        key = (route, *begins, *self._fence.key, replace(terms.shape, terms=None), terms.own_law, terms.rounds)
        return _Question(key, here, near_m, lambda: terms.in_lane(Lane.URGENT).lay(route, joint, nav))

    def _route_of(self, task: Sail, terms: MissionTerms) -> Route:
        """The route without a last leg that is sailed sideways."""
        points, beyond, stop = task.route, task.beyond, task.stop
        if terms.ends_sideways(points):
            points, beyond, stop = points[:-1], (), False
        seqs = tuple(p.seq for p in points)
        return Route(terms.waypoints(points), seqs, terms.waypoints(beyond), stop, task.astern)

    @staticmethod
    def _from_boat(nav: NavState) -> FromBoat:
        return FromBoat((nav.north_m, nav.east_m))

    # --- the present one -------------------------------------------------------------------------------------------

    def update(self, inputs: ModeInputs) -> PathProgress:
        """One step along the path; `passed`: of the route's own points."""
        self.tracker.turns_against(inputs.turn_resistance)
        progress = self.tracker.update(inputs.nav, self.speed_mps(inputs), inputs.dt_s)
        return replace(progress, passed=self._rounded.passed(progress.passed))

    def refusal(self, inputs: ModeInputs) -> str | None:
        """Why the path from the boat's place on it is refused, or None."""
        seqs = [self.route[self._rounded.own_index(i)].seq for i in range(len(self._rounded.waypoints))]
        return self.terms(inputs).track_refusal(self.tracker.legs, seqs)

    def led_round(self, task: Sail, inputs: ModeInputs) -> tuple[bool, str | None]:
        """Lead the rest of the present route round a new fence. Returns (whether that is done, why the path is
        refused)."""
        terms, rest = self.terms(inputs), self.rest
        stop = task.stop and not self.sideways
        route = Route(terms.waypoints(rest), tuple(p.seq for p in rest), (), stop, task.astern)
        if not route.waypoints:
            return True, None
        if not self._laid(self._question(route, self._from_boat(inputs.nav), terms, inputs.nav)):
            return False, None
        laid, self._next = self._next, None
        if laid is None or not laid.rounded.added:
            return True, None
        self._sail_instead(task, laid.rounded, laid.laid, inputs.nav)
        return True, laid.refusal

    def finder(self, task: Sail, inputs: ModeInputs) -> Callable[[Water], RoundObstacles | int]:
        """What leads the rest of the present route round obstacles; the index of its first point that cannot be reached
        where there is no way. It uses nothing that changes."""
        terms, rest, stop = self.terms(inputs), self.rest, task.stop and not self.sideways
        waypoints, here = terms.waypoints(rest), (inputs.nav.north_m, inputs.nav.east_m)

        def find(water: Water) -> RoundObstacles | int:
            found = rounded(waypoints, here, water.clear, water.way)
            if isinstance(found, int):
                return found
            laid = terms.shape.lay(FromBoat(here), found.waypoints, (), stop) if terms.own_law else None
            return RoundObstacles(here, found, laid)

        return find

    def go_round(self, task: Sail, found: RoundObstacles, inputs: ModeInputs) -> None:
        """Sail what `finder` found. Where the boat has moved, the track is laid anew from there."""
        near = math.dist(found.here, (inputs.nav.north_m, inputs.nav.east_m)) <= SAME_PLACE_M
        self._sail_instead(task, found.rounded, found.laid if near else None, inputs.nav)

    def _sail_instead(self, task: Sail, found: Rounded, laid: LaidTrack | None, nav: NavState) -> None:
        """Sail the rest of the present route by other points from here."""
        self.route, self.reported, self._rounded = self.route[self.reported :], 0, found
        if laid is None or not self.tracker.is_own:
            self.tracker.start(found.waypoints, nav, task.stop and not self.sideways)
        else:
            self.tracker.take(laid, nav)
