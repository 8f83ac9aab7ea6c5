"""RTL: back to home or the nearest rally point along a straight line, then hold there."""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.config import VesselConfig
from companion.core.geodesy import LocalFrame
from companion.core.types import Home, ModeId, NavState, Setpoint, Severity
from companion.mission.plan import PlanKind, Plans
from companion.modes.events import EventLog
from companion.modes.headway import Headway
from companion.modes.mode import Mode, ModeInputs
from companion.modes.station import Station
from companion.modes.watch import WatchCircles
from companion.params import Parameters

_NAV_RALLY_POINT = 5100


class ReturnPoint:
    """Where RTL and the mission's return item lead: home, or with RTL_USE_RALLY the nearest of home and the rally points."""

    def __init__(self, parameters: Parameters, plans: Plans, frame: Callable[[], LocalFrame]) -> None:
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

    def nearest(self, nav: NavState, home: Home | None) -> tuple[str, float, float] | None:
        """(name, north_m, east_m) of the nearest, or None where there is none."""
        frame = self._frame()
        points = [(name, *frame.to_ned(lat_deg, lon_deg)) for name, lat_deg, lon_deg in self.candidates(home)]
        return min(points, key=lambda point: (point[1] - nav.north_m) ** 2 + (point[2] - nav.east_m) ** 2, default=None)


class RtlMode(Mode):
    """Remembers where it leads, chosen on entry, and whether arrival was said."""

    id = ModeId.RTL
    text = "Back to home or the nearest rally point, then holds there"

    def __init__(self, config: VesselConfig, parameters: Parameters, point: ReturnPoint, events: EventLog) -> None:
        self._point = point
        self._events = events
        self._station = Station(config, parameters)
        self._name = "home"
        self._arrival_said = False
        self._watch = WatchCircles(parameters, events, "RTL")
        self._headway = Headway("RTL", events)

    def check(self, inputs: ModeInputs) -> str | None:
        return None if self._point.candidates(inputs.home) else "no home position"

    def enter(self, inputs: ModeInputs) -> str | None:
        point = self._point.nearest(inputs.nav, inputs.home)
        if point is None:
            return "no home position"
        self._name, north_m, east_m = point
        self._arrival_said = False
        self._watch.reset()
        self._headway.reset()
        self._station.go_to(inputs.nav, north_m, east_m, None, None)
        return None

    def stuck_s(self, now_s: float) -> float | None:
        return self._headway.stuck_s(now_s)

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
