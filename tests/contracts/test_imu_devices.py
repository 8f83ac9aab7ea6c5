"""Every inertial sensor of the tables with the device that it reads: rates, gravity, attitude, heading, field, loss and
return."""

from __future__ import annotations

import math
import statistics
from dataclasses import replace
from typing import Any

import pytest

from companion.config.vessel import find, load
from companion.core.readings import Heading, Imu, MagneticField, Reading
from companion.io.sensors import open_sensor
from sitl.world import World, WorldConditions

REVOLT = load(find("revolt"))
GNSS, IMU = REVOLT.sensors
DRIVERS = ("mtdata2", "vectornav", "mavlink_imu")


class Bench:
    def __init__(self, driver: str, faults: tuple[str, ...] = (), **more: Any) -> None:
        row = replace(IMU, driver=driver, rate_hz=50.0, **more)
        self.world = World(replace(REVOLT, sensors=(GNSS, row)), WorldConditions(seed=2, faults=faults))
        self.world.set_state(yaw_rad=math.radians(100.0))
        self.sensor = open_sensor(row, self.world.open("imu", ""))
        self.steps = 0

    def run(self, seconds: float) -> list[Reading]:
        readings: list[Reading] = []
        for _ in range(round(20 * seconds)):
            self.steps += 1
            self.world.advance(0.05 * self.steps)
            readings += self.sensor.read(0.05 * self.steps)
        return readings

    def health(self) -> Any:
        return self.sensor.health(0.05 * self.steps)


@pytest.mark.parametrize("configure", [False, True])
@pytest.mark.parametrize("driver", DRIVERS)
def test_it_measures_gravity_and_heading_at_its_rate(driver: str, configure: bool) -> None:
    bench = Bench(driver, heading="magnetic", configure=configure)
    bench.run(2.0)
    readings = bench.run(10.0)
    imus = [reading for reading in readings if isinstance(reading, Imu)]
    headings = [reading for reading in readings if isinstance(reading, Heading)]
    assert bench.health().ok, bench.health().text
    assert len(imus) == pytest.approx(500, abs=10) and len(headings) == pytest.approx(100, abs=2)
    assert statistics.fmean(imu.z_mps2 for imu in imus) == pytest.approx(-9.82, abs=0.1)
    assert all(imu.roll_rad is not None for imu in imus)
    declination = 5.2  # at Trondheim, 2026
    assert math.degrees(statistics.fmean(heading.yaw_rad for heading in headings)) == pytest.approx(
        100.0 - declination, abs=4.0
    )
    assert "50 Hz" in bench.health().text or " 50, " in bench.health().text or "50.2" in bench.health().text, (
        bench.health().text
    )


@pytest.mark.parametrize("driver", DRIVERS)
def test_its_field_for_an_ahrs_of_our_own(driver: str) -> None:
    fields = [reading for reading in Bench(driver, heading="ahrs").run(10.0) if isinstance(reading, MagneticField)]
    assert len(fields) > 400
    x, y, z = (statistics.fmean(getattr(field, axis) for field in fields) for axis in "xyz")
    assert math.degrees(math.atan2(-y, x)) == pytest.approx(100.0 - 5.2, abs=2.5)
    assert math.degrees(math.atan2(z, math.hypot(x, y))) == pytest.approx(74.9, abs=1.5)


@pytest.mark.parametrize("fault", ["imu_lost", "imu_unplugged"])
@pytest.mark.parametrize("driver", DRIVERS)
def test_a_loss_is_seen_within_a_second_and_so_is_the_return(driver: str, fault: str) -> None:
    bench = Bench(driver, (f"{fault}@5+8",), configure=True)
    bench.run(4.9)
    assert bench.health().ok
    bench.run(1.1)
    assert not bench.health().ok
    bench.run(6.8)
    assert not bench.health().ok
    bench.run(8.0)
    assert bench.health().ok, bench.health().text
    assert len([reading for reading in bench.run(2.0) if isinstance(reading, Imu)]) == pytest.approx(100, abs=5)
