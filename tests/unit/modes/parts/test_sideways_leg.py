"""Headings of waypoints: taken up there, or along the whole leg."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.config.vessel import VesselConfig
from companion.core.decision import MissionState, ModeId
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, PoseSetpoint
from companion.mission.plan import PlanKind
from tests.unit.conftest import Boat


def sail(boat: Boat, *points: tuple[float, float, float]) -> list[tuple[float, float, float, type]]:
    """Points as (north, east, heading or NaN); the track until the mission is complete."""
    boat.upload(*(point[:2] for point in points))
    items = boat.plans.items(PlanKind.MISSION)
    boat.plans.replace(
        PlanKind.MISSION, [replace(item, param4=point[2]) for item, point in zip(items, points, strict=True)]
    )
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    boat.supervisor.arm(boat.now_s)
    track = []
    while boat.executor.progress.state is not MissionState.COMPLETE:
        boat.tick()
        track.append((boat.nav.north_m, boat.nav.east_m, math.degrees(boat.nav.yaw_rad), type(boat.setpoint)))
        assert len(track) < 6000
    return track


def test_at_the_waypoint_by_default(boat: Boat) -> None:
    track = sail(boat, (10.0, 0.0, 90.0))
    assert all(kind is PathSetpoint for north, _, _, kind in track if north < 8.0)
    assert track[-1][0] == pytest.approx(10.0, abs=1.6)


def test_along_the_leg(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(WP_YAW_MODE=1)
    track = sail(boat, (10.0, 0.0, 90.0), (10.0, 8.0, 90.0))
    assert {kind for *_, kind in track} == {PoseSetpoint}
    for north_m, east_m, yaw_deg, _ in track:
        if north_m > 0.05:
            assert yaw_deg == pytest.approx(90.0, abs=0.1)
        assert abs(east_m) < 0.05 or abs(north_m - 10.0) < 0.05
    assert boat.executor.progress.reached == 2 and boat.away_m(10.0, 8.0) < 0.05


def test_points_without_a_heading_are_sailed_through_first(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(WP_YAW_MODE=1)
    track = sail(boat, (15.0, 0.0, math.nan), (15.0, 10.0, 0.0 + 360.0), (0.0, 10.0, math.nan))
    sideways = [row for row in track if 2.5 < row[1] < 9.5 and row[0] > 13.0 and row[3] is PoseSetpoint]
    assert len(sideways) > 50 and all(abs(yaw_deg) < 0.5 for _, _, yaw_deg, _ in sideways)
    assert any(kind is PathSetpoint and north_m < 12.0 for north_m, _, _, kind in track[:200])
    assert [text for text in boat.texts() if text.startswith("Mission item")] == [
        f"Mission item {i} reached" for i in range(1, 4)
    ]


def test_a_boat_without_sway_sails_as_ever(make_boat: Callable[..., Boat], revolt: VesselConfig) -> None:
    jet = make_boat(replace(revolt, limits=replace(revolt.limits, sway_n=0.0)), WP_YAW_MODE=1)
    track = sail(jet, (10.0, 0.0, 90.0))
    assert all(kind is PathSetpoint for *_, kind in track[5:] if kind is not NeutralSetpoint)


def test_waiting_with_a_heading_holds_it(boat: Boat) -> None:
    boat.upload((8.0, 0.0))
    item = boat.plans.items(PlanKind.MISSION)[0]
    boat.plans.replace(PlanKind.MISSION, [replace(item, param1=60.0, param4=135.0)])
    boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.until(lambda: boat.away_m(8.0, 0.0) < 0.1)
    boat.step(50.0)
    assert boat.executor.progress.state is MissionState.ACTIVE
    assert math.degrees(boat.nav.yaw_rad) == pytest.approx(135.0, abs=0.1) and boat.away_m(8.0, 0.0) < 0.01
