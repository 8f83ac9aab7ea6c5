"""Keeping clear of other vessels: slow down, stop, or go around them and back to the route. Only this module acts on
traffic.

It acts while a mode sails along a path: Mission, RTL, and a go-to of Hold. The mode runs on meanwhile: its path
tracking keeps its place along the route while the boat is off it, and steers again where the detour meets the route.
CA_ACTION sets how far it goes: 1 announces conflicts; 2 slows down or stops; 3 alters course where the fence and
obstacles allow, and else slows down or stops. What ranging sensors see moving is minded as under 3, also where it is
0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Protocol

from companion.baselines.path_choice import ChosenPathTracker
from companion.config.reversing import turns_on_the_spot
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.decision import ModeInputs, TextKind
from companion.core.estimate import Contact
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.setpoint import PathSetpoint, Setpoint, braked, desired_motion
from companion.fence.guard import FenceGuard
from companion.guidance.turning import turning_of
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from companion.positioning.hold_point import HoldPoint
from companion.traffic import colreg, evasion
from companion.traffic.colreg import Encounter
from companion.traffic.tracker import TrafficTracker
from companion.traffic.watch import Conflict, TrafficWatch

_OFF, _WARN, _SLOW, _ALTER = 0, 1, 2, 3  # values of CA_ACTION
_CHECK_S = 1.0
_WAY_M = 500.0  # of the route that is checked, by a slow boat
_THIN_M = 2.0  # between the points of the route that are checked
_BEYOND_M = 15.0  # of the route beyond a detour, which shapes the detour's end
_OFF_ROUTE_M = 3.0  # from the detour's end: further off, the route has changed
_SPEED_SHARES = {0.5: 60.0, 0.0: 75.0}  # shares of the cruise speed: cost, to compare with metres of detour
_BETTER_M = 0.1
_PASSED_S, _LONGEST_S = 10.0, 150.0  # of a prediction
_WORTH_CROSSING_M = 1.0  # of clear water
_SOONER = 0.95  # of a shortfall: the speed changes for less than that
_PATIENT = frozenset({Encounter.STANDING, Encounter.OVERTAKING})  # encounters in which slowing down can wait
_MOVING_MPS = 0.3
_STOPPED_MPS = 0.1  # below this limit the boat holds its position
_ROUNDING = 0.2  # radius of a detour's corners, of its shortest leg: they are taken at speed
_BRAKE = 1.5  # times PATH_ACC
# A boat at more than this speed, a jet or one that planes, may lose so much of it in the bends of a detour.
_FAST_MPS, _BEND_SHARE, _BEND_BRAKE = 3.0, 0.6, 2.0


class SailingMode(Protocol):
    """What `TrafficGuard` needs of a mode."""

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        """(north_m, east_m) of the path from the boat on; empty where the mode sails along none."""
        ...

    def way_speed_mps(self, inputs: ModeInputs) -> float:
        """Speed along that path."""
        ...

    def excuse(self) -> None:
        """The boat makes no way for good reason: the mode must not report it as stuck."""
        ...


class TrafficGuard:
    """`steer(setpoint, mode, inputs)` each tick, on the mode's setpoint; `reset()` in ticks without one.

    Remembers the mode it acts for, the detour, the speed limit, whether it holds the boat where it stopped, and the
    last heading asked for until that of the mode is reached.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        tracker: TrafficTracker,
        events: EventLog,
        frame: Callable[[], LocalFrame],
        fence: FenceGuard,
        movers: Callable[[float], Sequence[Contact]] = lambda _now_s: (),
        refusal: Callable[[Sequence[evasion.Place]], str | None] | None = None,
    ) -> None:
        """`movers(now_s)`: what ranging sensors see moving. `refusal(line)`: why the boat may not be sent along a line;
        None: the fence's."""
        self._parameters = parameters
        self._events = events
        self._refusal = fence.line_refusal if refusal is None else refusal
        self._watch = TrafficWatch(config, parameters, tracker, events, frame, movers)
        self._hold_point = HoldPoint(config, parameters, fence)
        self._holding = False
        self._path_tracker = ChosenPathTracker(
            parameters,
            config.limits.sway_n > 0.0,
            top_speed_mps(config),
            turning=turning_of(config, turns_on_the_spot(config.thrusters)),
        )
        self._mode: SailingMode | None = None
        self._detour: evasion.Detour | None = None
        self._share = 1.0  # of the cruise speed, that is allowed
        self._limit_mps = math.inf
        self._yaw: float | None = None
        self._next_s = self._begun_s = 0.0
        self._announced = ""
        self._action = _OFF

    @property
    def detour_ahead(self) -> Sequence[evasion.Place]:
        """The rest of the detour under way; empty without one."""
        return () if self._detour is None else [point for leg in self._path_tracker.legs for point in leg]

    def give_up_detour(self) -> None:
        """Leave the detour, which something blocks, and look for another at once."""
        self._detour = None
        self._next_s = 0.0

    def reset(self) -> None:
        """Forget the detour and the speed limit: no mode sails along a path."""
        self._detour = self._mode = self._yaw = None
        self._share, self._limit_mps = 1.0, math.inf
        self._holding = False
        self._announced = ""

    def steer(self, setpoint: Setpoint, mode: SailingMode, inputs: ModeInputs) -> Setpoint:
        """The mode's setpoint, or one that keeps clear of traffic."""
        if mode is not self._mode:
            self.reset()
            self._mode = mode
        self._action = self._action_now(inputs.now_s)
        if self._action == _OFF or not inputs.nav.position_valid:
            self._watch.forget()
            self.reset()
            return setpoint
        inputs = replace(inputs, speed_mps=mode.way_speed_mps(inputs))
        if inputs.now_s >= self._next_s:
            self._next_s = inputs.now_s + _CHECK_S
            self._check(
                _near_part(mode.way_ahead(), inputs.speed_mps) if isinstance(setpoint, PathSetpoint) else (), inputs
            )
        if not isinstance(setpoint, PathSetpoint):
            self._detour, self._yaw, self._holding = None, None, False
            return setpoint
        if self._detour is not None:
            setpoint = self._around(setpoint, inputs)
        setpoint = self._limited(setpoint, inputs)
        if self._detour is not None or self._share < 1.0:
            mode.excuse()
        if self._share == 0.0 and (self._holding or self._limit_mps < _STOPPED_MPS):
            return self._hold(setpoint, inputs)
        self._holding = False
        return self._steady(setpoint, inputs.dt_s)

    def _action_now(self, now_s: float) -> int:
        """CA_ACTION; where it is off, what sensors see moving is kept clear of nevertheless."""
        action = int(self._parameters["CA_ACTION"])
        return _ALTER if action == _OFF and self._watch.sees_movers(now_s) else action

    # --- deciding --------------------------------------------------------------------------------------------------

    def _check(self, route: Sequence[evasion.Place], inputs: ModeInputs) -> None:
        """Look for conflicts along the route, and decide what to do about them."""
        nav, now_s = inputs.nav, inputs.now_s
        over_ground = (nav.north_mps, nav.east_mps)
        speed = math.hypot(*over_ground)
        contacts = self._watch.contacts(nav, max(speed, inputs.speed_mps), now_s)
        here = (nav.north_m, nav.east_m)
        if len(route) < 2 or evasion.length_of(route) < 1.0:
            drift = (here, (nav.north_m + 1000.0 * nav.north_mps, nav.east_m + 1000.0 * nav.east_mps))
            steady = evasion.SpeedRamp(speed, speed, self._acceleration)
            self._watch.announce(
                self._watch.conflicts(nav, drift, steady, over_ground, contacts, now_s) if speed > _MOVING_MPS else (),
                now_s,
            )
            self._detour, self._share = None, 1.0
            return
        if self._detour is not None and not _is_on(self._detour.points[-1], route):
            self._detour = None
        way = route if self._detour is None else self._remaining(route, inputs.speed_mps)
        ahead = _velocity(way, inputs.speed_mps) if self._detour is None else over_ground
        found = self._watch.conflicts(nav, way, self._ramp(self._share, inputs), ahead, contacts, now_s)
        self._watch.announce(found, now_s)
        if self._detour is not None or self._share < 1.0:
            self._watch.extend(now_s)
        if self._action == _WARN:
            self._detour, self._share = None, 1.0
            return
        urgent = [c for c in found if c.we_give_way or c.due_s < self._parameters["CA_STAND_T"]]
        if urgent:
            self._avoid(urgent, route, way, contacts, inputs)
        elif self._share < 1.0 and self._may_speed_up(way, contacts, inputs):
            self._share = 1.0
            self._announce(TextKind.ROUTINE, "Traffic: resuming speed", now_s)

    def _avoid(
        self,
        urgent: Sequence[Conflict],
        route: Sequence[evasion.Place],
        way: Sequence[evasion.Place],
        contacts: Sequence[Contact],
        inputs: ModeInputs,
    ) -> None:
        """Take the cheapest option that keeps CA_DIST; where none does, the one that keeps most of it, and of speeds
        that keep as much the one that is sooner clear. To cross ahead of a vessel that has the right of way is no
        option, unless all others would come nearer still."""
        keep_m = self._parameters["CA_DIST"] + self._watch.margin_m(inputs.nav)
        best: tuple[float, evasion.Detour | None, float] = (-math.inf, None, 1.0)
        ahead: tuple[float, evasion.Detour | None, float] = (-math.inf, None, 1.0)  # of those that cross ahead
        kept: dict[float, float] = {}  # clear water by share of the speed, without a detour
        for detour, share in self._options(urgent, route, keep_m, inputs):
            along = way if detour is None else (*detour.points, *evasion.remainder(route, detour.length_m))
            clear_m, crosses = self._clear_m(along, share, contacts, urgent, inputs, detour is not None)
            before_m = ahead[0] if crosses else best[0]
            if detour is None and not crosses:
                kept[share] = clear_m
            if clear_m > before_m + _BETTER_M and (detour is None or self._refusal(detour.points) is None):
                if crosses:
                    ahead = clear_m, detour, share
                else:
                    best = clear_m, detour, share
            if best[0] >= keep_m:
                break
        if best[0] < self._parameters["CA_DIST"] and ahead[0] > best[0] + _WORTH_CROSSING_M:
            best = ahead
        else:
            best = self._soonest_clear(best, kept, way, contacts, keep_m, inputs)
        if best[1] is None and all(self._can_wait(c, inputs.speed_mps) for c in urgent):
            return
        self._begin(best[1], best[2], route, urgent[0], inputs)

    def _soonest_clear(
        self,
        best: tuple[float, evasion.Detour | None, float],
        kept: dict[float, float],
        way: Sequence[evasion.Place],
        contacts: Sequence[Contact],
        keep_m: float,
        inputs: ModeInputs,
    ) -> tuple[float, evasion.Detour | None, float]:
        """Of the shares of the speed that keep as much clear water as the best, the one by which the others are sooner
        clear. A vessel that is nearest now comes no nearer whatever the boat does, but it need not go on beside that
        vessel or around its bow. `kept`: clear water by share."""
        clear_m, detour, share = best
        if detour is not None or clear_m >= keep_m:
            return best
        t_s, short = evasion.time_steps(self._parameters["CA_TIME"]), {share: math.inf}
        for one in (one for one, one_m in kept.items() if one_m >= clear_m - _BETTER_M):
            places = evasion.places_along(way, self._ramp(one, inputs), t_s)
            short[one] = evasion.shortfall_ms(places, t_s, contacts, self._watch.radius_m, keep_m)
        soonest = min(short, key=lambda one: short[one])
        return best if short[soonest] >= _SOONER * short[share] else (kept[soonest], None, soonest)

    def _can_wait(self, conflict: Conflict, speed_mps: float) -> bool:
        """Whether the boat may still come nearer: to a vessel that is at rest or goes ahead of it, or one that is met
        further ahead than a detour reaches."""
        patient = conflict.met in _PATIENT or conflict.due_s * speed_mps > evasion.reach_m(speed_mps)
        return patient and conflict.due_s > self._parameters["CA_STAND_T"]

    def _options(
        self, urgent: Sequence[Conflict], route: Sequence[evasion.Place], keep_m: float, inputs: ModeInputs
    ) -> list[tuple[evasion.Detour | None, float]]:
        """(detour, share of the speed), the cheapest first; the very first is to go on unchanged."""
        options: list[tuple[float, evasion.Detour | None, float]] = [
            (0.0, None, 1.0),
            *((cost, None, share) for share, cost in _SPEED_SHARES.items()),
        ]
        if self._action > _SLOW:
            allowed = [
                side for side in (colreg.STARBOARD, colreg.PORT) if all(side in colreg.sides(c.met) for c in urgent)
            ]
            if self._detour is not None and self._detour.side and inputs.speed_mps > _FAST_MPS:
                allowed = [side for side in allowed if side == self._detour.side]  # too fast to swing to and fro
            room_m = keep_m + self._watch.radius_m + max(c.contact.radius_m for c in urgent)
            detours = evasion.detours((inputs.nav.north_m, inputs.nav.east_m), route, room_m, allowed, inputs.speed_mps)
            options += [(detour.cost_m, detour, 1.0) for detour in detours]
        return [(detour, share) for _, detour, share in sorted(options, key=lambda option: option[0])]

    def _clear_m(
        self,
        way: Sequence[evasion.Place],
        share: float,
        contacts: Sequence[Contact],
        urgent: Sequence[Conflict],
        inputs: ModeInputs,
        bends: bool = False,
    ) -> tuple[float, bool]:
        """Least clear water in m along a way, up to its end, or for CA_TIME and until the `urgent` ones would have
        passed a boat that stops; and whether it crosses ahead of a vessel that has the right of way. `bends`: the way
        is one on which a fast boat may lose speed; then the least with and without that."""
        nav, speed = inputs.nav, share * inputs.speed_mps
        here = nav.north_m, nav.east_m
        duration_s = max([self._parameters["CA_TIME"], *(_passed_s(c.contact, here) for c in urgent)])
        if share == 1.0 and speed > 0.0:
            duration_s = max(duration_s, min(evasion.length_of(way), _way_m(speed)) / speed)
        t_s = evasion.time_steps(duration_s)
        ramp = self._ramp(share, inputs)
        places = evasion.places_along(way, ramp, t_s)
        clear_m = evasion.least_clear_water(places, t_s, contacts, self._watch.radius_m)
        if bends and speed > _FAST_MPS:
            slows = evasion.SpeedRamp(ramp.begin_mps, _BEND_SHARE * speed, _BEND_BRAKE * self._acceleration)
            later = evasion.places_along(way, slows, t_s)
            clear_m = min(clear_m, evasion.least_clear_water(later, t_s, contacts, self._watch.radius_m))
        reach_m = evasion.astern_reach_m(self._parameters["CA_DIST"])
        for conflict in urgent:
            other = conflict.contact
            if (
                share > 0.0
                and colreg.keeps_astern(conflict.met, other.status)
                and evasion.crosses_ahead(places, t_s, other, reach_m)
            ):
                return clear_m, True
        return clear_m, False

    def _begin(
        self,
        detour: evasion.Detour | None,
        share: float,
        route: Sequence[evasion.Place],
        conflict: Conflict,
        inputs: ModeInputs,
    ) -> None:
        """Begin the detour, or the share of the speed, and announce it."""
        if detour is not None:
            shortest = min(math.dist(a, b) for a, b in pairwise(detour.points))
            radius = max(self._parameters["NAV_ACC_RAD"], _ROUNDING * shortest)
            waypoints = [Waypoint(*point, radius_m=radius, straight=True) for point in detour.points[1:]]
            onward = evasion.first_part(evasion.remainder(route, detour.length_m), _BEYOND_M)[1:][-1:]
            lay = self._path_tracker.start if self._detour is None else self._path_tracker.replace
            lay(waypoints, inputs.nav, False, beyond=[Waypoint(*point, straight=True) for point in onward])
        elif self._detour is not None and share == 1.0:
            return  # the present detour is as good as any
        if detour is not None:
            self._detour, self._begun_s = detour, inputs.now_s
        self._share = share
        label = conflict.contact.label
        if detour is not None:
            text = f"Traffic: course to {('port', 'the route', 'starboard')[1 + detour.side]} for {label}"
        elif share == 1.0:
            text = f"Traffic: no way to keep clear of {label}"
        else:
            text = f"Traffic: {'stopping' if share == 0.0 else 'slowing down'} for {label}"
        self._announce(TextKind.ATTENTION, text, inputs.now_s)

    def _may_speed_up(self, way: Sequence[evasion.Place], contacts: Sequence[Contact], inputs: ModeInputs) -> bool:
        keep_m = self._parameters["CA_DIST"] + self._watch.margin_m(inputs.nav)
        return self._clear_m(way, 1.0, contacts, (), inputs)[0] >= keep_m

    # --- acting ----------------------------------------------------------------------------------------------------

    def _around(self, setpoint: PathSetpoint, inputs: ModeInputs) -> PathSetpoint:
        """Setpoint along the detour; at its end the mode steers again."""
        progress = self._path_tracker.update(inputs.nav, inputs.speed_mps, inputs.dt_s)
        if not progress.finished:
            return progress.setpoint
        self._detour = None
        self._next_s = max(inputs.now_s, self._begun_s + _CHECK_S)
        self._announce(TextKind.ROUTINE, "Traffic: back on the route", inputs.now_s)
        return setpoint

    def _remaining(self, route: Sequence[evasion.Place], speed_mps: float) -> Sequence[evasion.Place]:
        """The rest of the detour, and the route after it."""
        assert self._detour is not None
        points = [point for leg in self._path_tracker.legs for point in leg]
        end = min(range(len(route)), key=lambda i: math.dist(route[i], points[-1]))
        return _near_part([*points, *route[end + 1 :]], speed_mps)

    def _limited(self, setpoint: PathSetpoint, inputs: ModeInputs) -> PathSetpoint:
        """The setpoint, no faster than allowed; the limit changes by PATH_ACC."""
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
        return braked(setpoint, self._limit_mps / demand)

    def _hold(self, setpoint: PathSetpoint, inputs: ModeInputs) -> Setpoint:
        """Hold where the boat has stopped; the target shown stays that of the mode."""
        if not self._holding:
            self._holding = True
            self._hold_point.stop_here(inputs.nav)
        held = self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        self._yaw = desired_motion(held).yaw_rad
        return replace(held, progress=replace(held.progress, target=setpoint.progress.target))

    def _steady(self, setpoint: PathSetpoint, dt_s: float) -> PathSetpoint:
        """Turn at PATH_YAW_RATE from the heading of a detour to that of the mode."""
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

    def _ramp(self, share: float, inputs: ModeInputs) -> evasion.SpeedRamp:
        """From the boat's speed to that share of the cruise speed."""
        speed_mps = math.hypot(inputs.nav.north_mps, inputs.nav.east_mps)
        return evasion.SpeedRamp(speed_mps, share * inputs.speed_mps, self._acceleration)

    def _announce(self, kind: TextKind, text: str, now_s: float) -> None:
        if self._announced != text:
            self._announced = text
            self._events.say(now_s, kind, "traffic_action", text)


def _passed_s(contact: Contact, here: evasion.Place) -> float:
    """When a vessel has come nearest to a boat that lies here, and gone on a little; at most _LONGEST_S."""
    _, nearest_s = colreg.closest_approach(here, (0.0, 0.0), contact)
    return min(_LONGEST_S, nearest_s + _PASSED_S)


def _way_m(speed_mps: float) -> float:
    """How much of a way is checked."""
    return evasion.stretch(speed_mps) * _WAY_M


def _near_part(way: Sequence[evasion.Place], speed_mps: float) -> Sequence[evasion.Place]:
    """The part of a way that is checked."""
    return evasion.thinned(evasion.first_part(way, _way_m(speed_mps)), _THIN_M) if way else ()


def _is_on(point: evasion.Place, route: Sequence[evasion.Place]) -> bool:
    """Whether the point lies on the route."""
    for a, b in pairwise(route):
        north, east = b[0] - a[0], b[1] - a[1]
        square = north * north + east * east
        share = 0.0 if square == 0.0 else ((point[0] - a[0]) * north + (point[1] - a[1]) * east) / square
        share = min(1.0, max(0.0, share))
        if math.dist(point, (a[0] + share * north, a[1] + share * east)) < _OFF_ROUTE_M:
            return True
    return False


def _velocity(way: Sequence[evasion.Place], speed_mps: float) -> colreg.Velocity:
    """Velocity (north, east) with which the boat begins a way, by its first 5 m."""
    ahead = evasion.first_part(way, 5.0)[-1]
    away = max(1e-6, math.dist(way[0], ahead))
    return (ahead[0] - way[0][0]) / away * speed_mps, (ahead[1] - way[0][1]) / away * speed_mps
