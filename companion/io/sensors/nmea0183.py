"""NMEA 0183: satellite receivers, compasses and wind sensors of any maker, over serial or network.

Source: NMEA 0183 version 4.11 as pynmea2 knows it: its tables name the fields, their texts are read here. Sentences without a checksum are
not trusted. The two letters of the talker do not matter. Between the sentences may stand anything, so RTCM or a maker's binary messages on
the same line do no harm.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from datetime import date, time

import pynmea2
from pynmea2.nmea_utils import datestamp, dm_to_sd, timestamp

from companion.config import SensorConfig
from companion.core.angles import wrap_pi
from companion.core.ports import ByteStream
from companion.core.types import FixType, GnssFix, GroundVelocity, Heading, HeadingBy, Reading, TimeOfDay, Wind
from companion.io.sensors.driver import StreamDriver

_LONGEST = 120  # of a sentence between $ and *: receivers with many digits go past the standard's 82
_SENTENCE = re.compile(rb"\$([ -#%%-)+-~]{6,%d})\*([0-9A-Fa-f]{2})" % _LONGEST)
_KEPT_BYTES = _LONGEST + 4

_QUALITY = {
    1: FixType.FIX_3D,
    2: FixType.DGPS,
    3: FixType.FIX_3D,  # precise positioning service
    4: FixType.RTK_FIXED,
    5: FixType.RTK_FLOAT,
    9: FixType.DGPS,  # satellite-based corrections, as some makers say it
}  # 0 no fix, 6 dead reckoning, 7 typed in by hand, 8 simulator: not a position
_SIGMA_M = {FixType.FIX_2D: 5.0, FixType.FIX_3D: 1.5, FixType.DGPS: 0.5, FixType.RTK_FLOAT: 0.25, FixType.RTK_FIXED: 0.03}
_HDOP_RANGE = (0.7, 20.0)
_STATISTICS_AGE_S = 3.0  # how long a GST holds for the fixes after it
_PREFERRED_AGE_S = 2.0  # GLL and RMC count only where nothing better came for that long
_MPS = {"N": 1852.0 / 3600.0, "K": 1.0 / 3.6, "M": 1.0, "S": 1609.344 / 3600.0}
_STANDSTILL_MPS = 0.2  # below this, a course left empty means "none" and not "unknown"
_UNIX_DAY = date(1970, 1, 1).toordinal()


class THS(pynmea2.TalkerSentence):  # type: ignore[misc]  # pynmea2 is untyped
    """True heading and status, which pynmea2 does not know; defining it enters it in pynmea2's table."""

    fields = (("True heading", "heading", float), ("Mode", "mode"))


Sentence = Mapping[str, str]  # the texts of its fields by their names in pynmea2; those that a device leaves off are not there


class Nmea0183Sensor(StreamDriver):
    """NMEA sentences → `GnssFix`, `GroundVelocity`, `Heading`, `TimeOfDay`, `Wind`.

    Without a fix a `GnssFix` of type NONE is reported, its coordinates NaN. Times are those of arrival of a sentence's first byte, less
    the configured latency. Remembers the unfinished sentence, the last error statistics, and when each type of sentence last came.
    """

    messages = "NMEA sentences"

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        super().__init__(config, stream)
        self._tail = b""
        self._tail_arrival_s = 0.0
        self._sigma_m: float | None = None
        self._seen_s: dict[str, float] = {}
        self._handlers: Mapping[str, Callable[[Sentence, float, list[Reading]], None]] = {
            "GGA": self._gga,
            "GLL": self._gll,
            "RMC": self._rmc,
            "VTG": self._vtg,
            "HDT": self._hdt,
            "THS": self._ths,
            "HDG": self._hdg,
            "HDM": self._hdm,
            "ZDA": self._zda,
            "GST": self._gst,
            "MWV": self._mwv,
        }
        types = pynmea2.TalkerSentence.sentence_types
        self._names = {kind: tuple(field[1] for field in types[kind].fields) for kind in self._handlers}

    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        kept = len(self._tail)
        buffer = self._tail + data if kept else data
        done = 0
        for match in _SENTENCE.finditer(buffer):
            began_s = self._tail_arrival_s if match.start() < kept else arrival_s
            done = match.end()
            body = match[1]
            if checksum(body) == int(match[2], 16):
                self._count_valid(arrival_s)
                self._sentence(body.decode("ascii"), began_s - self._config.latency_s, readings)
            else:
                self._bad += 1
        begin = buffer.rfind(b"$", done)
        unfinished = begin >= 0 and len(buffer) - begin <= _KEPT_BYTES
        if unfinished and begin >= kept:
            self._tail_arrival_s = arrival_s
        self._tail = buffer[begin:] if unfinished else b""

    def _sentence(self, body: str, t_s: float, readings: list[Reading]) -> None:
        kind = body[2:5]
        handler = self._handlers.get(kind)
        if handler is None or body[5] != ",":
            return
        sentence = dict(zip(self._names[kind], body[6:].split(","), strict=False))
        try:
            handler(sentence, t_s, readings)
        except (ValueError, OverflowError):  # fields that are not what their place says
            self._bad += 1
        self._seen_s[kind] = t_s

    def _recent(self, kind: str, t_s: float) -> bool:
        return t_s - self._seen_s.get(kind, -math.inf) < _PREFERRED_AGE_S

    def _gga(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        fix = _QUALITY.get(int(_number(sentence.get("gps_qual")) or 0), FixType.NONE)
        satellites, hdop = _number(sentence.get("num_sats")), _number(sentence.get("horizontal_dil"))
        count = None if satellites is None else int(satellites)
        place = _place(sentence) if fix is not FixType.NONE else None
        if place is None:
            readings.append(GnssFix(t_s, self.name, math.nan, math.nan, None, FixType.NONE, count, hdop))
            return
        accuracy = self._accuracy_m(fix, hdop, t_s)
        readings.append(GnssFix(t_s, self.name, *place, _number(sentence.get("altitude")), fix, count, hdop, accuracy))

    def _accuracy_m(self, fix: FixType, hdop: float | None, t_s: float) -> float:
        """One sigma on each horizontal axis: as the receiver itself estimates it, else typical of the kind of fix."""
        if self._sigma_m is not None and t_s - self._seen_s["GST"] < _STATISTICS_AGE_S:
            return self._sigma_m
        low, high = _HDOP_RANGE
        return _SIGMA_M[fix] * min(max(1.0 if hdop is None else hdop, low), high)

    def _gst(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        north, east = _number(sentence.get("std_dev_latitude")), _number(sentence.get("std_dev_longitude"))
        self._sigma_m = math.sqrt(0.5 * (north * north + east * east)) or None if north is not None and east is not None else None

    def _gll(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        if sentence.get("status") == "A" and not self._recent("GGA", t_s):
            self._plain_fix(sentence, t_s, readings)

    def _plain_fix(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """A position whose sentence does not say how good it is."""
        place = _place(sentence)
        if place is not None:
            accuracy = self._accuracy_m(FixType.FIX_3D, None, t_s)
            readings.append(GnssFix(t_s, self.name, *place, None, FixType.FIX_3D, None, None, accuracy))

    def _rmc(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        if sentence.get("status") != "A":
            return
        if not self._recent("GGA", t_s) and not self._recent("GLL", t_s):
            self._plain_fix(sentence, t_s, readings)
        if not self._recent("VTG", t_s):
            self._velocity(_number(sentence.get("spd_over_grnd")), _MPS["N"], _number(sentence.get("true_course")), t_s, readings)
        if not self._recent("ZDA", t_s):
            self._time_of_day(_day(sentence.get("datestamp")), sentence.get("timestamp"), t_s, readings)

    def _vtg(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        if sentence.get("faa_mode") == "N":
            return
        speed, unit = _number(sentence.get("spd_over_grnd_kmph")), _MPS["K"]
        if speed is None:
            speed, unit = _number(sentence.get("spd_over_grnd_kts")), _MPS["N"]
        self._velocity(speed, unit, _number(sentence.get("true_track")), t_s, readings)

    def _velocity(self, speed: float | None, unit_mps: float, course_deg: float | None, t_s: float, readings: list[Reading]) -> None:
        if speed is None or speed < 0.0:
            return
        speed_mps = speed * unit_mps
        if course_deg is None:
            if speed_mps > _STANDSTILL_MPS:
                return
            course_deg = speed_mps = 0.0
        course_rad = math.radians(course_deg)
        readings.append(GroundVelocity(t_s, self.name, speed_mps * math.cos(course_rad), speed_mps * math.sin(course_rad)))

    def _hdt(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        self._heading(_number(sentence.get("heading")), HeadingBy.BASELINE, t_s, readings)

    def _ths(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        if sentence.get("mode") == "A":
            self._heading(_number(sentence.get("heading")), HeadingBy.BASELINE, t_s, readings)

    def _hdg(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """Magnetic; true already where the compass knows the variation."""
        heading = _number(sentence.get("heading"))
        if heading is None:
            return
        heading += _signed(sentence.get("deviation"), sentence.get("dev_dir")) or 0.0
        variation = _signed(sentence.get("variation"), sentence.get("var_dir"))
        if variation is None:
            self._heading(heading, HeadingBy.MAGNETIC, t_s, readings)
        else:
            self._heading(heading + variation, HeadingBy.COMPASS, t_s, readings)

    def _hdm(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        if not self._recent("HDG", t_s):
            self._heading(_number(sentence.get("heading")), HeadingBy.MAGNETIC, t_s, readings)

    def _heading(self, heading_deg: float | None, by: HeadingBy, t_s: float, readings: list[Reading]) -> None:
        if heading_deg is not None:
            yaw_rad = wrap_pi(math.radians(heading_deg) + self._config.heading_offset_rad)
            readings.append(Heading(t_s, self.name, yaw_rad, None, by))

    def _zda(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        day, month, year = _number(sentence.get("day")), _number(sentence.get("month")), _number(sentence.get("year"))
        if day is not None and month is not None and year is not None:
            self._time_of_day(date(int(year), int(month), int(day)), sentence.get("timestamp"), t_s, readings)

    def _time_of_day(self, day: date | None, text: str | None, t_s: float, readings: list[Reading]) -> None:
        if day is not None and text:
            clock: time = timestamp(text)
            seconds = (day.toordinal() - _UNIX_DAY) * 86400 + clock.hour * 3600 + clock.minute * 60 + clock.second
            readings.append(TimeOfDay(t_s, self.name, seconds * 1_000_000_000 + clock.microsecond * 1000))

    def _mwv(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        angle, speed = _number(sentence.get("wind_angle")), _number(sentence.get("wind_speed"))
        unit = _MPS.get(sentence.get("wind_speed_units", ""))
        if sentence.get("status") == "A" and sentence.get("reference") == "R" and angle is not None and speed is not None and unit is not None:
            readings.append(Wind(t_s, self.name, speed * unit, wrap_pi(math.radians(angle) + self._config.heading_offset_rad)))


def checksum(body: bytes) -> int:
    """The exclusive or of all bytes, at most 128: the one half over the other until one byte is left."""
    folded = int.from_bytes(body, "little")
    for half in (512, 256, 128, 64, 32, 16, 8):
        folded ^= folded >> half
    return folded & 0xFF


def _number(text: str | None) -> float | None:
    """A field as a number, None where it is empty. Raises ValueError for text that is no number: the caller drops the sentence."""
    if not text:
        return None
    number = float(text)
    if not math.isfinite(number):
        raise ValueError("not finite")
    return number


def _signed(text: str | None, side: str | None) -> float | None:
    """An angle with its E or W, positive east."""
    number = _number(text)
    return None if number is None or side not in ("E", "W") else (number if side == "E" else -number)


def _day(text: str | None) -> date | None:
    """ddmmyy as a date, None where it is empty."""
    if not text:
        return None
    day: date = datestamp(text)
    return day


def _place(sentence: Sentence) -> tuple[float, float] | None:
    """(latitude, longitude) in degrees; None where the fields are empty or impossible."""
    lat, lon, north, east = sentence.get("lat"), sentence.get("lon"), sentence.get("lat_dir"), sentence.get("lon_dir")
    if not (lat and lon and north in ("N", "S") and east in ("E", "W")):
        return None
    latitude: float = dm_to_sd(lat)
    longitude: float = dm_to_sd(lon)
    if latitude > 90.0 or longitude > 180.0:
        return None
    return (latitude if north == "N" else -latitude), (longitude if east == "E" else -longitude)
