"""Fields of NMEA 0183 sentences: texts → numbers in SI, places, days, times of day."""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import date, time
from functools import lru_cache

from pynmea2.nmea_utils import datestamp, timestamp

Sentence = Mapping[
    str, str
]  # the texts of its fields by their names in pynmea2; those that a device leaves off are not there
TALKER = "talker"  # in a `Sentence`, the two letters of who sends it

MPS = {"N": 1852.0 / 3600.0, "K": 1.0 / 3.6, "M": 1.0, "S": 1609.344 / 3600.0}
DAY_S = 86400
_MOST_SATELLITES = 99
_UNIX_DAY = date(1970, 1, 1).toordinal()
_LEAP, _BEFORE_LEAP = "235960", "235959"
_clock_of = lru_cache(16)(timestamp)  # several sentences of a moment have the same text


def checksum(body: bytes) -> int:
    """The exclusive or of all bytes, at most 256. It folds one half over the other until one byte is left."""
    folded = int.from_bytes(body, "little")
    for half in (1024, 512, 256, 128, 64, 32, 16, 8):
        folded ^= folded >> half
    return folded & 0xFF


def number(text: str | None) -> float | None:
    """A field as a number, None where it is empty. Raises ValueError for text that is no number: the caller rejects the
    sentence."""
    if not text:
        return None
    value = float(text)
    if not math.isfinite(value):
        raise ValueError("not finite")
    return value


def not_negative(text: str | None) -> float | None:
    """As `number`. Raises ValueError for a negative one, too."""
    value = number(text)
    if value is not None and value < 0.0:
        raise ValueError(f"negative: {text!r}")
    return value


def within_turn(text: str | None) -> float | None:
    """Degrees, as `number`. Raises ValueError beyond a whole turn, too: 999.9 is how some devices say that they do not
    know."""
    degrees = number(text)
    if degrees is not None and abs(degrees) > 360.0:
        raise ValueError(f"no direction: {text!r}")
    return degrees


def satellites(text: str | None) -> int | None:
    """A number of satellites, None where it is empty. Raises ValueError for more than the two digits that it has."""
    count = not_negative(text)
    if count is not None and count > _MOST_SATELLITES:
        raise ValueError(f"too many satellites: {text!r}")
    return None if count is None else int(count)


def angle_rad(text: str | None) -> float | None:
    """Degrees as text → radians; None where it is empty."""
    degrees = number(text)
    return None if degrees is None else math.radians(degrees)


def signed(text: str | None, side: str | None) -> float | None:
    """An angle with its E or W, positive east."""
    value = number(text)
    return None if value is None or side not in ("E", "W") else (value if side == "E" else -value)


def day(text: str | None) -> date | None:
    """ddmmyy as a date, None where it is empty."""
    if not text:
        return None
    found: date = datestamp(text)
    return found


def seconds_of_day(text: str) -> float:
    """hhmmss.sss in seconds since midnight; a leap second is the second 60. Raises ValueError for text that is no
    time."""
    leap = _is_leap_second(text)
    clock: time = _clock_of(_BEFORE_LEAP + text[6:] if leap else text)
    return clock.hour * 3600 + clock.minute * 60 + clock.second + leap + clock.microsecond * 1e-6


def unix_ns(on: date, text: str) -> int:
    """hhmmss.sss on a day as ns since 1970, which has no leap seconds: one has the number of the next midnight."""
    leap = _is_leap_second(text)
    clock: time = _clock_of(_BEFORE_LEAP + text[6:] if leap else text)
    seconds = (on.toordinal() - _UNIX_DAY) * DAY_S + clock.hour * 3600 + clock.minute * 60 + clock.second + leap
    return seconds * 1_000_000_000 + clock.microsecond * 1000


def place(sentence: Sentence) -> tuple[float, float] | None:
    """(latitude, longitude) in degrees; None where fields are empty. Raises ValueError for an impossible place."""
    lat, lon, north, east = sentence.get("lat"), sentence.get("lon"), sentence.get("lat_dir"), sentence.get("lon_dir")
    if not (lat and lon and north in ("N", "S") and east in ("E", "W")):
        return None
    latitude, longitude = _degrees(lat), _degrees(lon)
    if latitude > 90.0 or longitude > 180.0:
        raise ValueError(f"no place: {lat!r}, {lon!r}")
    return (latitude if north == "N" else -latitude), (longitude if east == "E" else -longitude)


def _degrees(text: str) -> float:
    """(d)ddmm.mmm in degrees. Raises ValueError for text that is none."""
    if text == "0":
        return 0.0
    point = text.find(".")
    if point < 3 or not text[:point].isdigit() or not text[point + 1 :].isdigit():
        raise ValueError(f"no degrees and minutes: {text!r}")
    minutes = float(text[point - 2 :])
    if minutes > 60.0:  # which some round up to
        raise ValueError(f"no minutes: {text!r}")
    return float(text[: point - 2]) + minutes / 60.0


def _is_leap_second(text: str) -> bool:
    return text[:6] == _LEAP
