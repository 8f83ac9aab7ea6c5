"""The fence in force: what it allows, and whether the boat is inside. Every other module asks here about the fence.

It is the plan's zones, within the circle around home where GF_MAX_HOR_DIST gives one. Without a fence, or with
GF_ACTION 0, everything is allowed and shapely is not imported.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Protocol

from companion.allocation.astern import braking_mps2
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.control.stick_governor import StickGovernor, StickLimit
from companion.core.decision import FenceState, Home, ModeId, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.frames import body_to_ned
from companion.core.geodesy import LocalFrame
from companion.core.ports import Worker
from companion.core.setpoint import HeadingSetpoint, PathSetpoint, Setpoint, braked
from companion.fence.allowed import Allowed, Place, Way
from companion.fence.home_circle import PARAMETER as _HOME_CIRCLE
from companion.fence.home_circle import HomeCircle
from companion.fence.limit import (
    SIGMAS,
    SpeedLimit,
    closing_limits,
    fitted_speed_mps,
    speed_limit,
    speed_to_stop_in,
    way_to_next_line_m,
)
from companion.fence.preparation import FEW_ITEMS, NOTHING, FencePlan, Prepared, Ways
from companion.fence.sight import Sight
from companion.guidance.coasting import Coasting
from companion.guidance.stopping import SMOOTHING_S, stopping_point
from companion.mission.plan import Adopt, PlanItem, PlanKind, Plans
from companion.params.store import Parameters

if TYPE_CHECKING:
    from companion.fence.area import FenceArea, Margin
    from companion.fence.areas import FenceAreas

_NO_ACTION = 0  # of GF_ACTION
_DECIDE_S = 1.0  # delay from the moment when a stop is needed to its begin
_DRIFT_MPS = 0.05  # a slower motion towards the line does not count while the boat is at rest near it
_FASTEST_MPS = 30.0
_AWAY_M = 2.0  # inside the keeping area, before a warning is over
_SOON_S = 20.0  # of the way that the boat goes, in which a person sees where it is
_STEERAGE_SHARE = 0.3  # of the cruise speed, left to a boat without sideways thrust so that it can turn back
_SLOWED_SHARE = 0.9  # of the demand: below it the boat counts as slowed
_SLOWED_S = 2.0  # for how long the state "slowed" lasts after that


class SteeredMode(Protocol):
    """What the fence needs to know of the active mode."""

    @property
    def id(self) -> ModeId:
        """Which mode it is."""
        ...

    @property
    def by_stick(self) -> bool:
        """Whether the operator's sticks steer."""
        ...

    @property
    def unplanned(self) -> bool:
        """Whether what steers the boat knows of no fence: sticks, or velocities from elsewhere."""
        ...

    @property
    def slows(self) -> bool:
        """Whether it slows down by itself ahead of the fence while the heading is known."""
        ...

    @property
    def needs_position(self) -> bool:
        """Whether the mode ends when the position is lost."""
        ...


class FenceGuard:
    """`update` once a tick, `limited` on each setpoint; all other methods are queries.

    Remembers the areas of the fence in force (rebuilt when it changes), whether the boat has been inside, and whether
    it is outside now or about to be. `cause`: the reason for which the failsafe "fence" acts, in words; None while
    nothing is wrong. `no_circle`: item of the fence in force that is a circle of radius 0; None without one.
    `switched_off`: an operator or a mission has switched the fence off.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        plans: Plans,
        events: EventLog,
        frame: Callable[[], LocalFrame],
        home: Callable[[], Home | None],
    ) -> None:
        """`home()`: None while there is none."""
        self._config = config
        self._parameters = parameters
        self._plans = plans
        self._events = events
        self._frame = frame
        self._circle = HomeCircle(parameters, home, events)
        self._governor = StickGovernor(config, parameters)
        self._braking_mps2 = braking_mps2(config)
        self._coasting = Coasting(config.hull, min(_FASTEST_MPS, top_speed_mps(config)))
        self._key: tuple[object, ...] = ()
        self._areas: FenceAreas | None = None
        self._ways: Ways | None = None
        self._prepared = NOTHING
        self._left: list[object] = []
        self._worker: Worker | None = None
        self._work: tuple[tuple[object, ...], Future[Prepared]] | None = None
        self._entered = False
        self._kept = False  # the armed boat has been where plans may lead
        self._breached = False
        self._is_narrow = False  # a new fence, of which that has not been said yet
        self._breaches = 0
        self._breach_s: float | None = None
        self._slowed = False
        self._slowed_s = 0.0  # time at which it was slowed last
        self._sight = Sight(parameters, events)
        self._seen = False  # in the last tick
        self.cause: str | None = None
        self.no_circle: int | None = None
        self.switched_off = False
        plans.prepare_by(PlanKind.FENCE, self.prepare)
        plans.on_change(self._on_change)
        parameters.on_change(self._on_parameter)
        self._prepare()

    # --- the areas -------------------------------------------------------------------------------------------------

    @property
    def key(self) -> tuple[object, ...]:
        """Changes whenever the allowed area may have changed; () while no fence is in force."""
        self.areas()
        return self._key

    def _wanted_key(self) -> tuple[object, ...]:
        p = self._parameters
        fence_id, circle = self._plans.plan_id(PlanKind.FENCE), self._circle.zone
        if self.switched_off or not (fence_id or circle) or p["GF_ACTION"] == _NO_ACTION:
            return ()
        return fence_id, circle, self._frame(), p["FENCE_GROUP0"], p["FENCE_MARGIN"]

    @property
    def state(self) -> FenceState | None:
        """The state that ground stations are shown; None while no fence is in force."""
        return None if self._areas is None else FenceState(self._breached, self._breaches, self._breach_s, self._slowed)

    def switch(self, on: bool, now_s: float) -> None:
        """Switch the fence off, or on again. It is on again too when the boat is disarmed, or gets another fence."""
        if self.switched_off != on:
            return
        self.switched_off = not on
        if not on:
            self._events.say(now_s, TextKind.ATTENTION, "fence_switched", "Fence off until switched on or disarmed")
        elif self._wanted_key():
            self._events.say(now_s, TextKind.ROUTINE, "fence_switched", "Fence on")
        else:
            text = "Fence on, but there is none, or GF_ACTION is 0"
            self._events.say(now_s, TextKind.ATTENTION, "fence_switched", text)
        self.areas()

    def work_with(self, worker: Worker) -> None:
        """Let `worker` prepare the areas of a fence that changes by its settings."""
        self._worker = worker

    def prepare(self, items: Sequence[PlanItem]) -> Callable[[], Adopt]:
        """The work that a new fence needs before it comes into force (`Plans.prepare_by`): its areas, with the settings
        of now."""
        plan = self._plan_of(items)

        def work() -> Adopt:
            prepared = plan.build()

            def adopt() -> None:
                self._leave(self._prepared)
                self._prepared = prepared

            return adopt

        return work

    def _on_change(self, kind: PlanKind) -> None:
        if kind is PlanKind.FENCE:
            self.switched_off = False
            self.areas()  # built now, because a tick has no time for it

    def _on_parameter(self, name: str, _value: float) -> None:
        if name == _HOME_CIRCLE:
            self._prepare()
            self.areas()

    def _prepare(self) -> None:
        """Load what builds areas before a tick needs it: home may come, or move, in a tick."""
        if self._circle.wanted:
            from companion.fence import area  # noqa: F401

    def areas(self) -> FenceAreas | None:
        """The areas of the fence in force; None where there is none, or while they are being prepared."""
        self._renew()
        return self._areas

    def _renew(self) -> tuple[object, ...]:
        """Put the fence that is wanted in force once it is prepared. Returns its key."""
        key = self._wanted_key()
        if key != self._key and self._is_prepared(key):
            self._put_in_force(self._prepared if key else NOTHING)
        return key

    @property
    def preparing(self) -> bool:
        """Whether a fence is wanted that is not in force yet."""
        return self._renew() != self._key

    def _put_in_force(self, prepared: Prepared) -> None:
        circle_moved = _is_same_but_for_the_circle(prepared.key, self._key)
        self._leave(Prepared(self._key, self._areas, self._ways))
        self._key, self._areas, self._ways = prepared.key, prepared.areas, prepared.ways
        self.no_circle = prepared.no_circle
        areas = prepared.areas
        self._is_narrow = areas is not None and areas.keeping.empty and not areas.fence.empty
        if not circle_moved:
            self._entered = self._kept = self._breached = self._slowed = False
            self.cause = None

    def _leave(self, prepared: Prepared) -> None:
        """It is no longer needed. To free a large fence takes long too, so its pieces are kept for the worker."""
        if self._worker is not None and prepared.ways is not None and prepared.ways.large:
            self._left += prepared.pieces()

    def _free(self) -> None:
        """Let the worker free what is left of large fences, a piece at a time. By now nobody else holds them."""
        if self._left and self._worker is not None:
            left, self._left = self._left, []
            for _ in range(len(left)):
                self._worker.submit(partial(_drop_one, left))

    def _is_prepared(self, key: tuple[object, ...]) -> bool:
        """Whether the areas for `key` are there. Those of a large fence are made by the worker. Until then the old ones
        stay in force, unless they lie in another plane."""
        if not key or self._prepared.key == key:
            return True
        plan = self._plan_of(self._plans.items(PlanKind.FENCE))
        if self._worker is None or len(plan.items) <= FEW_ITEMS:
            self._prepared = plan.build(self._prepared)
            return True
        if self._key and self._key[2] != plan.frame:
            self._put_in_force(NOTHING)
        if self._work is None or self._work[0] != key:
            self._work = key, self._worker.submit(partial(plan.build, self._prepared))
        if not self._work[1].done():
            return False
        self._leave(self._prepared)
        self._prepared, self._work = self._work[1].result(), None
        return self._prepared.key == key

    def _plan_of(self, items: Sequence[PlanItem]) -> FencePlan:
        """All that the areas depend on, as it is now."""
        p = self._parameters
        return FencePlan(
            tuple(items),
            self._circle.zone,
            self._frame(),
            p["FENCE_GROUP0"],
            p["FENCE_MARGIN"],
            self._config.length_m,
            p["NAV_ACC_RAD"],
        )

    @property
    def kept_m(self) -> float:
        """Distance of plans from the fence: half a boat's length and FENCE_MARGIN."""
        return 0.5 * self._config.length_m + self._parameters["FENCE_MARGIN"]

    # --- what it allows --------------------------------------------------------------------------------------------

    @property
    def allowed(self) -> Allowed:
        """Where the boat may be sent now."""
        return Allowed(self.areas(), self._ways, self.kept_m, self._parameters["NAV_ACC_RAD"])

    def point_refusal(self, north_m: float, east_m: float) -> str | None:
        """As `Allowed.point_refusal`."""
        return self.allowed.point_refusal(north_m, east_m)

    def line_refusal(self, line: Sequence[Place]) -> str | None:
        """As `Allowed.line_refusal`."""
        return self.allowed.line_refusal(line)

    def inside(self, places: Sequence[Place]) -> Sequence[bool]:
        """As `Allowed.inside`."""
        return self.allowed.inside(places)

    def clear(self, lines: Sequence[Sequence[Place]]) -> Sequence[bool]:
        """As `Allowed.clear`."""
        return self.allowed.clear(lines)

    def go_refusal(self, nav: NavState, north_m: float, east_m: float) -> str | None:
        """Why the boat may not be sent straight to a point: the point or the line; None where it may."""
        return self.point_refusal(north_m, east_m) or self.line_refusal(((nav.north_m, nav.east_m), (north_m, east_m)))

    def allows_berth(self, line: Sequence[Place]) -> bool:
        """As `Allowed.allows_berth`."""
        return self.allowed.allows_berth(line)

    def may_move_to(self, from_place: Place, to_place: Place) -> bool:
        """Whether sticks may move the hold point from one place to the other: to inside, or from outside further in."""
        areas = self.areas()
        if areas is None or areas.keeping.contains(*to_place):
            return True
        return areas.keeping.margin(*to_place).distance_m > areas.keeping.margin(*from_place).distance_m

    def held_place(self, place: Place) -> Place:
        """Where a boat that drifts in its watch circle holds, which is to hold `place`: the nearest place so far inside
        that the circle is, and that it can go straight to; the middle of a fence that is too small for that.
        `place` itself where it cannot go straight there, and outside the fence."""
        areas = self.areas()
        if areas is None or not areas.fence.contains(*place) or areas.keeping.contains(*place):
            return place
        inside = (areas.fence.middle if areas.keeping.empty else areas.keeping).nearest_inside(*place)
        return inside if inside is not None and areas.fence.covers((place, inside)) else place

    def room_about_m(self, place: Place) -> float:
        """How far a boat whose middle lies at `place` may drift on any course; infinite without a fence, and
        outside."""
        areas = self.areas()
        if areas is None or not areas.fence.contains(*place):
            return math.inf
        return max(0.0, areas.fence.margin(*place).distance_m - 0.5 * self._config.length_m)

    def room_m(self, place: Place, course_rad: float) -> float:
        """How far the middle of the boat may go from `place` on a course; infinite without a fence ahead, and
        outside."""
        areas = self.areas()
        if areas is None or not areas.fence.contains(*place):
            return math.inf
        if not areas.stopping.contains(*place):
            return 0.0
        return areas.stopping.way_to_line_m(*place, math.cos(course_rad), math.sin(course_rad))

    def way(self, begin: Place, end: Place) -> Way | None:
        """As `Allowed.way`."""
        return self.allowed.way(begin, end)

    # --- the boat and the fence ------------------------------------------------------------------------------------

    def update(self, nav: NavState, mode: SteeredMode, armed: bool, now_s: float) -> None:
        """Check where the boat is, and announce what changed. While its place is not known nothing changes."""
        areas = self.areas()
        self._free()
        self._circle.announce(now_s)
        if areas is None:
            self._sight.forget()
            return
        self._announce_narrow(now_s)
        before, self._seen = self._seen, self._sight.update(nav, armed, mode.needs_position, now_s)
        if not self._seen:
            if before and armed and mode.by_stick and self.cause is None:
                self.cause = self._out_of_sight(areas, nav)
            return
        margin = areas.fence.margin(nav.north_m, nav.east_m)
        outside = margin.distance_m < (self._parameters["FENCE_MARGIN"] if self._breached else 0.0)
        if outside and not self._breached:
            self._breached = True
            self._on_breach(areas, -margin.distance_m, now_s)
        elif self._breached and not outside:
            self._breached = False
            if not self._entered:
                self._events.say(now_s, TextKind.ROUTINE, "fence_entered", "Inside the fence: enforced from now on")
        self._entered = self._entered or not outside
        self._kept = armed and (self._kept or areas.keeping.margin(nav.north_m, nav.east_m).distance_m > 0.0)
        if self._breached:
            self.cause = "Outside the fence" if self._entered else None
        else:
            self.cause = self._ahead(areas, nav, mode) if armed else None

    def _announce_narrow(self, now_s: float) -> None:
        """Say of a new fence that it has no place for plans: the boat holds in its middle."""
        if self._is_narrow:
            self._is_narrow = False
            text = f"Fence leaves no room beyond FENCE_MARGIN {self._parameters['FENCE_MARGIN']:g} m"
            self._events.say(now_s, TextKind.ATTENTION, "fence_narrow", text)

    def _out_of_sight(self, areas: FenceAreas, nav: NavState) -> str | None:
        """The warning where the boat's place becomes unknown so near to the line that it may soon be there; None where
        it is not near."""
        soon_m = SIGMAS * nav.position_accuracy_m + _SOON_S * math.hypot(nav.north_mps, nav.east_mps)
        near = self._entered and areas.keeping.margin(nav.north_m, nav.east_m).distance_m <= soon_m
        return "Fence near, position unknown" if near else None

    def _on_breach(self, areas: FenceAreas, off_m: float, now_s: float) -> None:
        """A breach begins. The failsafe announces it at its own onset; it is not announced twice."""
        if not self._entered:
            text = (
                "Fence is empty: no place is inside it"
                if areas.fence.empty
                else f"Outside the new fence by {off_m:.0f} m: sail back in"
            )
            self._events.say(now_s, TextKind.ATTENTION, "fence_outside", text)
            return
        self._breaches += 1
        self._breach_s = now_s
        if self.cause is not None:
            self._events.say(now_s, TextKind.ALARM, "fence_breached", "Outside the fence")

    def _ahead(self, areas: FenceAreas, nav: NavState, mode: SteeredMode) -> str | None:
        """The warning where the boat is steered out of the fence; None where that is not so.

        It comes while the boat can still stop inside. In Heading, Rate and Offboard, which slow down by themselves, it
        comes when the boat has reached the line. However slowly a boat drifts, it comes when the hull may touch the
        line. Armed only: the mode in which a boat drifted disarmed is not the one that is armed.
        """
        if not mode.unplanned and self.cause is None:
            return None
        speed = math.hypot(nav.north_mps, nav.east_mps)
        edge = areas.keeping.margin(nav.north_m, nav.east_m)
        lasting = self.cause is not None
        near = areas.fence.margin(nav.north_m, nav.east_m)
        way_m = self._way_ahead_m(areas.keeping, nav, edge.distance_m, near) if speed > _DRIFT_MPS else math.inf
        need_m = 0.0
        if not (mode.slows and nav.heading_valid):
            need_m = self._way_to_rest_m(nav, speed) + _DECIDE_S * speed
        closing = nav.north_mps * near.north + nav.east_mps * near.east > _DRIFT_MPS
        begins = (
            (edge.distance_m <= SIGMAS * nav.position_accuracy_m + _DECIDE_S * _DRIFT_MPS and closing)
            or (speed > 2.0 * _DRIFT_MPS and way_m <= need_m)
            or (self._kept and edge.distance_m <= -self._parameters["FENCE_MARGIN"])
        )
        lasts = lasting and (edge.distance_m < _AWAY_M or way_m <= need_m)
        if not begins and not lasts:
            return None
        if lasts:
            return self.cause
        ahead_m = self._line_ahead_m(areas.fence, nav, way_m) if way_m <= need_m else near.distance_m
        return f"Fence {max(0.0, ahead_m):.0f} m ahead"

    @staticmethod
    def _line_ahead_m(fence: FenceArea, nav: NavState, way_m: float) -> float:
        """Way on the boat's course until the line itself; where it only comes too near to it, until that."""
        speed = math.hypot(nav.north_mps, nav.east_mps)
        line_m = fence.way_to_line_m(nav.north_m, nav.east_m, nav.north_mps / speed, nav.east_mps / speed)
        return line_m if math.isfinite(line_m) else way_m

    @staticmethod
    def _way_ahead_m(keeping: FenceArea, nav: NavState, edge_m: float, near: Margin) -> float:
        """Way on the boat's course until the edge of the keeping area; of a boat beyond that, until the edge at the
        line that comes next."""
        place, speed = (nav.north_m, nav.east_m), math.hypot(nav.north_mps, nav.east_mps)
        course = nav.north_mps / speed, nav.east_mps / speed
        if edge_m > 0.0:
            return keeping.way_to_line_m(*place, *course)
        way_m, share = way_to_next_line_m(keeping, place, course, (edge_m, near), 0.0)
        return way_m / share

    def _way_to_rest_m(self, nav: NavState, speed_mps: float) -> float:
        """The way that a stop takes: with sideways thrust that of the reference; without, Hold brakes or coasts as
        soon as it can."""
        way_m = math.dist(stopping_point(nav, self._parameters), (nav.north_m, nav.east_m))
        if self._config.limits.sway_n > 0.0:
            return way_m
        if self._braking_mps2 > 0.0:
            at_once_m = speed_mps**2 / (2.0 * self._braking_mps2)
        else:
            at_once_m = self._coasting.way_m(speed_mps)
        return min(way_m, SMOOTHING_S * speed_mps + at_once_m)

    def slowed(self, nav: NavState) -> NavState:
        """The estimate with which a reference for a stop begins: no faster than it can stop inside the fence. The
        feedback brakes a boat that is faster."""
        areas = self.areas()
        speed = math.hypot(nav.surge_mps, nav.sway_mps)
        if (
            areas is None
            or not speed >= 1.0e-6
            or not all(map(math.isfinite, (speed, nav.north_m, nav.east_m, nav.yaw_rad, nav.yaw_rate_radps)))
        ):
            return nav
        stop = stopping_point(nav, self._parameters)
        way_m = math.dist(stop, (nav.north_m, nav.east_m))
        share = min(1.0, fitted_speed_mps(areas, nav, way_m, 0.5 * SMOOTHING_S) / speed)
        return nav if share >= 1.0 else replace(nav, surge_mps=share * nav.surge_mps, sway_mps=share * nav.sway_mps)

    def reach_mps(self, place: Place, velocity: Place, deceleration_mps2: float) -> float:
        """Speed from which a reference at `place`, in the direction of `velocity`, still stops inside the keeping area;
        0 outside on the way out."""
        areas = self.areas()
        speed = math.hypot(*velocity)
        if areas is None or speed < 1.0e-6:
            return math.inf
        north, east = velocity[0] / speed, velocity[1] / speed
        return speed_to_stop_in(areas.keeping.way_inside_m(*place, north, east), deceleration_mps2, 0.0)

    def limited(
        self, setpoint: Setpoint, mode: SteeredMode, nav: NavState, cruise_mps: float, now_s: float
    ) -> Setpoint:
        """The setpoint, limited so that the boat stops inside the fence: the speed of a path setpoint, the force of a
        heading setpoint. Others are returned unchanged. A boat steered without a plan stops where the mode that the
        failsafe enters at the line still has room; any other without sideways thrust keeps steerage way."""
        areas = self.areas()
        seen = self._sight.sees(nav, mode.needs_position)
        if areas is None or not isinstance(setpoint, PathSetpoint | HeadingSetpoint) or not seen:
            self._slowed = False
            return setpoint
        demand = _demand(setpoint, nav)
        if mode.unplanned:
            areas = replace(areas, stopping=areas.keeping)
        limit = speed_limit(areas, nav, demand, self._parameters)
        if self._config.limits.sway_n <= 0.0 and not mode.unplanned:
            limit = replace(limit, speed_mps=max(limit.speed_mps, _STEERAGE_SHARE * cruise_mps))
        if isinstance(setpoint, HeadingSetpoint):
            limits = [limit]
            if self._config.limits.sway_n > 0.0:
                limits += closing_limits(areas, nav, demand, limit.way, self._parameters)
            result: HeadingSetpoint | PathSetpoint = self._governor.limited(
                setpoint, nav, [StickLimit(one.way, one.speed_mps, one.braking_mps2) for one in limits], now_s
            )
        else:
            result = _slower(setpoint, limit)
        left = _demand(result, nav)
        slowed = left[0] * demand[0] + left[1] * demand[1] < _SLOWED_SHARE * math.hypot(*demand) ** 2
        if slowed:
            if not self._slowed:
                self._events.say(now_s, TextKind.ROUTINE, "fence_slowed", "Fence ahead: slowing down")
            self._slowed_s = now_s
        self._slowed = slowed or (self._slowed and now_s - self._slowed_s < _SLOWED_S)
        return result


def _drop_one(pieces: list[object]) -> None:
    pieces.pop()


def _is_same_but_for_the_circle(key: tuple[object, ...], before: tuple[object, ...]) -> bool:
    """Whether there was and is a circle around home, and nothing else has changed. A boat that has been inside and is
    now outside has then left the fence, as in PX4."""
    if not key or not before:
        return False
    (plan, circle, *rest), (plan_before, circle_before, *rest_before) = key, before
    return None not in (circle, circle_before) and (plan, rest) == (plan_before, rest_before)


def _demand(setpoint: PathSetpoint | HeadingSetpoint, nav: NavState) -> tuple[float, float]:
    """Direction in which a setpoint sends the boat, in NED: its velocity in m/s, or its force in N."""
    if isinstance(setpoint, HeadingSetpoint):
        return body_to_ned(setpoint.wrench.surge_n, setpoint.wrench.sway_n, nav.yaw_rad)
    return body_to_ned(setpoint.surge_mps, setpoint.sway_mps, nav.yaw_rad)


def _slower(setpoint: PathSetpoint, limit: SpeedLimit) -> PathSetpoint:
    """The setpoint, no faster than the limit and braking at least as the limit asks."""
    speed = math.hypot(setpoint.surge_mps, setpoint.sway_mps)
    if speed <= limit.speed_mps:
        return setpoint
    return braked(setpoint, limit.speed_mps / speed, limit.braking_mps2)
