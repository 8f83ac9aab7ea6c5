"""RTL: returns to home or a rally point by a way inside the fence, then holds there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from companion.config.vessel import VesselConfig
from companion.core.decision import Home, KnownRefusal, ModeDeclaration, ModeId, ModeInputs, TextKind
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.setpoint import Setpoint
from companion.fence.allowed import Way
from companion.fence.guard import FenceGuard
from companion.guidance.own_track import OwnTrack, Place
from companion.mission.plan import PlanKind, Plans
from companion.modes.mode import Mode
from companion.modes.parts.headway import Headway
from companion.modes.parts.transit_round import transit_round
from companion.obstacles.way_round import WayRound
from companion.params.store import Parameters
from companion.positioning.hold_point import HoldPoint
from companion.positioning.watch_circles import WatchCircles

_NAV_RALLY_POINT = 5100
_SAME_PLACE_M = 1.0


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

    def way(self, begin: Place, home: Home | None) -> tuple[str, Way] | str:
        """(name, way) of the destination with the shortest way from `begin` (north_m, east_m), or why there is none."""
        frame = self._frame()
        points = [(name, frame.to_ned(lat_deg, lon_deg)) for name, lat_deg, lon_deg in self.candidates(home)]
        if not points:
            return "no home position"
        best: tuple[str, Way] | None = None
        for name, place in sorted(points, key=lambda point: math.dist(point[1], begin)):
            if best is not None and math.dist(place, begin) >= best[1].length_m:
                break
            way = self._fence.way(begin, place)
            if way is not None and (best is None or way.length_m < best[1].length_m):
                best = (name, way)
        return "no way home inside the fence" if best is None else best

    def way_now(self, here: Place, home: Home | None, by_track: bool = False) -> tuple[str, Way] | str:
        """As `way` from where the boat is, but with RTL_TRACK or `by_track` back along its own track to home, where the
        fence in force lets it."""
        by_track = by_track or bool(self._parameters["RTL_TRACK"])
        back = self._back(here, home) if home is not None and by_track else None
        return self.way(here, home) if back is None else ("home", back)

    def _back(self, begin: Place, at: Home) -> Way | None:
        """Along the track, and from its beginning to home."""
        home = self._frame().to_ned(at.lat_deg, at.lon_deg)
        track = () if self._track is None else self._track.way_back(begin)
        if len(track) < 2 or math.dist(begin, home) <= math.dist(begin, track[1]):
            return None
        last = self._fence.way(track[-1], home)
        if last is None or self._fence.line_refusal(track) is not None:
            return None
        rest = last.points[1:] if math.dist(track[-1], last.points[-1]) > _SAME_PLACE_M else ()
        return Way((*track, *rest), last.radius_m)


class RtlMode(Mode):
    """Remembers the destination chosen on entry, whether it is reached, whether its own track was asked for, and the
    last check with its position."""

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
        self, config: VesselConfig, parameters: Parameters, point: ReturnPoint, events: EventLog, fence: FenceGuard
    ) -> None:
        self._point = point
        self._events = events
        self._fence = fence
        self._hold_point = HoldPoint(config, parameters, fence)
        self._name = "home"
        self._arrived = False
        self._by_track = False
        self._checked: tuple[object, tuple[float, float], str | None] = ((), (0.0, 0.0), None)
        self._watch = WatchCircles(parameters, events, "RTL")
        self._headway = Headway("RTL", events)

    def check(self, inputs: ModeInputs) -> str | None:
        """Refuse without home, or without a way inside the fence. Callers check every tick while disarmed, so the
        result is kept while the boat stays within 1 m."""
        candidates, nav = self._point.candidates(inputs.home), inputs.nav
        if not candidates:
            return "no home position"
        if not self._fence.key or not nav.position_valid:
            return None
        key, place = (self._fence.key, tuple(candidates)), (nav.north_m, nav.east_m)
        if key != self._checked[0] or math.dist(place, self._checked[1]) > _SAME_PLACE_M:
            found = self._point.way_now(place, inputs.home)
            self._checked = key, place, found if isinstance(found, str) else None
        return self._checked[2]

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

    def _go(self, inputs: ModeInputs) -> str | None:
        found = self._point.way_now((inputs.nav.north_m, inputs.nav.east_m), inputs.home, self._by_track)
        if isinstance(found, str):
            return found
        self._name, way = found
        self._arrived = False
        self._watch.reset()
        self._headway.reset()
        self._hold_point.go_along(inputs.nav, way)
        return None

    def mind_fence(self, inputs: ModeInputs) -> str | None:
        """Look for another way home; stop without one."""
        return None if self._go(inputs) is None else "no way home inside the fence"

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
