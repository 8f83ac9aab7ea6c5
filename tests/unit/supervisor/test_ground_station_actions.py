"""What QGroundControl's buttons send, and what must become of it."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from companion.core.decision import Home, MissionState, ModeId, Result
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, PoseSetpoint
from tests.unit.conftest import Boat

SQUARE = ((15.0, 0.0), (15.0, 15.0), (0.0, 15.0))


def test_starts_disarmed_in_manual(boat: Boat) -> None:
    assert (boat.status.mode, boat.status.armed, boat.status.arming_refusals) == (ModeId.MANUAL, False, ())
    assert isinstance(boat.setpoint, NeutralSetpoint)


def test_modes_stand_in_display_order(boat: Boat) -> None:
    assert [mode.id.value for mode in boat.supervisor.modes] == [
        "Manual", "Forces", "Rate", "Heading", "Hold", "Mission", "RTL", "Dock", "Circle", "Trial", "Follow",
        "Offboard",
    ]  # fmt: skip
    assert [mode.id.value for mode in boat.supervisor.modes if mode.declaration.by_stick] == [
        "Manual",
        "Forces",
        "Rate",
        "Heading",
    ]
    assert all(mode.declaration.selectable and mode.text for mode in boat.supervisor.modes)


def test_start_mission_macro(boat: Boat) -> None:
    boat.upload(*SQUARE)
    version = boat.supervisor.version
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    assert boat.supervisor.version > version
    assert boat.supervisor.status(boat.now_s).mode is ModeId.MISSION
    boat.step(2.0)
    assert not boat.status.armed and isinstance(boat.setpoint, NeutralSetpoint)
    assert boat.status.mission.state is MissionState.NOT_STARTED
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()
    assert isinstance(boat.setpoint, PathSetpoint) and boat.status.mission.state is MissionState.ACTIVE
    boat.until(lambda: boat.status.mission.state is MissionState.COMPLETE)
    assert boat.status.mission.reached == 3
    boat.step(5.0)
    assert boat.status.mode is ModeId.HOLD and boat.away_m(0.0, 15.0) < 1.5
    assert "Mission complete" in boat.texts()


@pytest.mark.parametrize("mode", [m for m in ModeId if m is not ModeId.OFFBOARD])
def test_choosing_a_mode_never_arms(boat: Boat, mode: ModeId) -> None:
    boat.upload(*SQUARE)
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted
    boat.step(1.0)
    assert boat.status.mode is mode and not boat.status.armed and isinstance(boat.setpoint, NeutralSetpoint)


def test_offboard_without_setpoints_is_refused_with_the_reason(boat: Boat) -> None:
    outcome = boat.supervisor.request_mode(ModeId.OFFBOARD, boat.now_s)
    assert outcome.result is Result.TEMPORARILY_REJECTED
    assert outcome.reason == "Offboard refused: no setpoint yet: stream first"
    boat.step()
    assert outcome.reason in boat.texts() and boat.status.mode is ModeId.MANUAL


def test_mission_without_items_is_refused_and_said(boat: Boat) -> None:
    outcome = boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    assert outcome.result is Result.TEMPORARILY_REJECTED
    boat.step()
    assert "Mission refused: no mission loaded" in boat.texts() and boat.status.mode is ModeId.MANUAL


@pytest.mark.parametrize("mode", [ModeId.HOLD, ModeId.MISSION, ModeId.RTL])
@pytest.mark.parametrize("missing", ["position_valid", "heading_valid"])
def test_self_steered_modes_need_an_estimate(boat: Boat, mode: ModeId, missing: str) -> None:
    from dataclasses import replace

    boat.upload(*SQUARE)
    boat.nav = replace(boat.nav, **{missing: False})
    boat.step()
    outcome = boat.supervisor.request_mode(mode, boat.now_s)
    assert outcome.result is Result.TEMPORARILY_REJECTED and "not valid" in outcome.reason


def under_way(boat: Boat) -> None:
    boat.upload(*SQUARE)
    boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.until(lambda: boat.status.mission.seq == 1)
    boat.step(5.0)


def test_pause_pair_stops_and_leaves_the_point_alone(boat: Boat) -> None:
    under_way(boat)
    assert boat.supervisor.hold_here(boat.now_s).accepted
    boat.step(0.5)
    first = (boat.setpoint.progress.target.north_m, boat.setpoint.progress.target.east_m)
    assert boat.supervisor.hold_here(boat.now_s).accepted
    boat.step(0.5)
    assert (boat.setpoint.progress.target.north_m, boat.setpoint.progress.target.east_m) == first
    assert boat.status.mode is ModeId.HOLD and boat.status.mission.state is MissionState.PAUSED
    boat.step(20.0)
    assert boat.away_m(*first) < 0.01


def test_continue_goes_on_at_the_same_item(boat: Boat) -> None:
    under_way(boat)
    assert boat.supervisor.pause(boat.now_s).accepted
    boat.step(10.0)
    assert boat.supervisor.resume(boat.now_s).accepted
    boat.step()
    assert (boat.status.mode, boat.status.mission.state, boat.status.mission.seq) == (
        ModeId.MISSION,
        MissionState.ACTIVE,
        1,
    )
    boat.until(lambda: boat.status.mission.state is MissionState.COMPLETE)
    assert boat.status.mission.reached == 3


def test_resume_without_a_paused_mission_is_refused(boat: Boat) -> None:
    assert boat.supervisor.resume(boat.now_s).result is Result.TEMPORARILY_REJECTED
    assert boat.supervisor.pause(boat.now_s).result is Result.TEMPORARILY_REJECTED


def test_go_to_in_mid_mission_pauses_it(boat: Boat) -> None:
    under_way(boat)
    assert boat.supervisor.go_to(*boat.point(30.0, 5.0), math.nan, None, boat.now_s).accepted
    boat.step()
    assert boat.status.mode is ModeId.HOLD and isinstance(boat.setpoint, PathSetpoint)
    assert (boat.setpoint.progress.target.north_m, boat.setpoint.progress.target.east_m) == pytest.approx(
        (30.0, 5.0), abs=1e-3
    )
    boat.until(lambda: isinstance(boat.setpoint, PoseSetpoint))
    boat.step(30.0)
    assert boat.away_m(30.0, 5.0) < 0.01
    assert boat.status.mission.state is MissionState.PAUSED
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    boat.step()
    assert boat.status.mission.seq == 1
    boat.until(lambda: boat.status.mission.state is MissionState.COMPLETE)


def test_near_go_to_keeps_the_heading_and_does_not_turn_its_bow(boat: Boat) -> None:
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.step()
    assert boat.supervisor.go_to(*boat.point(0.0, 4.0), None, None, boat.now_s).accepted
    boat.step(5.0)
    assert isinstance(boat.setpoint, PoseSetpoint) and boat.setpoint.sway_mps > 0.0
    boat.until(lambda: boat.away_m(0.0, 4.0) < 0.01)
    assert boat.nav.yaw_rad == pytest.approx(0.0, abs=1e-6)


def test_go_to_takes_the_yaw_asked_for(boat: Boat) -> None:
    boat.supervisor.arm(boat.now_s)
    assert boat.supervisor.go_to(*boat.point(20.0, 0.0), math.radians(-90.0), 0.4, boat.now_s).accepted
    boat.step(30.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.4, abs=0.02)
    boat.until(lambda: boat.away_m(20.0, 0.0) < 0.01)
    boat.step(60.0)
    assert boat.nav.yaw_rad == pytest.approx(math.radians(-90.0), abs=1e-3)


def test_choosing_hold_again_gives_up_the_go_to(boat: Boat) -> None:
    boat.supervisor.arm(boat.now_s)
    boat.supervisor.go_to(*boat.point(40.0, 0.0), None, None, boat.now_s)
    boat.step(20.0)
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    boat.step()
    planned = boat.setpoint.progress.target.north_m
    assert isinstance(boat.setpoint, PathSetpoint) and boat.setpoint.surge_mps == 0.0, "it brakes"
    assert boat.nav.north_m < planned < boat.nav.north_m + 4.0
    boat.step()
    north = boat.setpoint.progress.target.north_m
    assert isinstance(boat.setpoint, PoseSetpoint) and north <= planned
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.step()
    assert boat.setpoint.progress.target.north_m == north
    boat.step(30.0)
    assert boat.away_m(north, 0.0) < 0.05


@pytest.mark.parametrize(
    ("lat_deg", "lon_deg", "result"),
    [
        (math.nan, 10.4, Result.DENIED),
        (63.4, math.inf, Result.DENIED),
        (91.0, 10.4, Result.DENIED),
        (63.4, 181.0, Result.DENIED),
        (64.0, 10.4, Result.DENIED),
    ],
)
def test_go_to_nowhere_is_denied(boat: Boat, lat_deg: float, lon_deg: float, result: Result) -> None:
    boat.supervisor.arm(boat.now_s)
    assert boat.supervisor.go_to(lat_deg, lon_deg, None, None, boat.now_s).result is result
    boat.step()
    assert boat.status.mode is ModeId.MANUAL and any("Go-to refused" in text for text in boat.texts())


def test_go_to_needs_to_be_armed(boat: Boat) -> None:
    outcome = boat.supervisor.go_to(*boat.point(5.0, 0.0), None, None, boat.now_s)
    assert outcome.result is Result.TEMPORARILY_REJECTED and "arm first" in outcome.reason


def test_return_leads_home_and_holds(boat: Boat) -> None:
    boat.supervisor.arm(boat.now_s)
    boat.supervisor.go_to(*boat.point(25.0, 10.0), None, None, boat.now_s)
    boat.until(lambda: boat.away_m(25.0, 10.0) < 0.1)
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).accepted
    boat.step()
    assert isinstance(boat.setpoint, PathSetpoint)
    boat.until(lambda: "rtl_arrived" in boat.names())
    assert boat.away_m(0.0, 0.0) < 0.1 and boat.status.mode is ModeId.RTL and isinstance(boat.setpoint, PoseSetpoint)


@pytest.mark.parametrize(("use_rally", "expected"), [(1, (20.0, 20.0)), (0, (0.0, 0.0))])
def test_return_takes_the_nearest_rally_point_if_told(
    make_boat: Callable[..., Boat], use_rally: int, expected: tuple[float, float]
) -> None:
    from companion.mission.plan import PlanKind

    boat = make_boat(RTL_USE_RALLY=use_rally)
    boat.upload((20.0, 20.0), (200.0, 0.0), kind=PlanKind.RALLY)
    boat.supervisor.arm(boat.now_s)
    boat.supervisor.go_to(*boat.point(30.0, 30.0), None, None, boat.now_s)
    boat.until(lambda: boat.away_m(30.0, 30.0) < 0.1)
    boat.supervisor.request_mode(ModeId.RTL, boat.now_s)
    boat.until(lambda: "rtl_arrived" in boat.names())
    assert boat.away_m(*expected) < 0.1


def test_set_current_under_way(boat: Boat) -> None:
    under_way(boat)
    assert boat.supervisor.set_current(2, False, boat.now_s).accepted
    boat.step()
    assert boat.status.mission.seq == 2 and boat.setpoint.progress.target.north_m == pytest.approx(0.0, abs=0.01)
    assert boat.supervisor.set_current(9, False, boat.now_s).result is Result.DENIED


def test_mission_start_from_an_item(boat: Boat) -> None:
    boat.upload(*SQUARE)
    assert boat.supervisor.start_mission(1, boat.now_s).accepted
    assert not boat.supervisor.status(boat.now_s).armed
    assert boat.supervisor.start_mission(7, boat.now_s).result is Result.DENIED
    boat.supervisor.arm(boat.now_s)
    boat.step()
    assert boat.status.mission.seq == 1
    boat.until(lambda: boat.status.mission.state is MissionState.COMPLETE)
    assert boat.supervisor.start_mission(None, boat.now_s).accepted
    boat.step()
    assert (boat.status.mission.state, boat.status.mission.seq) == (MissionState.ACTIVE, 0)


def test_speed_change(boat: Boat) -> None:
    boat.supervisor.arm(boat.now_s)
    boat.supervisor.go_to(*boat.point(80.0, 0.0), None, None, boat.now_s)
    boat.step(20.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.6, abs=0.01)
    assert boat.supervisor.change_speed(0.3, boat.now_s).accepted
    boat.step(20.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.3, abs=0.01) and boat.status.speed_override_mps == 0.3
    assert boat.supervisor.change_speed(50.0, boat.now_s).accepted
    assert boat.supervisor.status(boat.now_s).speed_override_mps == 1.0
    assert boat.supervisor.change_speed(math.nan, boat.now_s).result is Result.DENIED
    assert boat.supervisor.change_speed(-3.0, boat.now_s).result is Result.DENIED
    assert boat.supervisor.change_speed(None, boat.now_s).accepted
    assert boat.supervisor.status(boat.now_s).speed_override_mps is None


def test_home(boat: Boat) -> None:
    assert boat.status.home is not None and boat.status.home.lat_deg == boat.nav.lat_deg
    assert boat.supervisor.set_home(Home(63.0, 10.0, 3.0), boat.now_s).accepted
    assert boat.supervisor.status(boat.now_s).home == Home(63.0, 10.0, 3.0)
    assert boat.supervisor.set_home(Home(95.0, 10.0, 3.0), boat.now_s).result is Result.DENIED
    assert boat.supervisor.set_home(None, boat.now_s).accepted
    assert boat.supervisor.status(boat.now_s).home.lat_deg == pytest.approx(63.4389)


def test_home_moves_on_arming_if_told(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(HOME_ON_ARM=1)
    boat.supervisor.set_home(Home(63.0, 10.0, 3.0), boat.now_s)
    boat.supervisor.arm(boat.now_s)
    assert boat.supervisor.status(boat.now_s).home.lat_deg == pytest.approx(63.4389)


def test_disarm_and_terminate_stop_at_once(boat: Boat) -> None:
    under_way(boat)
    assert boat.supervisor.disarm(boat.now_s).accepted
    boat.step()
    assert not boat.status.armed and isinstance(boat.setpoint, NeutralSetpoint)
    assert boat.status.mission.state is MissionState.PAUSED
    boat.supervisor.arm(boat.now_s)
    boat.step()
    assert isinstance(boat.setpoint, PathSetpoint) and boat.status.mission.seq == 1
    assert boat.supervisor.terminate(boat.now_s).accepted
    assert not boat.supervisor.status(boat.now_s).armed
    boat.step()
    assert isinstance(boat.setpoint, NeutralSetpoint) and "terminated" in boat.names()
