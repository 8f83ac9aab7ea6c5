"""The simulated lidar and radar through the drivers that read them: what they say is where it is."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.devices import SensorConfig
from companion.config.vessel import find, load
from companion.core.readings import RadarTarget, Ranges
from companion.io.sensors import open_sensor
from sitl.obstacles import RoundObstacle, Wall
from sitl.world import World, WorldConditions

OTTER = load(find("otter"))


def heard(row: SensorConfig, *things: RoundObstacle | Wall) -> list[object]:
    world = World(replace(OTTER, sensors=(*OTTER.sensors, row)), WorldConditions(seed=3))
    world.obstacles.round += [thing for thing in things if isinstance(thing, RoundObstacle)]
    world.obstacles.walls += [thing for thing in things if isinstance(thing, Wall)]
    sensor = open_sensor(row, world.open(row.name, row.port))
    world.advance(2.0)
    return list(sensor.read(2.0))


def test_the_lidar_sees_things_and_quays() -> None:
    row = SensorConfig(name="lidar", driver="mavlink_range", port="memory:lidar", rate_hz=5.0)
    scans = [
        one
        for one in heard(row, RoundObstacle(12.0, 0.0, 2.0), Wall((-30.0, 20.0), (30.0, 20.0)))
        if isinstance(one, Ranges)
    ]
    assert len(scans) >= 9
    ahead, beside = ([scan.distances_m[i] for scan in scans if scan.distances_m[i] < 40.0] for i in (0, 18))
    assert min(ahead) == pytest.approx(10.0, abs=0.3) and min(beside) == pytest.approx(20.0, abs=0.3)
    assert sum(math.isinf(scan.distances_m[54]) for scan in scans) >= len(scans) - 1, "nothing to port"


def test_the_radar_reports_a_target_and_its_motion() -> None:
    row = SensorConfig(name="radar", driver="nmea0183", port="memory:radar", rate_hz=2.0)
    found = [one for one in heard(row, RoundObstacle(300.0, 0.0, 3.0, 0.0, 2.0)) if isinstance(one, RadarTarget)]
    assert found
    target = found[-1]
    assert target.distance_m == pytest.approx(300.0, abs=6.0) and target.speed_mps == pytest.approx(2.0, abs=0.05)
    assert target.course_rad == pytest.approx(0.5 * math.pi, abs=0.01)
