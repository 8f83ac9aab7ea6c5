"""NMEA 0183 sentences of satellite receivers: position, velocity, time, quality, satellites."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from datetime import date

from companion.core.readings import Corrections, FixType, GnssFix, GroundVelocity, Reading, TimeOfDay
from companion.io.sensors.nmea0183_fields import (
    MPS,
    Sentence,
    day,
    not_negative,
    number,
    place,
    satellites,
    unix_ns,
    within_turn,
)

Handler = Callable[[Sentence, float, list[Reading]], None]

_QUALITY = {
    1: FixType.FIX_3D,
    2: FixType.DGPS,
    3: FixType.FIX_3D,  # precise positioning service
    4: FixType.RTK_FIXED,
    5: FixType.RTK_FLOAT,
    9: FixType.DGPS,  # satellite-based corrections, as some makers say it
}  # 0 no fix, 6 dead reckoning, 7 typed in by hand, 8 simulator: not a position
_MODES = (  # of GNS, the best first, a letter for each constellation
    ("R", FixType.RTK_FIXED),
    ("F", FixType.RTK_FLOAT),
    ("D", FixType.DGPS),
    ("PA", FixType.FIX_3D),
)
_SIGMA_M = {
    FixType.FIX_2D: 5.0,
    FixType.FIX_3D: 1.5,
    FixType.DGPS: 0.5,
    FixType.RTK_FLOAT: 0.25,
    FixType.RTK_FIXED: 0.03,
}
_HDOP_RANGE = (0.7, 20.0)
_STATISTICS_AGE_S = 3.0  # how long GST and GSA hold for the fixes after them
_SATELLITES_AGE_S = 10.0
_STANDSTILL_MPS = 0.2  # below this, a course left empty means "none" and not "unknown"
_CORRECTIONS_PERIOD_S = 0.95
_FLAT = 2  # mode of a GSA without height
_UNMEASURED = frozenset("NEMS")  # mode indicators: no fix, dead reckoning, typed in by hand, simulator


class GnssSentences:
    """GGA, GNS, RMC, VTG, GLL, GST, ZDA, GSA, GSV → `GnssFix`, `GroundVelocity`, `TimeOfDay`, `Corrections`.

    Without a fix a `GnssFix` of type NONE is reported, its coordinates NaN. `recent(kind, t_s)` says whether that
    sentence has come lately: GNS, GLL and RMC count only where nothing better does. Remembers the last error
    statistics, dimension and dilution, satellites, and the kind of fix of the last GNS.
    """

    def __init__(self, name: str, recent: Callable[[str, float], bool]) -> None:
        self._name = name
        self._recent = recent
        self._sigma: tuple[float, float] | None = None  # (when, metres)
        self._solution: tuple[float, int, float | None] | None = None  # (when, GSA's mode, HDOP)
        self._corrections_s = -math.inf
        self._gns_fix = FixType.NONE
        self._satellites: dict[str, tuple[float, int, float]] = {}  # constellation → (when, in view, strongest dB-Hz)
        self.handlers: Mapping[str, Handler] = {
            "GGA": self._gga,
            "GNS": self._gns,
            "GLL": self._gll,
            "RMC": self._rmc,
            "VTG": self._vtg,
            "ZDA": self._zda,
            "GST": self._gst,
            "GSA": self._gsa,
        }

    def _gga(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        fix = _QUALITY.get(int(number(sentence.get("gps_qual")) or 0), FixType.NONE)
        hdop = not_negative(sentence.get("horizontal_dil"))
        fix = self._fix(sentence, fix, hdop, t_s, readings)
        self._corrected(sentence, fix, sentence.get("ref_station_id"), t_s, readings)

    def _gns(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """GGA of several constellations. Those of one of them, which may follow, have neither mode nor place, but the
        age of the corrections."""
        if self._recent("GGA", t_s):
            return
        mode = sentence.get("mode_indicator")
        if mode:
            fix = next((fix for letters, fix in _MODES if not set(letters).isdisjoint(mode)), FixType.NONE)
            self._gns_fix = self._fix(sentence, fix, not_negative(sentence.get("hdop")), t_s, readings)
        self._corrected(sentence, self._gns_fix, sentence.get("diferential"), t_s, readings)

    def _fix(
        self, sentence: Sentence, fix: FixType, hdop: float | None, t_s: float, readings: list[Reading]
    ) -> FixType:
        """Appends a position whose sentence says how good it is, and returns the kind of fix."""
        count = satellites(sentence.get("num_sats"))
        where = place(sentence) if fix is not FixType.NONE else None
        if where is None:
            readings.append(GnssFix(t_s, self._name, math.nan, math.nan, None, FixType.NONE, count, hdop))
            return FixType.NONE
        fix = self._dimension(fix, t_s)
        accuracy = self._accuracy_m(fix, hdop, t_s)
        readings.append(GnssFix(t_s, self._name, *where, number(sentence.get("altitude")), fix, count, hdop, accuracy))
        return fix

    def _corrected(
        self, sentence: Sentence, fix: FixType, station: str | None, t_s: float, readings: list[Reading]
    ) -> None:
        """The age of the corrections in use. It may be negative, where the base measures before the boat does."""
        age_s = number(sentence.get("age_gps_data"))
        if (
            age_s is not None
            and age_s >= 0.0
            and fix >= FixType.DGPS
            and t_s - self._corrections_s >= _CORRECTIONS_PERIOD_S
        ):
            self._corrections_s = t_s
            readings.append(Corrections(t_s, self._name, age_s, _station(station)))

    def _dimension(self, fix: FixType, t_s: float) -> FixType:
        """Quality 1 is the same with and without height; GSA tells the two apart."""
        flat = self._solution is not None and t_s - self._solution[0] < _STATISTICS_AGE_S and self._solution[1] == _FLAT
        return FixType.FIX_2D if fix is FixType.FIX_3D and flat else fix

    def _accuracy_m(self, fix: FixType, hdop: float | None, t_s: float) -> float:
        """One sigma on each horizontal axis: as the receiver itself estimates it, else typical of the kind of fix."""
        if self._sigma is not None and t_s - self._sigma[0] < _STATISTICS_AGE_S:
            return self._sigma[1]
        if hdop is None and self._solution is not None and t_s - self._solution[0] < _STATISTICS_AGE_S:
            hdop = self._solution[2]
        low, high = _HDOP_RANGE
        return _SIGMA_M[fix] * min(max(1.0 if hdop is None else hdop, low), high)

    def _gst(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        north, east = number(sentence.get("std_dev_latitude")), number(sentence.get("std_dev_longitude"))
        sigma_m = math.sqrt(0.5 * (north * north + east * east)) if north is not None and east is not None else 0.0
        self._sigma = (t_s, sigma_m) if sigma_m > 0.0 else None

    def _gsa(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        mode = number(sentence.get("mode_fix_type"))
        if mode is not None:
            self._solution = (t_s, int(mode), not_negative(sentence.get("hdop")))

    def satellites(self, talker: str, sentence: Sentence, t_s: float) -> None:
        """A GSV of one constellation: how many satellites are in view, and how strong the strongest is."""
        count = satellites(sentence.get("num_sv_in_view"))
        strengths = [number(sentence.get(f"snr_{n}")) or 0.0 for n in (1, 2, 3, 4)]
        if count is None:
            return
        first = sentence.get("msg_num") in ("1", "01")
        before = 0.0 if first or talker not in self._satellites else self._satellites[talker][2]
        self._satellites[talker] = t_s, count, max(before, *strengths)

    def remark(self, now_s: float) -> str:
        """Satellites in view, for people; empty where the receiver does not report them."""
        seen = [(count, dbhz) for t_s, count, dbhz in self._satellites.values() if now_s - t_s <= _SATELLITES_AGE_S]
        if not seen:
            return ""
        count, strongest_dbhz = sum(count for count, _ in seen), max(dbhz for _, dbhz in seen)
        return f"{count} satellites in view, the strongest {strongest_dbhz:.0f} dB-Hz"

    def _gll(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        if sentence.get("status") == "A" and _measured(sentence, "faa_mode") and not self._better(t_s):
            self._plain_fix(sentence, t_s, readings)

    def _better(self, t_s: float) -> bool:
        """Whether sentences come that say how good the position is."""
        return self._recent("GGA", t_s) or self._recent("GNS", t_s)

    def _plain_fix(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """A position whose sentence does not say how good it is."""
        where = place(sentence)
        if where is not None:
            fix = self._dimension(FixType.FIX_3D, t_s)
            readings.append(GnssFix(t_s, self._name, *where, None, fix, None, None, self._accuracy_m(fix, None, t_s)))

    def _rmc(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        if sentence.get("status") != "A":
            return
        measured = _measured(sentence, "mode_indicator")
        if measured and not self._better(t_s) and not self._recent("GLL", t_s):
            self._plain_fix(sentence, t_s, readings)
        if measured and not self._recent("VTG", t_s):
            self._velocity(
                number(sentence.get("spd_over_grnd")), MPS["N"], within_turn(sentence.get("true_course")), t_s, readings
            )
        if not self._recent("ZDA", t_s):
            self._time_of_day(day(sentence.get("datestamp")), sentence.get("timestamp"), t_s, readings)

    def _vtg(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        if not _measured(sentence, "faa_mode"):
            return
        speed, unit = number(sentence.get("spd_over_grnd_kmph")), MPS["K"]
        if speed is None:
            speed, unit = number(sentence.get("spd_over_grnd_kts")), MPS["N"]
        self._velocity(speed, unit, within_turn(sentence.get("true_track")), t_s, readings)

    def _velocity(
        self, speed: float | None, unit_mps: float, course_deg: float | None, t_s: float, readings: list[Reading]
    ) -> None:
        if speed is None or speed < 0.0:
            return
        speed_mps = speed * unit_mps
        if course_deg is None:
            if speed_mps > _STANDSTILL_MPS:
                return
            course_deg = speed_mps = 0.0
        course_rad = math.radians(course_deg)
        readings.append(
            GroundVelocity(t_s, self._name, speed_mps * math.cos(course_rad), speed_mps * math.sin(course_rad))
        )

    def _zda(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        on, month, year = number(sentence.get("day")), number(sentence.get("month")), number(sentence.get("year"))
        if on is not None and month is not None and year is not None:
            self._time_of_day(date(int(year), int(month), int(on)), sentence.get("timestamp"), t_s, readings)

    def _time_of_day(self, on: date | None, text: str | None, t_s: float, readings: list[Reading]) -> None:
        if on is not None and text:
            readings.append(TimeOfDay(t_s, self._name, unix_ns(on, text)))


def _measured(sentence: Sentence, mode: str) -> bool:
    """Whether position and velocity are measured. Receivers go on with sentences that say they are valid while they
    only go on by dead reckoning. Old ones have no mode."""
    return sentence.get(mode) not in _UNMEASURED


def _station(text: str | None) -> int | None:
    """The number of the reference station. Some receivers name it by letters."""
    return int(text) if text and text.isdecimal() else None
