"""How near a run came to violating a safety property, by the truth: a signed margin for each property that it has.

A property is had where there is what it is about: a fence, an obstacle, another vessel, a berth, a stretch of Hold. The
margins say nothing of accuracy, so they are the same question for a boat in any weather and with any fault.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.config.top_speed import top_speed_mps
from sitl.scenarios.boat import comes_back, holds_by_drifting
from sitl.scenarios.voyage import Floats, Voyage

_EVERY_S = 0.2  # between two places of the hull that are looked at
_WINDOW_S = 60.0  # of headway and circling
_SLOWEST_SHARE = 0.05  # of its usual speed, by which a boat under way must at least move on
# Events of a boat that waits for good reason, or has no thrust and says so.
_WAITING = (
    "obstacle_",
    "traffic_",
    "way_",
    "mission_delay",
    "bridge_silent",
    "thrust_lost",
    "heading_lost",
    "position_lost",
)
_ARRIVED = ("rtl_arrived", "mission_ended")  # after which the boat stays, in the same mode
_UNDER_WAY = ("Mission", "RTL")
_SELF_STEERED = ("Hold", "Mission", "RTL", "Dock", "Follow")
_MOST_TURNS = 1.5  # of the bow to one side within the window
_SETTLED_S = 30.0  # in Hold, before it counts
_MOVED_M = 1.0  # in one tick: Hold keeps another point
_LEAST_RADIUS_M, _LENGTHS = 6.0, 3.0  # of a Hold that drives off: twice the circle of `bow_hold`
_STOPPED_S = 2.0  # from disarming to propellers at rest
_STILL_SHARE = 0.02  # of full thrust
_TOUCH_MPS = 0.2  # four times the usual DOCK_SPEED
_HOME_S, _HOME_SHARE = 60.0, 0.3  # time for a way home, and the share of the top speed on it
_HOME_LENGTHS, _HOME_M = 3.0, 6.0


@dataclass(frozen=True, slots=True)
class Margin:
    """How far a run stayed from violating a property, in `unit`; at or below 0 it is violated. `scale`: what is far, to
    compare properties. `at_s`: when it was nearest."""

    name: str
    value: float
    unit: str
    scale: float
    at_s: float

    @property
    def share(self) -> float:
        """The margin as a share of what is far."""
        return self.value / self.scale

    def row(self) -> dict[str, Any]:
        """As it is written to result.json."""
        return asdict(self)


def margins_of(voyage: Voyage) -> list[Margin]:
    """The margin of every property that the run has."""
    return [margin for name, measure in PROPERTIES.items() if (margin := measure(name, voyage)) is not None]


def violated(margins: Sequence[Margin]) -> list[Margin]:
    """Those that are at or below 0, or no number."""
    return [margin for margin in margins if not margin.value > 0.0]


# --- distances -----------------------------------------------------------------------------------------------------


def _rows(voyage: Voyage, from_s: float = -math.inf) -> NDArray[np.int_]:
    """Indices of the rows that are looked at: armed, from that time on, some a second."""
    step = max(1, round(_EVERY_S / voyage.period_s))
    at = np.arange(0, len(voyage.t_s), step)
    found: NDArray[np.int_] = at[voyage.armed[at] & (voyage.t_s[at] >= from_s)]
    return found


def _corners(voyage: Voyage, at: NDArray[np.int_]) -> Floats:
    """Corners of the hull (rows, 4, 2) at these rows."""
    half = 0.5 * np.array([voyage.config.length_m, voyage.config.beam_m])
    body = np.array([(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]) * half
    return _placed(voyage.north_m[at], voyage.east_m[at], voyage.yaw_rad[at], body)


def _placed(north_m: Floats, east_m: Floats, yaw_rad: Floats, body: Floats) -> Floats:
    c, s = np.cos(yaw_rad)[:, None], np.sin(yaw_rad)[:, None]
    north = north_m[:, None] + c * body[:, 0] - s * body[:, 1]
    east = east_m[:, None] + s * body[:, 0] + c * body[:, 1]
    return np.stack([north, east], axis=-1)


def _least(name: str, values: Floats, times_s: Floats, unit: str, scale: float) -> Margin:
    i = int(np.argmin(values))
    return Margin(name, float(values[i]), unit, scale, float(times_s[i]))


def _fence(name: str, voyage: Voyage) -> Margin | None:
    """The hull inside the newest fence."""
    import shapely

    if not voyage.fences:
        return None
    from_s, corners = voyage.fences[-1]
    at = _rows(voyage, from_s)
    if not len(at):
        return None
    area = shapely.Polygon(corners)
    points = shapely.points(_corners(voyage, at))
    off = shapely.distance(points, area.exterior)
    inside = np.where(shapely.contains(area, points), off, -off).min(axis=1)
    return _least(name, inside, voyage.t_s[at], "m", 5.0)


def _obstacles(name: str, voyage: Voyage) -> Margin | None:
    """Water between hull and round obstacles or walls."""
    import shapely

    things, at = voyage.obstacles, _rows(voyage)
    if not (things.round or things.walls) or not len(at):
        return None
    hulls, t_s = shapely.polygons(_corners(voyage, at)), voyage.t_s[at]
    gaps = []
    for one in things.round:
        middle = shapely.points(one.north_m + t_s * one.north_mps, one.east_m + t_s * one.east_mps)
        gaps.append(shapely.distance(hulls, middle) - one.radius_m)
    gaps += [shapely.distance(hulls, shapely.LineString([wall.begin, wall.end])) for wall in things.walls]
    return _least(name, np.min(gaps, axis=0), t_s, "m", 3.0)


def _traffic(name: str, voyage: Voyage) -> Margin | None:
    """Water between the hulls of the boat and of other vessels, less half the distance that it keeps (CA_DIST)."""
    import shapely

    at = _rows(voyage)
    if not voyage.traffic or not len(at):
        return None
    hulls, t_s = shapely.polygons(_corners(voyage, at)), voyage.t_s[at]
    gaps = []
    for vessel in voyage.traffic:
        there = [vessel.at(t) for t in t_s]
        half = 0.5 * np.array([vessel.length_m, vessel.beam_m])
        body = np.array([(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]) * half
        north, east, course = (
            np.array([getattr(one, key) for one in there]) for key in ("north_m", "east_m", "course_rad")
        )
        gaps.append(shapely.distance(hulls, shapely.polygons(_placed(north, east, course, body))))
    return _least(name, np.min(gaps, axis=0) - 0.5 * voyage.parameters["CA_DIST"], t_s, "m", 10.0)


def _leader(name: str, voyage: Voyage) -> Margin | None:
    """Distance from lead boats, less the distance that it keeps (FOLL_MIN_DIST)."""
    at = _rows(voyage)
    if not voyage.leaders or not len(at):
        return None
    t_s = voyage.t_s[at]
    away = [
        np.hypot(
            voyage.north_m[at] - np.interp(t_s, boat.t_s, boat.north_m),
            voyage.east_m[at] - np.interp(t_s, boat.t_s, boat.east_m),
        )
        for boat in voyage.leaders
    ]
    return _least(name, np.min(away, axis=0) - voyage.parameters["FOLL_MIN_DIST"], t_s, "m", 8.0)


def _contact(name: str, voyage: Voyage) -> Margin | None:
    """Speed at which the boat touches its berth."""
    touched = np.flatnonzero(~np.isnan(voyage.contact_mps))
    if not len(touched):
        return None
    return _least(name, _TOUCH_MPS - voyage.contact_mps[touched], voyage.t_s[touched], "m/s", 0.1)


# --- control -------------------------------------------------------------------------------------------------------


def _headway(name: str, voyage: Voyage) -> Margin | None:
    """Under way: how far the boat gets within a minute, while it has no reason to wait."""
    rows = round(_WINDOW_S / voyage.period_s)
    usual_mps = min(top_speed_mps(voyage.config), voyage.parameters["WP_SPEED"])
    least_m = _SLOWEST_SHARE * usual_mps * _WINDOW_S
    waits_s = np.array([event.t_s for event in voyage.events if event.name.startswith(_WAITING)])
    arrived_s = np.array([event.t_s for event in voyage.events if event.name in _ARRIVED])
    found: list[tuple[float, float]] = []
    for first, end in voyage.stretches(*_UNDER_WAY):
        there_s = arrived_s[arrived_s >= voyage.t_s[first]]
        after = min(end, int(np.searchsorted(voyage.t_s, there_s[0]))) if len(there_s) else end
        for i in range(first, after - rows, max(1, round(5.0 / voyage.period_s))):
            if np.any((waits_s >= voyage.t_s[i] - _WINDOW_S) & (waits_s <= voyage.t_s[i + rows])):
                continue
            part = slice(i, i + rows)
            away = np.hypot(voyage.north_m[part] - voyage.north_m[i], voyage.east_m[part] - voyage.east_m[i])
            found.append((float(away.max()) - least_m, float(voyage.t_s[i])))
    if not found:
        return None
    value, at_s = min(found)
    return Margin(name, value, "m", 3.0 * least_m, at_s)


def _circling(name: str, voyage: Voyage) -> Margin | None:
    """Turns of the bow to one side within a minute, in modes that steer by themselves along no circle."""
    rows = round(_WINDOW_S / voyage.period_s)
    found: list[tuple[float, float]] = []
    for first, after in voyage.stretches(*(_UNDER_WAY if voyage.config.has_sail else _SELF_STEERED)):
        yaw, t_s = voyage.yaw_rad[first:after], voyage.t_s[first:after]
        span = min(rows, len(yaw) - 1)
        if span > 0:
            turned = np.abs(yaw[span:] - yaw[:-span]) / math.tau
            i = int(np.argmax(turned))
            found.append((_MOST_TURNS - float(turned[i]), float(t_s[i])))
    if not found:
        return None
    value, at_s = min(found)
    return Margin(name, value, "turns", 1.0, at_s)


def _disarmed(name: str, voyage: Voyage) -> Margin | None:
    """Thrust while the boat is disarmed; a propeller that runs away by itself does not count."""
    full = np.array([max(thruster.max_n, -thruster.min_n) for thruster in voyage.config.thrusters])
    armed_s = np.where(voyage.armed, voyage.t_s, -math.inf)
    at = np.flatnonzero(voyage.t_s - np.maximum.accumulate(armed_s) > _STOPPED_S)
    if not len(at):
        return None
    share = np.where(voyage.runaways, 0.0, np.abs(voyage.forces_n[at]) / full).max(axis=1)
    return _least(name, _STILL_SHARE - share, voyage.t_s[at], "of full thrust", _STILL_SHARE)


def _drive_off(name: str, voyage: Voyage) -> Margin | None:
    """Distance from the point that Hold keeps, once it has settled there; a point that it moves to is another one."""
    limit_m = max(_LEAST_RADIUS_M, _LENGTHS * voyage.config.length_m)
    if holds_by_drifting(voyage.config):
        limit_m = voyage.parameters["DP_ALARM_R"]
    settled = round(_SETTLED_S / voyage.period_s)
    found: list[tuple[float, float]] = []
    for first, after in _points_held(voyage):
        part = slice(first + settled, after)
        off = np.hypot(*(voyage.desired_m[part] - np.column_stack([voyage.north_m[part], voyage.east_m[part]])).T)
        if len(off) and not np.all(np.isnan(off)):
            i = int(np.nanargmax(off))
            found.append((limit_m - float(off[i]), float(voyage.t_s[part][i])))
    if not found:
        return None
    value, at_s = min(found)
    return Margin(name, value, "m", limit_m, at_s)


def _points_held(voyage: Voyage) -> Iterator[tuple[int, int]]:
    """First row, and the row after the last, of each stretch of Hold at one point."""
    for first, after in voyage.stretches("Hold"):
        steps = np.hypot(*np.diff(voyage.desired_m[first:after], axis=0).T)
        moved = first + 1 + np.flatnonzero(steps > _MOVED_M)
        edges = [first, *(int(row) for row in moved), after]
        yield from itertools.pairwise(edges)


def _return(name: str, voyage: Voyage) -> Margin | None:
    """Distance from home at the end of a run in which the boat had time enough to return, and no other order."""
    begins = [i for i, _ in voyage.stretches("RTL") if voyage.t_s[i] > voyage.ordered_s - voyage.period_s]
    if not begins:
        return None
    i = begins[0]
    home = int(np.argmax(voyage.armed))  # where it was armed
    away = np.hypot(voyage.north_m - voyage.north_m[home], voyage.east_m - voyage.east_m[home])
    needs_s = _HOME_S + float(away[i]) / (_HOME_SHARE * top_speed_mps(voyage.config))
    if voyage.t_s[-1] < voyage.t_s[i] + needs_s:
        return None
    limit_m = max(_HOME_M, _HOME_LENGTHS * voyage.config.length_m)
    if comes_back(voyage.config):
        limit_m = max(limit_m, voyage.parameters["DP_WATCH_R"])
    return Margin(name, limit_m - float(away[-1]), "m", 2.0 * limit_m, float(voyage.t_s[-1]))


PROPERTIES: Mapping[str, Callable[[str, Voyage], Margin | None]] = {
    "fence": _fence,
    "obstacles": _obstacles,
    "traffic": _traffic,
    "leader": _leader,
    "contact": _contact,
    "headway": _headway,
    "circling": _circling,
    "disarmed": _disarmed,
    "drive_off": _drive_off,
    "return": _return,
}
"""What measures each property: None where a run does not have it."""
