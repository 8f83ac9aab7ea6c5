"""Keeping clear of other vessels: slower, stopped, or around them, and back to the route. The one place that acts on traffic.

The mode goes on beside it: its path follower keeps its place along the route while the boat is off it, and takes over again where the way around
meets the route. CA_ACTION says how far this goes: 1 says what comes, 2 slows down or stops, 3 alters course where that can be done inside
the fence, and else slows down or stops. It acts while a mode sails along a path: Mission, RTL, and a go-to of Hold.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

from companion.config import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.geodesy import LocalFrame
from companion.core.types import Contact, Setpoint, SetpointKind, Severity
from companion.guidance import colreg, evasion
from companion.guidance.colreg import Encounter
from companion.guidance.crab import top_speed_mps
from companion.guidance.follower_choice import ChosenFollower
from companion.guidance.path_following import Waypoint
from companion.modes.events import EventLog
from companion.modes.fence_guard import FenceGuard
from companion.modes.mode import Mode, ModeInputs
from companion.modes.station import Station
from companion.modes.traffic_watch import Conflict, TrafficWatch
from companion.nav.traffic import TrafficTracker
from companion.params import Parameters

_OFF, _WARN, _SLOW = 0, 1, 2  # values of CA_ACTION; above: alter course
_CHECK_S = 1.0
_WAY_M = 500.0  # of the route that is looked at
_THIN_M = 2.0  # between its points
_BEYOND_M = 15.0  # of the route that shapes the end of a way around
_OFF_ROUTE_M = 3.0  # of the meeting point: the route is another one now
_PACES = {0.5: 60.0, 0.0: 75.0}  # shares of the cruise speed, and what they cost against metres of a way around
_BETTER_M = 0.1
_PATIENT = frozenset({Encounter.STANDING, Encounter.OVERTAKING})
_MOVING_MPS = 0.3
_STOPPED_MPS = 0.1  # allowed speed from which on the place is held
_ROUNDING = 0.2  # of the shortest part of a way around: its corners are taken at speed
_BRAKE = 1.5  # times PATH_ACC


class TrafficGuard:
    """`steer(setpoint, mode, inputs)` each tick, on the mode's setpoint; `rest()` in ticks without one.

    Remembers the mode it acts for, the way around and where it meets the route, the speed that is allowed, whether it holds the boat where it
    stopped, and the heading last asked for until the mode's own has been met.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        tracker: TrafficTracker,
        events: EventLog,
        frame: Callable[[], LocalFrame],
        fence: FenceGuard,
    ) -> None:
        self._parameters = parameters
        self._events = events
        self._fence = fence
        self._watch = TrafficWatch(config, parameters, tracker, events, frame)
        self._station = Station(config, parameters, fence)
        self._holding = False
        self._follower = ChosenFollower(parameters, config.limits.sway_n > 0.0, top_speed_mps(config))
        self._mode: Mode | None = None
        self._detour: evasion.Detour | None = None
        self._share = 1.0  # of the cruise speed, allowed
        self._limit_mps = math.inf
        self._yaw: float | None = None
        self._next_s = 0.0
        self._said: tuple[object, ...] = ()

    def rest(self) -> None:
        """The boat is not under way by a mode: nothing is kept of what was done."""
        self._detour = self._mode = self._yaw = None
        self._share, self._limit_mps = 1.0, math.inf
        self._holding = False
        self._said = ()

    def steer(self, setpoint: Setpoint, mode: Mode, inputs: ModeInputs) -> Setpoint:
        """The setpoint to follow: the mode's, or one that keeps clear."""
        if mode is not self._mode:
            self.rest()
            self._mode = mode
        if self._parameters["CA_ACTION"] == _OFF or not inputs.nav.position_valid:
            self._watch.forget()
            self.rest()
            return setpoint
        sailing = setpoint.kind is SetpointKind.PATH
        inputs = replace(inputs, speed_mps=mode.way_speed_mps(inputs))
        if inputs.now_s >= self._next_s:
            self._next_s = inputs.now_s + _CHECK_S
            self._check(_near_part(mode.way_ahead()) if sailing else (), inputs)
        if not sailing:
            self._detour, self._yaw, self._holding = None, None, False
            return setpoint
        if self._detour is not None:
            setpoint = self._around(setpoint, inputs)
        setpoint = self._paced(setpoint, inputs)
        if self._detour is not None or self._share < 1.0:
            mode.excuse()
        if self._share == 0.0 and (self._holding or self._limit_mps < _STOPPED_MPS):
            return self._hold(setpoint, inputs)
        self._holding = False
        return self._steady(setpoint, inputs.dt_s)

    # --- what to do ------------------------------------------------------------------------------------------------

    def _check(self, route: Sequence[evasion.Place], inputs: ModeInputs) -> None:
        nav, now_s = inputs.nav, inputs.now_s
        over_ground = (nav.north_mps, nav.east_mps)
        speed = math.hypot(*over_ground)
        contacts = self._watch.contacts(nav, max(speed, inputs.speed_mps), now_s)
        here = (nav.north_m, nav.east_m)
        if len(route) < 2 or evasion.length_of(route) < 1.0:
            drift = (here, (nav.north_m + 1000.0 * nav.north_mps, nav.east_m + 1000.0 * nav.east_mps))
            steady = evasion.Pace(speed, speed, self._acceleration)
            self._watch.tell(self._watch.conflicts(nav, drift, steady, over_ground, contacts, now_s) if speed > _MOVING_MPS else (), now_s)
            self._detour, self._share = None, 1.0
            return
        if self._detour is not None and not _is_on(self._detour.points[-1], route):
            self._detour = None
        way = route if self._detour is None else self._remaining(route)
        ahead = _velocity(way, inputs.speed_mps) if self._detour is None else over_ground
        found = self._watch.conflicts(nav, way, self._pace(speed, inputs), ahead, contacts, now_s)
        self._watch.tell(found, now_s)
        if self._detour is not None or self._share < 1.0:
            self._watch.keep_in_mind(now_s)
        if self._parameters["CA_ACTION"] == _WARN:
            self._detour, self._share = None, 1.0
            return
        urgent = [c for c in found if c.gives_way or c.due_s < self._parameters["CA_STAND_T"]]
        if urgent:
            self._avoid(urgent, route, way, contacts, inputs)
        elif self._share < 1.0 and self._may_speed_up(way, contacts, inputs):
            self._share = 1.0
            self._say(Severity.INFO, "Traffic: going on", now_s)

    def _avoid(
        self, urgent: Sequence[Conflict], route: Sequence[evasion.Place], way: Sequence[evasion.Place], contacts: Sequence[Contact], inputs: ModeInputs
    ) -> None:
        """The cheapest way to keep the distance; where nothing keeps it, what keeps most of it."""
        keep_m = self._parameters["CA_DIST"] + self._watch.margin_m(inputs.nav)
        best: tuple[float, evasion.Detour | None, float] = (-math.inf, None, 1.0)
        for detour, share in self._options(urgent, route, keep_m, inputs):
            along = way if detour is None else (*detour.points, *evasion.rest(route, detour.length_m))
            clear_m = self._clear_m(along, share, contacts, urgent, inputs)
            if clear_m > best[0] + _BETTER_M and (detour is None or self._fence.line_refusal(detour.points) is None):
                best = clear_m, detour, share
            if best[0] >= keep_m:
                break
        in_time = all(c.met in _PATIENT and c.due_s > self._parameters["CA_STAND_T"] for c in urgent)
        if best[1] is None and in_time:
            return  # who lies or goes ahead of the boat may be come nearer to before it slows down
        self._take(best[1], best[2], route, urgent[0], inputs)

    def _options(
        self, urgent: Sequence[Conflict], route: Sequence[evasion.Place], keep_m: float, inputs: ModeInputs
    ) -> list[tuple[evasion.Detour | None, float]]:
        """(way around, share of the speed), the cheapest first; going on as now comes first of all."""
        options: list[tuple[float, evasion.Detour | None, float]] = [(0.0, None, 1.0), *((cost, None, share) for share, cost in _PACES.items())]
        if self._parameters["CA_ACTION"] > _SLOW:
            allowed = [side for side in (colreg.STARBOARD, colreg.PORT) if all(side in colreg.sides(c.met) for c in urgent)]
            room_m = keep_m + self._watch.radius_m + max(c.contact.radius_m for c in urgent)
            detours = evasion.detours((inputs.nav.north_m, inputs.nav.east_m), route, room_m, allowed)
            options += [(detour.cost_m, detour, 1.0) for detour in detours]
        return [(detour, share) for _, detour, share in sorted(options, key=lambda option: option[0])]

    def _clear_m(self, way: Sequence[evasion.Place], share: float, contacts: Sequence[Contact], urgent: Sequence[Conflict], inputs: ModeInputs) -> float:
        """Least clear water along a way, up to its end or CA_TIME; −∞ where it leads across the bow of a vessel that has the right of way."""
        nav, speed = inputs.nav, share * inputs.speed_mps
        duration_s = self._parameters["CA_TIME"]
        if share == 1.0 and speed > 0.0:
            duration_s = max(duration_s, min(evasion.length_of(way), _WAY_M) / speed)
        t_s = evasion.times(duration_s)
        pace = evasion.Pace(math.hypot(nav.north_mps, nav.east_mps), speed, self._acceleration)
        places = evasion.travel(way, pace, t_s)
        clear_m = evasion.least_clear_water(places, t_s, contacts, self._watch.radius_m)
        reach_m = evasion.astern_reach_m(self._parameters["CA_DIST"])
        for conflict in urgent:
            other = conflict.contact
            if share > 0.0 and colreg.keeps_astern(conflict.met, other.status) and evasion.crosses_ahead(places, t_s, other, reach_m):
                return -math.inf
        return clear_m

    def _take(
        self, detour: evasion.Detour | None, share: float, route: Sequence[evasion.Place], conflict: Conflict, inputs: ModeInputs
    ) -> None:
        if detour is not None:
            shortest = min(math.dist(a, b) for a, b in pairwise(detour.points))
            radius = max(self._parameters["NAV_ACC_RAD"], _ROUNDING * shortest)
            waypoints = [Waypoint(*point, radius_m=radius, straight=True) for point in detour.points[1:]]
            onward = evasion.cut(evasion.rest(route, detour.length_m), _BEYOND_M)[1:][-1:]
            lay = self._follower.start if self._detour is None else self._follower.replace
            lay(waypoints, inputs.nav, False, beyond=[Waypoint(*point, straight=True) for point in onward])
        elif self._detour is not None and share == 1.0:
            return  # what is under way is as good as anything
        self._detour = detour if detour is not None else self._detour
        self._share = share
        label = conflict.contact.label
        if detour is not None:
            text = f"Traffic: course to {('port', 'the route', 'starboard')[1 + detour.side]} for {label}"
        else:
            text = f"Traffic: {'stopping' if share == 0.0 else 'slowing down' if share < 1.0 else 'no way to keep clear'} for {label}"
        self._say(Severity.WARNING, text, inputs.now_s)

    def _may_speed_up(self, way: Sequence[evasion.Place], contacts: Sequence[Contact], inputs: ModeInputs) -> bool:
        keep_m = self._parameters["CA_DIST"] + self._watch.margin_m(inputs.nav)
        return self._clear_m(way, 1.0, contacts, (), inputs) >= keep_m

    # --- doing it --------------------------------------------------------------------------------------------------

    def _around(self, setpoint: Setpoint, inputs: ModeInputs) -> Setpoint:
        """Along the way around; where it ends, the mode has the boat again."""
        progress = self._follower.update(inputs.nav, inputs.speed_mps, inputs.dt_s)
        if not progress.finished:
            return progress.setpoint
        self._detour = None
        self._next_s = inputs.now_s
        self._say(Severity.INFO, "Traffic: back on the route", inputs.now_s)
        return setpoint

    def _remaining(self, route: Sequence[evasion.Place]) -> Sequence[evasion.Place]:
        """What is left of the way around, and the route behind it."""
        assert self._detour is not None
        points = [point for leg in self._follower.legs for point in leg]
        end = min(range(len(route)), key=lambda i: math.dist(route[i], points[-1]))
        return _near_part([*points, *route[end + 1 :]])

    def _paced(self, setpoint: Setpoint, inputs: ModeInputs) -> Setpoint:
        """No faster than allowed; the speed changes as on any path."""
        demand = math.hypot(setpoint.surge_mps, setpoint.sway_mps)
        step = self._parameters["PATH_ACC"] * inputs.dt_s
        if self._share < 1.0:
            wanted = self._share * inputs.speed_mps
            self._limit_mps = max(wanted, min(self._limit_mps, demand) - _BRAKE * step)
        elif not math.isinf(self._limit_mps):
            self._limit_mps += step
            if self._limit_mps >= demand:
                self._limit_mps = math.inf
        if demand <= self._limit_mps:
            return setpoint
        share = self._limit_mps / demand
        return replace(setpoint, surge_mps=share * setpoint.surge_mps, sway_mps=share * setpoint.sway_mps, surge_mps2=min(0.0, setpoint.surge_mps2))

    def _hold(self, setpoint: Setpoint, inputs: ModeInputs) -> Setpoint:
        """Stay where the boat has stopped; where it leads to stays what it was."""
        if not self._holding:
            self._holding = True
            self._station.stop_here(inputs.nav)
        held = self._station.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        self._yaw = held.yaw_rad
        return replace(held, target_north_m=setpoint.target_north_m, target_east_m=setpoint.target_east_m)

    def _steady(self, setpoint: Setpoint, dt_s: float) -> Setpoint:
        """Between the mode's heading and that of a way around the heading asked for turns at PATH_YAW_RATE."""
        if setpoint.yaw_rad is None:
            return setpoint
        if self._detour is not None:
            self._yaw = setpoint.yaw_rad
        elif self._yaw is not None:
            most, off = math.radians(self._parameters["PATH_YAW_RATE"]) * dt_s, wrap_pi(setpoint.yaw_rad - self._yaw)
            self._yaw = None if abs(off) <= most else wrap_pi(self._yaw + math.copysign(most, off))
            if self._yaw is not None:
                return replace(setpoint, yaw_rad=self._yaw)
        return setpoint

    # --- parts -----------------------------------------------------------------------------------------------------

    @property
    def _acceleration(self) -> float:
        return self._parameters["PATH_ACC"]

    def _pace(self, speed_mps: float, inputs: ModeInputs) -> evasion.Pace:
        return evasion.Pace(speed_mps, self._share * inputs.speed_mps, self._acceleration)

    def _say(self, severity: Severity, text: str, now_s: float) -> None:
        if self._said != (text,):
            self._said = (text,)
            self._events.say(now_s, severity, "traffic_action", text)


def _near_part(way: Sequence[evasion.Place]) -> Sequence[evasion.Place]:
    """Of a way, what is looked at."""
    return evasion.thinned(evasion.cut(way, _WAY_M), _THIN_M) if way else ()


def _is_on(point: evasion.Place, route: Sequence[evasion.Place]) -> bool:
    for a, b in pairwise(route):
        north, east = b[0] - a[0], b[1] - a[1]
        square = north * north + east * east
        share = 0.0 if square == 0.0 else ((point[0] - a[0]) * north + (point[1] - a[1]) * east) / square
        share = min(1.0, max(0.0, share))
        if math.dist(point, (a[0] + share * north, a[1] + share * east)) < _OFF_ROUTE_M:
            return True
    return False


def _velocity(way: Sequence[evasion.Place], speed_mps: float) -> colreg.Velocity:
    """At which the boat sets out along a way, by its first metres."""
    ahead = evasion.cut(way, 5.0)[-1]
    away = max(1e-6, math.dist(way[0], ahead))
    return (ahead[0] - way[0][0]) / away * speed_mps, (ahead[1] - way[0][1]) / away * speed_mps
