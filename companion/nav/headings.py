"""Which heading is listened to, and what it is worth: antenna baseline before compass before course over ground."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from companion.config import UNIT_MATRIX, NavigatedBoat, SensorConfig
from companion.core.angles import wrap_pi
from companion.core.geodesy import distance_and_bearing
from companion.core.geomagnetism import decimal_year, declination_rad
from companion.core.records import quick
from companion.core.types import GroundVelocity, Heading, HeadingBy, Severity
from companion.nav.sources import SourceSelector

Say = Callable[[float, Severity, str, str], None]

_BASELINE_SIGMA_RAD = math.radians(0.4)
_COMPASS_SIGMA_RAD = math.radians(3.0)
_COMPASS_FACTOR = 3.0  # its error wanders slowly: each reading counts as that much noisier
_BASELINE_WANDER_RAD, _COMPASS_WANDER_RAD = math.radians(0.1), math.radians(2.1)  # what averaging does not take away
_UNCALIBRATED_WANDER_RAD = math.radians(15.0)  # iron aboard shifts a raw magnetometer by tens of degrees
_COURSE_SPEED_MPS = 1.0  # from there on a boat under way points roughly where it goes
_COURSE_SIGMA_RAD = math.radians(15.0)
_COURSE_PERIOD_S = 1.0
_COURSE_AFTER_S = 2.0  # without a heading
_DECLINATION_REACH_M = 20_000.0
_DECLINATION_NEAR_DEG = 0.1  # within 12 km anywhere, so within reach: fields come 50 times a second
_DECLINATION_REACH_YEARS = 0.2
_COMPASS, _COURSE = " compass", "course over ground"


@quick
@dataclass(frozen=True, slots=True)
class TrueHeading:
    """A heading to weigh in: `sigma_rad` of one reading, `slow_rad` of what averaging does not take away, `doubt_rad` to add to the
    estimate first, because a better source takes over from one whose slow error is still in it."""

    yaw_rad: float
    sigma_rad: float
    slow_rad: float = 0.0
    doubt_rad: float = 0.0


class Declination:
    """Declination of the place and the year. Remembers the last one and where and when it was valid."""

    def __init__(self) -> None:
        self._known: tuple[float, float, float, float | None] | None = None  # latitude, longitude, year, declination

    def at(self, lat_deg: float, lon_deg: float, time_unix_ns: int | None) -> float | None:
        """In radians, positive east; None where compasses do not point."""
        year, known = decimal_year(time_unix_ns), self._known
        if known is not None and abs(year - known[2]) <= _DECLINATION_REACH_YEARS:
            near = abs(lat_deg - known[0]) + abs(lon_deg - known[1]) < _DECLINATION_NEAR_DEG
            if near or distance_and_bearing(lat_deg, lon_deg, known[0], known[1])[0] <= _DECLINATION_REACH_M:
                return known[3]
        self._known = (lat_deg, lon_deg, year, declination_rad(lat_deg, lon_deg, year))
        return self._known[3]


class HeadingSources:
    """`Heading` readings of all sources → the one in use, made true.

    Baselines in the order of the vessel's file, then compasses in that order, then course over ground. The first that is alive is used;
    a better one is taken back after it has been good without a break for some seconds (`SourceSelector`). A change is said: a fall-back as
    a warning. Remembers the source in use, its slow error, the declination, and when a heading last came.
    """

    def __init__(self, config: NavigatedBoat, say: Say) -> None:
        names = {row.name: row.timeout_s for row in config.sensors}
        self._selector = SourceSelector({**names, **{name + _COMPASS: timeout_s for name, timeout_s in names.items()}})
        self._ranks = {name: rank for rank, name in enumerate([*names, *(name + _COMPASS for name in names), _COURSE])}
        self._configured = {row.name: (row.heading_accuracy_rad, _wander_rad(row)) for row in config.sensors}
        self._say = say
        self._declination = Declination()
        self._used: str | None = None
        self._slow_rad = 0.0
        self._heading_s = self._course_s = -math.inf

    def offer(self, heading: Heading, lat_deg: float, lon_deg: float, time_unix_ns: int | None) -> TrueHeading | None:
        """What to weigh in of this reading; None: nothing. The place and time are for the declination."""
        baseline = heading.by is HeadingBy.BASELINE
        yaw = heading.yaw_rad
        if heading.by is HeadingBy.MAGNETIC:
            declination = self.declination(lat_deg, lon_deg, time_unix_ns)
            if declination is None:
                return None
            yaw = wrap_pi(yaw + declination)
        source = heading.source if baseline else heading.source + _COMPASS
        if not self._selector.offer(source, heading.t_s):
            return None
        self._heading_s = heading.t_s
        accuracy, wander = self._configured.get(heading.source, (None, None))
        sigma = heading.accuracy_rad or accuracy or (_BASELINE_SIGMA_RAD if baseline else _COMPASS_SIGMA_RAD)
        if wander is None:
            wander = _BASELINE_WANDER_RAD if baseline else _COMPASS_WANDER_RAD
        return self._taken(heading.t_s, source, yaw, sigma if baseline else _COMPASS_FACTOR * sigma, wander)

    def declination(self, lat_deg: float, lon_deg: float, time_unix_ns: int | None) -> float | None:
        """In rad, positive east; None where compasses do not point."""
        return self._declination.at(lat_deg, lon_deg, time_unix_ns)

    def course(self, velocity: GroundVelocity) -> TrueHeading | None:
        """Course over ground as a heading, where there is no other and the boat is fast enough."""
        t_s = velocity.t_s
        if math.hypot(velocity.north_mps, velocity.east_mps) < _COURSE_SPEED_MPS:
            return None
        if t_s - self._heading_s <= _COURSE_AFTER_S or t_s - self._course_s < _COURSE_PERIOD_S:
            return None
        self._course_s = t_s
        course = math.atan2(velocity.east_mps, velocity.north_mps)
        return self._taken(t_s, _COURSE, course, _COURSE_SIGMA_RAD, 0.0)

    def _taken(self, t_s: float, source: str, yaw_rad: float, sigma_rad: float, slow_rad: float) -> TrueHeading:
        before, self._used = self._used, source
        doubt = max(self._slow_rad, slow_rad) if source != before else 0.0
        self._slow_rad = slow_rad
        if source != before:
            fallen = before is not None and self._rank(source) > self._rank(before)
            severity = Severity.WARNING if fallen else Severity.NOTICE if before is not None else Severity.INFO
            self._say(t_s, severity, "heading_source", f"Heading by {source}" + (f": {before} gives none" if fallen else ""))
        return TrueHeading(yaw_rad, sigma_rad, slow_rad, doubt)

    def _rank(self, source: str) -> int:
        return self._ranks.get(source, len(self._ranks) - 2)  # a source nobody configured: just before course over ground


def _wander_rad(row: SensorConfig) -> float | None:
    """The slow error as the vessel's file has it; None: by kind."""
    if row.heading == "ahrs" and row.heading_wander_rad is None and row.mag_offset == (0.0, 0.0, 0.0) and row.mag_matrix == UNIT_MATRIX:
        return _UNCALIBRATED_WANDER_RAD
    return row.heading_wander_rad
