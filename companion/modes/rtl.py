"""RTL: back to home or the nearest rally point, by a way that keeps inside the fence, then hold there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from companion.config import VesselConfig
from companion.core.geodesy import LocalFrame
from companion.core.types import Home, ModeId, Setpoint, Severity
from companion.mission.plan import PlanKind, Plans
from companion.modes.events import EventLog
from companion.modes.fence_guard import FenceGuard, Way
from companion.modes.headway import Headway
from companion.modes.mode import Mode, ModeInputs
from companion.modes.station import Station
from companion.modes.watch import WatchCircles
from companion.params import Parameters

_NAV_RALLY_POINT = 5100
_SAME_PLACE_M = 1.0


class ReturnPoint:
    """Where RTL and the mission's return item lead: home, or with RTL_USE_RALLY the one of home and the rally points with the shortest way."""

    def __init__(self, parameters: Parameters, plans: Plans, frame: Callable[[], LocalFrame], fence: FenceGuard) -> None:
        self._fence = fence
        self._parameters = parameters
        self._plans = plans
        self._frame = frame

    def candidates(self, home: Home | None) -> list[tuple[str, float, float]]:
        """(name, lat_deg, lon_deg) of all points that come into question."""
        points = [] if home is None else [("home", home.lat_deg, home.lon_deg)]
        if self._parameters["RTL_USE_RALLY"]:
            rally = [item for item in self._plans.items(PlanKind.RALLY) if item.command == _NAV_RALLY_POINT]
            points += [(f"rally point {item.seq}", item.lat_deg, item.lon_deg) for item in rally]
        return points

    def way(self, begin: tuple[float, float], home: Home | None) -> tuple[str, Way] | str:
        """(name, way) to the one with the shortest way from `begin` (north_m, east_m), or why there is none."""
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


class RtlMode(Mode):
    """Remembers where it leads, chosen on entry, whether arrival was said, and what the last check found from where."""

    id = ModeId.RTL
    text = "Back to home or the nearest rally point, inside the fence, then holds there"

    def __init__(self, config: VesselConfig, parameters: Parameters, point: ReturnPoint, events: EventLog, fence: FenceGuard) -> None:
        self._point = point
        self._events = events
        self._fence = fence
        self._station = Station(config, parameters, fence)
        self._name = "home"
        self._arrival_said = False
        self._checked: tuple[object, tuple[float, float], str | None] = ((), (0.0, 0.0), None)
        self._watch = WatchCircles(parameters, events, "RTL")
        self._headway = Headway("RTL", events)

    def check(self, inputs: ModeInputs) -> str | None:
        """Asked every tick while it waits disarmed, so what was found is good for as long as the boat stays about there."""
        candidates, nav = self._point.candidates(inputs.home), inputs.nav
        if not candidates:
            return "no home position"
        if not self._fence.key or not nav.position_valid:
            return None
        key, place = (self._fence.key, tuple(candidates)), (nav.north_m, nav.east_m)
        if key != self._checked[0] or math.dist(place, self._checked[1]) > _SAME_PLACE_M:
            found = self._point.way(place, inputs.home)
            self._checked = key, place, found if isinstance(found, str) else None
        return self._checked[2]

    def enter(self, inputs: ModeInputs) -> str | None:
        found = self._point.way((inputs.nav.north_m, inputs.nav.east_m), inputs.home)
        if isinstance(found, str):
            return found
        self._name, way = found
        self._arrival_said = False
        self._watch.reset()
        self._headway.reset()
        self._station.go_along(inputs.nav, way)
        return None

    def stuck_s(self, now_s: float) -> float | None:
        return self._headway.stuck_s(now_s)

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        return self._station.way_ahead

    def excuse(self) -> None:
        self._headway.reset()

    def update(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._station.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        if self._station.way_m is not None:
            self._headway.update(self._station.way_m, inputs.speed_mps, inputs.now_s)
        if not self._arrival_said and not self._station.going:
            self._arrival_said = True
            self._events.say(inputs.now_s, Severity.NOTICE, "rtl_arrived", f"RTL: at {self._name}, holding")
        if self._arrival_said:
            north_m, east_m = self._station.target
            self._watch.update(math.hypot(north_m - inputs.nav.north_m, east_m - inputs.nav.east_m), inputs.now_s)
        return setpoint
