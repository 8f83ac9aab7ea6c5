"""The emulated AIS receiver with the driver that reads it: what the traffic does is what the driver reads, as often as
transponders speak."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.devices import SensorConfig
from companion.config.vessel import find, load
from companion.core.geodesy import LocalFrame
from companion.core.readings import AisTarget
from companion.io.sensors import open_sensor
from sitl.traffic import ScriptedVessel
from sitl.world import World, WorldConditions

RECEIVER = SensorConfig(name="ais", driver="ais", port="memory:ais", rate_hz=5.0)
REVOLT = load(find("revolt"))


def listen(*vessels: ScriptedVessel, seconds: float) -> list[AisTarget]:
    config = replace(REVOLT, sensors=(*REVOLT.sensors, RECEIVER))
    world = World(config, WorldConditions(seed=2))
    sensor = open_sensor(RECEIVER, world.open("ais", "memory:ais"))
    world.traffic.vessels.extend(vessels)
    found: list[AisTarget] = []
    for n in range(1, round(seconds * 5) + 1):
        world.advance(n * 0.2)
        found += [reading for reading in sensor.read(n * 0.2) if isinstance(reading, AisTarget)]
    assert sensor.health(seconds).ok and "0 bad" in sensor.health(seconds).text
    return found


@pytest.mark.parametrize("class_a", [True, False])
@pytest.mark.parametrize("towards_deg", [35.0, 215.0])
def test_the_motion_that_is_read_is_the_motion_that_is(class_a: bool, towards_deg: float) -> None:
    c, s = math.cos(math.radians(towards_deg)), math.sin(math.radians(towards_deg))
    vessel = ScriptedVessel(
        230_000_123,
        "NORA",
        ((0.0, 100.0, -50.0), (100.0, 100.0 + 300.0 * c, -50.0 + 300.0 * s)),
        class_a=class_a,
        status=7,
    )
    found = listen(vessel, seconds=60.0)
    frame = LocalFrame(REVOLT.home.lat_deg, REVOLT.home.lon_deg)
    moving = [target for target in found if target.lat_deg is not None]
    assert len(moving) == 6
    for target in moving:
        assert target.lat_deg is not None and target.lon_deg is not None
        assert target.speed_mps == pytest.approx(3.0, abs=0.12) and target.mmsi == 230_000_123
        assert target.course_rad is not None and math.remainder(
            target.course_rad - math.radians(towards_deg), 2 * math.pi
        ) == pytest.approx(0.0, abs=0.07)
        assert target.heading_rad == pytest.approx(math.radians(towards_deg), abs=0.01) and target.status == (
            7 if class_a else None
        )
        there = vessel.at(target.t_s)
        assert frame.to_ned(target.lat_deg, target.lon_deg) == pytest.approx((there.north_m, there.east_m), abs=4.0)
    ship = [target for target in found if target.lat_deg is None]
    assert {target.name for target in ship if target.name} == {"NORA"} and {
        target.callsign for target in ship if target.callsign
    } == {"T123"}
    assert any((t.bow_m, t.stern_m, t.port_m, t.starboard_m) == (4.0, 4.0, 2.0, 1.0) for t in ship)


def test_a_script_needs_times_that_grow() -> None:
    with pytest.raises(ValueError, match="two points or more"):
        ScriptedVessel(1, "X", ((0.0, 0.0, 0.0), (0.0, 1.0, 1.0)))
