"""Errors of sensors by how they are made and where they stand, against what the formulae say."""

from __future__ import annotations

import cmath
import math
import statistics
from dataclasses import replace

import pytest

from companion.config.devices import SensorConfig
from companion.config.sensor_errors import SensorErrorConfig
from companion.config.vessel import find, load
from companion.core.angles import wrap_pi
from companion.core.geomagnetism import decimal_year, field_nt
from sitl.battery import BatteryModel
from sitl.magnetometer import MagnetometerModel
from sitl.sensor_errors import Aboard, CurrentField, ImuErrors, Sample, current_field, distorted_wind
from sitl.sensors import CompassModel
from sitl.thrusters import build
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions

REVOLT = load(find("revolt"))
HOME = REVOLT.home
NONE = SensorErrorConfig(0.0, 0.0, 0.0, 30.0, 0.0, 0.0, 0.0)
STILL: Sample = (0.0, 0.0, -9.8, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
HZ = 100.0


def aboard(errors: SensorErrorConfig, throttle: float = 0.0, power_w: float = 0.0) -> Aboard:
    thrusters = build([replace(REVOLT.thrusters[0], max_n=27.0)], 0.0, None)
    thrusters[0].demand(throttle, 0.0)
    thrusters[0].step(0.01)
    battery = BatteryModel(900.0)
    battery.step(power_w, 0.1)
    return Aboard(errors, thrusters, battery)


def imu(around: Aboard, seed: int = 1, field: CurrentField | None = None) -> ImuErrors:
    return ImuErrors(around, field, 0.0, "imu", 1.0 / HZ, seed)


def test_without_errors_the_sample_is_what_was_measured() -> None:
    sample = (0.1, 0.2, -9.8, 0.01, 0.02, 0.3, 0.04, 0.05, 0.6)
    assert imu(aboard(NONE, 0.8)).told(sample, 0.6) == pytest.approx(sample)


def test_scale_factors_have_their_sigma_and_stay() -> None:
    around, sample = aboard(replace(NONE, imu_scale=0.01)), (1.0, 2.0, -9.8, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0)
    scales = []
    for seed in range(200):
        model = imu(around, seed)
        told = model.told(sample, 0.0)
        assert model.told(sample, 0.0) == told
        scales += [told[i] / sample[i] - 1.0 for i in range(6)]
    assert statistics.pstdev(scales) == pytest.approx(0.01, rel=0.1)
    assert statistics.fmean(scales) == pytest.approx(0.0, abs=0.001)


def test_askew_axes_feel_gravity_and_the_attitude_agrees_with_the_accelerometers() -> None:
    around = aboard(replace(NONE, imu_misalignment_rad=math.radians(1.0)))
    for seed in range(20):
        x, y, z, *_, roll, pitch, _ = imu(around, seed).told(STILL, 0.0)
        assert math.atan2(-y, -z) == pytest.approx(roll, abs=1e-3)
        assert math.atan2(x, -z) == pytest.approx(pitch, abs=1e-3)
    crossed = [imu(around, seed).told((0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), 0.0)[3] for seed in range(200)]
    assert statistics.pstdev(crossed) == pytest.approx(math.radians(1.0), rel=0.15)


def shaken(throttle: float, full_rps: float, count: int = 1000) -> list[Sample]:
    model = imu(aboard(replace(NONE, vibration_mps=0.002, full_rps=full_rps), throttle))
    return [model.told(STILL, 0.0) for _ in range(count)]


def strength(samples: list[Sample], hz: float) -> float:
    """Amplitude of the three accelerations together at a frequency."""
    parts = []
    for axis in range(3):
        mean = statistics.fmean(sample[axis] for sample in samples)
        turned = ((s[axis] - mean) * cmath.exp(-2j * math.pi * hz * k / HZ) for k, s in enumerate(samples))
        parts.append(2.0 * abs(sum(turned)) / len(samples))
    return math.hypot(*parts)


def test_vibration_has_the_velocity_that_was_asked_at_full_revolutions() -> None:
    """a = 2π f v; the RMS of a velocity is its amplitude over √2."""
    assert strength(shaken(1.0, 10.0), 10.0) == pytest.approx(2.0 * math.pi * 10.0 * 0.002 * math.sqrt(2.0), rel=0.02)


def test_vibration_grows_with_the_square_of_the_revolutions_and_follows_their_frequency() -> None:
    assert strength(shaken(0.5, 10.0), 5.0) == pytest.approx(0.25 * strength(shaken(1.0, 10.0), 10.0), rel=0.02)
    assert strength(shaken(0.5, 10.0), 10.0) < 0.02 * strength(shaken(0.5, 10.0), 5.0)


def test_above_half_of_the_sampling_rate_it_shows_as_a_slower_one() -> None:
    """65 1/s sampled at 100 Hz: 35 Hz; the blades' 195 Hz: 5 Hz."""
    samples = shaken(1.0, 65.0)
    assert strength(samples, 35.0) == pytest.approx(2.0 * math.pi * 65.0 * 0.002 * math.sqrt(2.0), rel=0.02)
    assert strength(samples, 5.0) == pytest.approx(strength(samples, 35.0), rel=0.02)
    gyro = [math.hypot(*sample[3:6]) for sample in samples]
    assert max(gyro) > 0.002


def test_a_propeller_that_stands_shakes_nothing() -> None:
    assert shaken(0.0, 30.0, 20) == [STILL] * 20


def test_the_field_of_the_current_turns_the_compass_as_its_part_across_does() -> None:
    """Largest where the field stands across the heading: asin of its horizontal part over the Earth's."""
    around = aboard(replace(NONE, compass_nt_per_a=100.0), power_w=256.0)
    field = CurrentField(around, "compass", HOME, EPOCH_UNIX_NS, 3)
    north, east, down = field_nt(HOME.lat_deg, HOME.lon_deg, decimal_year(EPOCH_UNIX_NS))
    x, y, z = (share * math.hypot(north, east, down) for share in field.share)
    assert math.hypot(x, y, z) == pytest.approx(100.0 * around.battery.current_a)
    found = [field.deviation_rad(math.radians(degree)) for degree in range(360)]
    assert max(found) == pytest.approx(math.asin(math.hypot(x, y) / math.hypot(north, east)), rel=1e-3)
    heading = 0.7
    body = math.hypot(north, east) * math.cos(heading) + x, -math.hypot(north, east) * math.sin(heading) + y
    assert field.deviation_rad(heading) == pytest.approx(wrap_pi(math.atan2(-body[1], body[0]) - heading))


def test_no_current_no_deviation() -> None:
    around = aboard(replace(NONE, compass_nt_per_a=100.0))
    assert CurrentField(around, "compass", HOME, EPOCH_UNIX_NS, 3).deviation_rad(1.0) == 0.0
    assert current_field(aboard(NONE), "compass", HOME, EPOCH_UNIX_NS, 3) is None
    assert current_field(None, "compass", HOME, EPOCH_UNIX_NS, 3) is None


def test_compass_magnetometer_and_attitude_filter_agree_on_the_deviation() -> None:
    around, yaw = aboard(replace(NONE, compass_nt_per_a=100.0), power_w=256.0), 2.5
    config = SensorConfig("compass", "nmea0183", "memory:", rate_hz=10.0)
    field = CurrentField(around, "compass", HOME, EPOCH_UNIX_NS, 3)
    simple, still = (CompassModel(config, HOME, EPOCH_UNIX_NS, 0.1, 3, of) for of in (field, None))
    north_rad = math.atan2(*reversed(field_nt(HOME.lat_deg, HOME.lon_deg, decimal_year(EPOCH_UNIX_NS))[:2]))
    wanted = field.deviation_rad(yaw - north_rad)
    assert abs(wanted) > math.radians(1.0)
    assert wrap_pi(simple.sample(yaw) - still.sample(yaw)) == pytest.approx(wanted)

    def shown(of: Aboard | None) -> float:
        model = MagnetometerModel(config, HOME, EPOCH_UNIX_NS, 3, of)
        samples = [model.sample(0.0, 0.0, yaw) for _ in range(400)]
        return math.atan2(-sum(s[1] for s in samples), sum(s[0] for s in samples))

    assert wrap_pi(shown(around) - shown(None)) == pytest.approx(wanted, abs=math.radians(0.3))
    filtered = ImuErrors(around, field, north_rad, "compass", 1.0 / HZ, 3)
    first = filtered.told(STILL, yaw)[8]
    for _ in range(6000):
        last = filtered.told(STILL, yaw)[8]
    assert abs(first) < 0.01 * abs(wanted) and last == pytest.approx(wanted, rel=0.01)


def test_wind_rises_over_the_side_and_is_lost_behind_the_mast() -> None:
    errors = replace(NONE, wind_upwash=0.1, wind_shadow=0.3, shadow_from_rad=math.pi)
    assert distorted_wind(errors, 5.0, 0.0) == pytest.approx((5.0, 0.0))
    assert distorted_wind(errors, 5.0, 0.5 * math.pi) == pytest.approx((5.5, 0.5 * math.pi))
    assert distorted_wind(errors, 5.0, math.pi)[0] == pytest.approx(3.5)
    speed, angle = distorted_wind(errors, 5.0, math.radians(45.0))
    assert 5.0 < speed < 5.5 and math.radians(47.0) < angle < math.radians(49.0)
    assert distorted_wind(NONE, 5.0, 2.0) == (5.0, 2.0)


def test_a_plant_with_sensor_errors_tells_them() -> None:
    """The same boat, the same seed: its inertial sensor and its wind sensor show other values."""
    aboat = load(find("aboat"))
    assert aboat.sitl is not None
    plant = replace(aboat.sitl.plants[aboat.sitl.plant], sensor_errors=SensorErrorConfig())
    wrong = replace(aboat, sitl=replace(aboat.sitl, plants={**aboat.sitl.plants, aboat.sitl.plant: plant}))
    said = {}
    for name, boat in (("right", aboat), ("wrong", wrong)):
        world = World(boat, WorldConditions(wind="5@90"))
        ports = {sensor: world.open(sensor, "") for sensor in ("imu", "wind")}
        world.advance(1.0)
        said[name] = {sensor: port.read(1.0) for sensor, port in ports.items()}
    assert said["right"]["imu"] != said["wrong"]["imu"] and said["right"]["wind"] != said["wrong"]["wind"]
