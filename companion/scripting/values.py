"""What a script sees of the boat, and the items of its missions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from companion.core.geodesy import LocalFrame

_GLOBAL_RELATIVE_ALT, _MISSION_FRAME = 6, 2
_NAV_WAYPOINT = 16
_UNITS_PER_DEGREE = 1e7


@dataclass(frozen=True, slots=True)
class State:
    """The boat in one control step, as the feed has it. None: not known.

    `row` has the columns of the log's ticks.csv by name, `more` what `companion/record/feed_schema.py` lists beside
    them.
    """

    t_s: float
    mode: str
    armed: bool
    lat_deg: float | None
    lon_deg: float | None
    north_m: float | None
    east_m: float | None
    yaw_rad: float | None
    surge_mps: float | None
    sway_mps: float | None
    yaw_rate_radps: float | None
    depth_m: float | None
    battery: float | None  # share that is left, 0 to 1
    mission_state: str
    mission_item: int  # from 0, as in MAVLink
    failsafes: tuple[str, ...]
    row: Mapping[str, Any]
    more: Mapping[str, Any]


def state_of(message: Mapping[str, Any]) -> State:
    """The state of a `tick` message of the feed. Raises KeyError for a message without the columns."""
    row, more = message["row"], message["more"]
    mission, battery = more["mission"], more["battery"]
    return State(
        t_s=float(row["t_s"]),
        mode=row["mode"],
        armed=bool(row["armed"]),
        lat_deg=more["lat_deg"],
        lon_deg=more["lon_deg"],
        north_m=row["north_m"],
        east_m=row["east_m"],
        yaw_rad=row["yaw_rad"],
        surge_mps=row["surge_mps"],
        sway_mps=row["sway_mps"],
        yaw_rate_radps=row["yaw_rate_radps"],
        depth_m=more["depth_m"],
        battery=None if battery is None else battery["remaining"],
        mission_state=mission["state"],
        mission_item=mission["seq"],
        failsafes=tuple(str(row["failsafes"]).split()),
        row=row,
        more=more,
    )


@dataclass(frozen=True, slots=True)
class Item:
    """A mission item: a MAV_CMD with its parameters. `lat_deg`, `lon_deg` None: it has no place."""

    command: int
    param1: float = 0.0
    param2: float = 0.0
    param3: float = 0.0
    param4: float = math.nan
    lat_deg: float | None = None
    lon_deg: float | None = None
    z: float = 0.0

    @property
    def frame(self) -> int:
        """MAV_FRAME."""
        return _MISSION_FRAME if self.lat_deg is None else _GLOBAL_RELATIVE_ALT

    @property
    def x(self) -> int:
        """Latitude in 1e-7 degrees; 0 without a place."""
        return 0 if self.lat_deg is None else round(self.lat_deg * _UNITS_PER_DEGREE)

    @property
    def y(self) -> int:
        """Longitude in 1e-7 degrees; 0 without a place."""
        return 0 if self.lon_deg is None else round(self.lon_deg * _UNITS_PER_DEGREE)


def item(command: int, *params: float) -> Item:
    """An item without a place: `item(178, 1, 1.5)` changes the speed to 1.5 m/s. Up to 4 parameters."""
    return Item(command, *(*params, *(0.0,) * (4 - len(params)))[:4])


def waypoint(lat_deg: float, lon_deg: float, hold_s: float = 0.0, heading_deg: float = math.nan) -> Item:
    """A waypoint, with a stay and a heading where given."""
    return Item(_NAV_WAYPOINT, hold_s, 0.0, 0.0, heading_deg or 360.0, lat_deg, lon_deg)  # in a plan 0 is none


def item_of(message: Any) -> Item:
    """The item of a MISSION_ITEM_INT."""
    place = message.frame != _MISSION_FRAME
    return Item(
        message.command,
        message.param1,
        message.param2,
        message.param3,
        message.param4,
        message.x / _UNITS_PER_DEGREE if place else None,
        message.y / _UNITS_PER_DEGREE if place else None,
        message.z,
    )


def moved(lat_deg: float, lon_deg: float, north_m: float, east_m: float) -> tuple[float, float]:
    """The place so many metres north and east of another, (lat_deg, lon_deg)."""
    return LocalFrame(lat_deg, lon_deg).to_geodetic(north_m, east_m)
