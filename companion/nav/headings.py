"""The heading source in use and its accuracy: antenna baseline before compass before the boat's motion before course
over ground."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from companion.config.devices import UNIT_MATRIX, SensorConfig
from companion.config.vessel import NavigatedBoat
from companion.core.angles import wrap_pi
from companion.core.decision import TextKind
from companion.core.events import Announce
from companion.core.geodesy import distance_and_bearing
from companion.core.geomagnetism import decimal_year, declination_rad
from companion.core.readings import GroundVelocity, Heading, HeadingBy
from companion.nav.antenna_pair import antenna_pairs
from companion.nav.corrections import SensorCorrections
from companion.nav.sources import SourceSelector
from companion.nav.validity import HEADING_COAST_RAD

_BASELINE_SIGMA_RAD = math.radians(0.4)
_COMPASS_SIGMA_RAD = math.radians(3.0)
_COMPASS_FACTOR = 3.0  # its errors are correlated: each reading counts as that much noisier, if the file tells no noise
_BASELINE_WANDER_RAD, _COMPASS_WANDER_RAD = math.radians(0.1), math.radians(2.1)  # slow errors: averaging keeps them
_BASELINE_WANDER_S, _COMPASS_WANDER_S = 60.0, 300.0  # after which the slow error is another one
_UNCALIBRATED_WANDER_RAD = math.radians(15.0)  # iron aboard deflects a raw magnetometer by tens of degrees
_COURSE_SPEED_MPS = 1.0  # from this speed on, a boat points roughly along its course
_COURSE_KEPT_MPS = 0.7  # a boat that steers by its course slows in turns: down to here, the course goes on to serve
_COURSE_SIGMA_RAD = math.radians(15.0)  # from _COURSE_SPEED_MPS on; below, in proportion, as drift turns it by more
_COURSE_PERIOD_S = 1.0
_COURSE_AFTER_S = 2.0  # without a heading
_DECLINATION_REACH_M = 20_000.0
_DECLINATION_NEAR_DEG = 0.1  # within 12 km anywhere, so within reach: a cheap test, for 50 fields a second
_DECLINATION_REACH_YEARS = 0.2
_COMPASS, _COURSE, _MOTION = " compass", "course over ground", "motion"


@dataclass(frozen=True, slots=True)
class TrueHeading:
    """A heading to fuse. `sigma_rad`: of one reading; `slow_sigma_rad`: of the slow error, which averaging keeps, and
    `slow_time_s` after which that is another one. `anew`: the source, or its calibration, is another than before;
    `added_sigma_rad`: what an estimate that holds the slow error of the one before is off by then."""

    yaw_rad: float
    sigma_rad: float
    slow_sigma_rad: float = 0.0
    slow_time_s: float = 1.0
    anew: bool = False
    added_sigma_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class Measured:
    """A true heading of one source, `sigma_rad` as it would be fused; `wander_rad`: its slow error, `wander_s`: the
    time constant of that. `anew`: the source has been calibrated anew since its last heading."""

    t_s: float
    source: str
    yaw_rad: float
    sigma_rad: float
    wander_rad: float
    anew: bool = False
    wander_s: float = 1.0


class Declination:
    """Declination at a place and time. Remembers the last one, with its place and year."""

    def __init__(self) -> None:
        self._known: tuple[float, float, float, float | None] | None = None  # latitude, longitude, year, declination

    def at(self, lat_deg: float, lon_deg: float, time_unix_ns: int | None) -> float | None:
        """Declination in rad, positive east; None where a compass is unusable. `time_unix_ns` None: unknown."""
        year, known = decimal_year(time_unix_ns), self._known
        if known is not None and abs(year - known[2]) <= _DECLINATION_REACH_YEARS:
            near = abs(lat_deg - known[0]) + abs(lon_deg - known[1]) < _DECLINATION_NEAR_DEG
            if near or distance_and_bearing(lat_deg, lon_deg, known[0], known[1])[0] <= _DECLINATION_REACH_M:
                return known[3]
        self._known = (lat_deg, lon_deg, year, declination_rad(lat_deg, lon_deg, year))
        return self._known[3]


class HeadingSources:
    """`Heading` readings of all sources → true headings of the source in use.

    The order is: baselines as in the vessel's file, pairs of receivers, compasses, motion, course over ground. The
    first that is alive is used; `SourceSelector` goes back to a better one after some seconds without a break. A change
    is announced, a fall-back as a warning. Remembers the source in use, its slow error, the declination, and when a
    heading last came.
    """

    def __init__(
        self, config: NavigatedBoat, say: Announce, corrections: Mapping[str, SensorCorrections] | None = None
    ) -> None:
        """`corrections`: of the sensors that have some; they know how good a calibration aboard is."""
        pairs = antenna_pairs(config.sensors)
        names = {row.name: row.timeout_s for row in config.sensors} | {pair.name: pair.timeout_s for pair in pairs}
        self._selector = SourceSelector({**names, **{name + _COMPASS: timeout_s for name, timeout_s in names.items()}})
        self._ranks = {
            name: rank for rank, name in enumerate([*names, *(name + _COMPASS for name in names), _MOTION, _COURSE])
        }
        self._configured = {row.name: (row.heading_accuracy_rad, _wander_rad(row)) for row in config.sensors}
        self._configured |= {pair.name: (None, pair.wander_rad) for pair in pairs}
        self._wander_s = {row.name: row.heading_wander_s for row in config.sensors}
        self._noise_rad = {row.name: row.heading_noise_rad for row in config.sensors}
        self._corrections = corrections or {}
        self._versions = {name: correction.version for name, correction in self._corrections.items()}
        self._say = say
        self._declination = Declination()
        self._used: str | None = None
        self._slow_sigma_rad = 0.0
        self._heading_s = self._course_s = -math.inf

    @property
    def used(self) -> str | None:
        """The source in use; None before the first heading."""
        return self._used

    @property
    def by_motion(self) -> bool:
        """Whether the heading comes from the boat's motion alone, which nothing measures but the receiver."""
        return self._used in (_MOTION, _COURSE)

    @property
    def by_course(self) -> bool:
        """Whether the heading comes from the course over ground."""
        return self._used == _COURSE

    def measured(self, heading: Heading, lat_deg: float, lon_deg: float, time_unix_ns: int | None) -> Measured | None:
        """The true heading of a reading, whether or not its source is in use; None where a compass is unusable. Place
        and time are for the declination."""
        baseline = heading.by is HeadingBy.BASELINE
        yaw = heading.yaw_rad
        if heading.by is HeadingBy.MAGNETIC:
            declination = self.declination(lat_deg, lon_deg, time_unix_ns)
            if declination is None:
                return None
            yaw = wrap_pi(yaw + declination)
        accuracy, wander = self._configured.get(heading.source, (None, None))
        wander, anew = self._by_calibration(heading.source, wander)
        if wander is None:
            wander = _BASELINE_WANDER_RAD if baseline else _COMPASS_WANDER_RAD
        source = heading.source if baseline else heading.source + _COMPASS
        wander_s = self._wander_s.get(heading.source) or (_BASELINE_WANDER_S if baseline else _COMPASS_WANDER_S)
        sigma = self._noise_rad.get(heading.source) or _supposed_rad(heading.accuracy_rad or accuracy, baseline)
        return Measured(heading.t_s, source, yaw, sigma, wander, anew, wander_s)

    def offer(self, heading: Measured, good: bool = True) -> TrueHeading | None:
        """The heading to fuse; None if its source is not in use. One that is not `good` is never used."""
        if not self._selector.offer(heading.source, heading.t_s, good):
            return None
        self._heading_s = heading.t_s
        return self._use(heading)

    def _by_calibration(self, name: str, wander_rad: float | None) -> tuple[float | None, bool]:
        """The slow error of a sensor, and whether it has been calibrated anew since its last heading."""
        corrections = self._corrections.get(name)
        if corrections is None:
            return wander_rad, False
        anew = corrections.version != self._versions[name]
        self._versions[name] = corrections.version
        return (corrections.wander_rad if corrections.calibrated_aboard else wander_rad), anew

    def declination(self, lat_deg: float, lon_deg: float, time_unix_ns: int | None) -> float | None:
        """Declination in rad, positive east; None where a compass is unusable."""
        return self._declination.at(lat_deg, lon_deg, time_unix_ns)

    def found_by_motion(self, t_s: float) -> None:
        """The estimator has found the heading by the boat's motion (`heading_search`), and keeps it by that."""
        self._use(Measured(t_s, _MOTION, 0.0, 0.0, 0.0))

    def course(self, velocity: GroundVelocity, known_rad: float = math.inf, blind: bool = False) -> TrueHeading | None:
        """Course over ground as a heading to fuse; None while there is another heading, or the boat is too slow.
        `known_rad`: one sigma of the estimate's own heading. `blind`: the heading in use is found to lie and no gyro
        carries it, so that nothing else is waited for."""
        if self.by_motion and known_rad <= HEADING_COAST_RAD:
            return None
        t_s, speed_mps = velocity.t_s, math.hypot(velocity.north_mps, velocity.east_mps)
        in_use = self._used == _COURSE and t_s - self._course_s <= _COURSE_AFTER_S
        if speed_mps < (_COURSE_KEPT_MPS if in_use else _COURSE_SPEED_MPS):
            return None
        if t_s - self._heading_s <= (0.0 if blind else _COURSE_AFTER_S) or t_s - self._course_s < _COURSE_PERIOD_S:
            return None
        self._course_s = t_s
        course = math.atan2(velocity.east_mps, velocity.north_mps)
        sigma_rad = _COURSE_SIGMA_RAD * max(1.0, _COURSE_SPEED_MPS / speed_mps)
        return self._use(Measured(t_s, _COURSE, course, sigma_rad, 0.0))

    def _use(self, heading: Measured) -> TrueHeading:
        source, slow_sigma_rad = heading.source, heading.wander_rad
        before, self._used = self._used, source
        anew = source != before or heading.anew
        added = max(self._slow_sigma_rad, slow_sigma_rad) if anew else 0.0
        self._slow_sigma_rad = slow_sigma_rad
        if source != before:
            fallen = before is not None and self._rank(source) > self._rank(before)
            kind = TextKind.ATTENTION if fallen else TextKind.ROUTINE
            text = f"Heading source: {source}" + (f" ({before} lost)" if fallen else "")
            self._say(heading.t_s, kind, "heading_source", text)
        return TrueHeading(heading.yaw_rad, heading.sigma_rad, slow_sigma_rad, heading.wander_s, anew, added)

    def _rank(self, source: str) -> int:
        # a source that is not in the vessel's file ranks just before the boat's motion
        return self._ranks.get(source, len(self._ranks) - 3)


def _supposed_rad(accuracy_rad: float | None, baseline: bool) -> float:
    """The error of a heading from one to the next, where the vessel's file tells none."""
    if baseline:
        return accuracy_rad or _BASELINE_SIGMA_RAD
    return _COMPASS_FACTOR * (accuracy_rad or _COMPASS_SIGMA_RAD)


def _wander_rad(row: SensorConfig) -> float | None:
    """The slow error by the vessel's file; None: the default of the kind applies."""
    if (
        row.heading == "ahrs"
        and row.heading_wander_rad is None
        and row.mag_offset == (0.0, 0.0, 0.0)
        and row.mag_matrix == UNIT_MATRIX
    ):
        return _UNCALIBRATED_WANDER_RAD
    return row.heading_wander_rad
