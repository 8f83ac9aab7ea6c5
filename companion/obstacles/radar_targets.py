"""Targets that a radar tracks: those that move, and those that lie."""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.core.estimate import Contact, NavState
from companion.core.geodesy import LocalFrame
from companion.core.readings import RadarTarget

_FORGET_S = 15.0  # a radar reports each of its targets every few seconds
_MOVES_MPS = 0.5
_RADIUS_M = 5.0  # a radar does not say how large a target is
_MOST = 100


@dataclass(frozen=True, slots=True)
class _Target:
    label: str
    t_s: float
    north_m: float
    east_m: float
    north_mps: float
    east_mps: float
    moved_s: float  # time of its motion


class RadarTargets:
    """`take(target, nav, frame)` each report; `movers(now_s)` and `circles(now_s)` are where they are now. Remembers at
    most 100 targets for 15 s, and as long the motion of one that is reported by its position alone since."""

    def __init__(self) -> None:
        self._targets: dict[tuple[str, int], _Target] = {}

    def take(self, report: RadarTarget, nav: NavState, frame: LocalFrame) -> None:
        """A report without a place is ignored; one of a lost target ends it."""
        key = report.source, report.number
        if report.lost:
            self._targets.pop(key, None)
            return
        place = _place(report, nav, frame)
        if place is None or (key not in self._targets and len(self._targets) >= _MOST):
            return
        label = report.name or f"radar {report.number}"
        before = self._targets.get(key)
        if report.speed_mps is None and before is not None and report.t_s - before.moved_s <= _FORGET_S:
            motion = before.north_mps, before.east_mps, before.moved_s  # it sends TLL beside TTM
        else:
            motion = *_velocity(report, nav), report.t_s
        self._targets[key] = _Target(label, report.t_s, *place, *motion)

    def forget(self, now_s: float) -> None:
        """Forget targets that are no longer reported."""
        self._targets = {key: one for key, one in self._targets.items() if now_s - one.t_s <= _FORGET_S}

    def movers(self, now_s: float) -> list[Contact]:
        """Targets under way. Their numbers are below those of `Movers`."""
        return [
            Contact(
                -1_000_000 - number,
                one.label,
                one.north_m + (now_s - one.t_s) * one.north_mps,
                one.east_m + (now_s - one.t_s) * one.east_mps,
                one.north_mps,
                one.east_mps,
                _RADIUS_M,
                None,
            )
            for (_, number), one in self._targets.items()
            if math.hypot(one.north_mps, one.east_mps) >= _MOVES_MPS
        ]

    def circles(self) -> list[tuple[float, float, float]]:
        """Targets that lie: north_m, east_m, radius_m."""
        return [
            (one.north_m, one.east_m, _RADIUS_M)
            for one in self._targets.values()
            if math.hypot(one.north_mps, one.east_mps) < _MOVES_MPS
        ]


def _velocity(report: RadarTarget, nav: NavState) -> tuple[float, float]:
    """Over ground, (north, east) in m/s; at rest where it is not told."""
    speed, course = report.speed_mps or 0.0, report.course_rad
    north_mps = east_mps = 0.0
    if course is not None:
        course += nav.yaw_rad if report.relative else 0.0
        north_mps, east_mps = speed * math.cos(course), speed * math.sin(course)
    if report.relative:
        north_mps, east_mps = north_mps + nav.north_mps, east_mps + nav.east_mps
    return north_mps, east_mps


def _place(report: RadarTarget, nav: NavState, frame: LocalFrame) -> tuple[float, float] | None:
    if report.lat_deg is not None and report.lon_deg is not None:
        return frame.to_ned(report.lat_deg, report.lon_deg)
    if report.distance_m is None or report.bearing_rad is None:
        return None
    bearing = report.bearing_rad + (nav.yaw_rad if report.from_bow else 0.0)
    return nav.north_m + report.distance_m * math.cos(bearing), nav.east_m + report.distance_m * math.sin(bearing)
