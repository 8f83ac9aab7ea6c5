"""What a calibration aboard does to readings, and to the estimate."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from companion.config.devices import SensorConfig
from companion.core.readings import Heading, Imu, MagneticField, Reading
from companion.nav.corrections import corrections_of, inertial_sensors, magnetometers
from companion.nav.still_calibration import StillMean, level_of
from companion.params.store import Parameters

IMU = SensorConfig(name="imu", driver="mtdata2", port="memory:imu", heading="ahrs", mag_offset=(0.1, 0.0, 0.0))
SECOND = SensorConfig(name="second", driver="vectornav", port="memory:second")
GNSS = SensorConfig(name="gnss", driver="nmea0183", port="memory:gnss")


def sample(
    t_s: float = 0.0, force: tuple[float, ...] = (0.0, 0.0, -9.81), rates: tuple[float, ...] = (0.0, 0.0, 0.0)
) -> Imu:
    return Imu(t_s, "imu", *force, *rates)


def test_sensors_are_numbered_by_the_file() -> None:
    rows = (GNSS, SECOND, IMU)
    assert [row.name for row in inertial_sensors(rows)] == ["second", "imu"]
    assert [row.name for row in magnetometers(rows)] == ["imu"]
    assert sorted(corrections_of(rows, Parameters())) == ["imu", "second"]


def test_without_a_calibration_a_sample_stays_as_it_is() -> None:
    corrections = corrections_of([IMU], Parameters())["imu"]
    imu = sample()
    assert corrections.imu(imu) is imu and not corrections.calibrated_aboard
    assert corrections.field(MagneticField(0.0, "imu", 0.3, 0.2, 0.9)) == pytest.approx((0.2, 0.2, 0.9))


def test_a_change_of_the_mounting_is_noticed() -> None:
    parameters = Parameters()
    corrections = corrections_of([IMU], parameters)["imu"]
    parameters.set("SENS_BOARD_X_OFF", 2.0)
    assert corrections.version == 1 and corrections.imu(sample()) == sample()


def test_a_sensor_that_is_mounted_on_its_side_is_not_levelled() -> None:
    with pytest.raises(ValueError, match="mounted 90 deg off level"):
        level_of((0.0, -9.81, 0.0))


def test_a_gyro_bias_is_taken_off() -> None:
    parameters = Parameters()
    corrections = corrections_of([IMU], parameters)["imu"]
    parameters.set("CAL_GYRO0_ZOFF", 0.01)
    parameters.set("CAL_GYRO1_ZOFF", 0.05)  # another sensor's
    assert corrections.version == 1
    assert corrections.imu(sample(rates=(0.0, 0.0, 0.03))).yaw_rate_radps == pytest.approx(0.02)


def test_iron_by_parameters_counts_before_the_file() -> None:
    parameters = Parameters()
    corrections = corrections_of([IMU], parameters)["imu"]
    for axis in "XYZ":
        parameters.set(f"CAL_MAG0_{axis}OFF", 2.0)
        assert not corrections.calibrated_aboard
    for axis in "XYZ":
        parameters.set(f"CAL_MAG0_{axis}SCALE", 0.5)
    parameters.set("CAL_MAG0_XODIAG", 0.1)
    parameters.set("CAL_MAG0_WANDER", 3.0)
    assert corrections.calibrated_aboard and corrections.wander_rad == pytest.approx(math.radians(3.0))
    assert corrections.field(MagneticField(0.0, "imu", 4.0, 3.0, 2.0)) == pytest.approx((1.1, 0.7, 0.0))
    parameters.reset()
    assert not corrections.calibrated_aboard and corrections.wander_rad is None


def still(swing_radps: float, now_s: float = 6.0, drift_radps: float = 0.01) -> StillMean:
    mean = StillMean("imu", 5.0, math.radians(0.5), 0.0)
    for k in range(round(now_s / 0.1)):
        rates = (swing_radps * (-1) ** k, 0.0, drift_radps)
        mean.update([sample(0.1 * k + 0.01 * i, rates=rates) for i in range(10)], 0.1 * k)
    return mean


def test_means_of_a_boat_that_lies_still() -> None:
    mean = still(0.002)
    assert mean.complete and mean.failure is None
    assert mean.rates == pytest.approx((0.0, 0.0, 0.01), abs=1e-4)
    assert level_of(mean.force) == pytest.approx((0.0, 0.0))
    assert still(0.002, 2.5).progress == pytest.approx(0.48)


def test_a_boat_that_rocks_is_not_still() -> None:
    assert still(0.02).failure == "the boat moves" and not still(0.02).complete


def test_a_boat_that_turns_has_no_bias() -> None:
    assert still(0.0, drift_radps=0.2).failure == "the boat moves"


def turning(rate_radps: float, told: Callable[[float, float], Reading], turn_rad: float = 0.026) -> StillMean:
    """A boat that turns steadily, as its gyro and something else tell it: `told(t_s, yaw_rad)`."""
    mean = StillMean("imu", 5.0, math.radians(0.5), 0.0, turn_rad)
    for k in range(60):
        rates = (0.0, 0.0, rate_radps)
        gyro: list[Reading] = [sample(0.1 * k + 0.01 * i, rates=rates) for i in range(10)]
        mean.update([*gyro, told(0.1 * k, 3.1 + 0.1 * k * rate_radps)], 0.1 * k)
    return mean


def by_antennas(t_s: float, yaw_rad: float) -> Reading:
    return Heading(t_s, "gnss", yaw_rad)


def by_field(t_s: float, yaw_rad: float) -> Reading:
    """North of the Baltic, dip 71 degrees, with iron."""
    return MagneticField(t_s, "imu", 16.0 * math.cos(yaw_rad) + 5.0, -16.0 * math.sin(yaw_rad) - 4.0, 47.0)


@pytest.mark.parametrize("told", [by_antennas, by_field])
def test_a_steady_turn_is_no_bias(told: Callable[[float, float], Reading]) -> None:
    """A moored boat that swung by 4 deg/s had that for its gyro's bias, and its heading was off by up to 27 deg."""
    assert turning(math.radians(1.0), told).failure == "the boat moves"
    assert turning(0.0, told).complete
    assert turning(math.radians(1.0), told, math.inf).complete, "the level may turn"


def test_a_silent_sensor_is_named() -> None:
    mean = StillMean("imu", 5.0, 0.01, 0.0)
    for k in range(40):
        mean.update([], 0.1 * k)
    assert mean.failure == "imu is silent"
