"""The fence in force: what it refuses, where it leads, and what happens at its line."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from shapely.geometry import LineString, Point, Polygon

from companion.config.vessel import find, load
from companion.core.decision import MissionState, ModeId, Result
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, ThrusterSetpoint
from companion.guidance.stern_first import turned
from companion.mission.plan import PlanItem, PlanKind
from tests.unit.conftest import Boat

Place = tuple[float, float]
BOX: tuple[Place, ...] = ((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0))
WALL: tuple[Place, ...] = ((18.0, -20.0), (22.0, -20.0), (22.0, 20.0), (18.0, 20.0))  # between home and the north


def fence(
    boat: Boat, inside: Sequence[Sequence[Place]] = (BOX,), outside: Sequence[Sequence[Place]] = (), group: int = 0
) -> None:
    items: list[PlanItem] = []
    for command, polygons in ((5001, inside), (5002, outside)):
        for polygon in polygons:
            for place in polygon:
                lat_deg, lon_deg = boat.point(*place)
                items.append(
                    PlanItem(
                        len(items),
                        command,
                        0,
                        float(len(polygon)),
                        float(group),
                        0.0,
                        0.0,
                        round(lat_deg * 1e7),
                        round(lon_deg * 1e7),
                        0.0,
                    )
                )
    boat.plans.replace(PlanKind.FENCE, items)


def at(
    boat: Boat, north_m: float, east_m: float, north_mps: float = 0.0, east_mps: float = 0.0, yaw_rad: float = 0.0
) -> None:
    """Put the boat there."""
    lat_deg, lon_deg = boat.point(north_m, east_m)
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    boat.nav = replace(
        boat.nav,
        north_m=north_m,
        east_m=east_m,
        lat_deg=lat_deg,
        lon_deg=lon_deg,
        yaw_rad=yaw_rad,
        north_mps=north_mps,
        east_mps=east_mps,
        surge_mps=c * north_mps + s * east_mps,
        sway_mps=-s * north_mps + c * east_mps,
    )
    if not boat.status.armed:
        boat.step()


def armed_in(boat: Boat, mode: ModeId) -> None:
    if mode in (ModeId.MANUAL, ModeId.FORCES, ModeId.HEADING):
        boat.sticks = (0.0, 0.0, 0.0)
        boat.step()
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()


def go(boat: Boat, north_m: float, east_m: float) -> Any:
    return boat.supervisor.go_to(*boat.point(north_m, east_m), None, None, boat.now_s)


# --- what is refused -----------------------------------------------------------------------------------------------


def test_go_to_points(boat: Boat) -> None:
    fence(boat, outside=[WALL])
    armed_in(boat, ModeId.HOLD)
    for north_m, east_m, reason in (
        (60.0, 0.0, "outside the fence"),
        (20.0, 0.0, "outside the fence"),
        (49.0, 0.0, "nearer than 2.0 m to the fence"),
        (40.0, 0.0, "crosses the fence"),
        (40.0, 47.0, "way nearer than 2.0 m to the fence"),
    ):
        outcome = go(boat, north_m, east_m)
        assert outcome.result is Result.DENIED and reason in outcome.reason, (north_m, east_m)
    assert boat.status.mode is ModeId.HOLD and not boat.helm.mode.going
    assert boat.supervisor.go_to(math.nan, 10.0, None, None, boat.now_s).result is Result.DENIED
    assert go(boat, -40.0, 30.0).accepted
    boat.plans.replace(PlanKind.FENCE, [])
    assert go(boat, 60.0, 0.0).accepted


def test_nudges(boat: Boat) -> None:
    fence(boat)
    at(boat, 46.0, 0.0)
    armed_in(boat, ModeId.HOLD)
    outcome = boat.supervisor.nudge(3.0, 0.0, 0.0, boat.now_s)
    assert not outcome.accepted and "nearer than 2.0 m to the fence" in outcome.reason
    assert boat.supervisor.nudge(-3.0, 0.0, 0.0, boat.now_s).accepted


def test_a_mission_that_crosses_is_accepted_but_not_started(boat: Boat) -> None:
    boat.parameters.set("MIS_ROUND", 0.0)
    fence(boat, outside=[WALL])
    boat.upload((10.0, 0.0), (10.0, 30.0), (40.0, 30.0), (40.0, -30.0), (10.0, -10.0))
    boat.step(4.0)
    assert any(text.startswith("Check the mission: item 5: way crosses the fence") for text in boat.texts())
    outcome = boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    assert not outcome.accepted and "item 5: way crosses the fence" in outcome.reason
    boat.upload((10.0, 0.0), (10.0, 30.0), (40.0, 30.0), (60.0, 30.0))
    assert "item 4: outside the fence" in boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).reason
    boat.upload((10.0, 0.0), (10.0, 30.0), (40.0, 30.0))
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted


def test_chosen_while_disarmed_a_crossing_mission_is_not_armed(boat: Boat) -> None:
    boat.parameters.set("MIS_ROUND", 0.0)
    boat.upload((10.0, 0.0), (40.0, 0.0))
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    fence(boat, outside=[WALL])
    boat.step()
    assert any("item 2: way crosses the fence" in reason for reason in boat.status.arming_refusals)
    assert not boat.supervisor.arm(boat.now_s, force=True).accepted


def test_the_smooth_path_counts_and_not_the_straight_legs(boat: Boat) -> None:
    """A small obstacle where PCHIP swings out furthest from the straight leg, out of reach of the leg itself."""
    points = ((0.0, 0.0), (200.0, 0.0), (230.0, 200.0), (430.0, 230.0))
    chord = np.concatenate([[0.0], np.cumsum([math.dist(a, b) for a, b in pairwise(points)])])
    curve = PchipInterpolator(chord, np.array(points))(np.linspace(0.0, chord[-1], 2000))
    straight = LineString(points)
    furthest = max(curve.tolist(), key=lambda place: straight.distance(Point(place)))
    assert straight.distance(Point(furthest)) > 4.0
    n, e = furthest
    rock = ((n - 0.5, e - 0.5), (n + 0.5, e - 0.5), (n + 0.5, e + 0.5), (n - 0.5, e + 0.5))
    boat.parameters.set("NAV_ACC_RAD", 3.0)
    fence(boat, inside=(), outside=[rock])
    boat.upload(*points[1:])
    assert "crosses the fence" in boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).reason
    boat.parameters.set("PATH_KIND", 0)
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted


def test_return_items_and_loops_are_checked(boat: Boat) -> None:
    fence(boat, outside=[WALL])
    boat.upload(
        (10.0, 0.0), (10.0, 30.0), (40.0, 30.0), commands={3: PlanItem(3, 20, 2, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0)}
    )
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted, "the way home goes round the wall"
    boat.upload(
        (10.0, 0.0), (10.0, 30.0), (40.0, 30.0), commands={3: PlanItem(3, 177, 2, 0.0, -1.0, 0.0, 0.0, 0, 0, 0.0)}
    )
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted, "each lap goes round the wall"
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.parameters.set("MIS_ROUND", 0.0)
    assert "item 1: way crosses the fence" in boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).reason, (
        "the leg back to the first"
    )


def test_dock_beyond_the_fence(boat: Boat) -> None:
    fence(boat, inside=[((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0))])
    assert "crosses the fence" in boat.supervisor.request_mode(ModeId.DOCK, boat.now_s).reason


# --- ways home -----------------------------------------------------------------------------------------------------


def test_rtl_goes_round_an_exclusion(boat: Boat) -> None:
    fence(boat, outside=[WALL])
    at(boat, 40.0, 3.0)
    armed_in(boat, ModeId.HOLD)
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).accepted
    track: list[Place] = []

    def arrived() -> bool:
        track.append((boat.nav.north_m, boat.nav.east_m))
        return "RTL: at home, holding" in boat.texts()

    boat.until(arrived)
    line = LineString(track)
    assert line.distance(Polygon(WALL)) >= 1.9 and boat.away_m(0.0, 0.0) < 0.5
    assert line.length < 1.15 * LineString([(40.0, 3.0), (24.0, 22.0), (16.0, 22.0), (0.0, 0.0)]).length


def test_rtl_takes_the_shortest_way_and_not_the_nearest_point(boat: Boat) -> None:
    long_wall = ((18.0, -45.0), (22.0, -45.0), (22.0, 45.0), (18.0, 45.0))
    fence(boat, outside=[long_wall])
    boat.upload((32.0, -30.0), kind=PlanKind.RALLY)
    at(boat, 27.0, 0.0)
    armed_in(boat, ModeId.HOLD)
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).accepted
    boat.until(lambda: "RTL: at rally point 1, holding" in boat.texts())


def test_no_way_home_is_announced_and_the_failsafe_holds(boat: Boat) -> None:
    fence(boat, outside=[((18.0, -60.0), (22.0, -60.0), (22.0, 60.0), (18.0, 60.0))])
    at(boat, 40.0, 0.0)
    armed_in(boat, ModeId.HOLD)
    boat.step()
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).reason == "RTL refused: no way home inside the fence"
    boat.parameters.set("NAV_DLL_ACT", 2)
    boat.station = False
    boat.step(12.0)
    assert boat.status.mode is ModeId.HOLD and any(
        "No ground station" in text and "Hold" in text for text in boat.texts()
    )


# --- at the line ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("action", "mode"), [(1, ModeId.FORCES), (2, ModeId.HOLD), (3, ModeId.RTL)])
def test_by_stick_the_action_comes_while_the_boat_can_still_stop(boat: Boat, action: int, mode: ModeId) -> None:
    boat.parameters.set("GF_ACTION", action)
    fence(boat)
    armed_in(boat, ModeId.FORCES)
    for north_m in range(50):
        at(boat, float(north_m), 0.0, north_mps=1.0)
        boat.step()
        if "fence" in boat.status.failsafes:
            break
    assert 38 <= north_m <= 42, "a stop from 1 m/s takes some 7 m, 2 m before the line"
    assert boat.status.mode is mode
    assert any(text.startswith(f"Fence {50 - north_m} m ahead") for text in boat.texts())
    assert boat.status.fence is not None and not boat.status.fence.breached


@pytest.mark.parametrize(("vessel", "speed_mps", "early_m"), [("otter", 2.0, 12.0), ("rescuerunner", 10.0, 75.0)])
def test_without_sideways_thrust_it_comes_as_late_as_hold_can_stop(
    make_boat: Callable[..., Boat], vessel: str, speed_mps: float, early_m: float
) -> None:
    """Hold brakes with all thrust astern, or coasts. The reference of a boat with sideways thrust needs twice the way."""
    boat = make_boat(load(find(vessel)))
    fence(boat, inside=[((-50.0, -100.0), (200.0, -100.0), (200.0, 100.0), (-50.0, 100.0))])
    armed_in(boat, ModeId.FORCES)
    for north_m in range(200):
        at(boat, float(north_m), 0.0, north_mps=speed_mps)
        boat.step()
        if "fence" in boat.status.failsafes:
            break
    margin_m = boat.parameters["FENCE_MARGIN"] + 0.5 * boat.config.length_m
    assert speed_mps < 200.0 - margin_m - north_m < early_m


def test_the_warning_ends_when_the_boat_turns_away(boat: Boat) -> None:
    boat.parameters.set("GF_ACTION", 1)
    fence(boat)
    armed_in(boat, ModeId.MANUAL)
    at(boat, 44.0, 0.0, north_mps=0.8)
    boat.step()
    assert "fence" in boat.status.failsafes
    at(boat, 44.0, 0.0, north_mps=-0.3, yaw_rad=math.pi)
    boat.step()
    assert "fence" not in boat.status.failsafes and "Inside the fence and clear of it" in boat.texts()


def test_a_breach_counts_acts_and_ends_with_hysteresis(boat: Boat) -> None:
    fence(boat)
    armed_in(boat, ModeId.MANUAL)
    at(boat, 50.2, 0.0)
    boat.step()
    assert boat.status.mode is ModeId.HOLD and "Outside the fence: Hold" in boat.texts()
    assert boat.status.fence is not None and (boat.status.fence.breached, boat.status.fence.breaches) == (True, 1)
    assert boat.status.fence.breach_s == boat.now_s
    at(boat, 49.8, 0.0)
    boat.step()
    assert boat.status.fence.breached, "not yet FENCE_MARGIN inside"
    at(boat, 47.0, 0.0)
    boat.step()
    assert not boat.status.fence.breached and boat.status.fence.breaches == 1
    at(boat, 40.0, 0.0)
    boat.step()
    assert "fence" not in boat.status.failsafes


@pytest.mark.parametrize("mode", [ModeId.MANUAL, ModeId.FORCES, ModeId.HEADING])
def test_a_slow_drift_ends_before_the_hull_is_over_the_line(boat: Boat, mode: ModeId) -> None:
    fence(boat)
    armed_in(boat, mode)
    half_m, margin_m = 0.5 * boat.config.length_m, boat.parameters["FENCE_MARGIN"]
    for step in range(400):
        north_m = 46.0 + 0.01 * step
        at(boat, north_m, 0.0, north_mps=0.03)
        boat.step()
        if boat.status.mode is ModeId.HOLD:
            break
    assert 50.0 - half_m - margin_m <= north_m <= 50.0 - half_m + 0.03
    assert "Fence 1 m ahead: Hold" in boat.texts()


def test_a_boat_armed_near_the_line_is_left_to_the_operator_until_it_has_been_inside(boat: Boat) -> None:
    fence(boat)
    at(boat, 49.0, 0.0)
    armed_in(boat, ModeId.MANUAL)
    for north_m in (49.0, 49.1):
        at(boat, north_m, 0.0, north_mps=0.03)
        boat.step()
        assert boat.status.mode is ModeId.MANUAL and not boat.status.failsafes
    at(boat, 47.0, 0.0, north_mps=-0.2)
    boat.step()
    at(boat, 49.0, 0.0)
    boat.step()
    assert boat.status.mode is ModeId.HOLD


def test_an_operator_may_leave_by_manual(boat: Boat) -> None:
    fence(boat)
    armed_in(boat, ModeId.MANUAL)
    at(boat, 44.0, 0.0, north_mps=0.8)
    boat.step()
    assert boat.status.mode is ModeId.HOLD
    assert boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s).accepted
    for north_m in (45.0, 49.0, 52.0, 60.0):
        at(boat, north_m, 0.0, north_mps=0.8)
        boat.step()
        assert boat.status.mode is ModeId.MANUAL and isinstance(boat.setpoint, ThrusterSetpoint)
    assert "Outside the fence" in boat.texts() and boat.status.fence is not None and boat.status.fence.breached


def test_a_fence_that_comes_while_the_boat_is_outside_only_warns(boat: Boat) -> None:
    armed_in(boat, ModeId.MANUAL)
    at(boat, 80.0, 0.0)
    boat.step()
    fence(boat)
    boat.step(1.0)
    assert boat.status.mode is ModeId.MANUAL and not boat.status.failsafes
    assert "Outside the new fence by 30 m: sail back in" in boat.texts()
    assert go(boat, 30.0, 0.0).accepted, "back in is free"
    boat.until(lambda: boat.away_m(30.0, 0.0) < 1.0)
    assert "Inside the fence: enforced from now on" in boat.texts()
    assert not go(boat, 80.0, 0.0).accepted


def test_a_drift_while_disarmed_does_not_stop_the_mode_that_is_armed(boat: Boat) -> None:
    """Disarmed the boat was in Manual, and drifted towards the line. Hold stops by itself."""
    fence(boat)
    boat.step()
    at(boat, 44.0, 0.0, north_mps=0.8)
    boat.nav = replace(boat.nav, north_mps=0.8, surge_mps=0.8)
    armed_in(boat, ModeId.HOLD)
    boat.step(0.5)
    assert boat.status.mode is ModeId.HOLD and "fence" not in boat.names()


def test_disarmed_nothing_is_done(boat: Boat) -> None:
    fence(boat)
    boat.step()
    at(boat, 60.0, 0.0, north_mps=1.0)
    boat.step(1.0)
    assert not boat.status.failsafes and boat.status.fence is not None and boat.status.fence.breached
    assert isinstance(boat.setpoint, NeutralSetpoint)


def test_action_0_switches_the_fence_off(boat: Boat) -> None:
    fence(boat)
    boat.parameters.set("GF_ACTION", 0)
    armed_in(boat, ModeId.HOLD)
    at(boat, 60.0, 0.0)
    boat.step()
    assert boat.status.fence is None and not boat.status.failsafes
    assert go(boat, 80.0, 0.0).accepted
    boat.parameters.set("GF_ACTION", 2)
    boat.step()
    assert boat.status.fence is not None and "Go-to stopped: " in " ".join(boat.texts())


def test_group_0_by_parameter(boat: Boat) -> None:
    fence(boat, inside=[BOX, [(n + 60.0, e) for n, e in BOX]])
    armed_in(boat, ModeId.HOLD)
    assert not go(boat, -10.0, 20.0).accepted
    boat.parameters.set("FENCE_GROUP0", 1)
    assert go(boat, -10.0, 20.0).accepted
    assert go(boat, 100.0, 20.0).accepted


# --- a fence that comes under way ----------------------------------------------------------------------------------


@pytest.mark.parametrize("fence_first", [True, False])
def test_a_mission_leads_round_the_fence(boat: Boat, fence_first: bool) -> None:
    """Its leg crosses a zone that is there at the start, or comes under way: the boat sails round it."""
    if fence_first:
        fence(boat, outside=[WALL])
    boat.upload((10.0, 0.0), (40.0, 0.0))
    armed_in(boat, ModeId.MISSION)
    boat.step(5.0)
    if not fence_first:
        fence(boat, outside=[WALL])
        boat.step()
    areas = boat.fence_guard.areas()
    assert areas is not None and boat.status.mode is ModeId.MISSION
    for _ in range(300):
        boat.step(1.0)
        assert areas.stopping.contains(boat.nav.north_m, boat.nav.east_m)
        if boat.status.mission.state is MissionState.COMPLETE:
            break
    assert boat.status.mission.state is MissionState.COMPLETE and boat.nav.north_m > 37.0


def test_a_mission_under_way_gives_way_to_a_new_fence(boat: Boat) -> None:
    boat.parameters.set("MIS_ROUND", 0.0)
    boat.upload((10.0, 0.0), (40.0, 0.0))
    armed_in(boat, ModeId.MISSION)
    boat.step(5.0)
    fence(boat, outside=[WALL])
    boat.step()
    assert boat.status.mode is ModeId.HOLD and boat.status.intended_mode is ModeId.MISSION
    assert any(text.startswith("Mission stopped: item 2: way crosses the fence") for text in boat.texts())
    assert boat.status.mission.state is MissionState.PAUSED
    boat.step(30.0)
    assert boat.nav.north_m < 16.0
    fence(boat)
    assert boat.supervisor.resume(boat.now_s).accepted


def test_rtl_finds_another_way_when_a_fence_comes(boat: Boat) -> None:
    fence(boat)
    at(boat, 40.0, 0.0)
    armed_in(boat, ModeId.HOLD)
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).accepted
    boat.step(2.0)
    fence(boat, outside=[WALL])
    track: list[Place] = []

    def arrived() -> bool:
        track.append((boat.nav.north_m, boat.nav.east_m))
        return "RTL: at home, holding" in boat.texts()

    boat.until(arrived)
    assert LineString(track).distance(Polygon(WALL)) >= 1.5


def test_pause_at_speed_near_the_line_stops_inside(boat: Boat) -> None:
    """The gentle stop would take 15 m: the reference begins slower, and the feedback brakes."""
    fence(boat)
    at(boat, 42.0, 0.0)
    armed_in(boat, ModeId.HOLD)
    assert go(boat, 42.0, 10.0).accepted
    at(boat, 42.0, 0.0, north_mps=1.0)
    assert boat.supervisor.pause(boat.now_s).accepted
    boat.helm.mode.hold_here(boat.nav)
    north_m, _ = boat.helm.mode.target
    assert 42.0 < north_m <= 48.5


def test_the_stick_in_hold_moves_the_point_as_far_as_the_fence(boat: Boat) -> None:
    fence(boat)
    at(boat, 45.0, 0.0)
    boat.sticks = (0.0, 0.0, 0.0)
    armed_in(boat, ModeId.HOLD)
    boat.step(1.0)
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step(60.0)
    assert 47.0 < boat.nav.north_m <= 48.05
    boat.sticks = (-1.0, 0.0, 0.0)
    boat.step(20.0)
    assert boat.nav.north_m < 47.0, "back in is free"


def test_along_a_path_the_speed_falls_ahead_of_the_line(boat: Boat) -> None:
    """Even for a path that no check has refused, the boat stops before the fence."""
    armed_in(boat, ModeId.HOLD)
    assert go(boat, 60.0, 0.0).accepted
    boat.step(5.0)
    fence(boat)
    boat.overlook_the_fence()
    boat.step(130.0)
    assert 47.0 < boat.nav.north_m < 50.0
    assert boat.status.fence is not None and boat.status.fence.slowed and not boat.status.fence.breached
    assert "Fence ahead: slowing down" in boat.texts()


def test_stern_first_the_boat_brakes_ahead_of_the_line_as_bow_first(boat: Boat) -> None:
    fence(boat)
    armed_in(boat, ModeId.HOLD)
    at(boat, 45.0, 0.0, north_mps=1.0)
    guard, mode, bow_first = boat.fence_guard, boat.helm.mode, boat.nav
    limited = guard.limited(PathSetpoint(0.0, 1.0, surge_mps2=0.1), mode, bow_first, 1.0, boat.now_s)
    assert isinstance(limited, PathSetpoint) and limited.surge_mps < 0.9 and limited.surge_mps2 < 0.0
    asked = PathSetpoint(math.pi, -1.0, surge_mps2=-0.1)
    astern = guard.limited(asked, mode, turned(bow_first), 1.0, boat.now_s)
    assert isinstance(astern, PathSetpoint)
    assert (astern.surge_mps, astern.surge_mps2) == pytest.approx((-limited.surge_mps, -limited.surge_mps2))


@pytest.mark.parametrize("law", [0, 1])
def test_the_line_of_a_law_that_takes_over_under_way_is_checked(boat: Boat, law: int) -> None:
    """From where the boat is, off its path, to the next waypoint: that leads through a zone which the path keeps clear
    of."""
    assert boat.parameters.set("PATH_KIND", 0) is boat.parameters.set("WP_LAW", 1 - law) is None
    fence(boat, outside=[((14.0, -6.0), (22.0, -6.0), (22.0, -2.5), (14.0, -2.5))])
    boat.upload((40.0, 0.0), (40.0, 20.0))
    armed_in(boat, ModeId.MISSION)
    boat.step(10.0)
    at(boat, 10.0, -7.0)
    boat.step()
    assert boat.status.mode is ModeId.MISSION
    assert boat.parameters.set("WP_LAW", law) is None
    boat.step(0.3)
    assert boat.status.mode is ModeId.HOLD
    assert any(text.startswith("Mission stopped: item 1: way") for text in boat.texts())


@pytest.mark.parametrize(
    "broken", [{"yaw_rad": math.inf}, {"surge_mps": math.nan}, {"north_m": math.nan}, {"yaw_rate_radps": math.nan}]
)
def test_an_estimate_that_is_no_number_is_let_through(boat: Boat, broken: dict[str, float]) -> None:
    fence(boat)
    nav = replace(boat.nav, **{"surge_mps": 0.5, **broken})
    assert boat.fence_guard.slowed(nav) is nav


def test_a_guard_that_fails_is_announced_once_and_the_boat_can_still_be_steered(
    boat: Boat, monkeypatch: pytest.MonkeyPatch
) -> None:
    fence(boat)
    armed_in(boat, ModeId.RTL)

    def broken(*_: object) -> None:
        raise ZeroDivisionError("no such thing")

    monkeypatch.setattr(boat.fence_guard, "limited", broken)
    boat.step(3.0)
    assert boat.status.mode is ModeId.HOLD and boat.status.armed
    assert not isinstance(boat.supervisor.guide(boat.nav, boat.now_s, 0.1), NeutralSetpoint)
    assert sum("not guarded" in text for text in boat.texts()) == 1


# --- where a boat holds that drifts ----------------------------------------------------------------------------------


def test_a_boat_that_drifts_in_its_watch_circle_holds_so_far_inside_that_the_circle_is(boat: Boat) -> None:
    """A launch came to rest 10 m before a new fence, held there, and turned round over it."""
    guard = boat.supervisor.parts.fence
    assert guard.held_place((49.0, 0.0)) == (49.0, 0.0), "without a fence"
    fence(boat)
    assert guard.held_place((20.0, 5.0)) == (20.0, 5.0)
    assert guard.held_place((49.5, 5.0)) == pytest.approx((50.0 - guard.kept_m, 5.0), abs=0.01)
    assert guard.held_place((60.0, 5.0)) == (60.0, 5.0), "outside it holds where it is"


def test_in_a_fence_too_small_for_its_margin_it_holds_in_the_middle(boat: Boat) -> None:
    boat.parameters.set("FENCE_MARGIN", 50.0)
    fence(boat)
    at(boat, 0.0, 0.0)
    boat.tick()
    boat.tick()
    assert boat.texts().count("Fence leaves no room beyond FENCE_MARGIN 50 m") == 1
    guard = boat.supervisor.parts.fence
    assert guard.held_place((49.0, 3.0)) == pytest.approx((5.0, 3.0), abs=1.5)
    assert guard.room_about_m((30.0, 0.0)) == pytest.approx(20.0 - 0.5 * boat.config.length_m, abs=0.05)
    assert guard.room_about_m((60.0, 0.0)) == math.inf, "outside"


@pytest.mark.parametrize("by_fence", [True, False])
def test_stopped_by_the_fence_a_boat_holds_with_the_margin_to_spare(boat: Boat, by_fence: bool) -> None:
    """A boat that had come to rest with its bow at the line was pushed over it by waves. An operator who chooses Hold
    there holds there."""
    fence(boat)
    inside_m = 50.0 - boat.fence_guard.kept_m
    at(boat, inside_m + (0.05 if by_fence else 0.4), 5.0)
    armed_in(boat, ModeId.HEADING if by_fence else ModeId.HOLD)
    if by_fence:
        at(boat, inside_m + 0.05, 5.0, north_mps=0.2)
    boat.step(20.0)
    assert boat.status.mode is ModeId.HOLD
    assert boat.setpoint.progress.target.north_m == pytest.approx(inside_m + (0.0 if by_fence else 0.4), abs=0.02)


def test_room_ahead_of_the_boat(boat: Boat) -> None:
    guard = boat.supervisor.parts.fence
    assert guard.room_m((40.0, 0.0), 0.0) == math.inf
    fence(boat)
    half_m = 0.5 * boat.config.length_m
    assert guard.room_m((40.0, 0.0), 0.0) == pytest.approx(10.0 - half_m, abs=0.01)
    assert guard.room_m((40.0, 0.0), math.pi) == pytest.approx(90.0 - half_m, abs=0.01)
    assert guard.room_m((49.9, 0.0), 0.0) == 0.0
    assert guard.room_m((60.0, 0.0), 0.0) == math.inf, "outside"
