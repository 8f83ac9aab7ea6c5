"""OBSTACLE_DISTANCE and DISTANCE_SENSOR, packed by pymavlink, their values worked out by hand."""

from __future__ import annotations

import math
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.core.readings import Depth, Ranges
from companion.io.mavlink.ranges import ranges_of, reading_of


def sectors(first_deg: float = 0.0, step_deg: float = 5.0, frame: int = mavlink.MAV_FRAME_BODY_FRD, **cm: int) -> Any:
    distances = [int(cm.get(f"d{i}", 4001)) for i in range(72)]
    return mavlink.MAVLink_obstacle_distance_message(0, 0, distances, 5, 50, 4000, step_deg, first_deg, frame)


def test_sectors_are_clockwise_from_the_bow() -> None:
    found = ranges_of(sectors(d0=1000, d18=2050, d3=65535), "lidar", 7.0)
    assert isinstance(found, Ranges) and (found.t_s, found.from_north, len(found.distances_m)) == (7.0, False, 72)
    assert (found.first_rad, found.step_rad) == pytest.approx((0.0, math.radians(5.0)))
    assert (found.least_m, found.most_m) == (0.5, 40.0)
    assert found.distances_m[0] == 10.0 and found.distances_m[18] == pytest.approx(20.5)
    assert math.isnan(found.distances_m[3]) and math.isinf(found.distances_m[1])


def test_sectors_counter_clockwise_are_turned_round() -> None:
    found = ranges_of(sectors(first_deg=45.0, step_deg=-10.0, d0=300, d9=700), "lidar", 0.0)
    assert found is not None and len(found.distances_m) == 36 and found.step_rad == pytest.approx(math.radians(10.0))
    bearings = {off: found.first_rad + i * found.step_rad for i, off in enumerate(found.distances_m) if off < 40.0}
    assert math.degrees(bearings[3.0]) == pytest.approx(45.0) and math.degrees(bearings[7.0]) == pytest.approx(-45.0)


def test_only_a_frame_of_the_body_turns_with_the_mounting() -> None:
    body = ranges_of(sectors(), "lidar", 0.0, offset_rad=0.3, x_m=1.0)
    north = ranges_of(sectors(frame=mavlink.MAV_FRAME_GLOBAL), "lidar", 0.0, offset_rad=0.3)
    assert body is not None and north is not None
    assert (body.first_rad, body.x_m, body.from_north) == (0.3, 1.0, False)
    assert (north.first_rad, north.from_north) == (0.0, True)


@pytest.mark.parametrize("step_deg", [math.nan, 120.0, 1e-40, -1e-6])
def test_sectors_of_no_sense_are_ignored(step_deg: float) -> None:
    assert ranges_of(sectors(step_deg=step_deg), "lidar", 0.0) is None


@pytest.mark.parametrize("first_deg", [math.nan, math.inf, 1e38])
def test_sectors_that_begin_nowhere_are_ignored(first_deg: float) -> None:
    assert ranges_of(sectors(first_deg=first_deg), "lidar", 0.0) is None


def one(orientation: int, cm: int, fov_rad: float = 0.1, quality: int = 0) -> Any:
    upright = (1.0, 0.0, 0.0, 0.0)
    return mavlink.MAVLink_distance_sensor_message(
        0, 20, 3000, cm, 0, 1, orientation, 255, fov_rad, 0, upright, quality
    )


@pytest.mark.parametrize("fov_rad", [0.0, 1e-40, 1e-6, math.nan, 4.0])
def test_a_single_sensor_without_a_width_that_can_be_has_one_of_five_degrees(fov_rad: float) -> None:
    found = reading_of(one(mavlink.MAV_SENSOR_ROTATION_NONE, 1000, fov_rad), "sonar", 0.0)
    assert isinstance(found, Ranges) and found.step_rad == pytest.approx(math.radians(5.0))


def test_a_single_sensor_looks_where_it_is_mounted() -> None:
    found = reading_of(one(mavlink.MAV_SENSOR_ROTATION_YAW_90, 1234), "sonar", 2.0)
    assert isinstance(found, Ranges) and found.distances_m == (12.34,)
    assert (found.first_rad, found.step_rad) == pytest.approx((0.5 * math.pi, 0.1))
    last = reading_of(one(mavlink.MAV_SENSOR_ROTATION_NONE, 2999), "sonar", 2.0)
    assert isinstance(last, Ranges) and last.distances_m[0] == pytest.approx(29.99)


@pytest.mark.parametrize("cm", [3000, 3001])
def test_a_single_sensor_that_sees_nothing_tells_its_reach_or_more(cm: int) -> None:
    """At 30 m, its max_distance, there seemed to be an obstacle wherever it looked."""
    nothing = reading_of(one(mavlink.MAV_SENSOR_ROTATION_NONE, cm), "sonar", 2.0)
    assert isinstance(nothing, Ranges) and math.isinf(nothing.distances_m[0])


def test_a_sensor_that_looks_down_gives_the_depth() -> None:
    found = reading_of(one(mavlink.MAV_SENSOR_ROTATION_PITCH_270, 850), "sonar", 2.0)
    assert found == Depth(2.0, "sonar", 8.5, None, 30.0)
    assert reading_of(one(mavlink.MAV_SENSOR_ROTATION_PITCH_270, 3000), "sonar", 2.0) is None
    assert reading_of(one(mavlink.MAV_SENSOR_ROTATION_PITCH_90, 850), "sonar", 2.0) is None


def test_a_depth_of_zero_means_that_no_bottom_is_found() -> None:
    """The boat turned back over deep water, for a sounder whose least distance is 0 too."""
    message = one(mavlink.MAV_SENSOR_ROTATION_PITCH_270, 0)
    message.min_distance = 0
    assert reading_of(message, "sonar", 2.0) is None
    message.current_distance = 1
    assert reading_of(message, "sonar", 2.0) == Depth(2.0, "sonar", 0.01, None, 30.0)


@pytest.mark.parametrize(("quality", "counts"), [(0, True), (1, False), (2, True), (100, True)])
def test_a_distance_without_a_signal_is_not_known(quality: int, counts: bool) -> None:
    """A lost echo, of which signal_quality is 1, counted as measured."""
    ahead = reading_of(one(mavlink.MAV_SENSOR_ROTATION_NONE, 800, quality=quality), "sonar", 2.0)
    assert isinstance(ahead, Ranges) and math.isfinite(ahead.distances_m[0]) is counts
    below = reading_of(one(mavlink.MAV_SENSOR_ROTATION_PITCH_270, 90, quality=quality), "sonar", 2.0)
    assert (below is not None) is counts
