"""The mission's tasks as the boat carries them out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import astuple, replace
from typing import Any

import pytest

from companion.core.decision import MissionState, ModeId, Severity
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, Point, PoseSetpoint
from companion.mission.plan import PlanItem, PlanKind
from companion.modes.parts.turn import TurnPlan
from tests.laid_paths import followers_started
from tests.unit.conftest import Boat


def item(command: int, *params: float, x: int = 0, y: int = 0, frame: int = 2) -> PlanItem:
    p = (*params, *(0.0 for _ in range(4 - len(params))))
    return PlanItem(0, command, frame, p[0], p[1], p[2], p[3], x, y, 0.0)


def start(boat: Boat) -> None:
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()


def finish(boat: Boat) -> None:
    boat.until(lambda: boat.status.mission.state is MissionState.COMPLETE)


def test_path_is_not_laid_again_while_its_rest_is_sailed(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    laid = followers_started(monkeypatch)
    boat.upload((20.0, 0.0), (20.0, 20.0), (0.0, 20.0))
    start(boat)
    boat.until(lambda: boat.status.mission.seq == 1)
    boat.upload((20.0, 0.0), (20.0, 20.0), (0.0, 20.0))  # the same again: nothing changes
    finish(boat)
    assert len(laid) == 1 and boat.status.mission.reached == 3
    assert boat.texts().count("Mission item 1 reached") == 1


def test_a_waypoint_that_is_passed_far_off_is_not_called_reached(boat: Boat) -> None:
    boat.upload((20.0, 0.0), (40.0, 0.0))
    start(boat)
    while boat.status.mission.reached < 1:
        boat.nav = replace(boat.nav, east_m=9.0)  # a stream that carries it off
        boat.step()
    assert "Mission item 1 passed 9 m off" in boat.texts()
    assert boat.severities["item_reached"] is Severity.WARNING


def test_replaced_under_way(boat: Boat) -> None:
    boat.upload((20.0, 0.0), (20.0, 20.0), (0.0, 20.0))
    start(boat)
    boat.until(lambda: boat.status.mission.seq == 1)
    boat.upload((20.0, 0.0), (20.0, 20.0), (40.0, 20.0))
    boat.step()
    assert boat.status.mission.seq == 1 and "New mission goes on at item 2" in boat.texts()
    boat.upload((0.0, -20.0), (0.0, -40.0))
    boat.step()
    assert boat.status.mission.seq == 0 and "New mission begins at its first item" in boat.texts()
    assert boat.setpoint.progress.target.east_m == pytest.approx(-20.0, abs=0.01)
    finish(boat)
    assert boat.away_m(0.0, -40.0) < 1.5


def test_cleared_under_way_holds(boat: Boat) -> None:
    boat.upload((20.0, 0.0), (20.0, 20.0))
    start(boat)
    boat.step(10.0)
    boat.upload()
    boat.step(0.2)
    assert boat.status.mode is ModeId.HOLD and "Mission cleared" in boat.texts()
    boat.step(20.0)
    assert boat.away_m(0.0, 0.0) < 12.0


@pytest.mark.parametrize(("action", "mode"), [(1, ModeId.HOLD), (2, ModeId.RTL), (3, ModeId.MISSION)])
def test_what_comes_after_the_last_item(make_boat: Callable[..., Boat], action: int, mode: ModeId) -> None:
    boat = make_boat(MIS_DONE_ACT=action)
    boat.upload((10.0, 0.0))
    start(boat)
    finish(boat)
    boat.step()
    assert boat.status.mode is mode and boat.status.armed
    assert (isinstance(boat.setpoint, NeutralSetpoint)) == (action == 3)
    if action == 3:
        assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
        boat.step()
        assert boat.status.mission.state is MissionState.ACTIVE


def test_waypoint_with_a_hold_stays_that_long(boat: Boat) -> None:
    lat, lon = boat.point(10.0, 0.0)
    boat.upload((10.0, 10.0), commands={0: item(16, 12.0, x=round(lat * 1e7), y=round(lon * 1e7), frame=3)})
    start(boat)
    boat.until(lambda: boat.status.mission.reached == 1)
    arrived_s = boat.now_s
    assert boat.away_m(10.0, 0.0) < 1.5
    boat.step(11.0)
    assert boat.status.mission.seq == 0 and isinstance(boat.setpoint, PoseSetpoint)
    boat.until(lambda: boat.status.mission.seq == 1)
    assert 11.9 < boat.now_s - arrived_s < 13.0
    finish(boat)


@pytest.mark.parametrize("hold_s", [0.0, 3.0])
def test_a_heading_is_taken_up_before_the_mission_goes_on(boat: Boat, hold_s: float) -> None:
    lat, lon = boat.point(10.0, 0.0)
    heading = item(16, hold_s, 0.0, 0.0, 90.0, x=round(lat * 1e7), y=round(lon * 1e7), frame=3)
    boat.upload((30.0, 0.0), commands={0: heading})
    start(boat)
    boat.until(lambda: boat.status.mission.seq == 1)
    assert math.degrees(boat.nav.yaw_rad) == pytest.approx(90.0, abs=3.0)  # it turns back in the same tick
    assert boat.away_m(10.0, 0.0) < 0.5
    finish(boat)


def test_delay(boat: Boat) -> None:
    boat.upload((10.0, 0.0), (10.0, 10.0), commands={1: item(93, 20.0, -1.0, -1.0, -1.0)})
    start(boat)
    boat.until(lambda: boat.status.mission.seq == 1)
    began_s = boat.now_s
    boat.until(lambda: boat.status.mission.seq == 2)
    assert 20.0 <= boat.now_s - began_s < 30.0
    finish(boat)


def test_turn_on_the_spot_the_long_way(boat: Boat) -> None:
    boat.upload((10.0, 0.0), (20.0, 0.0), commands={1: item(115, 90.0, 0.0, -1.0, 0.0)})
    start(boat)
    boat.until(lambda: boat.status.mission.seq == 1 and isinstance(boat.setpoint, PoseSetpoint))
    turned, last = 0.0, boat.nav.yaw_rad
    while boat.status.mission.seq == 1:
        boat.step()
        if isinstance(boat.setpoint, PoseSetpoint):
            turned += math.remainder(boat.nav.yaw_rad - last, 2.0 * math.pi)
            last = boat.nav.yaw_rad
        assert boat.now_s < 600.0
    assert turned == pytest.approx(-1.5 * math.pi, abs=0.1)
    finish(boat)


def test_return_item(boat: Boat) -> None:
    boat.upload((20.0, 0.0), commands={1: item(20)})
    start(boat)
    finish(boat)
    assert boat.away_m(0.0, 0.0) < 0.2 and boat.status.mission.reached == 2


def test_speed_and_home_items(boat: Boat) -> None:
    lat, lon = boat.point(5.0, 5.0)
    boat.upload(
        (40.0, 0.0),
        commands={0: item(178, 1.0, 0.3), 1: item(179, 0.0, x=round(lat * 1e7), y=round(lon * 1e7), frame=0)},
    )
    start(boat)
    boat.step(30.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.3, abs=0.01)
    assert boat.status.home.lat_deg == pytest.approx(lat, abs=1e-6)


def test_after_neutral_it_goes_on_to_the_next_point_and_not_back_to_the_first(boat: Boat) -> None:
    """A boat that had no heading for a moment sailed back to where its route had begun."""
    boat.upload((20.0, 0.0), (20.0, 20.0), (0.0, 20.0))
    start(boat)
    boat.until(lambda: boat.status.mission.reached == 2)
    boat.step(5.0)
    boat.nav = replace(boat.nav, heading_valid=False)
    boat.step(3.0)
    assert isinstance(boat.setpoint, NeutralSetpoint)
    boat.nav = replace(boat.nav, heading_valid=True)
    boat.step(0.5)
    assert boat.status.mode is ModeId.MISSION
    assert boat.setpoint.progress.target == Point(pytest.approx(0.0, abs=0.01), pytest.approx(20.0, abs=0.01))
    finish(boat)


def test_pause_in_a_stay_goes_back_to_its_point(boat: Boat) -> None:
    lat, lon = boat.point(10.0, 0.0)
    boat.upload(commands={0: item(19, 30.0, x=round(lat * 1e7), y=round(lon * 1e7), frame=3)})
    start(boat)
    boat.until(lambda: isinstance(boat.setpoint, PoseSetpoint))
    boat.step(5.0)
    boat.supervisor.go_to(*boat.point(30.0, 0.0), None, None, boat.now_s)
    boat.until(lambda: boat.away_m(30.0, 0.0) < 0.1)
    boat.supervisor.resume(boat.now_s)
    finish(boat)
    assert boat.away_m(10.0, 0.0) < 1.6


@pytest.mark.parametrize(
    ("start_deg", "yaw_deg", "relative", "direction", "expected_deg"),
    [
        (0, 90, False, 0, 90),
        (0, 90, False, -1, -270),
        (170, -170, False, 0, 20),
        (0, 300, True, 1, 300),
        (0, 45, True, -1, -45),
        (10, 350, False, 1, 340),
    ],
)
def test_turn_plan(start_deg: float, yaw_deg: float, relative: bool, direction: int, expected_deg: float) -> None:
    yaw = math.radians(start_deg)
    plan = TurnPlan(yaw, math.radians(yaw_deg), relative, direction)
    turned = 0.0
    for _ in range(1000):
        step = math.remainder(plan.update(yaw) - yaw, 2.0 * math.pi)
        step = max(-0.05, min(0.05, step))
        yaw += step
        turned += step
    assert math.degrees(turned) == pytest.approx(expected_deg, abs=1e-6)


def test_survey_transects_are_sailed_straight(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    laid = followers_started(monkeypatch)
    boat.parameters.set("PATH_KIND", 3)
    boat.upload(
        (10.0, 10.0),
        (10.0, 60.0),
        (20.0, 60.0),
        (20.0, 10.0),
        commands={1: item(206, 5.0), 3: item(206, 0.0), 5: item(206, 5.0)},
    )
    start(boat)
    ((_, waypoints),) = laid
    assert [w.straight for w in waypoints] == [False, True, False, True]
    boat.until(lambda: boat.nav.east_m > 20.0)
    off = []
    boat.until(lambda: off.append(abs(boat.nav.north_m - 10.0)) or boat.nav.east_m > 55.0)
    assert max(off) < 0.3


def test_a_route_in_sections_goes_on_without_a_jump(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("companion.mission.itinerary.LONGEST_ROUTE", 3)
    boat.upload(*((12.0 * n, 6.0 * (n % 2)) for n in range(1, 8)))
    start(boat)
    yaws, places = [], []

    def asked() -> bool:
        if isinstance(boat.setpoint, PathSetpoint):
            yaws.append(boat.setpoint.yaw_rad)
            places.append(astuple(boat.setpoint.progress.place))
        return boat.status.mission.state is MissionState.COMPLETE

    boat.until(asked)
    assert boat.status.mission.reached == 7
    assert max(abs(math.remainder(b - a, 2.0 * math.pi)) for a, b in itertools.pairwise(yaws)) < math.radians(1.3)
    assert max(math.dist(a, b) for a, b in itertools.pairwise(places)) < 0.15


def orbit(boat: Any, north_m: float, east_m: float, turns: float, radius_m: float, leave: float = 0.0) -> PlanItem:
    lat_deg, lon_deg = boat.point(north_m, east_m)
    return item(18, turns, leave, radius_m, 1.0, x=round(lat_deg * 1e7), y=round(lon_deg * 1e7), frame=3)


def bearings_about(boat: Any, north_m: float, east_m: float, until: Any) -> tuple[float, list[float]]:
    """(angle swept clockwise while item 1 is current, distances from the point in the last 10 s of it)."""
    swept, last, distances = 0.0, None, []
    while not until():
        boat.step()
        bearing = math.atan2(boat.nav.east_m - east_m, boat.nav.north_m - north_m)
        if last is not None:
            swept += math.remainder(bearing - last, 2.0 * math.pi)
        last = bearing
        distances.append(boat.away_m(north_m, east_m))
    return swept, distances[-100:]


@pytest.mark.parametrize(("radius_m", "sign"), [(8.0, 1.0), (-8.0, -1.0)])
def test_a_point_is_orbited_and_the_mission_goes_on(boat: Any, radius_m: float, sign: float) -> None:
    boat.upload((15.0, 0.0), (0.0, 40.0), commands={1: orbit(boat, 30.0, 20.0, 2.0, radius_m)})
    start(boat)
    boat.until(lambda: boat.status.mission.seq == 1)
    speed_mps = math.hypot(boat.nav.surge_mps, boat.nav.sway_mps)
    assert speed_mps > 0.3  # it does not stop before the circle
    swept, distances = bearings_about(boat, 30.0, 20.0, lambda: boat.status.mission.seq != 1)
    assert 2.0 * 2.0 * math.pi <= sign * swept < 2.75 * 2.0 * math.pi
    assert max(abs(distance - 8.0) for distance in distances) < 0.1
    assert "Mission item 2 reached" in boat.texts() and boat.status.orbit is None
    finish(boat)
    assert boat.away_m(0.0, 40.0) < 1.5


def test_the_orbit_is_left_towards_the_next_item(boat: Any) -> None:
    boat.upload((15.0, 0.0), (60.0, 60.0), commands={1: orbit(boat, 30.0, 20.0, 1.0, 8.0, leave=1.0)})
    start(boat)
    boat.until(lambda: boat.status.mission.seq == 2)
    to_next = math.atan2(60.0 - boat.nav.east_m, 60.0 - boat.nav.north_m)
    assert abs(math.remainder(boat.nav.yaw_rad - to_next, 2.0 * math.pi)) < 0.2


def test_an_orbit_at_the_end_leaves_the_boat_holding(boat: Any) -> None:
    boat.upload((15.0, 0.0), commands={1: orbit(boat, 30.0, 20.0, 1.0, 8.0)})
    start(boat)
    finish(boat)
    boat.step(20.0)
    assert boat.status.mode is ModeId.HOLD and abs(boat.away_m(30.0, 20.0) - 8.0) < 3.0


def test_a_paused_orbit_begins_anew(boat: Any) -> None:
    boat.upload((15.0, 0.0), commands={1: orbit(boat, 30.0, 20.0, 1.0, 8.0)})
    start(boat)
    boat.until(lambda: boat.status.mission.seq == 1)
    boat.step(40.0)
    assert boat.supervisor.pause(boat.now_s).accepted
    boat.step(20.0)
    assert boat.supervisor.resume(boat.now_s).accepted
    swept, _ = bearings_about(boat, 30.0, 20.0, lambda: boat.status.mission.state is MissionState.COMPLETE)
    assert swept >= 2.0 * math.pi


def test_a_mission_whose_orbit_leaves_the_fence_is_refused(boat: Any) -> None:
    corners = ((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0))
    zones = []
    for seq, corner in enumerate(corners):
        lat_deg, lon_deg = boat.point(*corner)
        zones.append(PlanItem(seq, 5001, 0, 4.0, 0.0, 0.0, 0.0, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0))
    boat.plans.replace(PlanKind.FENCE, zones)
    boat.upload((15.0, 0.0), commands={1: orbit(boat, 35.0, 20.0, 1.0, 18.0)})
    outcome = boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    assert outcome.reason == "Mission refused: item 2: way crosses the fence"
    boat.upload((15.0, 0.0), commands={1: orbit(boat, 25.0, 20.0, 1.0, 18.0)})
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
