"""The program that stands in the page of sensors for tanks without satellites: its sentences are what its poses are."""

from __future__ import annotations

import math
import socket
import time
from typing import Any

import pytest

from companion.config.devices import SensorConfig
from companion.core.geodesy import LocalFrame
from companion.core.readings import FixType, GnssFix, Heading
from companion.io.sensors import open_sensor
from sitl.memory import MemoryStream
from tests.docs.pages import blocks

PROGRAM = next(block.text for block in blocks("python") if block.title == "mocap_nmea.py")


class Enough(Exception):
    """Ends the program."""


def test_poses_of_a_tank_are_fixes_and_headings(monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[bytes] = []

    class Port:
        def __init__(self, *kind: Any) -> None:
            pass

        def sendto(self, data: bytes, to: tuple[str, int]) -> None:
            sent.append(data)
            if len(sent) == 3:
                raise Enough

    now = [100.0]
    monkeypatch.setattr(socket, "socket", Port)
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time, "sleep", lambda s: now.__setitem__(0, now[0] + s))
    space: dict[str, Any] = {"__name__": "mocap_nmea"}
    with pytest.raises(Enough):
        exec(compile(PROGRAM, "mocap_nmea.py", "exec"), space)
    wire = MemoryStream("mocap")
    sensor = open_sensor(SensorConfig("mocap", "nmea0183", "udpin:127.0.0.1:10110", antennas=2), wire)
    wire.to_host.put(0.5, b"".join(sent))
    readings = [*sensor.read(1.0), *sensor.read(2.0)]
    fix = [reading for reading in readings if isinstance(reading, GnssFix)][-1]
    heading = [reading for reading in readings if isinstance(reading, Heading)][-1]
    north_m, east_m, heading_deg = space["pose"]()
    assert fix.fix is FixType.RTK_FIXED and fix.lat_deg is not None and fix.lon_deg is not None
    place = LocalFrame(space["LAT_DEG"], space["LON_DEG"]).to_ned(fix.lat_deg, fix.lon_deg)
    assert place == pytest.approx((north_m, east_m), abs=1e-3)
    assert math.degrees(heading.yaw_rad) % 360.0 == pytest.approx(heading_deg % 360.0, abs=0.01)
