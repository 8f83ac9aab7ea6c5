"""NMEA sentences, checked by hand, through the driver."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pytest

from companion.config.devices import SensorConfig
from companion.config.vessel import ConfigError
from companion.core.readings import (
    Corrections,
    FixType,
    GnssFix,
    GroundVelocity,
    Heading,
    HeadingBy,
    Reading,
    TimeOfDay,
    Wind,
)
from companion.io.sensors import DRIVERS, open_sensor

# sentences as makers' manuals print them, with their checksums
GGA = b"$GPGGA,092750.000,5321.6802,N,00630.3372,W,1,8,1.03,61.7,M,55.2,M,,*76\r\n"
RMC = b"$GPRMC,092750.000,A,5321.6802,N,00630.3372,W,0.02,31.66,280511,,,A*43\r\n"
VTG = b"$GPVTG,054.7,T,034.4,M,005.5,N,010.2,K*48\r\n"
HDT = b"$GPHDT,123.456,T*32\r\n"
ZDA = b"$GPZDA,201530.00,04,07,2002,00,00*60\r\n"


def sentence(body: str) -> bytes:
    """The body with a checksum made the slow way."""
    total = 0
    for character in body:
        total ^= ord(character)
    return f"${body}*{total:02X}\r\n".encode()


class Line:
    """A ByteStream in memory."""

    name = "line"

    def __init__(self) -> None:
        self.chunks: list[tuple[float, bytes]] = []
        self.broken: str | None = None

    def read(self, now_s: float) -> Sequence[tuple[float, bytes]]:
        chunks, self.chunks = self.chunks, []
        return chunks

    def write(self, data: bytes, now_s: float) -> None:
        raise AssertionError("a sensor is not written to")

    def fault(self) -> str | None:
        return self.broken

    def fileno(self) -> int | None:
        return 7

    def close(self) -> None:
        self.broken = "closed"


def driver(**more: Any) -> tuple[Any, Line]:
    line = Line()
    return open_sensor(SensorConfig("gnss", "nmea0183", "serial:/dev/x:9600", **more), line), line


def read(*chunks: bytes, **more: Any) -> list[Reading]:
    """Readings of chunks that came in at 1 s, 2 s, …"""
    sensor, line = driver(**more)
    line.chunks = [(1.0 + i, chunk) for i, chunk in enumerate(chunks)]
    return list(sensor.read(9.0))


def test_gga_by_hand() -> None:
    (fix,) = read(GGA)
    assert isinstance(fix, GnssFix)
    assert fix.lat_deg == pytest.approx(53.0 + 21.6802 / 60.0)
    assert fix.lon_deg == pytest.approx(-(6.0 + 30.3372 / 60.0))
    assert (fix.t_s, fix.source, fix.fix, fix.satellites, fix.hdop, fix.altitude_m) == (
        1.0,
        "gnss",
        FixType.FIX_3D,
        8,
        1.03,
        61.7,
    )
    assert fix.position_accuracy_m == pytest.approx(1.5 * 1.03)


def test_rmc_gives_position_velocity_and_time() -> None:
    fix, velocity, time = read(RMC)
    assert isinstance(fix, GnssFix) and fix.fix is FixType.FIX_3D
    assert isinstance(velocity, GroundVelocity)
    assert math.hypot(velocity.north_mps, velocity.east_mps) == pytest.approx(0.02 * 1852.0 / 3600.0)
    assert isinstance(time, TimeOfDay)
    assert time.time_unix_ns == 1_306_574_870_000_000_000  # date -u -d '2011-05-28 09:27:50' +%s


def test_rmc_steps_back_where_better_sentences_come() -> None:
    readings = read(GGA + VTG + ZDA + RMC)
    assert [type(reading) for reading in readings] == [GnssFix, GroundVelocity, TimeOfDay]


def test_vtg_by_hand() -> None:
    (velocity,) = read(VTG)
    assert isinstance(velocity, GroundVelocity)
    assert velocity.north_mps == pytest.approx(10.2 / 3.6 * math.cos(math.radians(54.7)))
    assert velocity.east_mps == pytest.approx(10.2 / 3.6 * math.sin(math.radians(54.7)))


def test_vtg_at_rest_has_no_course() -> None:
    assert read(sentence("GNVTG,,T,,M,0.02,N,0.04,K,A")) == [GroundVelocity(1.0, "gnss", 0.0, 0.0)]
    assert read(sentence("GNVTG,,T,,M,2.0,N,3.7,K,A")) == []
    assert read(sentence("GNVTG,10.0,T,,M,2.0,N,3.7,K,N")) == []


def test_zda_by_hand() -> None:
    (time,) = read(ZDA)
    assert time == TimeOfDay(1.0, "gnss", 1_025_813_730_000_000_000)  # date -u -d '2002-07-04 20:15:30' +%s


def test_fraction_of_a_second() -> None:
    (time,) = read(sentence("GPZDA,201530.05,04,07,2002,00,00"))
    assert isinstance(time, TimeOfDay)
    assert time.time_unix_ns == 1_025_813_730_050_000_000


def test_heading_with_offset_and_wrap() -> None:
    (plain,) = read(HDT)
    (turned,) = read(HDT, heading_offset_rad=math.radians(90.0))
    assert isinstance(plain, Heading) and isinstance(turned, Heading)
    assert plain.yaw_rad == pytest.approx(math.radians(123.456))
    assert turned.yaw_rad == pytest.approx(math.radians(123.456 + 90.0 - 360.0))


def test_ths_by_status() -> None:
    (heading,) = read(sentence("GNTHS,271.5,A"))
    assert isinstance(heading, Heading)
    assert heading.yaw_rad == pytest.approx(math.radians(-88.5))
    assert read(sentence("GNTHS,271.5,V")) == []


def test_compasses() -> None:
    """HDG is true with its own variation, magnetic without; HDM is magnetic, and left aside where HDG comes too."""
    (heading,) = read(sentence("HCHDG,98.3,1.0,W,12.6,E"))
    assert isinstance(heading, Heading) and heading.by is HeadingBy.COMPASS
    assert heading.yaw_rad == pytest.approx(math.radians(98.3 - 1.0 + 12.6))
    (heading,) = read(sentence("HCHDG,98.3,1.0,E,,"))
    assert isinstance(heading, Heading) and heading.by is HeadingBy.MAGNETIC
    assert heading.yaw_rad == pytest.approx(math.radians(99.3))
    (heading,) = read(sentence("HCHDM,310.5,M"))
    assert isinstance(heading, Heading) and heading.by is HeadingBy.MAGNETIC
    assert heading.yaw_rad == pytest.approx(math.radians(-49.5))
    assert read(sentence("HCHDM,,M")) == [] == read(sentence("HCHDG,,,,,"))
    both = read(HDT + sentence("HCHDG,98.3,1.0,W,12.6,E") + sentence("HCHDM,98.3,M"))
    assert [reading.by for reading in both if isinstance(reading, Heading)] == [HeadingBy.BASELINE, HeadingBy.COMPASS]


def test_a_magnetic_compass_says_a_true_heading() -> None:
    """It is as good as its HDG, and left aside where that comes too; two antennas and gyrocompasses are better."""
    for body in ("HCHDT,229.2,T", "HCTHS,229.2,A"):
        (heading,) = read(sentence(body))
        assert isinstance(heading, Heading) and heading.by is HeadingBy.COMPASS
        assert heading.yaw_rad == pytest.approx(math.radians(229.2 - 360.0))
    (heading,) = read(sentence("HCHDG,214.7,,,14.5,E") + sentence("HCHDT,229.2,T"))
    assert isinstance(heading, Heading) and heading.by is HeadingBy.COMPASS
    for body in ("GNHDT,229.2,T", "HEHDT,229.2,T", "GNTHS,229.2,A"):
        (heading,) = read(sentence(body))
        assert isinstance(heading, Heading) and heading.by is HeadingBy.BASELINE


@pytest.mark.parametrize("magnetic", ["GPHDM,120.3,M", "GPHDG,120.3,,,3.1,E", "GPHDG,120.3,,,,"])
def test_a_satellite_compass_is_no_second_witness(magnetic: str) -> None:
    """As Furuno's SC-60 and SC-110 send it: the magnetic heading is the true one less the variation. Without a true one
    it counts, and so does that of a compass on the same line."""
    assert [reading.by for reading in read(HDT + sentence(magnetic)) if isinstance(reading, Heading)] == [
        HeadingBy.BASELINE
    ]
    kinds = [type(reading) for reading in read(HDT, b"", sentence("GPHDT,,T") + sentence(magnetic))]
    assert kinds == [Heading, Heading]
    (_, compass) = read(HDT + sentence(magnetic) + sentence("HCHDM,118.0,M"))
    assert isinstance(compass, Heading) and compass.yaw_rad == pytest.approx(math.radians(118.0))
    (_, compass) = read(HDT + sentence(magnetic) + sentence("HCHDT,121.0,T"))
    assert isinstance(compass, Heading) and compass.by is HeadingBy.COMPASS


@pytest.mark.parametrize(
    "quality, fix",
    [
        (1, FixType.FIX_3D),
        (2, FixType.DGPS),
        (3, FixType.FIX_3D),
        (4, FixType.RTK_FIXED),
        (5, FixType.RTK_FLOAT),
        (9, FixType.DGPS),
    ]
    + [(quality, FixType.NONE) for quality in (0, 6, 7, 8)],
)
def test_quality(quality: int, fix: FixType) -> None:
    reading, *rest = read(
        sentence(f"GNGGA,120000.00,6326.33401,N,01023.94001,E,{quality},12,0.8,10.4,M,40.0,M,1.5,0001")
    )
    assert isinstance(reading, GnssFix)
    assert rest == ([Corrections(1.0, "gnss", 1.5, 1)] if fix >= FixType.DGPS else [])
    assert reading.fix is fix
    assert math.isnan(reading.lat_deg) == (fix is FixType.NONE)


def test_no_fix_is_reported_without_a_place() -> None:
    (fix,) = read(sentence("GNGGA,120000.00,,,,,0,00,,,M,,M,,"))
    assert isinstance(fix, GnssFix)
    assert (fix.fix, fix.satellites, fix.hdop, fix.altitude_m) == (FixType.NONE, 0, None, None)
    assert math.isnan(fix.lat_deg) and math.isnan(fix.lon_deg)


def test_dead_reckoning_is_no_measurement() -> None:
    """As a receiver sends it without satellites. VTG, RMC and GLL say that they are valid."""
    place, course = "4133.06452,N,00213.52562,E", "3.793,131.96"
    assert read(sentence("GNVTG,131.96,T,130.71,M,3.793,N,7.025,K,E")) == []
    assert read(sentence(f"GNGLL,{place},101938.00,A,E")) == []
    (time,) = read(sentence(f"GNRMC,101938.00,A,{place},{course},280622,1.26,E,E,V"))
    assert isinstance(time, TimeOfDay)
    for mode in ("A", "D", "F", "P", "R"):
        fix, velocity, _ = read(sentence(f"GNRMC,101938.00,A,{place},{course},280622,1.26,E,{mode},V"))
        assert isinstance(fix, GnssFix) and isinstance(velocity, GroundVelocity)


def test_a_reference_station_named_by_letters() -> None:
    """The example in NovAtel's manual: RMC still steps back behind the better GGA."""
    gga = b"$GPGGA,134658.00,5106.9792,N,11402.3003,W,2,09,1.0,1048.47,M,-16.27,M,08,AAAA*60\r\n"
    readings = read(gga + sentence("GPRMC,134658.00,A,5106.9792,N,11402.3003,W,0.08,323.3,210307,0.0,E,D"))
    assert [type(reading) for reading in readings] == [GnssFix, Corrections, GroundVelocity, TimeOfDay]
    assert readings[1] == Corrections(1.0, "gnss", 8.0, None)


def test_accuracy_from_gst() -> None:
    gst = sentence("GNGST,120000.00,1.2,0.020,0.010,45.0,0.012,0.016,0.030")
    fix = next(reading for reading in read(gst + GGA) if isinstance(reading, GnssFix))
    assert fix.position_accuracy_m == pytest.approx(math.sqrt((0.012**2 + 0.016**2) / 2.0))
    stale = read(gst, b"", b"", b"", b"", GGA)[-1]
    assert isinstance(stale, GnssFix)
    assert stale.position_accuracy_m == pytest.approx(1.5 * 1.03)


def test_gll_and_unknown() -> None:
    (fix,) = read(sentence("GPGLL,4916.45,S,12311.12,E,225444,A,A"))
    assert isinstance(fix, GnssFix)
    assert (fix.lat_deg, fix.lon_deg) == pytest.approx((-(49.0 + 16.45 / 60.0), 123.0 + 11.12 / 60.0))
    assert read(sentence("GPGLL,4916.45,S,12311.12,E,225444,V,N")) == []
    sensor, line = driver()
    line.chunks = [(1.0, sentence("GPXYZ,1,2,3") + sentence("PASHR,1.0,2.0"))]
    assert sensor.read(1.0) == []
    assert sensor.health(1.0).ok


def test_wind() -> None:
    (wind,) = read(sentence("WIMWV,214.8,R,0.1,K,A"))
    assert wind == Wind(1.0, "gnss", pytest.approx(0.1 / 3.6), pytest.approx(math.radians(214.8 - 360.0)))
    (knots,) = read(sentence("WIMWV,45.0,R,10.0,N,A"))
    assert isinstance(knots, Wind)
    assert knots.speed_mps == pytest.approx(5.14444, abs=1e-4)
    assert read(sentence("WIMWV,45.0,T,10.0,N,A")) == []
    assert read(sentence("WIMWV,45.0,R,10.0,N,V")) == []


def test_time_of_validity_is_arrival_less_latency() -> None:
    """Of the first byte: a sentence that trickles in was valid when it began."""
    (fix,) = read(b"noise" + GGA[:20], GGA[20:60], GGA[60:], latency_s=0.05)
    assert fix.t_s == pytest.approx(0.95)


def test_every_split_gives_the_same() -> None:
    whole = GGA + b"\xd3\x00\x13$\xff\x00binary" + HDT + VTG
    for at in range(1, len(whole)):
        assert len(read(whole[:at], whole[at:])) == 3
    assert len(read(*(whole[i : i + 1] for i in range(len(whole))))) == 3


@pytest.mark.parametrize(
    "bad",
    [
        HDT.replace(b"*32", b"*33"),
        HDT.replace(b"*32", b""),
        HDT.replace(b"123.456", b"123.457"),
        b"$GPHDT," + b"1" * 200 + b",T*00\r\n",
        sentence("GPHDT,north,T"),
        sentence("GPHDT,,T"),
        sentence("GPHDT,nan,T"),
        sentence("GPHDT,inf,T"),
        sentence("GPHDT"),
        sentence("GPGLL,9916.45,N,12311.12,W,225444,A,A"),
        sentence("GPGLL,49x6.45,N,12311.12,W,225444,A,A"),
        sentence("GPGLL,9000.01,N,12311.12,W,225444,A,A"),
        sentence("GPGLL,4916.45,N,18000.01,W,225444,A,A"),
        sentence("GPGLL,4975.00,N,12311.12,W,225444,A,A"),
        sentence("GNGGA,120000.00,9126.33401,N,01023.94001,E,1,12,0.8,10.4,M,40.0,M,,"),
        sentence("GNGGA,120000.00,6326.33401,N,01023.94001,E,1,12,-0.8,10.4,M,40.0,M,,"),
        sentence("GNGGA,120000.00,6326.33401,N,01023.94001,E,1,100000000,0.8,10.4,M,40.0,M,,"),
        sentence("GNGNS,120000.00,6326.33401,N,01023.94001,E,AA,12,-0.8,10.4,40.0,,,V"),
        sentence("GPHDT,999.9,T"),
        sentence("HCHDM,-400.0,M"),
        sentence("HCHDG,655.35,,,,"),
        sentence("GNVTG,999.9,T,,M,2.0,N,3.7,K,A"),
        sentence("WIMWV,45.0,R,-10.0,N,A"),
        sentence("WIMWV,999.9,R,10.0,N,A"),
        sentence("IIVWR,30.0,L,-10.0,N,,M,,K"),
        sentence("GPZDA,201530.00,31,02,2002,00,00"),
        sentence("GPZDA,999999.00,01,02,2002,00,00"),
        sentence("WIMWV,45.0,R,10.0,X,A"),
    ],
)
def test_bad_sentences_give_nothing(bad: bytes) -> None:
    assert read(bad) == []


def test_values_that_cannot_be_are_counted_as_bad() -> None:
    sensor, line = driver()
    line.chunks = [(1.0, sentence("WIMWV,45.0,R,-10.0,N,A") + sentence("GPGLL,9000.01,N,12311.12,W,225444,A,A"))]
    assert sensor.read(1.0) == [] and sensor.counts == (2, 2)


def test_a_wind_that_says_it_is_not_valid_is_not_bad() -> None:
    sensor, line = driver()
    line.chunks = [(1.0, sentence("WIMWV,999.9,R,-1.0,N,V") + sentence("IIVWR,75,R,1.0,N,0.51,M,1.85,K"))]
    assert sensor.read(1.0) == [] and sensor.counts == (2, 0)


def test_corrections_of_a_base_that_measures_ahead_have_no_age() -> None:
    """As RTKLIB prints it. The position counts all the same."""
    (fix,) = read(sentence("GNGGA,120000.00,6326.33401,N,01023.94001,E,4,12,0.8,10.4,M,40.0,M,-0.2,0001"))
    assert isinstance(fix, GnssFix) and fix.fix is FixType.RTK_FIXED


def test_health_tells_wrong_baud_rate_from_silence_and_fault() -> None:
    sensor, line = driver(timeout_s=2.0)
    health = sensor.health(5.0)
    assert not health.ok and health.age_s is None and "nothing received" in health.text
    line.chunks = [(5.0, bytes(range(128, 256)) * 6)]
    sensor.read(5.0)
    health = sensor.health(5.0)
    assert not health.ok and "wrong baud rate in 'serial:/dev/x:9600'" in health.text
    line.chunks = [(6.0, HDT)]
    sensor.read(6.0)
    health = sensor.health(6.5)
    assert health.ok and health.age_s == 0.5 and health.text == "1 NMEA sentences, 0 bad"
    assert "silent for 3.0 s" in sensor.health(9.0).text
    line.broken = "serial:/dev/x:9600: no such device"
    assert not sensor.health(6.5).ok and "no such device" in sensor.health(6.5).text


def test_a_device_whose_sentences_are_of_no_use_is_named_by_them() -> None:
    sensor, line = driver()
    line.chunks = [(5.0, b"!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C\r\n" * 60)]
    assert sensor.read(5.0) == []
    assert "sends no sentence that is used here, but AIS" in sensor.health(5.5).text


def test_table() -> None:
    assert set(DRIVERS) == {"nmea0183", "mtdata2", "vectornav", "mavlink_imu", "mavlink_range", "ais", "sbus", "crsf"}
    with pytest.raises(ConfigError, match="no driver 'sextant'; known: ais, crsf, mavlink_imu, mavlink_range"):
        open_sensor(SensorConfig("gnss", "sextant", "serial:/dev/x"), Line())
    sensor, line = driver()
    assert sensor.fileno() == 7
    sensor.close()
    assert line.broken == "closed"
