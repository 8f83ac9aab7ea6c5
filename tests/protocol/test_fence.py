"""The fence as a ground station meets it: upload, refusals, breach, the way home; a whole vessel in lockstep."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from shapely.geometry import Point, Polygon

from companion.io.mavlink.wire import messages as mavlink
from tests.protocol.desk import Desk, of
from tests.protocol.test_found_faults import desk_in, sail
from tests.protocol.test_qgroundcontrol import ARM, HOLD, MISSION, NAN, RTL, item

MANUAL, HEADING = 0x00010000, 0x00070000
BOX = ((-30.0, -30.0), (30.0, -30.0), (30.0, 30.0), (-30.0, 30.0))
WALL = ((8.0, -6.0), (10.0, -6.0), (10.0, 6.0), (8.0, 6.0))
GEOFENCE = 0x100000


def fence_items(
    inside: Sequence[Sequence[tuple[float, float]]], outside: Sequence[Sequence[tuple[float, float]]] = ()
) -> list[Any]:
    items: list[Any] = []
    for command, polygons in ((5001, inside), (5002, outside)):
        for polygon in polygons:
            items += [
                item(len(items) + n, command, *place, float(len(polygon)), kind=1, frame=0)
                for n, place in enumerate(polygon)
            ]
    return items


def go_to(desk: Desk, north_m: float, east_m: float) -> int:
    lat_deg, lon_deg = desk.vessel.frame.to_geodetic(north_m, east_m)
    x, y = round(lat_deg * 1e7), round(lon_deg * 1e7)
    answers = desk.tell(mavlink.MAVLink_command_int_message(1, 1, 0, 192, 0, 0, -1.0, 1.0, 0.0, NAN, x, y, NAN))
    return int(of(answers, "COMMAND_ACK")[0].result)


def away_m(desk: Desk, north_m: float, east_m: float) -> float:
    return math.hypot(desk.rig.world.truth.north_m - north_m, desk.rig.world.truth.east_m - east_m)


def sail_until(desk: Desk, condition: Callable[[], bool], timeout_s: float = 150.0) -> None:
    """With the station's heartbeats."""
    end_s = desk.rig.now_s + timeout_s
    while not condition():
        assert desk.rig.now_s < end_s, desk.texts()[-5:]
        sail(desk, 1.0)


def test_refused_go_to_refused_mission_and_the_way_round(tmp_path: Path) -> None:
    desk = desk_in(tmp_path)
    desk.rig.vessel.parameters.set("MIS_ROUND", 0.0)
    assert desk.upload([item(0, 16, 5.0, 0.0), item(1, 16, 14.0, 0.0)]) == mavlink.MAV_MISSION_ACCEPTED
    assert desk.upload(fence_items([BOX], [WALL]), 1) == mavlink.MAV_MISSION_ACCEPTED
    desk.tick(40)
    assert any("Check the mission: item 2: way crosses the fence" in text for text in desk.texts())
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, MISSION))
    desk.tick(2)
    assert desk.latest("HEARTBEAT").custom_mode != MISSION
    assert any("Mission refused: item 2: way crosses the fence" in text for text in desk.texts())

    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, HOLD))
    assert desk.result(ARM, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    assert go_to(desk, 60.0, 0.0) == mavlink.MAV_RESULT_DENIED
    assert go_to(desk, 14.0, 0.0) == mavlink.MAV_RESULT_DENIED
    assert desk.result(192, -1.0, 1.0, 0.0, NAN, math.inf, 10.0, NAN) == mavlink.MAV_RESULT_DENIED
    desk.tick()
    assert [text for text in desk.texts() if text.startswith("Go-to refused")] == [
        "Go-to refused: outside the fence",
        "Go-to refused: way crosses the fence",
    ]
    assert go_to(desk, 9.0, 14.0) == mavlink.MAV_RESULT_ACCEPTED
    sail_until(desk, lambda: away_m(desk, 9.0, 14.0) < 1.0)
    assert go_to(desk, 15.0, 3.0) == mavlink.MAV_RESULT_ACCEPTED
    sail_until(desk, lambda: away_m(desk, 15.0, 3.0) < 1.0)

    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, RTL))
    wall, nearest_m = Polygon(WALL), math.inf

    def at_home() -> bool:
        nonlocal nearest_m
        truth = desk.rig.world.truth
        nearest_m = min(nearest_m, wall.distance(Point(truth.north_m, truth.east_m)))
        return any("RTL: at home" in text for text in desk.texts())

    sail_until(desk, at_home, 250.0)
    assert nearest_m > 1.5, "the hull stays clear of the wall"
    assert desk.latest("FENCE_STATUS").breach_count == 0
    desk.close()


def test_a_breach_is_told_and_acted_on(tmp_path: Path) -> None:
    desk = desk_in(tmp_path)
    desk.tick(20)
    assert (
        desk.latest("FENCE_STATUS") is None and not desk.latest("SYS_STATUS").onboard_control_sensors_present & GEOFENCE
    )
    assert desk.latest("SYS_STATUS").onboard_control_sensors_health & GEOFENCE
    assert desk.upload(fence_items([[(n / 5.0, e / 5.0) for n, e in BOX]]), 1) == mavlink.MAV_MISSION_ACCEPTED
    desk.tick(20)
    status = desk.latest("SYS_STATUS")
    assert (
        status.onboard_control_sensors_present
        & status.onboard_control_sensors_enabled
        & status.onboard_control_sensors_health
        & GEOFENCE
    )
    assert (desk.latest("FENCE_STATUS").breach_status, desk.latest("FENCE_STATUS").breach_mitigation) == (
        0,
        mavlink.FENCE_MITIGATE_NONE,
    )

    assert desk.vessel.parameters.set("GF_ACTION", 1) is None
    desk.tell(mavlink.MAVLink_manual_control_message(1, 0, 0, 0, 0, 0), mavlink.MAVLink_set_mode_message(1, 1, MANUAL))
    assert desk.result(ARM, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    for _ in range(300):
        desk.tell(mavlink.MAVLink_manual_control_message(1, 1000, 0, 0, 0, 0))
        sail(desk, 0.1)
        if desk.latest("FENCE_STATUS").breach_status:
            break
    told = desk.latest("FENCE_STATUS")
    assert (told.breach_status, told.breach_count, told.breach_type) == (1, 1, mavlink.FENCE_BREACH_BOUNDARY)
    assert desk.latest("HEARTBEAT").custom_mode == MANUAL, "a warning is no action"
    assert (
        any(re.fullmatch(r"Fence [0-9]+ m ahead", text) for text in desk.texts())
        and "Outside the fence" in desk.texts()
    )
    sail(desk, 1.5)
    assert not desk.latest("SYS_STATUS").onboard_control_sensors_health & GEOFENCE

    assert desk.vessel.parameters.set("GF_ACTION", 2) is None
    assert go_to(desk, 0.0, 0.0) == mavlink.MAV_RESULT_ACCEPTED, "back in is free"
    sail_until(desk, lambda: not desk.latest("FENCE_STATUS").breach_status)
    desk.close()


@pytest.mark.parametrize("radius_m", [14.5, 15.0])
@pytest.mark.parametrize("mode", [HEADING, MANUAL])
def test_the_circle_around_home_stops_the_boat(tmp_path: Path, mode: int, radius_m: float) -> None:
    """GF_MAX_HOR_DIST as QGroundControl's slider sets it: no zone is uploaded. In Heading the boat slows down by
    itself, in Manual GF_ACTION comes in time. A little too fast for the stop, it braked with all its thrust, and lay 9 m
    short of the fence."""
    desk = desk_in(tmp_path)
    desk.tell(mavlink.MAVLink_param_set_message(1, 1, b"GF_MAX_HOR_DIST", radius_m, mavlink.MAV_PARAM_TYPE_REAL32))
    desk.tick(2)
    assert desk.latest("PARAM_VALUE").param_value == radius_m and any("Fence: within" in text for text in desk.texts())
    desk.tell(mavlink.MAVLink_manual_control_message(1, 0, 0, 0, 0, 0), mavlink.MAVLink_set_mode_message(1, 1, mode))
    assert desk.result(ARM, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    desk.tick(2)
    furthest_m = 0.0
    for _ in range(80):
        desk.tell(mavlink.MAVLink_manual_control_message(1, 1000, 0, 0, 0, 0))
        sail(desk, 0.4)
        furthest_m = max(furthest_m, away_m(desk, 0.0, 0.0))
    assert radius_m - 5.0 < furthest_m < radius_m and abs(desk.rig.world.truth.surge_mps) < 0.1
    assert desk.latest("FENCE_STATUS").breach_count == 0
    if mode == MANUAL:
        assert any(re.fullmatch(r"Fence [0-9]+ m ahead: Hold", text) for text in desk.texts())
    assert go_to(desk, 40.0, 0.0) == mavlink.MAV_RESULT_DENIED
    assert go_to(desk, 0.0, 0.0) == mavlink.MAV_RESULT_ACCEPTED
    desk.close()
