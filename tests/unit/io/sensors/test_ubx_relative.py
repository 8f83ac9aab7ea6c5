"""UBX-NAV-RELPOSNED: the vector from a moving base, alone and among the sentences of a receiver."""

from __future__ import annotations

import math

import pytest

from companion.config.devices import SensorConfig
from companion.core.readings import FixType, GnssFix, RelativeFix
from companion.io.sensors.nmea0183 import Nmea0183Sensor
from companion.io.sensors.ubx_relative import RelativeSolutions
from tests.unit.io.sensors.relposned import FIXED, FLOAT, ITOW_MS, framed, old_relposned, relposned
from tests.unit.io.sensors.test_nmea0183 import sentence
from tests.wires import Wire


@pytest.mark.parametrize("message", [relposned(), old_relposned()])
def test_both_versions(message: bytes) -> None:
    (found,) = RelativeSolutions().feed(message)
    assert (found.north_m, found.east_m, found.down_m) == pytest.approx((12.3456, -7.0012, 0.15))
    assert found.accuracy_m == pytest.approx(math.sqrt(0.5 * (0.008**2 + 0.006**2)))
    assert found.fix is FixType.RTK_FIXED and found.base == 4
    assert found.of_day_s == pytest.approx(0.4)


def test_what_its_flags_say() -> None:
    def fix(flags: int) -> FixType:
        (found,) = RelativeSolutions().feed(relposned(flags=flags))
        return found.fix

    assert fix(FIXED) is FixType.RTK_FIXED and fix(FLOAT) is FixType.RTK_FLOAT
    no_fix, not_valid, code_only, direction_only = FIXED & ~0x01, FIXED & ~0x04, FIXED & ~0x18, FIXED | 0x200
    assert {fix(flags) for flags in (no_fix, not_valid, code_only, direction_only)} == {FixType.NONE}


def test_it_is_found_wherever_it_is_cut() -> None:
    stream = b"$GNGGA,\xb5\xb5\x62\x01" + relposned() + b"\xd3\x00\x13" + relposned(itow_ms=ITOW_MS + 1000) + b"\xb5"
    for cut in range(len(stream)):
        reader = RelativeSolutions()
        assert len(reader.feed(stream[:cut]) + reader.feed(stream[cut:])) == 2


def test_other_messages_and_spoilt_ones_are_none() -> None:
    reader = RelativeSolutions()
    spoilt = bytearray(relposned())
    spoilt[20] ^= 0x40
    assert reader.feed(framed(bytes(92), b"\x01\x07") + bytes(spoilt) + framed(bytes(10))) == []
    assert reader.bad == 1
    assert len(reader.feed(relposned())) == 1


# --- among the sentences -------------------------------------------------------------------------------------------


def receiver() -> tuple[Nmea0183Sensor, Wire]:
    line = Wire()
    return Nmea0183Sensor(SensorConfig("gnss", "nmea0183", "serial:/dev/x:9600", latency_s=0.05), line), line


def gga(clock: str) -> bytes:
    return sentence(f"GNGGA,{clock},5736.0000000,N,01133.0000000,E,1,11,1.1,2.0,M,40.0,M,,")


def test_its_time_is_that_of_its_epoch_however_late_it_comes() -> None:
    sensor, line = receiver()
    line.chunks = [(10.05, gga("000000.40")), (10.15, gga("000000.50")), (10.33, relposned())]
    first, _, relative = sensor.read(10.4)
    assert isinstance(first, GnssFix) and isinstance(relative, RelativeFix)
    assert relative.t_s == pytest.approx(first.t_s) == pytest.approx(10.0)
    assert (relative.source, relative.north_m, relative.east_m) == ("gnss", 12.3456, pytest.approx(-7.0012))


def test_without_other_times_it_is_valid_on_arrival() -> None:
    sensor, line = receiver()
    line.chunks = [(10.33, relposned())]
    (relative,) = sensor.read(10.4)
    assert relative.t_s == pytest.approx(10.28)


def test_the_same_epoch_again_is_no_news() -> None:
    sensor, line = receiver()
    line.chunks = [(10.3, relposned()), (10.4, relposned()), (11.3, relposned(itow_ms=ITOW_MS + 1000))]
    assert len(sensor.read(11.4)) == 2


def test_a_receiver_without_a_solution_says_so() -> None:
    sensor, line = receiver()
    line.chunks = [(10.3, relposned(flags=FIXED & ~0x04))]
    (relative,) = sensor.read(10.4)
    assert isinstance(relative, RelativeFix)
    assert relative.fix is FixType.NONE and math.isnan(relative.north_m) and relative.accuracy_m is None
