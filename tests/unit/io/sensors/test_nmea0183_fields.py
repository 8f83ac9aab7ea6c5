"""Times of day in NMEA 0183 sentences, against pynmea2."""

from __future__ import annotations

from datetime import UTC, date, datetime
from functools import reduce
from operator import xor

import pytest
from pynmea2.nmea_utils import timestamp

from companion.io.sensors.nmea0183_fields import checksum, seconds_of_day, unix_ns


@pytest.mark.parametrize("text", ["000000", "235959.999", "123519.5", "092750.000", "010203.123456", "201530.00"])
def test_a_time_is_that_of_pynmea2(text: str) -> None:
    clock = timestamp(text)
    whole = clock.hour * 3600 + clock.minute * 60 + clock.second
    assert seconds_of_day(text) == whole + clock.microsecond * 1e-6
    moment = datetime.combine(date(2026, 5, 31), clock, UTC)
    seconds = int(moment.replace(microsecond=0).timestamp())
    assert unix_ns(date(2026, 5, 31), text) == seconds * 1_000_000_000 + clock.microsecond * 1000


def test_a_leap_second_is_a_time() -> None:
    """Every sentence of that second was refused: no position for a second, and then the start of another clock."""
    assert [seconds_of_day(text) for text in ("235959.90", "235960", "235960.50")] == [86399.9, 86400.0, 86400.5]
    midnight_ns = 20_454 * 86_400_000_000_000  # 2026-01-01
    assert (
        unix_ns(date(2025, 12, 31), "235960.25") == midnight_ns + 250_000_000 == unix_ns(date(2026, 1, 1), "000000.25")
    )
    with pytest.raises(ValueError):
        seconds_of_day("235961")


@pytest.mark.parametrize("length", [0, 1, 2, 82, 127, 128, 129, 200, 255, 256])
def test_the_checksum_is_the_exclusive_or_of_all_bytes(length: int) -> None:
    body = bytes(32 + k * k % 90 for k in range(length))
    assert checksum(body) == reduce(xor, body, 0)


@pytest.mark.parametrize(
    "text", ["", "12", "240000", "126000", "125960", "12a519", "123519.x", "123519.nan", "1235191.5"]
)
def test_what_is_no_time_is_refused(text: str) -> None:
    with pytest.raises(ValueError):
        timestamp(text)
    with pytest.raises(ValueError):
        seconds_of_day(text)
