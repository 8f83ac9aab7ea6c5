"""The table of other vessels: merges their AIS reports, forgets silent vessels, and predicts where each one is now."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.core.estimate import Contact, TrackedTarget
from companion.core.frames import body_to_ned
from companion.core.geodesy import LocalFrame
from companion.core.readings import AisTarget

MOST_TARGETS = 256  # kept at a time
_NEW_A_SECOND = 50  # from one source into a full table; both channels of AIS carry 75 messages a second
# Silence after which a vessel is forgotten. It reports every 2 to 30 s; every 3 minutes when slow or at anchor.
_FORGET_S, _FORGET_SLOW_S = 90.0, 420.0
_SLOW_MPS = 1.6  # class B reports every 3 minutes below 2 knots, class A at anchor below 3 knots
_UPDATE_S = 1.0
_UNKNOWN_RADIUS_M = 10.0
_LIES = frozenset({1, 5, 6})  # AIS status: at anchor, moored, aground
_FISHES, _SAILS = 7, 8  # AIS status
_STATUS_OF_KIND = {30: _FISHES, 36: _SAILS}  # by type of ship: class B tells no status
_SWINGS_MPS = 0.5  # slower, such a ship swings at its anchor, or its receiver makes noise: it goes nowhere
_MMSI = range(1, 1_000_000_000)
_MOTION = ("t_s", "source", "lat_deg", "lon_deg", "course_rad", "speed_mps", "heading_rad", "turn_rate_radps")
_SHIP = ("status", "kind", "bow_m", "stern_m", "port_m", "starboard_m", "callsign", "name")


class TrafficTracker:
    """`take(report, …)` each report, `update(now_s)` once a tick. Remembers at most MOST_TARGETS vessels.

    When the table is full, a new vessel replaces the furthest of those heard once, else the furthest of all, and only
    if it is nearer itself. One source adds at most 50 vessels a second to a full table. A report that is older than the
    known motion of its vessel does not change that motion. Silence counts from the time of the newest report, not from
    when another system passed it on: two boats that tell each other of a vessel would else keep it for ever.
    """

    def __init__(self, own_mmsi: int | None = None) -> None:
        """`own_mmsi`: the boat's own MMSI; reports of it come from its own transponder and are ignored."""
        self._own = own_mmsi
        self._targets: dict[int, TrackedTarget] = {}
        self._sorted: tuple[TrackedTarget, ...] | None = ()
        self._updated_s = -math.inf
        self._admitted: dict[str, int] = {}  # by source, since the last update

    @property
    def targets(self) -> tuple[TrackedTarget, ...]:
        """All vessels, by MMSI."""
        if self._sorted is None:
            self._sorted = tuple(self._targets[mmsi] for mmsi in sorted(self._targets))
        return self._sorted

    def take(self, report: AisTarget, now_s: float, here: tuple[float, float] | None) -> None:
        """One report. `here`: (lat_deg, lon_deg) of the boat, None while not known. A report with an impossible MMSI or
        position is ignored."""
        if report.mmsi not in _MMSI or report.mmsi == self._own or not _is_place(report):
            return
        before = self._targets.get(report.mmsi)
        if before is None:
            new = TrackedTarget(report, min(now_s, report.t_s), int(report.lat_deg is not None))
            if _is_silent(new, now_s) or (len(self._targets) >= MOST_TARGETS and not self._make_room(report, here)):
                return
            self._targets[report.mmsi] = new
        else:
            self._targets[report.mmsi] = _merged(before, report, now_s)
        self._sorted = None

    def update(self, now_s: float) -> None:
        """Once a second, forget silent vessels."""
        if now_s - self._updated_s < _UPDATE_S:
            return
        self._updated_s = now_s
        self._admitted.clear()
        gone = [mmsi for mmsi, target in self._targets.items() if _is_silent(target, now_s)]
        for mmsi in gone:
            del self._targets[mmsi]
            self._sorted = None

    def _make_room(self, report: AisTarget, here: tuple[float, float] | None) -> bool:
        """Whether the full table has room for the report, after another vessel is forgotten for it."""
        admitted = self._admitted.get(report.source, 0)
        if admitted >= _NEW_A_SECOND:
            return False
        self._admitted[report.source] = admitted + 1
        ranks = {mmsi: (target.reports < 2, _away(target.known, here)) for mmsi, target in self._targets.items()}
        worst = max(ranks, key=lambda mmsi: ranks[mmsi])
        if ranks[worst] <= (True, _away(report, here)):
            return False
        del self._targets[worst]
        return True


def _is_place(report: AisTarget) -> bool:
    """Whether the position is possible; a report without one passes too."""
    if report.lat_deg is None or report.lon_deg is None:
        return report.lat_deg is report.lon_deg
    return abs(report.lat_deg) <= 90.0 and abs(report.lon_deg) <= 180.0


def _is_silent(target: TrackedTarget, now_s: float) -> bool:
    """Whether the vessel has been silent for so long that it is forgotten."""
    speed = target.known.speed_mps
    return now_s - target.heard_s > (_FORGET_SLOW_S if speed is None or speed < _SLOW_MPS else _FORGET_S)


def _away(report: AisTarget, here: tuple[float, float] | None) -> float:
    """Approximate distance in degrees of latitude; infinite where a position is not known."""
    if here is None or report.lat_deg is None or report.lon_deg is None:
        return math.inf
    east = math.remainder(report.lon_deg - here[1], 360.0) * math.cos(math.radians(here[0]))
    return math.hypot(report.lat_deg - here[0], east)


def _merged(before: TrackedTarget, report: AisTarget, now_s: float) -> TrackedTarget:
    """The vessel with the report added. Motion is replaced as a whole, unknown fields included; of the ship's data,
    only the fields that the report has."""
    known, reports = before.known, before.reports
    changes = {name: value for name in _SHIP if (value := getattr(report, name)) is not None}
    if report.lat_deg is not None and (known.lat_deg is None or report.t_s >= known.t_s):
        changes |= {name: getattr(report, name) for name in _MOTION}
        reports += 1
    return TrackedTarget(replace(known, **changes), max(before.heard_s, min(now_s, report.t_s)), reports)


def contact(target: TrackedTarget, frame: LocalFrame, now_s: float) -> Contact | None:
    """Where the vessel is now, if it has gone straight on since its last position; None before the first. Without
    speed, or without course and heading, it is taken to be at rest; so is one that reports that it lies at anchor, is
    moored or aground, and is slow. Of a vessel that tells no status its type counts."""
    known = target.known
    if known.lat_deg is None or known.lon_deg is None:
        return None
    north_m, east_m = frame.to_ned(known.lat_deg, known.lon_deg)
    north_mps, east_mps = _velocity(known)
    age_s = max(0.0, now_s - known.t_s)
    (x_m, y_m), radius_m = _hull(known)
    heading = known.heading_rad if known.heading_rad is not None else known.course_rad
    if heading is not None:
        off_north, off_east = body_to_ned(x_m, y_m, heading)
        north_m, east_m = north_m + off_north, east_m + off_east
    else:
        radius_m += math.hypot(x_m, y_m)
    return Contact(
        known.mmsi,
        target.label,
        north_m + age_s * north_mps,
        east_m + age_s * east_mps,
        north_mps,
        east_mps,
        radius_m,
        _STATUS_OF_KIND.get(known.kind or 0) if known.status is None else known.status,
    )


def _velocity(known: AisTarget) -> tuple[float, float]:
    """(north, east) in m/s, by which it is predicted."""
    speed = known.speed_mps or 0.0
    course = known.course_rad if known.course_rad is not None else known.heading_rad
    if course is None or (known.status in _LIES and speed < _SWINGS_MPS):
        return 0.0, 0.0
    return speed * math.cos(course), speed * math.sin(course)


def _hull(known: AisTarget) -> tuple[tuple[float, float], float]:
    """(metres ahead, metres to starboard) from the reported position to the middle of the hull, and the radius in m of
    a circle around the hull."""
    bow, stern, port, starboard = (
        value or 0.0 for value in (known.bow_m, known.stern_m, known.port_m, known.starboard_m)
    )
    if bow + stern <= 0.0:
        return (0.0, 0.0), _UNKNOWN_RADIUS_M
    radius_m = 0.5 * math.hypot(bow + stern, port + starboard)
    if bow == 0.0 and port == 0.0:  # the size is known, but not where in it the antenna is
        return (0.0, 0.0), 2.0 * radius_m
    return (0.5 * (bow - stern), 0.5 * (starboard - port)), radius_m
