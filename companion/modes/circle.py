"""Circle: orbits a point by radius, direction and number of turns, then holds."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.core.decision import KnownRefusal, ModeDeclaration, ModeId, ModeInputs, OrbitState, TextKind
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.setpoint import Setpoint
from companion.fence.guard import FenceGuard
from companion.guidance.orbit import Circle, OrbitGuidance, chosen_circle, least_radius_m, radius_refusal, whole_line
from companion.guidance.sideslip import steered_hull_of
from companion.guidance.turning import bends_of
from companion.modes.mode import FURTHEST_LEG_M, Mode
from companion.modes.parts.headway import Headway
from companion.modes.parts.refusals import FENCE_REFUSALS
from companion.params.store import Parameters
from companion.positioning.hold_point import HoldPoint
from companion.positioning.watch_circles import WatchCircles

_SAME_PLACE_M = 1.0
_TURN_RAD = 2.0 * math.pi
_ENDED = "the circle is over"


@dataclass(frozen=True, slots=True)
class OrbitOrder:
    """An orbit as an operator asks for it.

    A field that is None keeps its value while the boat orbits. Otherwise CIRC_RADIUS, CIRC_SPEED and CIRC_DIR apply,
    the centre is the boat's place, and the orbit has no end. `total_rad`: the angle to sweep; infinite: no end. A speed
    alone changes that of the orbit under way, and begins none that is over.
    """

    centre: tuple[float, float] | None = None  # lat_deg, lon_deg
    radius_m: float | None = None
    clockwise: bool | None = None
    speed_mps: float | None = None
    total_rad: float | None = None

    @property
    def mode(self) -> ModeId:
        """As every order's."""
        return ModeId.CIRCLE

    @property
    def speed_alone(self) -> bool:
        """Whether it gives nothing but a speed."""
        others = (self.centre, self.radius_m, self.clockwise, self.total_rad)
        return self.speed_mps is not None and others == (None,) * 4


@dataclass(frozen=True, slots=True)
class _Plan:
    """The orbit to sail. `speed_mps` None: CIRC_SPEED, or with `at_cruise` the speed of self-steered modes. `total_rad`
    may be infinite."""

    circle: Circle
    speed_mps: float | None
    total_rad: float
    at_cruise: bool = False


class CircleMode(Mode):
    """Orbits a point. Chosen without an order it orbits the place where the boat is.

    Remembers the orbit, whether it is over so that the boat holds, and the result and place of the last check.
    """

    declaration = ModeDeclaration(
        id=ModeId.CIRCLE,
        text="Orbits a point by radius, direction and number of turns, then holds",
        px4=0x01030000,  # POSCTL, sub-mode ORBIT
        rover=9,
        standard_mode=2,  # ORBIT
        again="an orbit that is over starts again",
        commands=(34,),  # DO_ORBIT
        refusals=(
            KnownRefusal(
                r"radius .*|the radius should be above 0 m",
                "the radius is too small for this boat",
                "Set <param>CIRC_RADIUS</param> larger.",
            ),
            KnownRefusal(
                _ENDED,
                "a speed alone does not begin a circle that is over",
                "Choose Circle again, or order a circle by its radius.",
            ),
            KnownRefusal(r"centre .* km away", "the centre is too far away", "Choose a centre near the boat."),
            *FENCE_REFUSALS,
        ),
    )

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        events: EventLog,
        frame: Callable[[], LocalFrame],
        fence: FenceGuard,
    ) -> None:
        self._parameters = parameters
        self._length_m = config.length_m
        self._events = events
        self._frame = frame
        self._fence = fence
        can_sway, bends = config.limits.sway_n > 0.0, bends_of(config, steady=True)
        self._guidance = OrbitGuidance(parameters, can_sway, top_speed_mps(config), bends, steered_hull_of(config))
        self._hold_point = HoldPoint(config, parameters, fence)
        self._watch = WatchCircles(parameters, events, "Circle")
        self._headway = Headway("Circle", events)
        self._plan: _Plan | None = None  # None: not active
        self._left: _Plan | None = None  # the one before
        self._over = False
        self._checked: tuple[object, tuple[float, float], str | None] = ((), (0.0, 0.0), None)

    # --- choosing --------------------------------------------------------------------------------------------------

    def _wanted(self, inputs: ModeInputs) -> _Plan:
        order = inputs.order if isinstance(inputs.order, OrbitOrder) else OrbitOrder()
        before = self._plan
        if order.centre is not None:
            centre = self._frame().to_ned(*order.centre)
        elif before is not None:
            centre = (before.circle.north_m, before.circle.east_m)
        else:
            centre = (inputs.nav.north_m, inputs.nav.east_m)
        radius_m, clockwise = order.radius_m, order.clockwise
        speed_mps, total_rad = order.speed_mps, order.total_rad
        if before is not None:
            clockwise = before.circle.clockwise if radius_m is None and clockwise is None else clockwise
            radius_m = before.circle.radius_m if radius_m is None else radius_m
            speed_mps = before.speed_mps if speed_mps is None else speed_mps
            total_rad = before.total_rad if total_rad is None else total_rad
        circle = chosen_circle(centre, radius_m, clockwise, self._parameters)
        at_cruise = before is not None and before.at_cruise and speed_mps is None
        return _Plan(circle, speed_mps, math.inf if total_rad is None else total_rad, at_cruise)

    def check(self, inputs: ModeInputs) -> str | None:
        """Refuse a radius that the boat cannot sail, a centre too far off, and a circle that leaves the fence.

        A disarmed boat asks every tick, so the answer is kept while the boat stays within a metre.
        """
        if self._plan is not None and self._over and _speed_alone(inputs) is not None:
            return _ENDED
        plan, nav = self._wanted(inputs), inputs.nav
        if not nav.position_valid:
            return None
        place = (nav.north_m, nav.east_m)
        follows_boat = inputs.order is None and self._plan is None  # the centre
        centre = None if follows_boat else (plan.circle.north_m, plan.circle.east_m)
        key = (centre, plan.circle.radius_m, plan.circle.clockwise, plan.total_rad, self._least_m, self._fence.key)
        if key != self._checked[0] or math.dist(place, self._checked[1]) > _SAME_PLACE_M:
            self._checked = key, place, self._refusal(plan, place)
        return self._checked[2]

    @property
    def _least_m(self) -> float:
        return least_radius_m(self._parameters, self._length_m)

    def _refusal(self, plan: _Plan, place: tuple[float, float]) -> str | None:
        circle = plan.circle
        if (reason := radius_refusal(circle.radius_m, self._least_m)) is not None:
            return reason
        away_m = math.dist(place, (circle.north_m, circle.east_m))
        if away_m > FURTHEST_LEG_M:
            return f"centre {away_m / 1000.0:.0f} km away"
        return self._fence.line_refusal(whole_line(circle, place, plan.total_rad, self._parameters))

    def chosen_again(self, inputs: ModeInputs) -> bool:
        """Begin anew with a new order, or after the last turn. A speed alone is taken up on the way."""
        speed_mps = _speed_alone(inputs)
        if self._plan is None or self._over or speed_mps is None:
            return self._over or inputs.order is not None
        self._plan = replace(self._plan, speed_mps=speed_mps, at_cruise=False)
        self._events.say(inputs.now_s, TextKind.ROUTINE, "speed_changed", f"Circle: {speed_mps:.2f} m/s")
        return False

    def enter(self, inputs: ModeInputs) -> str | None:
        """Start the orbit from the present motion."""
        if (reason := self.check(inputs)) is not None:
            return reason
        plan = self._wanted(inputs)
        self._plan, self._over = plan, False
        self._headway.reset()
        self._guidance.start(plan.circle, inputs.nav, None if math.isinf(plan.total_rad) else plan.total_rad)
        self._events.say(inputs.now_s, TextKind.ROUTINE, "circle_begins", f"Circle: {_said(plan)}")
        return None

    def resume(self, inputs: ModeInputs) -> str | None:
        """Go on with the orbit, also where another mode has refused to be entered, or hold on if it is over."""
        self._plan = self._plan or self._left
        if self._plan is None:
            return self.enter(inputs)
        if self._over:
            self._hold_point.rejoin(inputs.nav)
        else:
            self._guidance.rejoin(inputs.nav)
        return None

    def leave(self) -> None:
        """The orbit is over, unless it is resumed."""
        self._left, self._plan = self._plan, None

    # --- under way -------------------------------------------------------------------------------------------------

    @property
    def orbit(self) -> OrbitState | None:
        """The circle that the boat sails; None once the boat holds."""
        if self._plan is None or self._over:
            return None
        circle = self._plan.circle
        return OrbitState(circle.north_m, circle.east_m, circle.sign * circle.radius_m)

    def mind_fence(self, inputs: ModeInputs) -> str | None:
        """Stop if the rest of the orbit leaves the new fence."""
        return None if self._over else self._fence.line_refusal(self._guidance.line())

    def stuck_s(self, now_s: float) -> float | None:
        """Seconds for which the boat has made no way round the circle."""
        return self._headway.stuck_s(now_s)

    def excuse(self) -> None:
        """Count anew: traffic keeps the boat from making way."""
        self._headway.reset()

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        """The rest of the orbit as points; empty while the boat holds."""
        return () if self._plan is None or self._over else self._guidance.line()

    def way_speed_mps(self, inputs: ModeInputs) -> float:
        """The speed of the order, else CIRC_SPEED until the operator sets another, else that of self-steered modes."""
        plan = self._plan
        if plan is not None and plan.at_cruise:
            return inputs.speed_mps
        return (plan.speed_mps if plan is not None else None) or self._parameters["CIRC_SPEED"] or inputs.speed_mps

    def drop_speed(self) -> None:
        """Forget the speed of the order, and CIRC_SPEED for this orbit."""
        if self._plan is not None:
            self._plan = replace(self._plan, speed_mps=None, at_cruise=True)

    def update(self, inputs: ModeInputs) -> Setpoint:
        """Along the circle; after the last turn, at the hold point."""
        if self._over:
            return self._hold(inputs)
        speed_mps = self.way_speed_mps(inputs)
        progress = self._guidance.update(inputs.nav, speed_mps, inputs.dt_s)
        self._headway.update(progress.way_m, speed_mps, inputs.now_s)
        if not progress.finished:
            return progress.setpoint
        self._over = True
        self._hold_point.stop_here(inputs.nav)
        self._watch.reset()
        turns = (progress.swept_rad or 0.0) / _TURN_RAD
        self._events.say(inputs.now_s, TextKind.ROUTINE, "circle_done", f"Circle: {turns:.1f} turns done, holding")
        return self._hold(inputs)

    def _hold(self, inputs: ModeInputs) -> Setpoint:
        """Hold the point where the boat could stop after the last turn."""
        setpoint = self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        north_m, east_m = self._hold_point.target
        self._watch.update(math.hypot(north_m - inputs.nav.north_m, east_m - inputs.nav.east_m), inputs.now_s)
        return setpoint


def _speed_alone(inputs: ModeInputs) -> float | None:
    """The speed of an order that gives nothing else; None: another order, or none."""
    order = inputs.order
    return order.speed_mps if isinstance(order, OrbitOrder) and order.speed_alone else None


def _said(plan: _Plan) -> str:
    """Text about the orbit, for people."""
    way = "clockwise" if plan.circle.clockwise else "counter-clockwise"
    turns = "" if math.isinf(plan.total_rad) else f", {plan.total_rad / _TURN_RAD:.3g} turns"
    return f"radius {plan.circle.radius_m:.1f} m, {way}{turns}"
