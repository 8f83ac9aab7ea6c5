"""Hold: dynamic positioning. Stops and holds, or goes to a commanded point and holds there."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.reversing import can_reverse
from companion.config.vessel import VesselConfig
from companion.control.manual import beyond_deadband
from companion.core.angles import wrap_pi
from companion.core.decision import ModeDeclaration, ModeId, ModeInputs, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.frames import body_to_ned
from companion.core.setpoint import PoseSetpoint, Setpoint
from companion.fence.allowed import Way
from companion.fence.guard import FenceGuard
from companion.modes.mode import Mode
from companion.modes.parts.headway import Headway
from companion.modes.parts.transit_round import transit_round
from companion.obstacles.way_round import WayRound
from companion.params.store import Parameters
from companion.positioning.consequence import ConsequenceCheck
from companion.positioning.hold_point import HoldPoint
from companion.positioning.watch_circles import WatchCircles
from companion.positioning.weathervane import Weathervane


class HoldMode(Mode):
    """Keeps the hold point and the held heading. Deflected sticks move both. With DP_WEATHERVANE a heading that nobody
    gave is turned to the weather, and any heading where the boat is driven off. Its hold point, watch circles,
    weathervane, headway watch and consequence check keep all state."""

    declaration = ModeDeclaration(
        id=ModeId.HOLD,
        text="Holds position and heading, or goes to a point and holds there",
        px4=0x03040000,
        rover=4,
        rover_aliases=(5,),  # LOITER
        px4_aliases=(0x00030000,),  # POSCTL: sticks move the point that is held
        standard_mode=1,  # POSITION_HOLD
        again="a go-to is given up, and the boat holds where it can stop",
        has_plan=False,
        commands=(31010, 192, 17),  # USER_1: nudge; DO_REPOSITION: go-to; NAV_LOITER_UNLIM
    )

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog, fence: FenceGuard) -> None:
        self._fence = fence
        self._parameters = parameters
        self._events = events
        self._hold_point = HoldPoint(config, parameters, fence)
        self._circles = WatchCircles(parameters, events)
        self._consequence = ConsequenceCheck(config, parameters, events)
        self._weathervane = Weathervane(config, parameters, events, fence=fence)
        self._headway = Headway("Hold", events)
        self._jumps = 0
        self._landing = False
        self._cannot_sway = config.limits.sway_n <= 0.0 and not config.has_sail
        if config.limits.sway_n > 0.0:
            self._text = self.declaration.text
        elif config.has_sail:
            self._text = "Sails back and forth across the wind in a watch circle; no heading"
        elif not can_reverse(config.thrusters):
            self._text = (
                "Keeps inside a watch circle: drifts, and sails back bow into wind and current; "
                "no heading, no way astern"
            )
        else:
            self._text = "Keeps inside a watch circle, bow into wind and current; heading cannot be held"

    @property
    def text(self) -> str:
        """What Hold does on this boat, depending on its thrusters."""
        return self._text

    @property
    def going(self) -> bool:
        """Whether the boat is on its way to a commanded point."""
        return self._hold_point.going

    @property
    def target(self) -> tuple[float, float]:
        """(north_m, east_m) of the hold point, or of the go-to's destination."""
        return self._hold_point.target

    def enter(self, inputs: ModeInputs) -> str | None:
        """Stop and hold here."""
        self._headway.reset()
        self._weathervane.free()
        self._jumps = inputs.nav.jumps_followed
        self.hold_here(inputs.nav)
        return None

    def resume(self, inputs: ModeInputs) -> str | None:
        """Return to the hold point, or continue the go-to."""
        self._hold_point.rejoin(inputs.nav)
        self._consequence.reset()
        return None

    def chosen_again(self, inputs: ModeInputs) -> bool:
        """Give up a go-to and hold here."""
        if self.going:
            self.hold_here(inputs.nav)
        return False

    def mind_fence(self, inputs: ModeInputs) -> str | None:
        """Stop a go-to that the fence now refuses, and hold here. Hold itself always continues."""
        if self.going and (reason := self._fence.go_refusal(inputs.nav, *self.target)) is not None:
            self.hold_here(inputs.nav)
            self._events.say(inputs.now_s, TextKind.ATTENTION, "fence_stops", f"Go-to stopped: {reason}")
        return None

    @property
    def voyage_over(self) -> bool:
        """Whether the boat was told to land, and holds there."""
        return self._landing and not self.going and self._hold_point.arrived

    def land(self) -> None:
        """The present hold point is the end of the voyage, until the point is moved."""
        self._landing = True

    def hold_here(self, nav: NavState) -> None:
        """Stop in the shortest distance and hold there."""
        self._hold_point.stop_here(nav)
        self._moved()

    def go_to(
        self, nav: NavState, north_m: float, east_m: float, yaw_rad: float | None, speed_mps: float | None
    ) -> None:
        """Go to another point, from the present motion. Call it only after `enter`."""
        self._hold_point.go_to(nav, north_m, east_m, yaw_rad, speed_mps, fresh=False)
        if yaw_rad is not None:
            self._weathervane.give(nav.t_s)
        self._moved()

    def nudge(self, forward_m: float, starboard_m: float, turn_rad: float) -> str | None:
        """Move the hold point along the axes of the held heading. Return a reason if it cannot move, else None."""
        if self._hold_point.in_transit:
            return "the boat is on its way to a point"
        north_m, east_m, yaw_rad = self._hold_point.held
        moved_north_m, moved_east_m = body_to_ned(forward_m, starboard_m, yaw_rad)
        place = (north_m + moved_north_m, east_m + moved_east_m)
        if not self._fence.may_move_to((north_m, east_m), place):
            return self._fence.point_refusal(*place)
        self._hold_point.shift(*place, wrap_pi(yaw_rad + turn_rad))
        if turn_rad != 0.0:
            self._weathervane.give()
        self._moved()
        return None

    def head(self, yaw_rad: float) -> str | None:
        """Turn to another heading at the hold point. Return a reason during a go-to, else None."""
        if self._hold_point.in_transit:
            return "the boat is on its way to a point"
        self._hold_point.turn_to(wrap_pi(yaw_rad))
        self._weathervane.give()
        self._moved()
        return None

    def stuck_s(self, now_s: float) -> float | None:
        """Seconds without headway to the hold point; None if unknown."""
        return self._headway.stuck_s(now_s)

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        """The rest of the path to the hold point."""
        return self._hold_point.way_ahead

    def way_speed_mps(self, inputs: ModeInputs) -> float:
        """The speed along the path to the hold point, m/s."""
        return self._hold_point.way_speed_mps(inputs.speed_mps)

    @property
    def goes_round(self) -> bool:
        """Whether the boat is in transit to a point."""
        return self._hold_point.in_transit

    @property
    def drifts(self) -> bool:
        """Whether a boat without sideways thrust moves about inside its watch circle."""
        return self._cannot_sway and not self._hold_point.in_transit

    @property
    def held_point(self) -> tuple[float, float] | None:
        """The point about which the boat moves, once it has come to rest there."""
        return self._hold_point.target if self.drifts and self._hold_point.arrived else None

    def hold_instead(self, north_m: float, east_m: float) -> None:
        """Hold another point."""
        self._hold_point.shift(north_m, east_m, self._hold_point.held[2])
        self._moved()

    def way_round(self, inputs: ModeInputs) -> WayRound[Way | None] | None:
        """Another way to the point of the go-to."""
        return transit_round(self._hold_point, inputs)

    def excuse(self) -> None:
        """Restart the headway watch."""
        self._headway.reset()

    def _moved(self) -> None:
        self._landing = False
        self._weathervane.restart()
        self._headway.rebase()
        self._circles.reset()
        self._consequence.reset()

    def _stay(self, inputs: ModeInputs) -> None:
        """Where the estimate has followed a jump, the boat stays at its place over ground: the hold point follows."""
        if inputs.nav.jumps_followed == self._jumps:
            return
        self._jumps = inputs.nav.jumps_followed
        if not self.going:
            self.hold_here(inputs.nav)
            self._events.say(
                inputs.now_s, TextKind.ATTENTION, "hold_point_moved", "Hold point moved: the position jumped"
            )

    def drop_speed(self) -> None:
        """Forget the speed that came with the go-to."""
        self._hold_point.drop_speed()

    def update(self, inputs: ModeInputs) -> Setpoint:
        """The setpoint that keeps the hold point or goes to it."""
        self._stay(inputs)
        point, stops = self.target, not self._hold_point.arrived
        setpoint = self._hold_point.update(inputs.nav, inputs.manual, inputs.speed_mps, inputs.dt_s)
        if self._hold_point.way_m is not None:
            self._headway.update(self._hold_point.way_m, inputs.speed_mps, inputs.now_s)
        self._landing = self._landing and (self.target == point or self.going or stops)
        if self._hold_point.arrived or self._weathervane.turning:
            north_m, east_m = self._hold_point.target
            self._circles.update(math.hypot(inputs.nav.north_m - north_m, inputs.nav.east_m - east_m), inputs.now_s)
            self._consequence.update(inputs)
            alarmed = self._circles.alarmed or self._headway.is_stuck(inputs.now_s)
            self._weathervane.see(inputs, (north_m, east_m), self._circles.left, alarmed)
        elif isinstance(setpoint, PoseSetpoint):
            self._weathervane.see_way(inputs, (setpoint.north_m, setpoint.east_m))
        self._turn_to_weather(inputs)
        if isinstance(setpoint, PoseSetpoint):
            circle_m = 0.0 if self.going else self._parameters["DP_ECON"]
            return setpoint.within(circle_m, self._weathervane.driven_off)
        return setpoint

    def _turn_to_weather(self, inputs: ModeInputs) -> None:
        """While a point is held: turn a free heading. A stick that turns the boat gives it one."""
        if inputs.manual is not None and beyond_deadband(inputs.manual.yaw, self._parameters["MAN_DEADBAND"]) != 0.0:
            self._weathervane.give(inputs.now_s)
        if self.going and not self._weathervane.driven_off:
            return
        heading_rad = self._weathervane.update(inputs, self._hold_point.held[2])
        if heading_rad is not None:
            self._hold_point.turn_to(heading_rad, self._weathervane.driven_off)
