"""What a measurement's sigma is, by its receiver's claim and the vessel's file."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.config.devices import FixErrors, SensorConfig
from companion.core.readings import FixType, GnssFix, GroundVelocity
from companion.nav.accuracies import SensorAccuracies
from companion.nav.error_state import FilterNoise
from companion.nav.measured_off import Wander

ROWS = (
    SensorConfig("plain", "nmea0183", "memory:plain", velocity_accuracy_mps=0.2),
    SensorConfig("known", "nmea0183", "memory:known", accuracy_floor_m=0.5, position_wander_m=0.04),
    SensorConfig(
        "surveyed",
        "nmea0183",
        "memory:surveyed",
        position_noise_m=0.4,
        position_wander_m=1.5,
        position_wander_s=200.0,
        velocity_accuracy_mps=0.08,
        velocity_lasts_s=2.0,
        rtk_float=FixErrors(wander_m=0.2, velocity_mps=0.03),
        rtk_fixed=FixErrors(noise_m=0.006, wander_m=0.01, wander_s=40.0),
    ),
    SensorConfig(
        "imu",
        "vectornav",
        "memory:imu",
        rate_hz=100.0,
        accelerometer_noise_mps2_rthz=0.01,
        gyro_noise_radps_rthz=0.001,
    ),
)
OF = SensorAccuracies(ROWS)


def fix(source: str, kind: FixType, claimed_m: float | None) -> GnssFix:
    return GnssFix(0.0, source, 60.0, 22.0, None, kind, 12, 0.8, position_accuracy_m=claimed_m)


@pytest.mark.parametrize(
    ("source", "claimed_m", "sigma_m"),
    [("plain", 0.3, 0.3), ("plain", None, 3.0), ("known", 0.3, 0.5), ("known", 0.9, 0.9), ("stranger", 0.01, 0.01)],
)
def test_a_claim_counts_down_to_the_floor_of_the_file(source: str, claimed_m: float | None, sigma_m: float) -> None:
    assert OF.position_m(fix(source, FixType.FIX_3D, claimed_m)) == sigma_m


def test_fixes_without_carrier_phase_count_less_and_wander_more() -> None:
    plain, rtk = fix("plain", FixType.FIX_3D, 1.0), fix("plain", FixType.RTK_FIXED, 0.01)
    assert OF.fused_m(plain, 1.0) == 3.0 and OF.fused_m(rtk, 0.01) == 0.01
    assert OF.slow_m(plain, 1.0) == pytest.approx(0.7) and OF.slow_m(rtk, 0.01) == 0.008
    assert OF.slow_m(fix("known", FixType.FIX_3D, 1.0), 1.0) == 0.04


def test_noise_and_slow_error_of_a_fix() -> None:
    """The filter holds the slow error, so a fix counts by its noise; a float solution is not as good as a fixed one."""
    plain, floating = fix("plain", FixType.FIX_3D, 1.0), fix("plain", FixType.RTK_FLOAT, 0.2)
    fixed = fix("plain", FixType.RTK_FIXED, 0.01)
    assert OF.noise_m(plain, 1.0) == pytest.approx(0.3) and OF.noise_m(floating, 0.2) == pytest.approx(0.06)
    assert OF.noise_m(fixed, 0.01) == 0.01
    assert OF.noise_m(fix("known", FixType.FIX_3D, 1.0), 1.0) == 0.5
    assert OF.slow_m(floating, 0.2) == pytest.approx(0.14)
    assert OF.wander(plain, 0.7) == Wander(0.7, 300.0) and OF.wander(floating, 0.1) == Wander(0.1, 100.0)


def test_what_the_file_tells_of_one_kind_of_fix_says_nothing_of_the_others() -> None:
    """A receiver that loses its corrections has metres of slow error, whatever it had before."""
    plain, floating = fix("surveyed", FixType.DGPS, 1.0), fix("surveyed", FixType.RTK_FLOAT, 0.1)
    fixed = fix("surveyed", FixType.RTK_FIXED, 0.02)
    assert [OF.noise_m(one, 0.1) for one in (plain, floating, fixed)] == pytest.approx([0.4, 0.03, 0.006])
    assert [OF.slow_m(one, 0.1) for one in (plain, floating, fixed)] == [1.5, 0.2, 0.01]
    assert [OF.wander(one, 1.0).time_s for one in (plain, floating, fixed)] == [200.0, 100.0, 40.0]
    assert OF.slow_m(fix("known", FixType.RTK_FIXED, 0.01), 0.01) == 0.008, "only told of plain fixes"
    velocity = GroundVelocity(0.0, "surveyed", 1.0, 0.0)
    assert OF.velocity_mps(velocity, FixType.RTK_FLOAT) == 0.03
    assert OF.velocity_mps(velocity, FixType.RTK_FIXED) == pytest.approx(0.024)
    assert OF.velocity_mps(velocity, FixType.DGPS) == 0.04


def test_errors_of_velocities_that_last_make_a_random_walk() -> None:
    velocity = GroundVelocity(0.0, "plain", 1.0, 0.0)
    assert OF.walk_mps_rthz(velocity, None, 0.1) == pytest.approx(0.1)
    assert OF.walk_mps_rthz(velocity, FixType.RTK_FIXED, 0.1) == 0.0
    assert OF.walk_mps_rthz(GroundVelocity(0.0, "surveyed", 1.0, 0.0), None, 0.1) == pytest.approx(0.2)


def test_velocity_is_as_good_as_its_receivers_fix() -> None:
    velocity = GroundVelocity(0.0, "plain", 1.0, 0.0)
    assert OF.velocity_mps(velocity, None) == OF.velocity_mps(velocity, FixType.FIX_3D) == 0.2
    assert OF.velocity_mps(velocity, FixType.RTK_FIXED) == pytest.approx(0.06)


def test_noise_of_an_inertial_sensor_is_of_its_row() -> None:
    assert OF.imu("imu") == FilterNoise(0.01, 0.001) and OF.imu("stranger") == FilterNoise()


@pytest.mark.parametrize(("driver", "factor"), [("vectornav", 5.0**0.5), ("mavlink_imu", 5.0**0.5), ("mtdata2", 1.0)])
def test_newest_values_that_come_seldom_hold_the_noise_of_the_whole_band(driver: str, factor: float) -> None:
    """Without measurements the heading was off by more than it claimed; what an MTi integrates is less noisy."""
    row = replace(ROWS[-1], driver=driver, rate_hz=10.0)
    noise = SensorAccuracies((row,)).imu("imu")
    assert noise.accelerometer_mps2_rthz == pytest.approx(0.01 * factor)
    assert noise.gyro_radps_rthz == pytest.approx(0.001 * factor)


def test_biases_of_an_inertial_sensor_that_the_file_tells_are_those_at_switch_on_and_later() -> None:
    row = SensorConfig(
        "imu", "vectornav", "memory:imu", accelerometer_bias_mps2=0.02, gyro_bias_radps=5e-4, bias_s=1800.0
    )
    noise = SensorAccuracies((row,)).imu("imu")
    assert noise.accelerometer_switch_on_mps2 == noise.accelerometer_bias_mps2 == 0.02
    assert noise.gyro_switch_on_radps == noise.gyro_bias_radps == 5e-4
    assert noise.accelerometer_bias_time_s == noise.gyro_bias_time_s == 1800.0
