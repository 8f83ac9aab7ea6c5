"""RTL: returns to home or a rally point by a way inside the fence, then holds there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from companion.config.vessel import VesselConfig
from companion.core.decision import Home, KnownRefusal, ModeDeclaration, ModeId, ModeInputs, TextKind
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.setpoint import Setpoint
from companion.fence.allowed import Allowed, Way
from companion.fence.guard import FenceGuard
from companion.guidance.own_track import OwnTrack, Place
from companion.mission.plan import PlanKind, Plans
from companion.modes.mode import Mode
from companion.modes.parts.headway import Headway
from companion.modes.parts.search import Search, Waiting
from companion.modes.parts.transit_round import transit_round
from companion.obstacles.charted_fence import ChartedFence
from companion.obstacles.way_round import WayRound
from companion.params.store import Parameters
from companion.positioning.hold_point import HoldPoint
from companion.positioning.watch_circles import WatchCircles

_NAV_RALLY_POINT = 5100
_SAME_PLACE_M = 1.0
_MOST_SEARCHES = 3  # for one way: the boat may have moved until it is found
_NO_WAY = "no way home inside the fence"

Found = tuple[str, Way] | str


@dataclass(frozen=True, slots=True)
class ReturnByTrack:
    """Return along the boat's own track, whatever RTL_TRACK says."""

    @property
    def mode(self) -> ModeId:
        """As every order's."""
        return ModeId.RTL


class ReturnPoint:
    """The destination of RTL and of the mission's return item: home. With RTL_USE_RALLY it is home or the rally point
    with the shortest way."""

    def __init__(
        self,
        parameters: Parameters,
        plans: Plans,
        frame: Callable[[], LocalFrame],
        fence: FenceGuard,
        track: OwnTrack | None = None,
    ) -> None:
        """`track`: where the boat has been; None: RTL_TRACK has no effect."""
        self._fence, self._track = fence, track
        self._parameters = parameters
        self._plans = plans
        self._frame = frame

    def candidates(self, home: Home | None) -> list[tuple[str, float, float]]:
        """(name, lat_deg, lon_deg) of each possible destination."""
        points = [] if home is None else [("home", home.lat_deg, home.lon_deg)]
        if self._parameters["RTL_USE_RALLY"]:
            rally = [item for item in self._plans.items(PlanKind.RALLY) if item.command == _NAV_RALLY_POINT]
            points += [(f"rally point {item.number}", item.lat_deg, item.lon_deg) for item in rally]
        return points

    def way(self, begin: Place, home: Home | None) -> Found:
        """(name, way) of the destination with the shortest way from `begin` (north_m, east_m), or why there is none."""
        return _shortest(self._fence.allowed, self._places(home), begin)

    def look(self, here: Place, home: Home | None, by_track: bool = False) -> Callable[[], Found]:
        """What finds the same from where the boat is; with RTL_TRACK or `by_track` back along its own track to home,
        where the fence in force lets it. It uses nothing that changes."""
        allowed, places = self._fence.allowed, self._places(home)
        track = self._track_back(here, home) if by_track or self._parameters["RTL_TRACK"] else ()
        if len(track) < 2 or home is None:
            return partial(_shortest, allowed, places, here)
        return partial(_back_or_shortest, allowed, places, track, self._frame().to_ned(home.lat_deg, home.lon_deg))

    def is_at_hand(self, here: Place, home: Home | None, by_track: bool) -> bool:
        """Whether `look` takes no time: the fence has few sides, or the nearest destination lies straight ahead."""
        allowed = self._fence.allowed
        if allowed.is_small or by_track or self._parameters["RTL_TRACK"]:
            return allowed.is_small
        places = self._places(home)
        return not places or allowed.is_straight(here, min(places, key=lambda p: math.dist(p[1], here))[1])

    def _places(self, home: Home | None) -> list[tuple[str, Place]]:
        frame = self._frame()
        return [(name, frame.to_ned(lat_deg, lon_deg)) for name, lat_deg, lon_deg in self.candidates(home)]

    def _track_back(self, begin: Place, at: Home | None) -> tuple[Place, ...]:
        """The own track from `begin`; empty where home is nearer than its first bend."""
        if at is None or self._track is None:
            return ()
        home, track = self._frame().to_ned(at.lat_deg, at.lon_deg), self._track.way_back(begin)
        return () if len(track) < 2 or math.dist(begin, home) <= math.dist(begin, track[1]) else track


def _shortest(allowed: Allowed, places: Sequence[tuple[str, Place]], begin: Place) -> Found:
    """As `ReturnPoint.way`."""
    if not places:
        return "no home position"
    best: tuple[str, Way] | None = None
    for name, place in sorted(places, key=lambda point: math.dist(point[1], begin)):
        if best is not None and math.dist(place, begin) >= best[1].length_m:
            break
        way = allowed.way(begin, place)
        if way is not None and (best is None or way.length_m < best[1].length_m):
            best = (name, way)
    return _NO_WAY if best is None else best


def _back_or_shortest(
    allowed: Allowed, places: Sequence[tuple[str, Place]], track: tuple[Place, ...], home: Place
) -> Found:
    """Along the track, and from its beginning to home; by the shortest way where the fence forbids that."""
    last = allowed.way(track[-1], home)
    if last is None or allowed.line_refusal(track) is not None:
        return _shortest(allowed, places, track[0])
    rest = last.points[1:] if math.dist(track[-1], last.points[-1]) > _SAME_PLACE_M else ()
    return "home", Way((*track, *rest), last.radius_m)


class RtlMode(Mode):
    """Remembers the destination chosen on entry, whether it is reached, whether its own track was asked for, the search
    for a way with what it depends on, and the last check with its position."""

    declaration = ModeDeclaration(
        id=ModeId.RTL,
        text="Back to home or the nearest rally point, inside the fence or along the own track, then holds there",
        px4=0x05040000,
        rover=11,
        again="RTL and SmartRTL change between the shortest way and the own track",
        rover_aliases=(12,),  # SMART_RTL
        rover_orders={12: ReturnByTrack()},
        standard_mode=5,  # SAFE_RECOVERY
        commands=(20,),  # NAV_RETURN_TO_LAUNCH
        refusals=(
            KnownRefusal(
                r"no home position",
                "no home position",
                "Home is set when the boat has a position. Or set it: Set home here, or a rally point.",
            ),
            KnownRefusal(r"no way home.*", "no way home inside the fence", "Change the fence, or add a rally point."),
        ),
    )

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        point: ReturnPoint,
        events: EventLog,
        charted: ChartedFence,
    ) -> None:
        self._point = point
        self._events = events
        self._fence = charted.guard
        self._hold_point = HoldPoint(config, parameters, self._fence)
        self._name = "home"
        self._arrived = False
        self._by_track = False
        self._blocked: str | None = None
        self._search: Search[Found] = Search(charted.submit)
        self._waiting = Waiting(events)
        self._searches = 0
        self._sought: object = ()
        self._checks: Search[Found] = Search(charted.submit)
        self._checking: tuple[object, Place] = ((), (0.0, 0.0))
        self._checked: tuple[object, Place, str | None] = ((), (0.0, 0.0), None)
        self._watch = WatchCircles(parameters, events, "RTL")
        self._headway = Headway("RTL", events)

    def _key(self, inputs: ModeInputs) -> tuple[object, ...]:
        """What a way home depends on, besides the boat's place."""
        return self._fence.key, tuple(self._point.candidates(inputs.home))

    def check(self, inputs: ModeInputs) -> str | None:
        """Refuse without home, or without a way inside the fence as far as that is known. Callers check every tick
        while disarmed, so the result is kept while the boat stays within 1 m."""
        nav = inputs.nav
        if not self._point.candidates(inputs.home):
            return "no home position"
        if not self._fence.key or not nav.position_valid:
            return None
        key, place = self._key(inputs), (nav.north_m, nav.east_m)
        known, at, _ = self._checked
        if not self._checks.pending and (key != known or math.dist(place, at) > _SAME_PLACE_M):
            self._checking = key, place
            self._checks.begin(self._point.look(place, inputs.home))
        if self._checks.done:
            found = self._checks.take()
            asked, at = self._checking
            self._checked = asked, at, found if isinstance(found, str) else None
        return self._checked[2] if self._checked[0] == key else None

    def enter(self, inputs: ModeInputs) -> str | None:
        """Choose the destination with the shortest way, or the own track, and start towards it."""
        self._by_track = isinstance(inputs.order, ReturnByTrack)
        return self._go(inputs)

    def resume(self, inputs: ModeInputs) -> str | None:
        """As `enter`, by the same kind of way."""
        return self._go(inputs)

    def chosen_again(self, inputs: ModeInputs) -> bool:
        """With the other kind of way it begins anew."""
        return isinstance(inputs.order, ReturnByTrack) is not self._by_track and not self._arrived

    def leave(self) -> None:
        """Look for no way any longer."""
        self._search.drop()
        self._waiting.reset()
        self._blocked = None

    @property
    def blocked(self) -> str | None:
        """Why no way home was found, where that took longer than a tick."""
        return self._blocked

    def _go(self, inputs: ModeInputs) -> str | None:
        """Start on the way home. Where finding it takes long, hold here until it is found."""
        self._searches = 0
        self._blocked = None
        self._waiting.reset()
        found = self._look(inputs)
        if found is None:
            self._arrived = False
            self._hold_point.stop_here(inputs.nav)
            return None
        return self._start(found, inputs)

    def _look(self, inputs: ModeInputs) -> Found | None:
        """The way from here; None while it is looked for."""
        here = (inputs.nav.north_m, inputs.nav.east_m)
        look = self._point.look(here, inputs.home, self._by_track)
        if self._point.is_at_hand(here, inputs.home, self._by_track):
            self._search.drop()
            return look()
        self._sought = self._key(inputs)
        self._searches += 1
        self._search.begin(look)
        return self._search.take() if self._search.done else None

    def _start(self, found: Found, inputs: ModeInputs) -> str | None:
        if isinstance(found, str):
            return found
        self._name, way = found
        self._arrived = False
        self._watch.reset()
        self._headway.reset()
        self._hold_point.go_along(inputs.nav, way)
        return None

    def _mind_search(self, inputs: ModeInputs) -> None:
        """Start on the way once it is found. One that no longer begins here, or leads to where home was, is looked for
        again."""
        if not self._search.done:
            self._blocked = self._waiting.update(inputs.now_s)
            if self._blocked is not None:
                self._search.drop()
            return
        sought = self._search.take()
        found: Found | None = sought
        here = (inputs.nav.north_m, inputs.nav.east_m)
        if self._sought != self._key(inputs):
            self._searches = 0
            found = self._look(inputs)
        elif not isinstance(sought, str) and not self._fence.allowed.is_open(here, sought[1].points[1]):
            found = self._look(inputs) if self._searches < _MOST_SEARCHES else _NO_WAY
        if found is not None:
            self._blocked = self._start(found, inputs)

    def mind_fence(self, inputs: ModeInputs) -> str | None:
        """Look for another way home; stop without one."""
        return None if self._go(inputs) is None else _NO_WAY

    def stuck_s(self, now_s: float) -> float | None:
        """Seconds without headway on the way home; None if unknown."""
        return self._headway.stuck_s(now_s)

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        """The rest of the way home."""
        return self._hold_point.way_ahead

    @property
    def goes_round(self) -> bool:
        """Whether the boat is in transit home."""
        return self._hold_point.in_transit

    def way_round(self, inputs: ModeInputs) -> WayRound[Way | None] | None:
        """Another way to the same destination."""
        return transit_round(self._hold_point, inputs)

    def excuse(self) -> None:
        """Restart the headway watch."""
        self._headway.reset()

    @property
    def voyage_over(self) -> bool:
        """Whether the boat is at home or the rally point."""
        return self._arrived

    def update(self, inputs: ModeInputs) -> Setpoint:
        """Go home, announce the arrival, then hold there."""
        if self._search.pending:
            self._mind_search(inputs)
        if self._search.pending or self._blocked is not None:
            return self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        setpoint = self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        if self._hold_point.way_m is not None:
            self._headway.update(self._hold_point.way_m, inputs.speed_mps, inputs.now_s)
        if not self._arrived and not self._hold_point.going:
            self._arrived = True
            self._events.say(inputs.now_s, TextKind.ROUTINE, "rtl_arrived", f"RTL: at {self._name}, holding")
        if self._arrived:
            north_m, east_m = self._hold_point.target
            self._watch.update(math.hypot(north_m - inputs.nav.north_m, east_m - inputs.nav.east_m), inputs.now_s)
        return setpoint
