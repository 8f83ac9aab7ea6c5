"""A berth in the local plane, and the choice of the berth to dock at."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState
from companion.core.frames import body_to_ned, ned_to_body
from companion.core.geodesy import LocalFrame
from companion.mission.commands import Command, heading_rad
from companion.mission.plan import PlanKind, Plans

_TOWARDS = {"port": (0.0, -1.0), "starboard": (0.0, 1.0), "bow": (1.0, 0.0), "stern": (-1.0, 0.0)}  # in body axes
_STANDOFF_M, _CLEARANCE_M = 2.0, 0.1  # used if the vessel has no [dock] table


@dataclass(frozen=True, slots=True)
class Berth:
    """A berth for the boat's reference point. (`north_m`, `east_m`) is a point of the berth's face: the middle of the
    boat's side is opposite it.

    `yaw_rad` is the boat's heading when docked. `towards` is the unit vector in body axes that points at the face.
    `reach_m` is the distance from the face to the reference point when alongside.
    """

    north_m: float
    east_m: float
    yaw_rad: float
    towards: tuple[float, float]
    reach_m: float
    standoff_m: float

    def pose(self, off_m: float, along_m: float = 0.0) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad) of the boat at `off_m` from the berth and `along_m` along it. Along is 90°
        clockwise of `towards`."""
        x, y = self.towards
        distance_m = self.reach_m + off_m
        north_m, east_m = body_to_ned(-distance_m * x - along_m * y, -distance_m * y + along_m * x, self.yaw_rad)
        return self.north_m + north_m, self.east_m + east_m, self.yaw_rad

    def place(self, north_m: float, east_m: float) -> tuple[float, float]:
        """(off_m, along_m) of a boat at this position. `off_m` is 0 alongside and negative inside the berth."""
        towards_m, along_m = self.resolved(north_m - self.north_m, east_m - self.east_m)
        return -towards_m - self.reach_m, along_m

    def closing_mps(self, nav: NavState) -> float:
        """The boat's speed towards the face, m/s."""
        return self.resolved(nav.north_mps, nav.east_mps)[0]

    def resolved(self, north: float, east: float) -> tuple[float, float]:
        """The components of a vector towards the face and along it."""
        (x, y), (tx, ty) = ned_to_body(north, east, self.yaw_rad), self.towards
        return x * tx + y * ty, y * tx - x * ty


class BerthChoice:
    """Chooses the berth: the nearest NAV_LAND item of the mission that has a heading, else the vessel's own."""

    def __init__(self, config: VesselConfig, plans: Plans, frame: Callable[[], LocalFrame]) -> None:
        self._config = config
        self._plans = plans
        self._frame = frame

    def at(self, lat_deg: float, lon_deg: float, yaw_rad: float) -> Berth:
        """As `berth_at`, in the plane as it is now."""
        return berth_at(self._config, self._frame(), lat_deg, lon_deg, yaw_rad)

    def find(self, nav: NavState) -> Berth | None:
        """The berth to dock at from here; None without one."""
        items = [item for item in self._plans.items(PlanKind.MISSION) if item.command == Command.NAV_LAND]
        headed = [(item, yaw_rad) for item in items if (yaw_rad := heading_rad(item)) is not None]
        berths = [self.at(item.lat_deg, item.lon_deg, yaw_rad) for item, yaw_rad in headed]
        dock = self._config.dock
        if not berths and dock is not None:
            return self.at(dock.lat_deg, dock.lon_deg, dock.yaw_rad)
        return min(berths, key=lambda b: math.hypot(b.north_m - nav.north_m, b.east_m - nav.east_m), default=None)


def berth_at(config: VesselConfig, frame: LocalFrame, lat_deg: float, lon_deg: float, yaw_rad: float) -> Berth:
    """The berth at this position, with side, standoff and clearance from the vessel's [dock] table."""
    dock = config.dock
    side = "port" if dock is None else dock.side
    clearance_m = _CLEARANCE_M if dock is None else dock.clearance_m
    half_m = 0.5 * (config.beam_m if side in ("port", "starboard") else config.length_m)
    standoff_m = _STANDOFF_M if dock is None else dock.standoff_m
    return Berth(*frame.to_ned(lat_deg, lon_deg), yaw_rad, _TOWARDS[side], half_m + clearance_m, standoff_m)
