"""Hold: dynamic positioning. Holds where the boat can stop, or goes to the point commanded and holds there."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.frames import body_to_ned
from companion.core.types import ModeId, NavState, Setpoint
from companion.modes.consequence import ConsequenceCheck
from companion.modes.events import EventLog
from companion.modes.fence_guard import FenceGuard
from companion.modes.headway import Headway
from companion.modes.mode import Mode, ModeInputs
from companion.modes.propulsion import can_reverse
from companion.modes.station import Station
from companion.modes.watch import WatchCircles
from companion.params import Parameters


class HoldMode(Mode):
    """What it remembers is in its station, its watch circles and its consequence check. Sticks, when deflected, move the point and the heading held."""

    id = ModeId.HOLD

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog, fence: FenceGuard) -> None:
        self._fence = fence
        self._station = Station(config, parameters, fence)
        self._circles = WatchCircles(parameters, events)
        self._consequence = ConsequenceCheck(config, parameters, events)
        self._headway = Headway("Hold", events)
        if config.limits.sway_n > 0.0:
            self.text = "Holds position and heading, or goes to a point and holds there"
        elif not can_reverse(config.thrusters):
            self.text = "Keeps inside a watch circle: drifts, and sails back bow into wind and current; no heading, no way astern"
        else:
            self.text = "Keeps inside a watch circle, bow into wind and current; heading cannot be held"

    @property
    def going(self) -> bool:
        """On the way to a point that was asked for."""
        return self._station.going

    @property
    def target(self) -> tuple[float, float]:
        """(north_m, east_m) held or on the way to."""
        return self._station.target

    def enter(self, inputs: ModeInputs) -> str | None:
        self._headway.reset()
        self.hold_here(inputs.nav)
        return None

    def resume(self, inputs: ModeInputs) -> str | None:
        self._station.rejoin(inputs.nav)
        self._consequence.reset()
        return None

    def hold_here(self, nav: NavState) -> None:
        """Stop on the shortest way and hold there."""
        self._station.stop_here(nav)
        self._moved()

    def go_to(self, nav: NavState, north_m: float, east_m: float, yaw_rad: float | None, speed_mps: float | None) -> None:
        """Go on from the present motion to another point. To be called after `enter`."""
        self._station.go_to(nav, north_m, east_m, yaw_rad, speed_mps, fresh=False)
        self._moved()

    def nudge(self, forward_m: float, starboard_m: float, turn_rad: float) -> str | None:
        """Move what is held, as the held heading has it. A reason where nothing is held yet."""
        if self._station.in_transit:
            return "the boat is on its way to a point"
        north_m, east_m, yaw_rad = self._station.held
        moved_north_m, moved_east_m = body_to_ned(forward_m, starboard_m, yaw_rad)
        place = (north_m + moved_north_m, east_m + moved_east_m)
        if not self._fence.may_move_to((north_m, east_m), place):
            return self._fence.point_refusal(*place)
        self._station.shift(*place, wrap_pi(yaw_rad + turn_rad))
        self._moved()
        return None

    def head(self, yaw_rad: float) -> str | None:
        """Another heading at the point held. A reason where nothing is held yet."""
        if self._station.in_transit:
            return "the boat is on its way to a point"
        self._station.turn_to(wrap_pi(yaw_rad))
        self._moved()
        return None

    def stuck_s(self, now_s: float) -> float | None:
        return self._headway.stuck_s(now_s)

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        return self._station.way_ahead

    def way_speed_mps(self, inputs: ModeInputs) -> float:
        return self._station.way_speed_mps(inputs.speed_mps)

    def excuse(self) -> None:
        self._headway.reset()

    def _moved(self) -> None:
        self._headway.rebase()
        self._circles.reset()
        self._consequence.reset()

    def drop_speed(self) -> None:
        """Forget the speed that came with the go-to."""
        self._station.drop_speed()

    def update(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._station.update(inputs.nav, inputs.manual, inputs.speed_mps, inputs.dt_s)
        if self._station.way_m is not None:
            self._headway.update(self._station.way_m, inputs.speed_mps, inputs.now_s)
        if self._station.arrived:
            north_m, east_m = self._station.target
            self._circles.update(math.hypot(inputs.nav.north_m - north_m, inputs.nav.east_m - east_m), inputs.now_s)
            self._consequence.update(inputs)
        return setpoint
