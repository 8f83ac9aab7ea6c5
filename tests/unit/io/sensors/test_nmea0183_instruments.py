"""NMEA sentences of instruments and of quality, as manuals print them, their values worked out by hand; talkers; what
people are told."""

from __future__ import annotations

import math

import pytest

from companion.core.readings import Depth, FixType, GnssFix, Heading, Measurement, Wind
from tests.unit.io.sensors.test_nmea0183 import GGA, HDT, VTG, driver, read, sentence

# of manuals and of other parsers' documentation, with the checksums printed there
GSA = b"$GPGSA,A,3,02,,,07,,09,24,26,,,,,1.6,1.6,1.0*3D\r\n"
GSV = b"$GPGSV,3,1,11,03,03,111,00,04,15,270,00,06,01,010,00,13,06,292,00*74\r\n"
ROT = b"$HEROT,-11.23,A*07\r\n"
VWR = b"$IIVWR,75,R,1.0,N,0.51,M,1.85,K*6C\r\n"
DBT = b"$SDDBT,8.1,f,2.4,M,1.3,F*0B\r\n"
DPT = b"$SDDPT,17.9,0.5*6D\r\n"
VHW = b"$IIVHW,,T,,M,06.12,N,11.33,K*50\r\n"
RSA = b"$IIRSA,10.5,A,0.4,A*70\r\n"
KNOT = 1852.0 / 3600.0


def measured(*chunks: bytes) -> dict[str, float]:
    readings = read(*chunks)
    assert all(isinstance(reading, Measurement) and reading.source == "gnss" for reading in readings)
    return {reading.name: reading.value for reading in readings}  # type: ignore[union-attr]


def test_depth_by_hand() -> None:
    assert read(DPT) == [Depth(1.0, "gnss", 17.9, 0.5)]
    assert read(sentence("SDDPT,3.4,-0.3,100.0")) == [Depth(1.0, "gnss", 3.4, -0.3, 100.0)]
    assert read(DBT) == [Depth(1.0, "gnss", 2.4)]
    assert read(sentence("SDDBT,10.0,f,,M,,F")) == [Depth(1.0, "gnss", pytest.approx(3.048))]
    assert read(DPT + DBT) == [Depth(1.0, "gnss", 17.9, 0.5)], "DPT says more"
    assert read(sentence("SDDPT,,0.5")) == [] == read(sentence("SDDBT,,f,,M,,F")) == read(sentence("SDDPT,-3.0,0.5"))


def test_a_depth_of_zero_means_that_no_bottom_is_found() -> None:
    """No transducer measures 0 m below itself. The boat fled from shallow water that was too deep for its sounder."""
    assert read(sentence("SDDPT,0.0,0.5")) == [] == read(sentence("SDDBT,0.0,f,0.0,M,0.0,F"))
    assert read(sentence("SDDPT,0.1,0.5")) == [Depth(1.0, "gnss", 0.1, 0.5)]


def test_relative_wind_by_hand() -> None:
    assert read(VWR) == [Wind(1.0, "gnss", pytest.approx(0.51), pytest.approx(math.radians(75.0)))]
    assert read(sentence("IIVWR,30.0,L,10.0,N,,M,,K")) == [
        Wind(1.0, "gnss", pytest.approx(10.0 * KNOT), pytest.approx(math.radians(-30.0)))
    ]
    assert len(read(sentence("WIMWV,214.8,R,0.1,K,A") + VWR)) == 1, "MWV says the same"
    assert read(sentence("WIMWV,214.8,R,,K,V") + VWR) == [], "MWV says that it is not valid"
    assert len(read(sentence("WIMWV,214.8,T,0.1,K,A") + VWR)) == 1, "MWV is about true wind"
    assert read(sentence("IIVWR,30.0,,10.0,N,,M,,K")) == []


def test_rates_and_rudders_and_speed_through_water_by_hand() -> None:
    assert measured(ROT) == {"rate_of_turn_radps": pytest.approx(-11.23 * math.pi / 180.0 / 60.0)}
    assert measured(sentence("HEROT,-11.23,V")) == {}
    assert measured(RSA) == {
        "rudder_rad": pytest.approx(0.183260, abs=1e-6),
        "rudder_port_rad": pytest.approx(0.006981, abs=1e-6),
    }
    assert measured(b"$IIRSA,10.5,A,,V*4D\r\n") == {"rudder_rad": pytest.approx(math.radians(10.5))}
    assert measured(VHW) == {"water_surge_mps": pytest.approx(3.148, abs=1e-3)}
    assert measured(sentence("VWVHW,,T,,M,,N,3.6,K")) == {"water_surge_mps": pytest.approx(1.0)}
    both = sentence("VDVBW,2.0,-0.5,A,2.1,0.3,A") + VHW
    assert measured(both) == {
        "water_surge_mps": pytest.approx(2.0 * KNOT),
        "water_sway_mps": pytest.approx(-0.5 * KNOT),
    }
    assert measured(sentence("VDVBW,2.0,-0.5,V,2.1,0.3,A") + VHW) == {}
    over_ground = sentence("GPVBW,,,V,2.1,0.3,A")
    assert measured(over_ground + VHW) == {"water_surge_mps": pytest.approx(3.148, abs=1e-3)}


def test_transducers_by_hand() -> None:
    body = "YXXDR,A,5.2,D,PTCH,A,-7.4,D,ROLL,P,1.02481,B,Barometer,C,19.5,C,Air Temp,U,12.6,V,BATT#0,G,3,,LEVEL,T,600,R,ENGINE"
    assert measured(sentence(body)) == {
        "ptch_rad": pytest.approx(math.radians(5.2)),
        "roll_rad": pytest.approx(math.radians(-7.4)),
        "barometer_pa": pytest.approx(102481.0),
        "air_temp_c": 19.5,
        "batt_0_v": 12.6,
        "level": 3.0,
        "engine_radps": pytest.approx(62.831853),
    }
    assert measured(sentence("YXXDR,A,,D,PTCH")) == {} == measured(sentence("YXXDR"))
    assert measured(sentence("YXXDR,,1.0,,")) == {}


def test_transducers_that_a_weather_station_numbers_by_kind() -> None:
    """As Vaisala's WXT530 does: pressure and wind speed were both called 0."""
    assert measured(sentence("WIXDR,P,1028.1,H,0,C,24.9,C,0,H,43.2,P,0,A,302,D,0,S,0.1,M,0,S,0.4,M,1")) == {
        "p0_pa": pytest.approx(102810.0),
        "c0_c": 24.9,
        "h0_share": pytest.approx(0.432),
        "a0_rad": pytest.approx(math.radians(302.0)),
        "s0": 0.1,
        "s1": 0.4,
    }


def test_a_fix_without_height_is_told_by_gsa() -> None:
    flat = sentence("GPGSA,A,2,02,07,09,,,,,,,,,,1.6,1.5,")
    fixes = [reading for reading in read(GSA + GGA, flat + GGA, b"", b"", b"", GGA) if isinstance(reading, GnssFix)]
    assert [fix.fix for fix in fixes] == [FixType.FIX_3D, FixType.FIX_2D, FixType.FIX_3D]
    assert fixes[1].position_accuracy_m == pytest.approx(5.0 * 1.03)


def test_gsas_dilution_where_the_position_has_none() -> None:
    (fix,) = read(GSA + sentence("GPGLL,4916.45,N,12311.12,W,225444,A,A"))
    assert isinstance(fix, GnssFix) and fix.position_accuracy_m == pytest.approx(1.5 * 1.6)


def test_satellites_in_view_are_shown() -> None:
    sensor, line = driver()
    glonass = sentence("GLGSV,1,1,04,65,33,111,41.5,66,15,270,,67,01,010,00,68,06,292,38")
    line.chunks = [(1.0, GGA + GSV + glonass)]
    sensor.read(1.0)
    assert sensor.health(1.5).text == "3 NMEA sentences, 0 bad; 15 satellites in view, the strongest 42 dB-Hz"


def test_only_the_talkers_named() -> None:
    """A satellite compass and a magnetic one on one line: each sensor of the file takes its own."""
    both = sentence("HEHDT,10.0,T") + sentence("GPHDT,20.0,T")
    (heading,) = read(both, talkers=("GP",))
    assert isinstance(heading, Heading) and heading.yaw_rad == pytest.approx(math.radians(20.0))
    assert len(read(both)) == 2
    sensor, line = driver(talkers=("GP",))
    line.chunks = [(1.0, sentence("HEHDT,10.0,T"))]
    assert sensor.read(1.0) == [] and sensor.health(1.0).ok, "the line is well all the same"


def test_proprietary_and_ais_sentences_are_passed_by() -> None:
    from tests.unit.io.sensors.test_ais import CLASS_A

    sensor, line = driver()
    line.chunks = [
        (
            1.0,
            sentence("PASHR,085335.000,224.19,T,-01.26,+00.83,+00.00,0.101,0.113,0.267,1,0")
            + sentence("PGHDT,1.0,T")
            + CLASS_A
            + HDT,
        )
    ]
    (heading,) = sensor.read(1.0)
    assert isinstance(heading, Heading) and heading.yaw_rad == pytest.approx(math.radians(123.456))
    assert sensor.health(1.0).text == "4 NMEA sentences, 0 bad"


def test_rates_are_measured_and_shown() -> None:
    sensor, line = driver(rate_hz=20.0)
    for k in range(101):
        line.chunks = [(1.0 + 0.05 * k, HDT + (VTG if k % 4 == 0 else b""))]
        sensor.read(1.0 + 0.05 * k)
    assert sensor.health(6.0).text == "127 NMEA sentences, 0 bad; HDT 20, VTG 5 Hz"
    slow, line = driver(rate_hz=20.0)
    for k in range(7):
        line.chunks = [(1.0 + k, HDT)]
        slow.read(1.0 + k)
    assert slow.health(7.0).ok and slow.health(7.0).text.endswith("HDT 1 Hz; slower than rate_hz = 20")


def test_sentences_without_checksums_are_not_called_a_wrong_baud_rate() -> None:
    sensor, line = driver()
    line.chunks = [(1.0, HDT.replace(b"*32", b"") * 60)]
    assert sensor.read(1.0) == []
    health = sensor.health(1.0)
    assert not health.ok and "without a checksum" in health.text and "baud" not in health.text


# --- times -----------------------------------------------------------------------------------------------------------


def fix_at(seconds: float) -> bytes:
    return sentence(
        f"GNGGA,12{int(seconds // 60):02d}{seconds % 60:05.2f},6326.33401,N,01023.94001,E,1,12,0.8,10.4,M,40.0,M,,"
    )


def test_a_held_up_sentence_keeps_its_own_time() -> None:
    """Fixes of 0.1 s each, every fifth held up by 80 ms: spaced 0.1 s all the same, and a heading of the same burst
    with them."""
    sensor, line = driver(latency_s=0.02)
    times, headings = [], []
    for k in range(100):
        arrival_s = 7.0 + 0.1 * k + (0.08 if k % 5 == 3 else 0.0)
        line.chunks = [(arrival_s, fix_at(0.1 * k)), (arrival_s + 0.004, HDT)]
        readings = sensor.read(arrival_s + 0.01)
        times += [reading.t_s for reading in readings if isinstance(reading, GnssFix)]
        headings += [reading.t_s for reading in readings if isinstance(reading, Heading)]
    assert times == pytest.approx([6.98 + 0.1 * k for k in range(100)], abs=2e-3)
    assert headings[1:] == pytest.approx(times[1:])
    assert "16 ms late, at most 80" in sensor.health(17.0).text


def test_a_heading_between_two_fixes_is_valid_on_arrival() -> None:
    sensor, line = driver()
    line.chunks = [(1.0, fix_at(0.0)), (1.1, fix_at(0.1)), (1.102, HDT), (1.12, HDT), (1.16, HDT)]
    headings = [reading.t_s for reading in sensor.read(2.0) if isinstance(reading, Heading)]
    assert headings == [1.1, 1.12, 1.16]


def test_a_zda_with_the_pulse_of_the_second_does_not_draw_the_fixes_to_itself() -> None:
    """It comes 20 ms after its moment, the fix 200 ms after: only `latency_s` can know that, and it is the fix's."""
    sensor, line = driver(latency_s=0.2)
    for k in range(5):
        line.chunks = [(3.02 + k, sentence(f"GPZDA,12000{k}.00,01,06,2026,00,00")), (3.2 + k, fix_at(float(k)))]
        time, fix = sensor.read(3.3 + k)
        assert (time.t_s, fix.t_s) == pytest.approx((2.82 + k, 3.0 + k))


def test_midnight_and_a_jump_of_the_receivers_clock() -> None:
    sensor, line = driver()
    stamps = ["235959.80", "235959.90", "000000.00", "000000.10", "120000.00", "120000.10"]
    line.chunks = [
        (1.0 + 0.1 * k + 0.01 * (k % 2), sentence(f"GNGGA,{text},6326.33401,N,01023.94001,E,1,12,0.8,10.4,M,40.0,M,,"))
        for k, text in enumerate(stamps)
    ]
    times = [reading.t_s for reading in sensor.read(2.0)]
    assert times == pytest.approx([1.0, 1.1, 1.2, 1.3, 1.4, 1.5], abs=1e-3)


def test_no_time_is_later_than_its_arrival() -> None:
    sensor, line = driver()
    unstamped = sentence("GNGGA,,6326.33401,N,01023.94001,E,1,12,0.8,10.4,M,40.0,M,,")
    arrivals = [1.0, 1.1, 1.2, 1.3, 1.4]
    line.chunks = list(zip(arrivals, [fix_at(5.0), fix_at(9.0), fix_at(1.0), fix_at(1.0), unstamped], strict=True))
    assert all(reading.t_s <= arrival_s for reading, arrival_s in zip(sensor.read(2.0), arrivals, strict=True))
