"""Each emulated device with the driver that reads it: two pieces of code that know the same protocol apart from each
other."""

from __future__ import annotations

import math
import statistics
from dataclasses import replace
from typing import TypeVar

import pytest

from companion.config.devices import SensorConfig
from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import ActuatorCommand, Beacon, Deployment, Light, ThrusterCommand, ThrusterFeedback
from companion.core.geodesy import LocalFrame
from companion.core.ports import Actuator, Sensor
from companion.core.readings import (
    Battery,
    Corrections,
    Depth,
    FixType,
    GnssFix,
    GroundVelocity,
    Heading,
    HeadingBy,
    Imu,
    Leak,
    MagneticField,
    Reading,
    TimeOfDay,
    Wind,
)
from companion.io.actuators import open_actuator
from companion.io.sensors import open_sensor
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions

T = TypeVar("T")
REVOLT = load(find("revolt"))
GNSS, IMU = REVOLT.sensors
FORWARD = (ThrusterCommand(6.75, 0.5, 0.2), ThrusterCommand(6.75, 0.5, -0.2), ThrusterCommand(0.0, 0.3, None))


class Boat:
    """A world and the drivers of its devices; no controller."""

    def __init__(self, vessel: VesselConfig = REVOLT, **arguments: object) -> None:
        self.world = World(vessel, WorldConditions(**arguments))  # type: ignore[arg-type]
        self.sensors: list[Sensor] = [
            open_sensor(config, self.world.open(config.name, config.port)) for config in vessel.sensors
        ]
        self.bridges: list[Actuator] = [
            open_actuator(config, vessel, self.world.open(config.name, config.port)) for config in vessel.actuators
        ]
        self.now_s = 0.0

    def sail(self, seconds: float, armed: bool = True) -> list[Reading]:
        readings: list[Reading] = []
        for _ in range(round(seconds * 10)):
            self.now_s = round(self.now_s + 0.1, 6)
            self.world.advance(self.now_s)
            for device in (*self.sensors, *self.bridges):
                readings += device.read(self.now_s)
            for bridge in self.bridges:
                bridge.write(ActuatorCommand(self.now_s, armed, FORWARD), self.now_s)
        return readings

    def ok(self) -> dict[str, bool]:
        return {device.name: device.health(self.now_s).ok for device in (*self.sensors, *self.bridges)}


def last(readings: list[Reading], kind: type[T]) -> T:
    return [reading for reading in readings if isinstance(reading, kind)][-1]


def vessel(*sensors: SensorConfig, yaw_deg: float = 0.0) -> VesselConfig:
    return replace(REVOLT, sensors=sensors or REVOLT.sensors, home=replace(REVOLT.home, yaw_rad=math.radians(yaw_deg)))


def test_what_the_drivers_read_is_what_the_boat_does() -> None:
    boat = Boat(vessel(yaw_deg=120.0))
    readings = boat.sail(20.0)
    truth = boat.world.truth
    frame = LocalFrame(REVOLT.home.lat_deg, REVOLT.home.lon_deg)
    fix = last(readings, GnssFix)
    assert fix.fix is FixType.RTK_FIXED and fix.t_s == pytest.approx(20.0)
    north, east = frame.to_ned(fix.lat_deg, fix.lon_deg)
    c, s = math.cos(truth.yaw_rad), math.sin(truth.yaw_rad)
    assert (north, east) == pytest.approx((truth.north_m - 0.81 * c, truth.east_m - 0.81 * s), abs=0.05)
    velocity = last(readings, GroundVelocity)
    assert c * velocity.north_mps + s * velocity.east_mps == pytest.approx(truth.surge_mps, abs=0.06)
    assert last(readings, Heading).yaw_rad == pytest.approx(truth.yaw_rad, abs=math.radians(0.8))
    assert last(readings, TimeOfDay).time_unix_ns == pytest.approx(EPOCH_UNIX_NS + 20 * 10**9, abs=1e6)
    imu = last(readings, Imu)
    assert imu.z_mps2 == pytest.approx(-9.82, abs=0.1)
    assert imu.yaw_rate_radps == pytest.approx(truth.yaw_rate_radps, abs=math.radians(0.4))
    assert imu.yaw_rad == pytest.approx(truth.yaw_rad, abs=math.radians(4.0))
    assert imu.t_s == pytest.approx(20.0)
    feedback = {reading.index: reading for reading in readings if isinstance(reading, ThrusterFeedback)}
    assert {index: reading.throttle for index, reading in feedback.items()} == pytest.approx(
        {0: 0.5, 1: 0.5, 2: 0.3}, abs=1e-3
    )
    assert [feedback[index].azimuth_rad for index in (0, 1)] == pytest.approx([0.2, -0.2], abs=1e-4)
    assert last(readings, Battery).remaining == pytest.approx(truth.battery_remaining, abs=0.005)
    assert not last(readings, Leak).wet
    assert all(boat.ok().values())


def test_a_baseline_mounted_askew_is_put_right() -> None:
    boat = Boat(vessel(replace(GNSS, heading_offset_rad=math.radians(90.0)), IMU, yaw_deg=30.0))
    assert last(boat.sail(1.0, armed=False), Heading).yaw_rad == pytest.approx(
        math.radians(30.0), abs=math.radians(1.0)
    )


def test_latency_is_taken_out_of_the_time_of_validity() -> None:
    boat = Boat(vessel(replace(GNSS, latency_s=0.06), IMU))
    readings = boat.sail(1.0)
    times = [reading.t_s for reading in readings if isinstance(reading, GnssFix)]
    assert times[-1] == pytest.approx(0.9) and times[0] == pytest.approx(0.05)


def test_wind_sensor_gives_apparent_wind() -> None:
    boat = Boat(
        vessel(*REVOLT.sensors, replace(GNSS, name="wind", x_m=0.0, z_m=0.0, rate_hz=4.0), yaw_deg=90.0), wind="8@180"
    )
    readings = [reading for reading in boat.sail(20.0, armed=False) if isinstance(reading, Wind)]
    assert statistics.fmean(reading.speed_mps for reading in readings) == pytest.approx(8.0, abs=2.5)
    assert all(
        0.0 < reading.from_rad < math.pi for reading in readings
    )  # bow east, wind from the south: from starboard


@pytest.mark.parametrize("device", ["compass", "imu"])
def test_a_compass_gives_magnetic_heading(device: str) -> None:
    """Trondheim has magnetic north 5.2° to the east in 2026."""
    imu = replace(IMU, heading="magnetic" if device == "imu" else "none")
    compass = replace(GNSS, name="compass", x_m=0.0, z_m=0.0, rate_hz=10.0)
    boat = Boat(vessel(GNSS, imu, *([compass] if device == "compass" else []), yaw_deg=100.0))
    readings = [
        reading for reading in boat.sail(20.0, armed=False) if isinstance(reading, Heading) and reading.source == device
    ]
    assert len(readings) == pytest.approx(200, abs=2) and {reading.by for reading in readings} == {HeadingBy.MAGNETIC}
    mean = statistics.fmean(reading.yaw_rad for reading in readings)
    assert math.degrees(mean) == pytest.approx(100.0 - 5.2, abs=4.0)


def test_a_magnetometer_gives_the_field_of_the_place() -> None:
    """What its file's calibration makes of it is the World Magnetic Model's direction, within what a calibration
    leaves."""
    matrix = ((1.1, 0.05, 0.0), (0.05, 0.9, -0.03), (0.0, -0.03, 1.0))
    row = replace(IMU, heading="ahrs", mag_offset=(0.2, -0.1, 0.3), mag_matrix=matrix)
    boat = Boat(vessel(GNSS, row, yaw_deg=100.0))
    readings = boat.sail(10.0, armed=False)
    fields = [reading for reading in readings if isinstance(reading, MagneticField)]
    assert len(fields) == pytest.approx(500, abs=3) and not any(
        isinstance(r, Heading) and r.source == "imu" for r in readings
    )
    raw = [
        statistics.fmean(getattr(field, axis) for field in fields) - offset
        for axis, offset in zip("xyz", row.mag_offset, strict=True)
    ]
    x, y, z = (sum(a * b for a, b in zip(line, raw, strict=True)) for line in matrix)
    assert math.hypot(x, y, z) == pytest.approx(1.0, abs=0.02)
    assert math.degrees(math.atan2(-y, x)) == pytest.approx(100.0 - 5.2, abs=2.5)
    assert math.degrees(math.atan2(z, math.hypot(x, y))) == pytest.approx(74.9, abs=1.0)  # the dip at Trondheim


@pytest.mark.parametrize(
    ("fault", "device"),
    [
        ("imu_lost", "imu"),
        ("imu_unplugged", "imu"),
        ("gnss_unplugged", "gnss"),
        ("mcu_silent", "microcontroller"),
        ("mcu_deaf", "microcontroller"),
        ("microcontroller_unplugged", "microcontroller"),
    ],
)
def test_a_fault_shows_in_the_health_of_its_device_and_goes(fault: str, device: str) -> None:
    boat = Boat(faults=[f"{fault}@2+4"])
    boat.sail(1.9)
    assert all(boat.ok().values())
    boat.sail(4.0)
    assert [name for name, ok in boat.ok().items() if not ok] == [device]
    boat.sail(1.9)
    assert all(boat.ok().values())


def test_a_dead_thruster_is_reported_by_a_board_that_is_well() -> None:
    boat = Boat(faults=["thruster_bow_dead@1+2"])
    dead = [reading for reading in boat.sail(2.0) if isinstance(reading, ThrusterFeedback) and reading.index == 2][-1]
    assert not dead.ok and all(boat.ok().values())
    back = [reading for reading in boat.sail(2.0) if isinstance(reading, ThrusterFeedback) and reading.index == 2][-1]
    assert back.ok


def test_without_a_fix_the_receiver_is_well_and_says_so() -> None:
    boat = Boat(faults=["gnss_lost@1"])
    boat.sail(1.0)
    readings = boat.sail(1.0)
    assert last(readings, GnssFix).fix is FixType.NONE
    assert not any(isinstance(reading, Heading) for reading in readings)


def test_leak_and_low_battery_arrive() -> None:
    readings = Boat(faults=["leak@1", "battery_low@1"]).sail(2.0)
    assert last(readings, Leak).wet
    assert last(readings, Battery).remaining == pytest.approx(0.08, abs=0.005)


@pytest.mark.parametrize("bridge", [bridge.name for bridge in REVOLT.actuators])
def test_a_bridge_carries_retraction_and_beacon_both_ways(bridge: str) -> None:
    """What stands in a command comes out at the device, and where the thruster stands comes back."""
    boat = Boat()
    (driver,), (board,) = (
        [d for d in boat.bridges if d.name == bridge],
        [b for b in boat.world.boards if b.name == bridge],
    )
    lamps = Beacon(Light.OFF, Light.STEADY, Light.BLINK)
    seen: list[Deployment | None] = []
    for lower in (None, False, True):
        for _ in range(70):
            boat.now_s = round(boat.now_s + 0.1, 6)
            boat.world.advance(boat.now_s)
            for reading in driver.read(boat.now_s):
                if (
                    isinstance(reading, ThrusterFeedback)
                    and reading.index == 2
                    and (not seen or seen[-1] is not reading.deployment)
                ):
                    seen.append(reading.deployment)
            driver.write(ActuatorCommand(boat.now_s, False, FORWARD, lower=lower, beacon=lamps), boat.now_s)
    assert board.beacon == lamps
    assert seen == [Deployment.LOWERED, Deployment.MOVING, Deployment.RETRACTED, Deployment.MOVING, Deployment.LOWERED]


def test_a_single_antenna_gives_place_speed_and_time_and_no_heading() -> None:
    boat = Boat(load(find("aboat")))
    boat.world.set_state(surge_mps=1.2, yaw_rad=math.radians(60.0))
    readings = [reading for reading in boat.sail(2.0, armed=False) if getattr(reading, "source", "") == "gnss"]
    fix, truth = last(readings, GnssFix), boat.world.truth
    north, east = LocalFrame(60.41, 22.07).to_ned(fix.lat_deg, fix.lon_deg)
    assert fix.fix is FixType.DGPS and (north, east) == pytest.approx((truth.north_m, truth.east_m), abs=1.5)
    velocity = last(readings, GroundVelocity)
    assert math.hypot(velocity.north_mps, velocity.east_mps) == pytest.approx(
        math.hypot(truth.surge_mps, truth.sway_mps), abs=0.15
    )
    assert last(readings, TimeOfDay).time_unix_ns == pytest.approx(EPOCH_UNIX_NS + 2 * 10**9, abs=2e8)
    assert not any(isinstance(reading, Heading) for reading in readings)


def test_a_sounder_gives_depth() -> None:
    boat = Boat(
        vessel(GNSS, IMU, SensorConfig(name="sounder", driver="nmea0183", port="memory:sounder", rate_hz=5.0, z_m=0.2))
    )
    depths = [reading for reading in boat.sail(10.0, armed=False) if isinstance(reading, Depth)]
    assert len(depths) == pytest.approx(50, abs=1) and depths[0].source == "sounder" and depths[0].offset_m == 0.2
    assert statistics.fmean(depth.below_transducer_m for depth in depths) == pytest.approx(5.8, abs=0.02)


def test_a_receiver_tells_of_its_corrections() -> None:
    ages = [reading for reading in Boat().sail(10.0, armed=False) if isinstance(reading, Corrections)]
    assert len(ages) == pytest.approx(10, abs=1) and ages[0] == Corrections(ages[0].t_s, "gnss", 1.0, 1)
    assert not any(isinstance(reading, Corrections) for reading in Boat(gnss="standalone").sail(3.0, armed=False))


def test_a_vessel_brings_its_own_receiver_and_battery() -> None:
    aboat = load(find("aboat"))
    assert aboat.sitl is not None and (aboat.sitl.gnss, aboat.sitl.battery_wh) == ("sbas", 960.0)
    by_default, asked = Boat(aboat), Boat(aboat, gnss="rtk")
    fixes = [last(boat.sail(1.0, armed=False), GnssFix).fix for boat in (by_default, asked)]
    assert fixes == [FixType.DGPS, FixType.RTK_FIXED]
