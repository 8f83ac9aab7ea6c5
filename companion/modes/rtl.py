"""RTL: returns to home or a rally point by a way inside the fence, then holds there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.config.vessel import VesselConfig
from companion.core.decision import KnownRefusal, ModeDeclaration, ModeId, ModeInputs, TextKind
from companion.core.events import EventLog
from companion.core.setpoint import PoseSetpoint, Setpoint
from companion.core.work import Lane
from companion.fence.allowed import Way
from companion.modes.mode import Mode
from companion.modes.parts.headway import Headway
from companion.modes.parts.return_point import NO_WAY, Homeward, Return, ReturnPoint
from companion.modes.parts.search import SAME_PLACE_M, Answer, Search, Waiting
from companion.modes.parts.transit_round import transit_round
from companion.obstacles.charted_fence import ChartedFence
from companion.obstacles.way_round import WayRound
from companion.params.store import Parameters
from companion.positioning.hold_point import HoldPoint
from companion.positioning.watch_circles import WatchCircles
from companion.positioning.weathervane import Weathervane

_MOST_SEARCHES = 3  # for one way: the boat may have moved until it is found


@dataclass(frozen=True, slots=True)
class ReturnByTrack:
    """Return along the boat's own track, whatever RTL_TRACK says."""

    @property
    def mode(self) -> ModeId:
        """As every order's."""
        return ModeId.RTL


class RtlMode(Mode):
    """Remembers the destination chosen on entry, whether it is reached, whether its own track was asked for, and the
    search for a way. While the way is looked for the boat holds."""

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
        self._search: Search[Homeward | str] = Search(charted.submit_urgent)
        self._seeks = False
        self._waiting = Waiting(events)
        self._searches = 0
        self._checks: Search[Homeward | str] = Search(charted.submit)
        self._watch = WatchCircles(parameters, events, "RTL")
        self._weathervane = Weathervane(config, parameters, events, "RTL", self._fence)
        self._headway = Headway("RTL", events)

    def check(self, inputs: ModeInputs) -> str | None:
        """Refuse without home, or without a way inside the fence as far as that is known. Callers check every tick
        while disarmed, so the result is kept while the boat stays within 1 m."""
        nav, key = inputs.nav, self._point.key(inputs.home)
        returning = self._point.now(inputs.home)
        if not returning.candidates:
            return "no home position"
        if not self._fence.key or not nav.position_valid:
            return None
        here = (nav.north_m, nav.east_m)
        answer = self._checks.look(key, here, lambda: returning.in_lane(Lane.USUAL).find(here))
        newest = answer or self._checks.known(key, here)
        return newest.found if newest is not None and isinstance(newest.found, str) else None

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
        self._seeks = False
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
        self._search.drop()
        self._events.renew("rtl_arrived")
        returning = self._point.back(inputs.home, self._by_track)
        here = (inputs.nav.north_m, inputs.nav.east_m)
        self._seeks = not returning.is_at_hand(here)
        if not self._seeks:
            return self._start(returning.find(here), inputs)
        answer = self._look(returning, inputs)
        if answer is not None:
            return self._start(answer.found, inputs)
        self._arrived = False
        self._hold_point.stop_here(inputs.nav)
        return None

    def _look(self, returning: Return, inputs: ModeInputs) -> Answer[Homeward | str] | None:
        """The way home; None while it is looked for. It may be found when the boat has moved."""
        here, laying = (inputs.nav.north_m, inputs.nav.east_m), self._hold_point.laying()
        key = (*self._point.key(inputs.home), self._by_track)
        return self._search.look(key, here, lambda: returning.in_lane(Lane.URGENT).laid(here, laying), math.inf)

    def _start(self, found: Homeward | str, inputs: ModeInputs) -> str | None:
        self._seeks = False
        if isinstance(found, str):
            return found
        self._name = found.name
        self._arrived = False
        self._watch.reset()
        self._weathervane.free()
        self._headway.reset()
        begin, here = found.way.points[0], (inputs.nav.north_m, inputs.nav.east_m)
        near = math.dist(begin, here) <= SAME_PLACE_M
        self._hold_point.go_along(inputs.nav, found.way, found.laid if near else None)
        return None

    def _seek(self, inputs: ModeInputs) -> None:
        """Start on the way once it is found. One that no longer begins here is looked for again."""
        here = (inputs.nav.north_m, inputs.nav.east_m)
        answer = self._look(self._point.back(inputs.home, self._by_track), inputs)
        if answer is not None and not self._begins_here(answer.found, here):
            self._search.drop()
            self._searches += 1
            if self._searches >= _MOST_SEARCHES:
                self._blocked, self._seeks = NO_WAY, False
                return
            answer = self._look(self._point.back(inputs.home, self._by_track), inputs)
        if answer is not None:
            self._blocked = self._start(answer.found, inputs)
            return
        self._blocked = self._waiting.update(inputs.now_s)
        if self._blocked is not None:
            self._search.drop()
            self._seeks = False

    def _begins_here(self, found: Homeward | str, here: tuple[float, float]) -> bool:
        """Whether a way that was found from about here can be sailed from here."""
        if isinstance(found, str) or math.dist(found.way.points[0], here) <= SAME_PLACE_M:
            return True
        return self._fence.allowed.is_open(here, found.way.points[1])

    def mind_fence(self, inputs: ModeInputs) -> str | None:
        """Look for another way home; stop without one."""
        return None if self._go(inputs) is None else NO_WAY

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
        if self._seeks:
            self._seek(inputs)
        if self._seeks or self._blocked is not None:
            return self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        setpoint = self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        if self._hold_point.way_m is not None:
            self._headway.update(self._hold_point.way_m, inputs.speed_mps, inputs.now_s)
        if not self._arrived and not self._hold_point.going:
            self._arrived = True
            self._events.say(inputs.now_s, TextKind.ROUTINE, "rtl_arrived", f"RTL: at {self._name}, holding")
        if self._hold_point.arrived or self._weathervane.turning:
            self._keep_place(inputs)
        elif isinstance(setpoint, PoseSetpoint):
            self._weathervane.see_way(inputs, (setpoint.north_m, setpoint.east_m))
        if isinstance(setpoint, PoseSetpoint) and self._weathervane.driven_off:
            return setpoint.within(setpoint.circle_m, True)
        return setpoint

    def _keep_place(self, inputs: ModeInputs) -> None:
        """At home, or as near as the weather lets the boat come: watch how far off it is, and turn its bow to weather
        that drives it off sideways."""
        north_m, east_m = self._hold_point.target
        self._watch.update(math.hypot(north_m - inputs.nav.north_m, east_m - inputs.nav.east_m), inputs.now_s)
        alarmed = self._watch.alarmed or self._headway.is_stuck(inputs.now_s)
        self._weathervane.see(inputs, (north_m, east_m), self._watch.left, alarmed)
        if self._arrived or self._weathervane.driven_off:
            heading_rad = self._weathervane.update(inputs, self._hold_point.held[2])
            if heading_rad is not None:
                self._hold_point.turn_to(heading_rad, self._weathervane.driven_off)
