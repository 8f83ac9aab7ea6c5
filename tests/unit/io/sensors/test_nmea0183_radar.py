"""TTM and TLL of a radar, and a sounder that looks ahead, their values worked out by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.devices import SensorConfig
from companion.core.readings import Depth, DepthAhead, GnssFix, RadarTarget
from companion.io.sensors import open_sensor
from sitl.memory import MemoryStream
from tests.unit.io.sensors.test_nmea0183 import sentence
from tests.unit.io.sensors.test_nmea0183_instruments import fix_at

ROW = SensorConfig(name="radar", driver="nmea0183", port="memory:radar")


def read(*bodies: str, row: SensorConfig = ROW) -> list[object]:
    port = MemoryStream("radar")
    driver = open_sensor(row, port)
    for body in bodies:
        port.device.send(sentence(body), 1.0)
    return list(driver.read(1.0))


def test_a_target_by_bearing_and_distance() -> None:
    [found] = read("RATTM,07,0.50,120.0,T,4.0,270.0,T,,,N,BUOY,T,,,A")
    assert isinstance(found, RadarTarget)
    assert (found.number, found.name, found.lost, found.from_bow, found.relative) == (7, "BUOY", False, False, False)
    assert (found.distance_m, found.bearing_rad) == pytest.approx((926.0, math.radians(120.0)))
    assert (found.speed_mps, found.course_rad) == pytest.approx((4.0 * 0.514444, math.radians(270.0)), rel=1e-5)


def test_relative_bearings_and_kilometres() -> None:
    [found] = read("RATTM,01,2.0,10.0,R,3.6,0.0,R,,,K,,T,,,A")
    assert isinstance(found, RadarTarget) and found.from_bow and found.relative
    assert (found.distance_m, found.speed_mps) == pytest.approx((2000.0, 1.0))


def test_a_target_by_position_and_a_lost_one() -> None:
    placed, lost = read("RATLL,03,6326.340,N,01023.940,E,X,120000,T,", "RATTM,03,,,T,,,T,,,N,,L,,,A")
    assert isinstance(placed, RadarTarget) and isinstance(lost, RadarTarget)
    assert (placed.lat_deg, placed.lon_deg) == pytest.approx((63.439, 10.399)) and lost.lost and not placed.lost


@pytest.mark.parametrize("body", ["RATTM,,1.0,10.0,T,,,T,,,N,,T,,,A", "RATTM,01,1.0,10.0,T,,,T,,,,,T,,,A"])
def test_a_target_without_number_or_unit_is_ignored(body: str) -> None:
    assert read(body) == []


def test_a_sounder_that_looks_ahead() -> None:
    ahead = replace(ROW, depth_ahead_m=15.0)
    assert read("SDDPT,3.40,0.2,100", row=ahead) == [DepthAhead(1.0, "radar", 3.4, 15.0)]
    assert read("SDDBT,11.15,f,3.40,M,1.86,F", row=ahead) == [DepthAhead(1.0, "radar", 3.4, 15.0)]
    assert isinstance(read("SDDPT,3.40,0.2,100")[0], Depth)


@pytest.mark.parametrize(
    "body", ["RATTM,01,0.50,120.0,T,4.0,270.0,T,,,N,,T,,{},A", "RATLL,03,6326.340,N,01023.940,E,X,{},T,"]
)
def test_a_radars_clock_does_not_move_the_fixes(body: str) -> None:
    """On the receiver's line its clock is 0.2 s fast. Fixes keep the time of their arrival, targets that of theirs."""
    port = MemoryStream("radar")
    driver = open_sensor(ROW, port)
    for k in range(5):
        port.device.send(fix_at(float(k)), 1.0 + k)
        port.device.send(sentence(body.format(f"12000{k}.80")), 1.6 + k)
    times = [(type(reading), reading.t_s) for reading in driver.read(6.0)]
    assert times == [(kind, t_s + k) for k in range(5) for kind, t_s in ((GnssFix, 1.0), (RadarTarget, 1.6))]
