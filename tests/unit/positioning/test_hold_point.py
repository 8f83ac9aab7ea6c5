"""Watch circle, transit, and the boat without sideways thrust."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from companion.config.vessel import VesselConfig, find, load
from companion.core.decision import ModeId
from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint, PoseSetpoint, Setpoint
from companion.core.tick import Inputs
from companion.params.store import Parameters
from companion.positioning.hold_point import PoseKeeper
from tests.unit.conftest import Boat
from tests.unit.estimates import AT_REST

LENGTH_M = 3.0


def holding(boat: Boat) -> Any:
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.step(5.0)
    return boat


def test_the_watch_circle_is_announced_on_leaving_and_on_return(boat: Boat) -> None:
    holding(boat)
    boat.obey = lambda setpoint: None
    for north_m, times in ((2.9, (0, 0)), (3.1, (1, 0)), (2.9, (1, 0)), (3.2, (1, 0)), (1.0, (1, 1)), (4.0, (2, 1))):
        boat.nav = replace(boat.nav, north_m=north_m)
        boat.step(1.0)
        assert (boat.names().count("watch_circle_left"), boat.names().count("watch_circle_back")) == times


def test_hold_under_way_stops_ahead_and_not_behind(boat: Boat) -> None:
    boat.supervisor.arm(boat.now_s)
    boat.parameters.set("DP_SPEED_AHEAD", 0.5)
    boat.nav = replace(boat.nav, surge_mps=0.5, north_mps=0.5)
    boat.supervisor.update(boat.nav, Inputs(), (), boat.now_s)
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.step()
    assert boat.setpoint.surge_mps == pytest.approx(0.5, abs=0.02)
    assert boat.setpoint.progress.target.north_m == pytest.approx(0.5**2 / (2.0 * 0.085) + 0.5 * 0.75, abs=0.02)
    boat.step(30.0)
    assert boat.nav.north_m == pytest.approx(boat.setpoint.progress.target.north_m, abs=1e-6)


def at(north_m: float, surge_mps: float) -> NavState:
    return replace(AT_REST, north_m=north_m, surge_mps=surge_mps, north_mps=surge_mps)


def stopping(surge_mps: float) -> PoseKeeper:
    keeper = PoseKeeper(Parameters({"DP_SPEED_AHEAD": 0.5, "DP_ACC_SURGE": 0.1}), LENGTH_M)
    keeper.start(at(0.0, surge_mps))
    return keeper


def asked(keeper: PoseKeeper, north_m: float, surge_mps: float) -> Setpoint:
    return keeper.update(at(north_m, surge_mps), None, 1.0, 0.1)


def test_from_full_speed_the_boat_brakes_with_all_its_thrust_and_holds_where_it_rests() -> None:
    keeper = stopping(2.0)
    for north_m, surge_mps in ((0.2, 1.9), (2.0, 1.0), (3.0, 0.4)):
        setpoint = asked(keeper, north_m, surge_mps)
        assert isinstance(setpoint, PathSetpoint) and setpoint.surge_mps == 0.0 and setpoint.yaw_rad == AT_REST.yaw_rad
        assert not keeper.arrived
    assert isinstance(asked(keeper, 3.2, 0.2), PoseSetpoint)
    assert keeper.target[0] == pytest.approx(3.2 + stopping_m(0.2), abs=0.01)  # from where it was slow, not from 0 m


def stopping_m(surge_mps: float) -> float:
    return surge_mps * 0.5 * (1.5 + surge_mps / 0.085)


def test_a_boat_that_cannot_brake_holds_the_place_that_was_planned() -> None:
    keeper = stopping(2.0)
    planned_m = keeper.target[0]
    assert isinstance(asked(keeper, planned_m - 0.1, 1.5), PathSetpoint)
    assert isinstance(asked(keeper, planned_m + 0.1, 1.5), PoseSetpoint)
    assert keeper.target[0] == planned_m


def test_a_fence_too_near_for_the_stop_has_the_boat_brake_with_all_its_thrust() -> None:
    """It led the reference from rest, whose feedback brakes less: a barge came to rest 1.4 m further on."""
    keeper = PoseKeeper(Parameters({"DP_SPEED_AHEAD": 0.5, "DP_ACC_SURGE": 0.1}), LENGTH_M)
    keeper.start(at(0.0, 2.0), fitted=at(0.0, 0.0))
    for north_m, surge_mps in ((0.2, 1.9), (2.0, 1.0)):
        setpoint = asked(keeper, north_m, surge_mps)
        assert isinstance(setpoint, PathSetpoint) and setpoint.surge_mps == 0.0
    setpoint = asked(keeper, 2.5, 0.4)
    assert isinstance(setpoint, PoseSetpoint) and setpoint.surge_mps <= 0.0 and keeper.target[0] == 0.0


def test_a_boat_that_was_carried_off_sideways_is_not_led_on_with_the_weather() -> None:
    """CyberShip II drifted at 0.6 m/s while it was not armed; its reference led it 16 m further, with all its thrust."""
    keeper = PoseKeeper(Parameters({"DP_SPEED_SWAY": 0.06, "DP_ACC_SWAY": 0.015, "DP_ACC_SURGE": 0.05}), LENGTH_M)
    drifting = replace(AT_REST, sway_mps=-0.6, east_mps=-0.6)
    keeper.start(drifting)
    assert abs(keeper.target[1]) < 0.25
    keeper.hold(0.0, 2.0, 0.0, None)
    furthest_m = 0.0
    for _ in range(300):
        setpoint = keeper.update(drifting, None, 1.0, 0.1)
        assert isinstance(setpoint, PoseSetpoint)
        furthest_m = min(furthest_m, setpoint.east_m)
    assert furthest_m > -0.25


@pytest.mark.parametrize("boat_mps", [0.18, 0.09])
def test_the_reference_waits_for_a_boat_that_the_weather_leaves_too_little_thrust(boat_mps: float) -> None:
    """In 2.8 m/s of wind against a current of 0.15 m/s ReVolt's ran 1.2 m ahead of it (`four_corner`, 707011)."""
    keeper = PoseKeeper(Parameters({"DP_SPEED_AHEAD": 0.25}), LENGTH_M)
    keeper.start(AT_REST)
    keeper.hold(5.0, 0.0, 0.0, None)
    north_m, leads_m = 0.0, []
    while north_m < 4.0:
        setpoint = keeper.update(at(north_m, boat_mps), None, 1.0, 0.1)
        assert isinstance(setpoint, PoseSetpoint)
        leads_m.append(setpoint.north_m - north_m)
        north_m += 0.1 * boat_mps
    assert max(leads_m) < 0.15 * LENGTH_M
    assert leads_m[-1] < 0.09 * LENGTH_M


def test_the_reference_arrives_where_the_boat_cannot() -> None:
    keeper = PoseKeeper(Parameters({"DP_SPEED_AHEAD": 0.25}), LENGTH_M)
    keeper.start(AT_REST)
    keeper.hold(2.0, 0.0, 0.0, None)
    for _ in range(1500):
        keeper.update(AT_REST, None, 1.0, 0.1)
    assert keeper.arrived


@pytest.mark.parametrize(("begun_mps", "brakes"), [(1.3, True), (0.4, False)])
def test_at_the_end_of_a_way_a_fast_boat_brakes_before_its_reference_leads_it_beyond(
    begun_mps: float, brakes: bool
) -> None:
    """A catamaran of 1.6 m came to the standoff point off its berth at 1.3 m/s, and ran into the berth."""
    keeper = PoseKeeper(Parameters({"DP_SPEED_AHEAD": 0.3, "DP_ACC_SURGE": 0.2}), 1.6)
    north_m, surge_mps = 0.0, begun_mps
    keeper.start(at(north_m, surge_mps))
    keeper.come_to(1.6, 0.0, 1.0)
    led_m, braked = [], False
    while len(led_m) < 300 and not keeper.arrived:
        setpoint = keeper.update(at(north_m, surge_mps), None, 1.0, 0.1)
        if isinstance(setpoint, PathSetpoint):
            assert (setpoint.surge_mps, setpoint.yaw_rad) == (0.0, 0.0)
            braked, surge_mps = True, surge_mps - 0.1
        elif isinstance(setpoint, PoseSetpoint):
            led_m.append(setpoint.north_m)
            surge_mps = setpoint.surge_mps
        north_m += 0.1 * surge_mps
    assert braked == brakes and keeper.arrived
    assert max(led_m) < 1.6 + 0.3
    assert keeper.target == (1.6, 0.0, 1.0)


def test_at_the_speeds_of_positioning_the_reference_brakes() -> None:
    assert isinstance(asked(stopping(0.45), 0.0, 0.45), PoseSetpoint)


def test_another_point_ends_the_braking() -> None:
    keeper = stopping(2.0)
    asked(keeper, 1.0, 1.5)
    keeper.hold(5.0, 0.0, 0.0, None)
    setpoint = asked(keeper, 1.2, 1.4)
    assert isinstance(setpoint, PoseSetpoint) and keeper.target[0] == 5.0
    assert setpoint.north_m == pytest.approx(1.15, abs=0.1)  # from where the boat is, not from where it began to brake


def test_the_turn_from_transit_to_holding_is_smooth(boat: Boat) -> None:
    boat.supervisor.arm(boat.now_s)
    boat.supervisor.go_to(*boat.point(30.0, 20.0), None, None, boat.now_s)
    boat.until(lambda: isinstance(boat.setpoint, PathSetpoint) and boat.away_m(30.0, 20.0) < 4.0)
    speeds = []
    while boat.away_m(30.0, 20.0) > 0.01:
        boat.step()
        speeds.append(boat.setpoint.surge_mps)
        assert len(speeds) < 600
    assert max(abs(a - b) for a, b in itertools.pairwise(speeds)) < 0.05


@pytest.fixture
def jet(make_boat: Callable[..., Boat], revolt: VesselConfig) -> Any:
    return make_boat(replace(revolt, limits=replace(revolt.limits, sway_n=0.0)))


def drifting(boat: Boat, north_mps: float, east_mps: float) -> None:
    """A current carries the ideal boat."""
    follow = boat.obey

    def drift(setpoint: Any) -> None:
        follow(setpoint)
        boat.nav = replace(
            boat.nav, north_m=boat.nav.north_m + north_mps * 0.1, east_m=boat.nav.east_m + east_mps * 0.1
        )

    boat.obey = drift


def test_a_boat_without_sideways_thrust_describes_its_hold(jet: Any, boat: Boat) -> None:
    texts = {b: next(m.text for m in b.supervisor.modes if m.id is ModeId.HOLD) for b in (jet, boat)}
    assert "watch circle" in texts[jet] and "watch circle" not in texts[boat]


def test_a_boat_without_sway_stays_inside_its_circle_bow_to_the_stream(jet: Any) -> None:
    holding(jet)
    jet.nav = replace(jet.nav, current_north_mps=0.0, current_east_mps=0.15)
    drifting(jet, 0.0, 0.15)
    jet.step(60.0)
    farthest = 0.0
    for _ in range(600):
        jet.step()
        farthest = max(farthest, jet.away_m(0.0, 0.0))
        assert isinstance(jet.setpoint, PathSetpoint) and jet.setpoint.sway_mps == 0.0
    assert farthest < 3.0 and jet.nav.yaw_rad == pytest.approx(-math.pi / 2.0, abs=0.3)


def test_a_boat_without_sway_returns_when_nothing_is_known_of_the_drift(jet: Any) -> None:
    holding(jet)
    drifting(jet, 0.1, -0.1)
    farthest = 0.0
    for _ in range(1200):
        jet.step()
        farthest = max(farthest, jet.away_m(0.0, 0.0))
    assert farthest < 3.5


def test_a_boat_without_sway_goes_to_points_near_and_far(jet: Any) -> None:
    holding(jet)
    for point in ((4.0, 3.0), (30.0, -10.0)):
        assert jet.supervisor.go_to(*jet.point(*point), None, None, jet.now_s).accepted
        jet.until(lambda point=point: jet.away_m(*point) < 1.1, 300.0)
        jet.step(20.0)
        assert jet.away_m(*point) < 3.0


def test_a_boat_without_sway_skips_turns_on_the_spot(jet: Any) -> None:
    from companion.core.decision import MissionState
    from companion.mission.plan import PlanItem

    jet.upload((10.0, 0.0), (20.0, 0.0), commands={1: PlanItem(0, 115, 2, 90.0, 0.0, 0.0, 0.0, 0, 0, 0.0)})
    jet.supervisor.request_mode(ModeId.MISSION, jet.now_s)
    jet.supervisor.arm(jet.now_s)
    jet.until(lambda: jet.status.mission.state is MissionState.COMPLETE)
    assert "turn_skipped" in jet.names()


def test_a_go_to_of_a_boat_without_sideways_thrust_that_makes_no_headway_is_announced(
    make_boat: Callable[..., Boat],
) -> None:
    """Blown away on the way to a near point, it was never at the point, and nothing was said."""
    boat = holding(make_boat(load(find("otter"))))
    boat.supervisor.go_to(*boat.point(4.0, 0.0), None, None, boat.now_s)
    for i in range(900):
        boat.step()
        boat.nav = replace(boat.nav, north_m=-0.02 * i, surge_mps=0.0, north_mps=-0.2)
    assert "no_headway" in boat.names()
