"""What a page may ask of the boat: one row an order, with its MAVLink command and its checks.

`order_of(asked, hello)` makes a `CommandOrder` or a `ParameterOrder` of a page's request, or raises OrderError. Nothing
that is not in the table goes out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

_CUSTOM_MODE = 1.0
_NAN = math.nan
_TRIAL = 31014
TRIMS: Mapping[str, tuple[float, float]] = {
    "DP_BW_SURGE": (0.05, 3.0),
    "DP_BW_SWAY": (0.05, 3.0),
    "DP_BW_YAW": (0.05, 3.0),
    "WP_SPEED": (0.05, 20.0),
}
"""Parameters that a page may set, with the range of the page; the boat has its own."""

STOPS = ("hold", "disarm")
"""Orders that stop the boat: however late one comes, it goes out."""

Asked = Mapping[str, Any]


class OrderError(Exception):
    """A request that is none: one line for the page."""


@dataclass(frozen=True, slots=True)
class CommandOrder:
    """A command of MAVLink. `place`: (latitude, longitude) in degrees for a COMMAND_INT, None for a COMMAND_LONG."""

    number: int
    params: tuple[float, ...]
    place: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class ParameterOrder:
    """A parameter to set."""

    name: str
    value: float


Order = CommandOrder | ParameterOrder


def order_of(asked: Asked, modes: Mapping[str, int]) -> Order:
    """The order that a page asks for, by the key `order`. `modes`: the boat's modes with their numbers. Raises
    OrderError."""
    make = _ORDERS.get(str(asked.get("order")))
    if make is None:
        raise OrderError(f"no such order: {asked.get('order')}")
    return make(asked, modes)


def _number(asked: Asked, key: str, low: float, high: float) -> float:
    value = asked.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise OrderError(f"{key}: give a number from {low:g} to {high:g}")
    return float(value)


def _optional(asked: Asked, key: str, low: float, high: float) -> float:
    return _NAN if asked.get(key) is None else _number(asked, key, low, high)


def _plain(number: int, *params: float) -> Callable[[Asked, Mapping[str, int]], Order]:
    return lambda asked, modes: CommandOrder(number, params)


def _mode(asked: Asked, modes: Mapping[str, int]) -> Order:
    name = str(asked.get("mode"))
    if name not in modes:
        raise OrderError(f"no such mode: {name}")
    return CommandOrder(176, (_CUSTOM_MODE, float(modes[name])))


def _go_to(asked: Asked, modes: Mapping[str, int]) -> Order:
    place = _number(asked, "lat_deg", -90.0, 90.0), _number(asked, "lon_deg", -180.0, 180.0)
    heading_deg = _optional(asked, "heading_deg", -360.0, 360.0)
    return CommandOrder(192, (-1.0, 1.0, 0.0, math.radians(heading_deg)), place)


def _nudge(asked: Asked, modes: Mapping[str, int]) -> Order:
    ahead_m, starboard_m = _number(asked, "ahead_m", -100.0, 100.0), _number(asked, "starboard_m", -100.0, 100.0)
    return CommandOrder(31010, (1.0, ahead_m, starboard_m, _number(asked, "turn_deg", -180.0, 180.0)))


def _heading(asked: Asked, modes: Mapping[str, int]) -> Order:
    return CommandOrder(31010, (2.0, _number(asked, "heading_deg", -360.0, 360.0) % 360.0))


def _station(asked: Asked, modes: Mapping[str, int]) -> Order:
    bearing_deg = _number(asked, "bearing_deg", -360.0, 360.0)
    return CommandOrder(31012, (bearing_deg, _number(asked, "distance_m", 0.0, 1000.0)))


def _trim(asked: Asked, modes: Mapping[str, int]) -> Order:
    name = str(asked.get("name"))
    if name not in TRIMS:
        raise OrderError(f"{name} cannot be set here")
    return ParameterOrder(name, _number(asked, "value", *TRIMS[name]))


_ORDERS: Mapping[str, Callable[[Asked, Mapping[str, int]], Order]] = {
    "arm": _plain(400, 1.0),
    "disarm": _plain(400, 0.0),
    "mode": _mode,
    "hold": _plain(192, -1.0, 1.0, 0.0, _NAN, _NAN, _NAN),
    "go_to": _go_to,
    "nudge": _nudge,
    "heading": _heading,
    "mission_start": _plain(300, 0.0, 0.0),
    "continue": _plain(193, 1.0),
    "station": _station,
    "trial_accept": _plain(_TRIAL, 0.0, 1.0),
    "trial_undo": _plain(_TRIAL, 0.0, 2.0),
    "restart": _plain(246, 1.0),
    "trim": _trim,
    "take_control": _plain(32100, 1.0, 1.0),
    "release_control": _plain(32100, 0.0, 0.0),
}
"""Hold here is a go-to without a place."""
