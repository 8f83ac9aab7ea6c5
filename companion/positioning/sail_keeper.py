"""Holding near a point under sail: the boat sails to and fro across the wind, since it steers only with way on."""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.core.actuation import ZERO_WRENCH
from companion.core.estimate import NavState
from companion.core.events import unheard
from companion.core.readings import ManualInput
from companion.core.setpoint import PathSetpoint, Point, Progress, Setpoint, WrenchSetpoint
from companion.guidance.sail_motor import SailMotor
from companion.guidance.sail_turn import WAY_SHARE
from companion.guidance.sail_wind import SailWind
from companion.params.store import Parameters
from companion.positioning.drift import DriftKeeper

_ACROSS_SHARE = 0.45  # of the watch circle: how far to either side of the point the boat sails
_TACKS = 1.1  # of the way that a tack needs
_ABOVE_SHARE = 0.15  # of the watch circle: how far upwind of the point it aims, since turns and leeway lose way


class SailKeeper:
    """A `Keeper`. The boat sails across the wind from one side of the point to the other, and turns there: through the
    wind while it lies to leeward, before it while it lies to windward. Without a known wind the sheet is free. While
    motors drive the boat it drifts, and goes back upstream by them.

    Remembers the hold point, the side that it sails to, the wind, the drift, and whether it has been near the point.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._parameters = parameters
        self._wind = SailWind(parameters, unheard)
        self._motor = SailMotor(config, parameters, unheard)
        self._drifting = DriftKeeper(config, parameters)
        self._point = (0.0, 0.0)
        self._heading_rad = 0.0
        self._side = 1.0  # to the right of who looks into the wind
        self._from_rad: float | None = None
        self._arrived = False

    @property
    def arrived(self) -> bool:
        """Whether the boat has been inside the watch circle since the point was set."""
        return self._arrived

    @property
    def target(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad): the hold point and the last heading asked for."""
        return (*self._point, self._heading_rad)

    def start(self, nav: NavState, fitted: NavState | None = None) -> None:
        """Hold here."""
        self._point = (nav.north_m, nav.east_m)
        self._heading_rad = nav.yaw_rad
        self._arrived = True
        self._drifting.hold(*self._point, nav.yaw_rad, None)
        if (from_rad := nav.wind_from_rad) is not None:
            self._side = math.copysign(1.0, math.sin(nav.yaw_rad - from_rad))

    def hold(
        self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None, hurries: bool = False
    ) -> None:
        """Hold another point. Heading, speed and hurry are ignored: a boat under sail cannot hold a heading there."""
        self._point = (north_m, east_m)
        self._arrived = False
        self._drifting.hold(north_m, east_m, yaw_rad, speed_mps)

    def update(self, nav: NavState, stick: ManualInput | None, speed_mps: float, dt_s: float) -> Setpoint:
        """A path setpoint to the side that it sails to, at `speed_mps` and DP_SPEED_AHEAD at most, but with way for a
        tack."""
        self._wind.update(nav, nav.t_s, dt_s)
        self._motor.update(self._wind, nav.t_s)
        north_m, east_m = nav.north_m - self._point[0], nav.east_m - self._point[1]
        off_m, radius_m = math.hypot(north_m, east_m), self._parameters["DP_WATCH_R"]
        self._arrived = self._arrived or off_m <= radius_m
        if self._motor.drives:
            found = self._drifting.update(nav, stick, speed_mps, dt_s)
            self._heading_rad = self._drifting.target[2]
            return found
        point = Point(*self._point)
        progress = Progress(place=point, target=point, distance_to_go_m=off_m)
        if nav.wind_from_rad is not None:
            self._from_rad = nav.wind_from_rad
        if self._from_rad is None:
            return WrenchSetpoint(ZERO_WRENCH, progress)
        c, s = math.cos(self._from_rad), math.sin(self._from_rad)
        across_m = _ACROSS_SHARE * radius_m
        if self._side * (c * east_m - s * north_m) >= across_m:
            self._side = -self._side
        right_m, up_m = self._side * 1.5 * across_m, _ABOVE_SHARE * radius_m
        aim = up_m * c - right_m * s - north_m, up_m * s + right_m * c - east_m
        self._heading_rad = math.atan2(aim[1], aim[0])
        tack_mps = 0.0 if nav.wind_speed_mps is None else _TACKS * WAY_SHARE * nav.wind_speed_mps
        sail_mps = min(speed_mps, max(self._parameters["DP_SPEED_AHEAD"], tack_mps))
        return PathSetpoint(self._heading_rad, sail_mps, progress=progress)
