"""Offboard as a mode: who may enter when, what each setpoint makes of the boat, silence, the fence."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from companion.config.vessel import VesselConfig, find, load
from companion.core.decision import ModeId, Result
from companion.core.frames import body_to_ned
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, PoseSetpoint, WrenchSetpoint
from companion.modes.parts.offboard_target import OffboardTarget
from tests.unit.conftest import Boat
from tests.unit.fence.test_guard import fence

FORWARD = OffboardTarget(velocity=(0.3, 0.0), yaw_rad=0.0)


def stream(boat: Boat, target: OffboardTarget, duration_s: float) -> None:
    for _ in range(max(1, round(duration_s / 0.1))):
        boat.supervisor.offboard_setpoint(target, boat.now_s)
        boat.tick()


def steered(boat: Boat, target: OffboardTarget, duration_s: float = 0.1) -> Any:
    """Armed and in Offboard, as MAVSDK does it: arm, stream, then choose the mode."""
    boat.station = False
    assert boat.supervisor.arm(boat.now_s, force=True).accepted
    assert boat.supervisor.offboard_setpoint(target, boat.now_s) is None
    assert boat.supervisor.request_mode(ModeId.OFFBOARD, boat.now_s).accepted
    stream(boat, target, duration_s)
    return boat


@pytest.fixture
def jet(make_boat: Callable[..., Boat]) -> Any:
    config = load(find("rescuerunner"))
    return make_boat(config, **config.parameters)


@pytest.fixture
def no_sway(make_boat: Callable[..., Boat], revolt: VesselConfig) -> Any:
    """Goes astern, but not sideways."""
    return make_boat(replace(revolt, limits=replace(revolt.limits, sway_n=0.0)))


# --- entering, silence -----------------------------------------------------------------------------------------------


def test_it_is_refused_without_a_fresh_setpoint_and_entered_with_one(boat: Boat) -> None:
    assert boat.supervisor.arm(boat.now_s).accepted
    assert "no setpoint yet: stream first" in boat.supervisor.request_mode(ModeId.OFFBOARD, boat.now_s).reason
    stream(boat, FORWARD, 1.0)
    boat.step(1.0)
    outcome = boat.supervisor.request_mode(ModeId.OFFBOARD, boat.now_s)
    assert outcome.result is Result.TEMPORARILY_REJECTED and outcome.reason == "Offboard refused: no setpoint for 1.1 s"
    stream(boat, FORWARD, 0.1)
    assert boat.supervisor.request_mode(ModeId.OFFBOARD, boat.now_s).accepted
    assert boat.status.mode is ModeId.MANUAL and not isinstance(boat.setpoint, PoseSetpoint), (
        "setpoints alone move nothing"
    )
    boat.tick()
    assert boat.status.mode is ModeId.OFFBOARD and isinstance(boat.setpoint, PoseSetpoint)


def test_chosen_disarmed_it_waits_for_arming_which_needs_setpoints_too(boat: Boat) -> None:
    stream(boat, FORWARD, 0.2)
    assert boat.supervisor.request_mode(ModeId.OFFBOARD, boat.now_s).accepted
    stream(boat, FORWARD, 2.0)
    assert isinstance(boat.setpoint, NeutralSetpoint) and not boat.status.armed
    boat.step(2.0)
    assert "Offboard: no setpoint for" in boat.supervisor.arm(boat.now_s).reason
    stream(boat, FORWARD, 0.1)
    assert boat.supervisor.arm(boat.now_s).accepted


@pytest.mark.parametrize(("action", "mode"), [(1, ModeId.HOLD), (2, ModeId.RTL), (3, ModeId.OFFBOARD)])
def test_silence_falls_back_within_a_second(make_boat: Callable[..., Boat], action: int, mode: ModeId) -> None:
    boat = steered(make_boat(OFFB_LOSS_ACT=action), FORWARD, 30.0)
    last_s = boat.now_s - 0.1
    boat.until(lambda: "offboard_lost" in boat.names(), 2.0)
    assert boat.now_s - last_s <= 1.0 and boat.status.mode is mode
    assert "offboard_lost" in boat.status.failsafes
    assert (isinstance(boat.setpoint, NeutralSetpoint)) == (action == 3)
    boat.step(3.0)
    stream(boat, FORWARD, 2.0)
    assert "Offboard setpoints are back" in boat.texts() and boat.status.failsafes == ()
    assert boat.status.mode is mode, "it goes back only when it is chosen again"
    assert (
        (isinstance(boat.setpoint, PoseSetpoint) and boat.setpoint.surge_mps > 0.0)
        or action == 2
        or mode is ModeId.HOLD
    )
    assert boat.supervisor.request_mode(ModeId.OFFBOARD, boat.now_s).accepted


@pytest.mark.parametrize(("limits", "text"), [((5.0, None), "limit of 5 s"), ((None, 1.0), "limit of 1 m")])
@pytest.mark.parametrize(("action", "mode"), [(1, ModeId.HOLD), (3, ModeId.OFFBOARD)])
def test_a_limit_of_the_stay_acts_as_the_loss_does(
    make_boat: Callable[..., Boat], limits: tuple[float | None, float | None], text: str, action: int, mode: ModeId
) -> None:
    boat = make_boat(OFFB_LOSS_ACT=action)
    assert boat.supervisor.limit_offboard(*limits).accepted
    steered(boat, FORWARD, 2.0)
    assert boat.status.failsafes == () and not isinstance(boat.setpoint, NeutralSetpoint)
    boat.nav = replace(boat.nav, north_m=1.5)
    stream(boat, FORWARD, 4.0)
    assert boat.status.mode is mode and any(f"{text} reached" in one for one in boat.texts()), boat.texts()
    assert isinstance(boat.setpoint, NeutralSetpoint) is (action == 3)
    stream(boat, FORWARD, 4.0)
    assert "offboard_lost" in boat.status.failsafes, "the stream goes on, the stay is over"
    assert boat.supervisor.request_mode(ModeId.OFFBOARD, boat.now_s).accepted
    boat.nav = replace(boat.nav, north_m=30.0)
    stream(boat, FORWARD, 20.0)
    assert boat.status.mode is ModeId.OFFBOARD and boat.status.failsafes == (), "a new stay has no limits"


def test_a_moment_in_neutral_begins_no_new_stay(boat: Boat) -> None:
    assert boat.supervisor.limit_offboard(20.0, None).accepted
    steered(boat, FORWARD, 10.0)
    boat.silent = {device.name for device in boat.config.actuators}
    stream(boat, FORWARD, 4.0)
    assert isinstance(boat.setpoint, NeutralSetpoint)
    boat.silent = set()
    stream(boat, FORWARD, 3.0)
    assert isinstance(boat.setpoint, PoseSetpoint) and boat.status.mode is ModeId.OFFBOARD
    stream(boat, FORWARD, 5.0)
    assert any("limit of 20 s reached" in text for text in boat.texts()) and boat.status.mode is ModeId.HOLD


def test_the_stream_stands_for_a_ground_station(boat: Boat) -> None:
    steered(boat, FORWARD, 40.0)
    assert boat.status.mode is ModeId.OFFBOARD and boat.status.failsafes == ()
    boat.step(14.0)
    assert boat.status.mode is ModeId.HOLD and "station_lost" in boat.status.failsafes


def test_a_boat_that_lost_its_position_falls_back_as_any_mode_does(boat: Boat) -> None:
    steered(boat, FORWARD, 5.0)
    boat.nav = replace(boat.nav, position_valid=False)
    stream(boat, FORWARD, 0.5)
    assert "position_lost" in boat.status.failsafes and isinstance(boat.setpoint, NeutralSetpoint)


# --- by dynamic positioning ------------------------------------------------------------------------------------------


def test_a_point_is_gone_to_and_held_with_its_heading(boat: Boat) -> None:
    steered(boat, OffboardTarget((4.0, -3.0), yaw_rad=1.0), 120.0)
    assert boat.away_m(4.0, -3.0) < 0.01 and boat.nav.yaw_rad == pytest.approx(1.0, abs=0.01)
    stream(boat, OffboardTarget((4.0, -2.0)), 60.0)
    assert boat.away_m(4.0, -2.0) < 0.01 and boat.nav.yaw_rad == pytest.approx(1.0, abs=0.01), (
        "no heading asked for: the one held"
    )


def test_a_far_point_is_sailed_to_bow_first_as_in_hold(boat: Boat) -> None:
    steered(boat, OffboardTarget((40.0, 0.0), yaw_rad=0.5), 5.0)
    assert isinstance(boat.setpoint, PathSetpoint)
    stream(boat, OffboardTarget((40.0, 0.0), yaw_rad=0.5), 150.0)
    assert boat.away_m(40.0, 0.0) < 0.01 and boat.nav.yaw_rad == pytest.approx(0.5, abs=0.01)


def test_a_point_that_wanders_under_way_is_met_in_the_end(boat: Boat) -> None:
    steered(boat, OffboardTarget((30.0, 0.0)), 5.0)
    for i in range(200):
        stream(boat, OffboardTarget((30.0, 0.05 * i)), 0.1)
    stream(boat, OffboardTarget((30.0, 9.95)), 150.0)
    assert boat.away_m(30.0, 9.95) < 0.01


def test_along_the_hull_from_where_the_boat_is(boat: Boat) -> None:
    """MAVProxy's `guided forward 3`: the point is where the bow pointed when it came."""
    boat.nav = replace(boat.nav, yaw_rad=math.radians(90.0))
    boat.step()
    ahead = OffboardTarget((3.0, 1.0), yaw_rad=0.25, body=True, offset=True)
    boat.parameters.set("OFFB_TIMEOUT", 60.0)
    steered(boat, ahead)
    boat.station = True
    boat.step(50.0)
    assert boat.away_m(-1.0, 3.0) < 0.02 and boat.nav.yaw_rad == pytest.approx(math.radians(90.0) + 0.25, abs=0.01)


@pytest.mark.parametrize(
    ("target", "velocity"),
    [
        (OffboardTarget(velocity=(0.2, 0.05), yaw_rad=0.0), (0.2, 0.05)),
        (OffboardTarget(velocity=(0.3, -0.4)), (0.3, -0.4)),
        (OffboardTarget(velocity=(0.25, 0.05), body=True, offset=True), (0.25, 0.05)),
        (OffboardTarget(velocity=(9.0, 0.0), yaw_rad=0.0), (1.0, 0.0)),
        (OffboardTarget(acceleration=(0.01, 0.0)), (0.4, 0.0)),
    ],
)
def test_velocities_over_ground(boat: Boat, target: OffboardTarget, velocity: tuple[float, float]) -> None:
    steered(boat, target, 40.0 if target.acceleration else 90.0)
    assert (boat.nav.north_mps, boat.nav.east_mps) == pytest.approx(velocity, abs=0.02)
    assert isinstance(boat.setpoint, PoseSetpoint)


def test_no_number_as_heading_keeps_it(boat: Boat) -> None:
    boat.nav = replace(boat.nav, yaw_rad=1.0)
    boat.step()
    steered(boat, OffboardTarget(velocity=(0.0, 0.05), keeps_yaw=True), 40.0)
    assert boat.nav.yaw_rad == pytest.approx(1.0, abs=0.01) and boat.nav.east_mps == pytest.approx(0.05, abs=0.01)


def test_a_heading_alone_turns_where_it_is(boat: Boat) -> None:
    steered(boat, OffboardTarget(yaw_rad=-2.0), 90.0)
    assert boat.nav.yaw_rad == pytest.approx(-2.0, abs=0.01) and boat.away_m(0.0, 0.0) < 0.01


def test_a_point_with_a_velocity_goes_on_by_it(boat: Boat) -> None:
    steered(boat, OffboardTarget((2.0, 0.0), (0.2, 0.0), yaw_rad=0.0))
    start_s = boat.now_s
    for _ in range(900):
        stream(boat, OffboardTarget((2.0 + 0.2 * (boat.now_s - start_s), 0.0), (0.2, 0.0), yaw_rad=0.0), 0.1)
    assert boat.nav.north_mps == pytest.approx(0.2, abs=0.01)
    assert boat.nav.north_m == pytest.approx(2.0 + 0.2 * (boat.now_s - start_s), abs=0.25)


def test_from_velocity_to_point_and_back_without_a_jump(boat: Boat) -> None:
    steered(boat, FORWARD, 30.0)
    for target in (
        OffboardTarget((14.0, 0.0), yaw_rad=0.0),
        FORWARD,
        OffboardTarget(yaw_rad=0.5),
        OffboardTarget((60.0, 3.0)),
        FORWARD,
    ):
        for _ in range(60):
            before = boat.nav
            stream(boat, target, 0.1)
            assert math.dist((before.north_m, before.east_m), (boat.nav.north_m, boat.nav.east_m)) < 0.1
    assert boat.status.mode is ModeId.OFFBOARD and "mode_failed" not in boat.names()


# --- where it cannot push itself sideways ----------------------------------------------------------------------------


def test_a_jet_sails_velocities_as_course_and_speed(jet: Any) -> None:
    steered(jet, OffboardTarget(velocity=(3.0, 4.0), yaw_rad=0.0), 60.0)
    assert isinstance(jet.setpoint, PathSetpoint)
    assert (jet.nav.north_mps, jet.nav.east_mps) == pytest.approx((3.0, 4.0), abs=0.05)
    stream(jet, OffboardTarget(velocity=(0.0, 0.0), yaw_rad=0.0), 20.0)
    assert isinstance(jet.setpoint, WrenchSetpoint) and jet.setpoint.wrench.surge_n == 0.0


def test_a_jet_goes_to_a_point_and_stays_as_in_hold(jet: Any) -> None:
    steered(jet, OffboardTarget((120.0, 0.0), (0.0, 0.0)), 60.0)
    assert jet.nav.north_m > 60.0
    stream(jet, OffboardTarget((0.0, 0.0), yaw_rate_radps=0.1), 1.0)
    assert isinstance(jet.setpoint, PathSetpoint) and jet.setpoint.progress.target.north_m == pytest.approx(
        0.0, abs=1e-6
    )


def test_a_jet_takes_a_point_with_no_velocity_for_the_point(jet: Any) -> None:
    point = OffboardTarget((120.0, 0.0), (0.0, 0.0), yaw_rad=0.0)
    steered(jet, point, 200.0)
    jet.nav, jet.pinned = replace(jet.nav, north_m=120.0, east_m=-5.0), True
    stream(jet, point, 20.0)
    assert isinstance(jet.setpoint, WrenchSetpoint), "inside its watch circle it drifts"
    stream(jet, OffboardTarget((120.0, 0.0), (0.5, 0.0), yaw_rad=0.0), 1.0)
    assert isinstance(jet.setpoint, PathSetpoint)


def test_along_the_hull_of_a_boat_without_sideways_thrust(no_sway: Any) -> None:
    rate = math.radians(5.0)
    steered(no_sway, OffboardTarget(velocity=(0.4, 0.3), yaw_rate_radps=rate, body=True, offset=True), 30.0)
    assert no_sway.setpoint.surge_mps == pytest.approx(0.4) and no_sway.setpoint.sway_mps == 0.0
    before = no_sway.nav.yaw_rad
    stream(no_sway, OffboardTarget(velocity=(0.4, 0.3), yaw_rate_radps=rate, body=True, offset=True), 4.0)
    assert math.remainder(no_sway.nav.yaw_rad - before, math.tau) == pytest.approx(4.0 * rate, abs=1e-3)
    stream(no_sway, OffboardTarget(velocity=(-0.5, 0.0), body=True, offset=True), 20.0)
    assert no_sway.setpoint.surge_mps == pytest.approx(-no_sway.parameters["DP_SPEED_ASTERN"])
    stream(no_sway, OffboardTarget(acceleration=(0.0, -0.02)), 60.0)
    assert no_sway.nav.east_mps < -0.3


# --- fence, speed ----------------------------------------------------------------------------------------------------


def test_points_outside_the_fence_are_refused_and_the_boat_falls_back(boat: Boat) -> None:
    fence(boat)
    outside = OffboardTarget((60.0, 0.0))
    assert "outside the fence" in (boat.supervisor.offboard_setpoint(outside, boat.now_s) or "")
    steered(boat, OffboardTarget((5.0, 0.0)), 5.0)
    stream(boat, outside, 2.0)
    assert boat.status.mode is ModeId.HOLD
    assert any(text.startswith("Offboard: setpoints refused: point outside the fence") for text in boat.texts())
    assert boat.supervisor.offboard_setpoint(OffboardTarget((0.0, 1e9)), boat.now_s).endswith("km away")


@pytest.mark.parametrize("speed", [0.3, 1.0])
@pytest.mark.parametrize("body", [False, True])
def test_velocities_stop_inside_the_fence(boat: Boat, speed: float, body: bool) -> None:
    fence(boat)  # 50 m either way
    target = OffboardTarget(velocity=(speed, 0.0), yaw_rad=None if body else 0.0, body=body, offset=body)
    steered(boat, target, 60.0 + 60.0 / speed)
    assert 45.0 < boat.nav.north_m <= 48.05 and abs(boat.nav.north_mps) < 0.01
    assert boat.status.mode is ModeId.OFFBOARD and boat.status.failsafes == ()
    stream(boat, OffboardTarget(velocity=(-speed, 0.0), yaw_rad=0.0), 30.0)
    assert boat.nav.north_m < 47.0


def test_a_jet_stops_ahead_of_the_fence(jet: Any) -> None:
    """Boats that keep no place by velocities went on at their least speed, over the line."""
    fence(jet, inside=([(200.0, -200.0), (200.0, 200.0), (-200.0, 200.0), (-200.0, -200.0)],))
    ahead = OffboardTarget(velocity=(8.0, 0.0))
    steered(jet, ahead, 20.0)
    fast = jet.setpoint.surge_mps
    stream(jet, ahead, 100.0)
    assert jet.setpoint.surge_mps < 0.1 * fast and "fence_slowed" in jet.names()
    kept_m = 0.5 * jet.config.length_m + jet.parameters["FENCE_MARGIN"]
    assert 100.0 < jet.nav.north_m < 200.1 - kept_m
    jet.nav = replace(jet.nav, north_m=200.5 - kept_m, north_mps=0.3)  # wind from astern
    stream(jet, ahead, 0.3)
    assert jet.status.mode is ModeId.HOLD


def test_a_fence_uploaded_under_way_counts_for_the_point_already_asked_for(boat: Boat) -> None:
    steered(boat, OffboardTarget((80.0, 0.0)), 5.0)
    fence(boat)
    stream(boat, OffboardTarget((80.0, 0.0)), 1.5)
    assert boat.status.mode is ModeId.HOLD


def test_what_telemetry_shows_is_what_is_done(boat: Boat) -> None:
    """Not what was asked for: that may be more than the boat may do."""
    steered(boat, OffboardTarget(velocity=(9.0, 0.0), yaw_rad=0.0), 3.0)
    north_mps, _ = body_to_ned(boat.setpoint.surge_mps, boat.setpoint.sway_mps, boat.setpoint.yaw_rad)
    assert 0.0 < north_mps < 0.4 and boat.setpoint.surge_mps2 <= boat.parameters["DP_ACC_SURGE"] + 1e-9
