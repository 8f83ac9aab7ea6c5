"""Where RTL and the return item of a mission lead, and by which way."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from companion.core.decision import Home
from companion.core.geodesy import LocalFrame
from companion.core.work import Lane
from companion.fence.allowed import Allowed, Place, Way
from companion.fence.guard import FenceGuard
from companion.guidance.own_track import OwnTrack, TrackBack
from companion.guidance.path_laying import LaidTrack
from companion.mission.plan import PlanKind, Plans
from companion.modes.parts.search import SAME_PLACE_M, Key
from companion.params.store import Parameters
from companion.positioning.hold_point import WayLaying

NO_WAY = "no way home inside the fence"
_NAV_RALLY_POINT = 5100
_FEW = 20  # destinations, whose distances a tick can compute

Candidates = tuple[tuple[str, float, float], ...]


@dataclass(frozen=True, slots=True)
class Homeward:
    """The way to a destination, and the track along it where it was laid already."""

    name: str
    way: Way
    laid: LaidTrack | None = None


@dataclass(frozen=True, slots=True)
class Return:
    """All that a way home depends on, at one moment; it never changes. A way is found beside the control thread.
    `candidates`: (name, lat_deg, lon_deg) of each possible destination. `track`: the own track, where the boat is to go
    back along it."""

    allowed: Allowed
    frame: LocalFrame
    candidates: Candidates
    home: Home | None
    track: TrackBack | None = None

    def in_lane(self, lane: Lane) -> Return:
        """The same for another thread (`FenceArea.in_lane`)."""
        return replace(self, allowed=self.allowed.in_lane(lane))

    def find(self, begin: Place) -> Homeward | str:
        """The destination with the shortest way from `begin`, or why there is none; back along the own track to home,
        where there is one and the fence lets it."""
        back = None if self.track is None or self.home is None else self._back(self.track, self.home, begin)
        return self._shortest(begin) if back is None else Homeward("home", back)

    def laid(self, begin: Place, laying: WayLaying | None) -> Homeward | str:
        """As `find`, with its track."""
        found = self.find(begin)
        if isinstance(found, str) or laying is None:
            return found
        return Homeward(found.name, found.way, laying.lay(found.way))

    def is_at_hand(self, begin: Place) -> bool:
        """Whether `find` takes no time: the nearest destination lies straight ahead."""
        if self.track is not None or len(self.candidates) > _FEW:
            return False
        places = self._places()
        return not places or self.allowed.is_straight(begin, min(places, key=lambda p: math.dist(p[1], begin))[1])

    def _places(self) -> list[tuple[str, Place]]:
        return [(name, self.frame.to_ned(lat_deg, lon_deg)) for name, lat_deg, lon_deg in self.candidates]

    def _shortest(self, begin: Place) -> Homeward | str:
        places = self._places()
        if not places:
            return "no home position"
        best: Homeward | None = None
        for name, place in sorted(places, key=lambda point: math.dist(point[1], begin)):
            if best is not None and math.dist(place, begin) >= best.way.length_m:
                break
            way = self.allowed.way(begin, place)
            if way is not None and (best is None or way.length_m < best.way.length_m):
                best = Homeward(name, way)
        return NO_WAY if best is None else best

    def _back(self, track: TrackBack, at: Home, begin: Place) -> Way | None:
        """Along the track, and from its beginning to home; None where home is nearer than its first bend, or where the
        fence forbids that."""
        home, back = self.frame.to_ned(at.lat_deg, at.lon_deg), track.way(begin)
        if len(back) < 2 or math.dist(begin, home) <= math.dist(begin, back[1]):
            return None
        last = self.allowed.way(back[-1], home)
        if last is None or self.allowed.line_refusal(back) is not None:
            return None
        rest = last.points[1:] if math.dist(back[-1], last.points[-1]) > SAME_PLACE_M else ()
        return Way((*back, *rest), last.radius_m)


class ReturnPoint:
    """The destination of RTL and of the mission's return item: home. With RTL_USE_RALLY it is home or the rally point
    with the shortest way. Remembers the destinations while they do not change."""

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
        self._known: tuple[Key, Candidates] = ((), ())

    def key(self, home: Home | None) -> Key:
        """Changes whenever a way home may have changed, but for the place of the boat."""
        return *self._fence.key, *self._destinations(home)

    def now(self, home: Home | None) -> Return:
        """What the shortest way depends on now."""
        return Return(self._fence.allowed, self._frame(), self._candidates(home), home)

    def back(self, home: Home | None, by_track: bool = False) -> Return:
        """As `now`; with RTL_TRACK or `by_track` along the own track, as far as there is one."""
        tracked = self._track is not None and (by_track or bool(self._parameters["RTL_TRACK"]))
        track = self._track.back() if self._track is not None and tracked else None
        return replace(self.now(home), track=track)

    def _destinations(self, home: Home | None) -> Key:
        rallies = bool(self._parameters["RTL_USE_RALLY"])
        return home, rallies, self._plans.plan_id(PlanKind.RALLY) if rallies else 0

    def _candidates(self, home: Home | None) -> Candidates:
        key = self._destinations(home)
        if self._known[0] != key:
            points = [] if home is None else [("home", home.lat_deg, home.lon_deg)]
            rally = list(self._plans.items(PlanKind.RALLY)) if self._parameters["RTL_USE_RALLY"] else []
            points += [
                (f"rally point {p.number}", p.lat_deg, p.lon_deg) for p in rally if p.command == _NAV_RALLY_POINT
            ]
            self._known = key, tuple(points)
        return self._known[1]
