"""Hold: dynamic positioning. Holds where the boat can stop, or goes to the point commanded and holds there."""

from __future__ import annotations

import math

from companion.config import VesselConfig
from companion.core.types import ModeId, NavState, Setpoint, Severity
from companion.modes.events import EventLog
from companion.modes.mode import Mode, ModeInputs
from companion.modes.station import Station
from companion.params import Parameters

_BACK_INSIDE = 0.8  # of the watch circle


class HoldMode(Mode):
    """Remembers the station and whether the boat has left the watch circle. Sticks, when deflected, move the point and the heading held."""

    id = ModeId.HOLD

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog) -> None:
        self._parameters = parameters
        self._events = events
        self._station = Station(config, parameters)
        self._outside = False
        if config.limits.sway_n > 0.0:
            self.text = "Holds position and heading, or goes to a point and holds there"
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
        self.hold_here(inputs.nav)
        return None

    def resume(self, inputs: ModeInputs) -> str | None:
        self._station.rejoin(inputs.nav)
        return None

    def hold_here(self, nav: NavState) -> None:
        """Stop on the shortest way and hold there."""
        self._station.stop_here(nav)
        self._outside = False

    def go_to(self, nav: NavState, north_m: float, east_m: float, yaw_rad: float | None, speed_mps: float | None) -> None:
        """Go on from the present motion to another point. To be called after `enter`."""
        self._station.go_to(nav, north_m, east_m, yaw_rad, speed_mps, fresh=False)
        self._outside = False

    def drop_speed(self) -> None:
        """Forget the speed that came with the go-to."""
        self._station.drop_speed()

    def update(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._station.update(inputs.nav, inputs.manual, inputs.speed_mps, inputs.dt_s)
        if self._station.arrived:
            self._watch(inputs)
        return setpoint

    def _watch(self, inputs: ModeInputs) -> None:
        north_m, east_m = self._station.target
        off_m = math.hypot(inputs.nav.north_m - north_m, inputs.nav.east_m - east_m)
        radius_m = self._parameters["DP_WATCH_R"]
        if not self._outside and off_m > radius_m:
            self._outside = True
            self._events.say(inputs.now_s, Severity.WARNING, "watch_circle_left", f"Hold: {off_m:.1f} m off, outside the watch circle")
        elif self._outside and off_m < _BACK_INSIDE * radius_m:
            self._outside = False
            self._events.say(inputs.now_s, Severity.NOTICE, "watch_circle_back", "Hold: back inside the watch circle")
