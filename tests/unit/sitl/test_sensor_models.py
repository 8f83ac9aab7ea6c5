"""Sensor models: lever arms, gravity, noise of the size that is promised."""

from __future__ import annotations

import math
import statistics
from dataclasses import replace
from itertools import pairwise
from typing import get_args

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from companion.config.vessel import ConfigError, GnssGrade, find, load
from companion.core.geodesy import LocalFrame
from sitl.environment import Waves, WindModel
from sitl.hull import Hull
from sitl.sensors import GRADES, YAW_RAD, YAW_TAU_S, GnssModel, ImuModel, StrapdownMean, grade, gravity_mps2

VESSEL = load(find("revolt"))
GNSS, IMU = VESSEL.sensors
HOME = VESSEL.home
FRAME = LocalFrame(HOME.lat_deg, HOME.lon_deg)
assert VESSEL.sitl is not None
PLANT = VESSEL.sitl.plants["as_sailed"]
NONE: frozenset[str] = frozenset()


def calm() -> Waves:
    return Waves(WindModel(0.0, 0.0, 0), 0)


def placed(yaw_rad: float = 0.0, *velocity: float) -> Hull:
    hull = Hull(PLANT.hull)
    hull.place(10.0, -20.0, yaw_rad, *velocity)
    return hull


def test_gravity_of_the_latitude() -> None:
    assert gravity_mps2(0.0) == pytest.approx(9.7803253359, abs=1e-9)
    assert gravity_mps2(90.0) == pytest.approx(9.8321849379, abs=1e-6)
    assert gravity_mps2(45.0) == pytest.approx(9.80620, abs=1e-4)


def test_unknown_grade_names_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="rtk, sbas, standalone"):
        grade("cold")


def test_a_file_can_ask_for_every_grade() -> None:
    assert set(get_args(GnssGrade)) == set(GRADES)


def test_position_is_the_antennas() -> None:
    model = GnssModel(replace(GNSS, x_m=-0.81, y_m=0.3), HOME, "rtk", 0.05, 1)
    hull = placed(math.pi / 2)
    fixes = [model.sample(hull, calm(), NONE).position for _ in range(20_000)]
    places = [FRAME.to_ned(fix[0], fix[1]) for fix in fixes if fix is not None]
    assert statistics.fmean(north for north, _ in places) == pytest.approx(10.0 - 0.3, abs=0.005)
    assert statistics.fmean(east for _, east in places) == pytest.approx(-20.0 - 0.81, abs=0.005)
    assert statistics.fmean(fix[2] for fix in fixes if fix is not None) == pytest.approx(0.2, abs=0.01)


def test_roll_swings_the_antenna() -> None:
    waves = calm()
    waves.roll_rad = math.radians(10.0)
    model = GnssModel(replace(GNSS, x_m=0.0, z_m=-2.0), HOME, "rtk", 0.05, 1)
    easts = [FRAME.to_ned(*(model.sample(placed(), waves, NONE).position or (0.0, 0.0))[:2])[1] for _ in range(20_000)]
    assert statistics.fmean(easts) == pytest.approx(-20.0 + 2.0 * math.sin(math.radians(10.0)), abs=0.01)


def test_heave_lifts_the_antenna_once() -> None:
    model, waves = GnssModel(GNSS, HOME, "basin", 0.05, 1), calm()
    flat = model.sample(placed(), waves, NONE).position
    waves.heave_m = -0.4  # the hull's way down
    lifted = model.sample(placed(), waves, NONE).position
    assert flat is not None and lifted is not None
    assert lifted[2] - flat[2] == pytest.approx(0.4, abs=0.02)


def test_velocity_is_the_antennas() -> None:
    model = GnssModel(replace(GNSS, x_m=-1.0, y_m=0.5), HOME, "rtk", 0.05, 1)
    hull = placed(math.pi / 2, 1.0, 0.0, 0.2)  # surge 1 m/s east, turning to starboard
    samples = [model.sample(hull, calm(), NONE) for _ in range(4000)]
    assert statistics.fmean(sample.east_mps for sample in samples) == pytest.approx(1.0 - 0.2 * 0.5, abs=0.002)
    assert statistics.fmean(sample.north_mps for sample in samples) == pytest.approx(0.2 * 1.0, abs=0.002)


@pytest.mark.parametrize("name", list(GRADES))
def test_errors_have_the_size_of_their_grade(name: str) -> None:
    errors, headings = [], []
    for seed in range(150):
        model = GnssModel(replace(GNSS, x_m=0.0, z_m=0.0), HOME, name, 0.05, seed)
        sample = model.sample(placed(), calm(), NONE)
        assert sample.position is not None and sample.heading_rad is not None
        north, east = FRAME.to_ned(*sample.position[:2])
        errors += [north - 10.0, east + 20.0]
        headings.append(sample.heading_rad)
    expected = math.hypot(GRADES[name].white_m, GRADES[name].slow_m)
    assert statistics.pstdev(errors) == pytest.approx(expected, rel=0.15)
    assert 1.0 < statistics.pstdev(headings) / GRADES[name].heading_rad < 2.0


def test_errors_of_position_stay_for_a_while() -> None:
    model = GnssModel(replace(GNSS, x_m=0.0, z_m=0.0), HOME, "standalone", 0.05, 4)
    hull = placed()
    norths = [FRAME.to_ned(*(model.sample(hull, calm(), NONE).position or (0.0, 0.0))[:2])[0] for _ in range(400)]
    assert statistics.pstdev(norths) < 0.5  # 20 s: mostly the white part
    assert abs(statistics.fmean(norths[:50]) - statistics.fmean(norths[-50:])) < 1.0


def test_faults_of_the_receiver() -> None:
    model = GnssModel(replace(GNSS, x_m=0.0, z_m=0.0), HOME, "rtk", 0.05, 1)
    hull = placed()
    lost = model.sample(hull, calm(), {"gnss_lost"})
    assert lost.position is None and lost.heading_rad is None
    no_heading = model.sample(hull, calm(), {"heading_lost"})
    assert no_heading.heading_rad is None and no_heading.position is not None
    off = model.sample(hull, calm(), {"gnss_off_10m"}).position
    assert off is not None
    assert math.dist(FRAME.to_ned(*off[:2]), (10.0, -20.0)) == pytest.approx(10.0, abs=0.2)
    assert model.sample(hull, calm(), {"rtk_lost"}).grade == GRADES["standalone"]
    wild = [model.sample(hull, calm(), {"gnss_wild"}).position for _ in range(100)]
    assert sum(position is not None and abs(position[0]) < 1.0 for position in wild) == 10


def test_heading_offset_is_of_the_baseline() -> None:
    model = GnssModel(replace(GNSS, heading_offset_rad=math.radians(30.0)), HOME, "rtk", 0.05, 1)
    heading = model.sample(placed(math.radians(50.0)), calm(), NONE).heading_rad
    assert heading is not None and math.degrees(heading) == pytest.approx(20.0, abs=1.0)  # the driver adds the offset


def mean_sample(model: ImuModel, hull: Hull, waves: Waves, count: int = 2000) -> list[float]:
    sums = [0.0] * 9
    for _ in range(count):
        for i, value in enumerate(model.sample(hull, waves)):
            sums[i] += (value - (*model.biases, 0.0, 0.0, 0.0)[i]) / count
    return sums


def test_at_rest_the_imu_feels_gravity_upwards() -> None:
    g = gravity_mps2(HOME.lat_deg)
    mean = mean_sample(ImuModel(IMU, HOME, 0.01, 1), placed(), calm())
    assert mean[:3] == pytest.approx([0.0, 0.0, -g], abs=1e-3)
    assert mean[3:6] == pytest.approx([0.0, 0.0, 0.0], abs=2e-4)


def test_a_heeled_imu_feels_gravity_along_its_axes() -> None:
    g = gravity_mps2(HOME.lat_deg)
    waves = calm()
    waves.roll_rad = math.radians(20.0)
    assert mean_sample(ImuModel(IMU, HOME, 0.01, 1), placed(), waves)[:3] == pytest.approx(
        [0.0, -g * math.sin(math.radians(20.0)), -g * math.cos(math.radians(20.0))], abs=1e-3
    )
    waves.roll_rad, waves.pitch_rad = 0.0, math.radians(20.0)  # bow up
    assert mean_sample(ImuModel(IMU, HOME, 0.01, 1), placed(), waves)[:3] == pytest.approx(
        [g * math.sin(math.radians(20.0)), 0.0, -g * math.cos(math.radians(20.0))], abs=1e-3
    )


def test_turning_on_the_spot_throws_a_lever_arm_outwards() -> None:
    hull = placed()
    hull.turn_radps = 0.8
    mean = mean_sample(ImuModel(replace(IMU, x_m=0.5, y_m=-0.25), HOME, 0.01, 1), hull, calm())
    assert mean[:2] == pytest.approx([-0.64 * 0.5, 0.64 * 0.25], abs=1e-3)
    assert mean[5] == pytest.approx(0.8, abs=2e-4)


def test_a_yaw_acceleration_swings_a_lever_arm_sideways() -> None:
    model, hull = ImuModel(replace(IMU, x_m=2.0), HOME, 0.01, 1), placed()
    model.sample(hull, calm())
    ys = []
    for k in range(1, 400):
        hull.turn_radps = 0.005 * k  # 0.5 rad/s²
        ys.append(model.sample(hull, calm())[1] - model.biases[1])
    assert statistics.fmean(ys) == pytest.approx(0.5 * 2.0, abs=2e-3)


def test_dead_reckoning_on_the_imu_follows_the_boat() -> None:
    """Bias-free integration of what the IMU measures, in waves, ends where the hull is: axes, signs and timing all
    fit."""
    hull, wind = placed(0.3), WindModel(5.0, 0.0, 1)
    waves, model = Waves(wind, 1), ImuModel(IMU, HOME, 0.01, 1)
    hull.set_current(0.1, 0.0)
    g = gravity_mps2(HOME.lat_deg)
    north_m, east_m, north_mps, east_mps, yaw = hull.north_m, hull.east_m, hull.north_mps, hull.east_mps, hull.yaw_rad
    for k in range(1, 3001):
        hull.step(20.0, 4.0, 3.0, 0.01)
        waves.update(0.01 * k)
        x, y, z, _p, q, r = (
            value - bias for value, bias in zip(model.sample(hull, waves)[:6], model.biases, strict=True)
        )
        roll, pitch = waves.roll_rad, waves.pitch_rad
        turn = (q * math.sin(roll) + r * math.cos(roll)) / math.cos(pitch)
        forward = math.cos(pitch) * x + math.sin(pitch) * (math.sin(roll) * y + math.cos(roll) * z)
        starboard = math.cos(roll) * y - math.sin(roll) * z
        mid = yaw + 0.005 * turn
        north_mps += 0.01 * (math.cos(mid) * forward - math.sin(mid) * starboard)
        east_mps += 0.01 * (math.sin(mid) * forward + math.cos(mid) * starboard)
        yaw += 0.01 * turn
        north_m, east_m = north_m + 0.01 * north_mps, east_m + 0.01 * east_mps
    assert g > 9.8
    assert math.dist((north_m, east_m), (hull.north_m, hull.east_m)) < 0.3
    assert math.remainder(yaw - hull.yaw_rad, 2.0 * math.pi) == pytest.approx(0.0, abs=0.01)
    assert math.dist((10.0, -20.0), (hull.north_m, hull.east_m)) > 5.0


def test_biases_walk_slowly() -> None:
    model, hull, waves = ImuModel(IMU, HOME, 0.01, 2), placed(), calm()
    start = model.biases
    for _ in range(6000):
        model.sample(hull, waves)
    moved = [abs(now - then) for now, then in zip(model.biases, start, strict=True)]
    assert all(0.0 < change < 0.02 for change in moved[:3])
    assert all(0.0 < change < math.radians(0.03) for change in moved[3:])


def yaw_errors(heading: str, count: int) -> list[float]:
    model, hull, waves = ImuModel(replace(IMU, heading=heading), HOME, 0.01, 2), placed(), calm()  # type: ignore[arg-type]
    return [model.sample(hull, waves)[8] for _ in range(count)]


def test_the_yaw_of_a_compass_errs_from_sample_to_sample_as_a_slow_process_does() -> None:
    """No steps every half second, which a filter of its headings would see; half a second later it is where the
    process is."""
    yaw, stepped = yaw_errors("magnetic", 20_000), yaw_errors("none", 20_000)
    changes = [later - before for before, later in pairwise(yaw[100:])]
    expected = YAW_RAD * math.sqrt(2.0 * 0.01 / YAW_TAU_S)
    assert statistics.fmean(change * change for change in changes) == pytest.approx(expected**2, rel=0.1)
    assert max(map(abs, changes)) < 6.0 * expected
    assert yaw[98::50] == pytest.approx(stepped[49:-49:50], abs=1e-12)


def test_a_sensor_that_integrates_gives_the_constant_motion_of_the_same_sums() -> None:
    """It feels what stands still in the world, while it turns ever faster about several axes."""
    mean, still, dt_s = StrapdownMean(0.01), np.array([0.4, -0.3, -9.8]), 0.01
    attitude = Rotation.from_euler("ZYX", [0.3, 0.1, -0.2])
    begin = attitude
    for k in range(10):
        rates = np.array([0.3, -0.2, 0.4]) + np.array([1.0, 2.0, -1.5]) * (k + 0.5) * dt_s
        middle = attitude * Rotation.from_rotvec(0.5 * dt_s * rates)
        force = middle.inv().apply(still)
        mean.take((*force, *rates, 0.0, 0.0, float(k)))
        attitude = attitude * Rotation.from_rotvec(dt_s * rates)
    told = np.array(mean.taken())
    turned = Rotation.from_rotvec(0.1 * told[3:6])
    assert (begin * turned).as_matrix() == pytest.approx(attitude.as_matrix(), abs=1e-6)
    steps = [begin * Rotation.from_rotvec((k + 0.5) * 1e-3 * told[3:6]) for k in range(100)]
    gained = sum(1e-3 * step.apply(told[:3]) for step in steps)
    assert gained == pytest.approx(0.1 * still, abs=2e-5)
    assert told[8] == 9.0


def test_one_sample_alone_is_given_as_it_is() -> None:
    mean, sample = StrapdownMean(0.01), (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0)
    mean.take(sample)
    assert mean.taken() == sample
