"""Turned sensors: a boat whose devices are mounted askew finds the same attitude once it is told how."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.config import vessel as vessel_config
from companion.core.readings import Imu, MagneticField
from companion.nav.ahrs_heading import AhrsHeading
from companion.nav.corrections import corrections_of
from companion.nav.lever_arms import Matrix, Vector, quaternion_of, rotate, rotation
from companion.nav.mounting import Mounting
from companion.nav.still_calibration import level_of
from companion.params.devices import ROTATIONS_DEG
from companion.params.store import Parameters
from companion.params.table import TABLE

REVOLT = vessel_config.load(vessel_config.find("revolt"))
WITH_COMPASS = replace(
    REVOLT, sensors=(REVOLT.sensors[0], replace(REVOLT.sensors[1], heading="ahrs", heading_wander_rad=0.01))
)
NAME = REVOLT.sensors[1].name
SPECS = {spec.name: spec for spec in TABLE}


def orientation(number: int) -> Matrix:
    """By the name of MAVLink's enumeration."""
    name = mavlink.enums["MAV_SENSOR_ORIENTATION"][number].name
    turns = {axis: math.radians(float(angle)) for axis, angle in re.findall(r"(ROLL|PITCH|YAW)_(\d+)", name)}
    return rotation(quaternion_of(*(turns.get(axis, 0.0) for axis in ("ROLL", "PITCH", "YAW"))))


def seen_by(matrix: Matrix, vector: Vector) -> Vector:
    """What a device that is turned so in the boat measures of a vector in the boat's axes."""
    a, b, c, d, e, f, g, h, i = matrix
    return rotate((a, d, g, b, e, h, c, f, i), vector)


@pytest.mark.parametrize("number", ROTATIONS_DEG)
def test_rotations_are_mavlinks(number: int) -> None:
    force, rates = (0.3, -0.4, -9.7), (0.1, 0.2, -0.3)
    matrix = orientation(number)
    turned = Mounting(REVOLT, Parameters({"SENS_BOARD_ROT": number})).turned(
        Imu(1.0, NAME, *seen_by(matrix, force), *seen_by(matrix, rates))
    )
    assert (turned.x_mps2, turned.y_mps2, turned.z_mps2) == pytest.approx(force)
    assert (turned.roll_rate_radps, turned.pitch_rate_radps, turned.yaw_rate_radps) == pytest.approx(rates)
    assert SPECS["SENS_BOARD_ROT"].choices[number] == SPECS["CAL_MAG2_ROT"].choices[number]


def test_nothing_is_turned_by_default() -> None:
    mounting, imu = Mounting(WITH_COMPASS, Parameters()), Imu(1.0, NAME, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    assert mounting.turned(imu) is imu and mounting.compass(NAME) is None


def test_offsets_count_at_once_and_come_after_the_rotation() -> None:
    parameters = Parameters({"SENS_BOARD_ROT": 2})
    mounting, level = Mounting(REVOLT, parameters), Imu(1.0, NAME, 0.0, 0.0, -9.81, 0.0, 0.0, 0.0)
    assert mounting.turned(level).x_mps2 == pytest.approx(0.0)
    parameters.set("SENS_BOARD_Y_OFF", 2.0)
    assert mounting.turned(level).x_mps2 == pytest.approx(-9.81 * math.sin(math.radians(2.0)))
    parameters.set("SENS_BOARD_ROT", 0)
    assert mounting.turned(replace(level, y_mps2=-1.0, z_mps2=0.0)).x_mps2 == pytest.approx(
        math.cos(math.radians(2.0))
    ), "a rotation counts from the next start"


@pytest.mark.parametrize("number", [0, 2, 8])
def test_a_level_calibration_turns_gravity_upright(number: int) -> None:
    askew = rotation(quaternion_of(math.radians(3.0), math.radians(-7.0), math.radians(20.0)))
    force = seen_by(orientation(number), seen_by(askew, (0.0, 0.0, -9.81)))
    parameters = Parameters({"SENS_BOARD_ROT": number, "SENS_BOARD_X_OFF": 11.0, "SENS_BOARD_Z_OFF": 20.0})
    mounting = Mounting(REVOLT, parameters)
    roll, pitch = level_of(mounting.unlevelled(force))
    assert (math.degrees(roll), math.degrees(pitch)) == pytest.approx((3.0, -7.0))
    parameters.set("SENS_BOARD_X_OFF", math.degrees(roll))
    parameters.set("SENS_BOARD_Y_OFF", math.degrees(pitch))
    levelled = mounting.turned(Imu(1.0, NAME, *force, 0.0, 0.0, 0.0))
    assert (levelled.x_mps2, levelled.y_mps2, levelled.z_mps2) == pytest.approx((0.0, 0.0, -9.81), abs=1e-6)


def test_a_magnetometer_turns_with_the_board_or_by_itself() -> None:
    with_board = Mounting(WITH_COMPASS, Parameters({"SENS_BOARD_ROT": 2}))
    assert with_board.compass(NAME) == pytest.approx(orientation(2))
    alone = Mounting(WITH_COMPASS, Parameters({"SENS_BOARD_ROT": 2, "CAL_MAG0_ROT": 8}))
    assert alone.compass(NAME) == pytest.approx(orientation(8))
    straight = Mounting(WITH_COMPASS, Parameters({"SENS_BOARD_ROT": 2, "CAL_MAG0_ROT": 0}))
    assert straight.compass(NAME) is None


def test_a_turned_compass_gives_the_heading_of_the_boat() -> None:
    parameters = Parameters()
    corrections = corrections_of(WITH_COMPASS.sensors, parameters)[NAME]
    ahrs = AhrsHeading(WITH_COMPASS.sensors[1], 9.81, parameters, corrections)
    turn = Mounting(WITH_COMPASS, Parameters({"CAL_MAG0_ROT": 6})).compass(NAME)
    heading = None
    for k in range(400):
        ahrs.field(MagneticField(0.01 * k, NAME, *seen_by(orientation(6), (0.0, -0.35, 0.9))), 0.0, turn)
        heading = ahrs.imu(Imu(0.01 * k, NAME, 0.0, 0.0, -9.81, 0.0, 0.0, 0.0)) or heading
    assert heading is not None and math.degrees(heading.yaw_rad) == pytest.approx(90.0, abs=0.5)
