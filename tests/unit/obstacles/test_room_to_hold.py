"""A boat that moves about its hold point holds where obstacles leave it room, and backs out of where they do not."""

from __future__ import annotations

import bisect
import math
from dataclasses import replace

import numpy as np
import pytest

from companion.config.vessel import VesselConfig, find, load
from companion.core.setpoint import PathSetpoint, WrenchSetpoint
from companion.fence.allowed import Allowed, Way
from companion.obstacles.open_water import Water
from companion.obstacles.room_to_hold import RoomToHold
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST
from tests.unit.obstacles.stubs import Sailing, no_fence
from tests.unit.obstacles.test_guard import Bridge, motion
from tests.unit.rudder_boat import SKIFF

OTTER, JET = load(find("otter")), load(find("rescuerunner"))
OUTBOARD = replace(JET, thrusters=(replace(JET.thrusters[0], kind="azimuth", min_n=-500.0),))
CIRCLE_M = 6.0
KEPT_M = 1.0 + 0.9  # half of the skiff's length, and the share of CP_DIST at which it stops


def room(config: VesselConfig = SKIFF) -> RoomToHold:
    return RoomToHold(config, Parameters({**config.parameters, "DP_WATCH_R": CIRCLE_M}))


def water(*circles: tuple[float, float, float]) -> Water:
    return Water(np.array(circles, dtype=float).reshape(-1, 3), 4.0, Allowed(None, None, 0.0, 1.0))


def test_only_a_boat_that_goes_on_as_it_turns_needs_room() -> None:
    """An outboard was taken for a boat that turns on the spot: launches drifted onto what they had stopped for."""
    needs = [room(config).room_m for config in (SKIFF, JET, OUTBOARD, OTTER)]
    assert needs == [CIRCLE_M, CIRCLE_M, CIRCLE_M, 0.0]
    stone = water((3.0, 0.0, 0.5))
    assert room(OTTER).better((0.0, 0.0), (0.0, 0.0), stone) is None


def test_it_holds_where_its_circle_is_free() -> None:
    stone = water((5.0, 0.0, 1.0))
    place = room().better((0.0, 0.0), (0.0, 0.0), stone)
    assert place is not None
    assert math.dist(place, (5.0, 0.0)) - 1.0 - KEPT_M >= CIRCLE_M - 0.01
    assert math.hypot(*place) < CIRCLE_M, "the nearest one"
    assert room().better((0.0, 0.0), (0.0, 0.0), water((8.0, 0.0, 1.0))) is None, "room enough in most weathers"


def test_among_obstacles_it_takes_the_best_place_or_stays() -> None:
    ring = [(9.0 * math.cos(a), 9.0 * math.sin(a), 1.5) for a in np.linspace(0.0, math.tau, 12, endpoint=False)]
    assert room().better((0.0, 0.0), (0.0, 0.0), water(*ring)) is None


@pytest.mark.parametrize(("bow_rad", "backs"), [(0.0, True), (math.pi, False), (0.5 * math.pi, False)])
def test_it_backs_out_where_that_leads_away_and_the_water_astern_is_free(bow_rad: float, backs: bool) -> None:
    nav, fence = replace(AT_REST, yaw_rad=bow_rad), no_fence(SKIFF, Parameters())
    stones = water((5.0, 0.0, 1.0), (0.0, -5.0, 1.0))
    assert room().backs_out(nav, stones, fence, False) is backs
    assert not room(OTTER).backs_out(nav, stones, fence, False)


def test_once_it_backs_out_it_goes_on_until_it_has_all_the_room() -> None:
    nav, fence, stone = replace(AT_REST, north_m=-2.5), no_fence(SKIFF, Parameters()), water((5.0, 0.0, 1.0))
    assert [room().backs_out(nav, stone, fence, begun) for begun in (False, True)] == [False, True]
    assert not room().backs_out(replace(nav, north_m=-4.0), stone, fence, True)


@pytest.mark.parametrize(("aside_mps", "backs"), [(0.0, True), (0.3, False), (-0.3, True)])
def test_it_backs_out_only_where_wind_and_current_do_not_set_it_down_meanwhile(aside_mps: float, backs: bool) -> None:
    """Bow off the wind, a rowing boat went astern for 85 s from a shoal, and was set onto the quay beside it."""
    nav, fence = replace(AT_REST, sway_mps=aside_mps), no_fence(SKIFF, Parameters())
    ahead, to_leeward = (4.0, 0.0, 1.0), (0.0, 3.6, 0.3)
    assert room().backs_out(nav, water(ahead, to_leeward), fence, True) is backs


def test_it_backs_out_no_further_than_it_needs_to_turn_to_the_way_that_is_found() -> None:
    """It went on to where all of its watch circle is free, and found no such place in a harbour."""
    wall = [(0.0, float(east_m), 1.0) for east_m in np.arange(-8.0, 8.5, 1.0)]
    bridge, mode = Bridge(*wall, config=SKIFF), Sailing([(-3.5, 0.0), (30.0, 0.0)], goes_round=True)
    bridge.parameters.set("DP_WATCH_R", 12.0)
    backed_m, out = 0.0, None
    for _ in range(100):
        out = bridge.steer(PathSetpoint(0.0, surge_mps=1.0), mode, 0.6, north_m=-3.5 - backed_m)
        if None in mode.laid[:1] and not isinstance(out, WrenchSetpoint):
            break
        backed_m += 0.2 * isinstance(out, WrenchSetpoint)
    assert isinstance(out, PathSetpoint) and isinstance(mode.laid[-1], Way)
    assert 0.4 < backed_m < 6.0


def test_it_does_not_give_up_while_it_backs_out() -> None:
    """Three boats with rudders gave up a harbour at its shoal after CP_WAIT, before they had room to turn away."""
    ring = [(20.0 * math.cos(a), 20.0 * math.sin(a), 1.0) for a in np.linspace(0.0, math.tau, 60, endpoint=False)]
    bridge, mode = Bridge(*ring, config=SKIFF), Sailing([(0.0, 0.0), (60.0, 0.0)], goes_round=True)
    bridge.parameters.set("DP_WATCH_R", 12.0)
    for _ in range(100):
        out = bridge.steer(PathSetpoint(0.0, surge_mps=1.0), mode, 0.6, north_m=12.0)
    assert isinstance(out, WrenchSetpoint) and bridge.guard.impossible is None
    for _ in range(50):
        bridge.steer(PathSetpoint(0.0, surge_mps=1.0), mode, 0.6)
    assert bridge.guard.impossible == "no open water"


def test_where_no_way_leads_on_the_boat_stops_with_room_to_hold() -> None:
    skiff_m, otter_m = (
        0.1 * bisect.bisect_left(range(190), True, key=lambda tenth: _stands_in_a_ring(config, 0.1 * tenth))
        for config in (SKIFF, OTTER)
    )
    assert otter_m - skiff_m == pytest.approx(0.5 * CIRCLE_M, abs=0.3)


def _stands_in_a_ring(config: VesselConfig, north_m: float) -> bool:
    """Whether the boat at that place, at rest, is not sent on."""
    ring = [(20.0 * math.cos(a), 20.0 * math.sin(a), 1.0) for a in np.linspace(0.0, math.tau, 60, endpoint=False)]
    bridge, mode = Bridge(*ring, config=config), Sailing([(0.0, 0.0), (60.0, 0.0)], goes_round=True)
    bridge.parameters.set("DP_WATCH_R", CIRCLE_M)
    for _ in range(4):
        got = bridge.steer(PathSetpoint(0.0, surge_mps=1.0), mode, 0.6, north_m=north_m)
    return isinstance(got, WrenchSetpoint) or (isinstance(got, PathSetpoint) and got.surge_mps < 0.1)


def test_too_fast_for_what_lies_ahead_a_boat_with_a_rudder_brakes_on_its_heading() -> None:
    """Its rudder turned it by thrust ahead, onto the obstacle that it was to go round."""
    asked = PathSetpoint(0.6, surge_mps=1.0)
    for config, brakes in ((SKIFF, True), (OTTER, False)):
        bridge = Bridge((3.5, 0.0, 1.0), config=config)
        got = bridge.steer(asked, Sailing(), **motion(1.2, 0.0))
        assert isinstance(got, PathSetpoint) and got.surge_mps < 0.9
        assert (got.yaw_rad == 0.0) is brakes


def test_in_hold_the_point_moves_to_open_water_and_that_is_said() -> None:
    bridge = Bridge((0.0, 5.5, 1.0), config=load(find("rescuerunner")))
    bridge.parameters.set("DP_WATCH_R", CIRCLE_M)
    mode = Sailing(drifts=True, held_point=(0.0, 0.0))
    for _ in range(11):
        bridge.steer(PathSetpoint(0.0), mode)
    assert mode.held_point is not None and mode.held_point[1] < -1.0
    assert "Obstacles in the watch circle: hold point moved" in bridge.texts()


@pytest.mark.parametrize("else_there", [[], [(40.0, 0.0, 1.0)]])
def test_what_only_passes_through_the_watch_circle_moves_no_hold_point(
    else_there: list[tuple[float, float, float]],
) -> None:
    """What moves lies to a lidar for a while, and what it hid: it moved the point of a boat in a calm by 19 m."""
    bridge = Bridge(config=load(find("rescuerunner")))
    bridge.parameters.set("DP_WATCH_R", CIRCLE_M)
    mode = Sailing(drifts=True, held_point=(0.0, 0.0))
    for step in range(40):
        passing = [(0.0, 5.5, 1.0)] if step % 10 < 8 else []
        bridge.seen.circles = np.array([*passing, *else_there]).reshape(-1, 3)
        bridge.steer(PathSetpoint(0.0), mode)
    assert mode.held_point == (0.0, 0.0)


def test_in_hold_a_boat_with_a_rudder_first_backs_out() -> None:
    bridge = Bridge((4.5, 0.0, 1.0), config=SKIFF)
    bridge.parameters.set("DP_WATCH_R", CIRCLE_M)
    mode = Sailing(drifts=True, held_point=(0.0, 0.0))
    out = bridge.steer(PathSetpoint(0.0), mode)
    assert isinstance(out, WrenchSetpoint) and out.wrench.surge_n < 0.0 and out.wrench.yaw_nm == 0.0
    bridge.steer(PathSetpoint(0.0), mode, north_m=-6.0)
    assert mode.held_point == (-6.0, 0.0)


def test_it_backs_no_longer_than_something_lies_there() -> None:
    """What it backed out from had gone; from then on it went astern, without end, while anything moved in its view."""
    bridge = Bridge((4.5, 0.0, 1.0), config=SKIFF)
    bridge.parameters.set("DP_WATCH_R", CIRCLE_M)
    mode = Sailing(drifts=True, held_point=(0.0, 0.0))
    assert isinstance(bridge.steer(PathSetpoint(0.0), mode), WrenchSetpoint)
    bridge.seen.circles, bridge.seen.passing = np.zeros((0, 3)), np.array([(40.0, 0.0, 1.0)])
    assert bridge.steer(PathSetpoint(0.0), mode) == PathSetpoint(0.0)


@pytest.mark.parametrize(("off_m", "backs"), [(12.0, True), (3.0, False)])
def test_it_does_not_back_onto_what_passes_astern(off_m: float, backs: bool) -> None:
    bridge = Bridge((4.5, 0.0, 1.0), config=SKIFF)
    bridge.parameters.set("DP_WATCH_R", CIRCLE_M)
    bridge.seen.passing = np.array([(-off_m, 0.5, 1.0)])
    out = bridge.steer(PathSetpoint(0.0), Sailing(drifts=True, held_point=(0.0, 0.0)))
    assert isinstance(out, WrenchSetpoint) is backs


def test_out_of_the_way_astern_a_boat_with_a_rudder_does_not_steer() -> None:
    """A launch of 7 m told to go astern pushed ahead for its rudder, half of the time, and touched a stone."""
    drift = {"surge_mps": 0.3, "north_mps": 0.3, "current_north_mps": 0.3, "current_east_mps": 0.0}
    mode = Sailing([(0.0, 0.0), (60.0, 0.0)], goes_round=True)
    for config, steers in ((SKIFF, False), (OTTER, True)):
        out = Bridge((0.5 * config.length_m + 2.0, 0.0, 1.0), config=config).steer(PathSetpoint(0.2), mode, **drift)
        if steers:
            assert isinstance(out, PathSetpoint) and out.surge_mps < 0.0
        else:
            assert isinstance(out, WrenchSetpoint) and out.wrench.surge_n < 0.0 and out.wrench.yaw_nm == 0.0


def test_an_outboard_backs_out_on_its_heading() -> None:
    bridge = Bridge((5.0, 0.0, 1.0), config=OUTBOARD)
    bridge.parameters.set("DP_WATCH_R", CIRCLE_M)
    out = bridge.steer(PathSetpoint(0.0), Sailing(drifts=True, held_point=(0.0, 0.0)))
    assert isinstance(out, PathSetpoint) and out.surge_mps < 0.0 and out.yaw_rad == 0.0


def test_a_stream_from_astern_carries_it_on_until_its_bow_has_come_round() -> None:
    rate_radps = math.radians(Parameters(OUTBOARD.parameters)["PATH_YAW_RATE"])
    assert room(OUTBOARD).carried_m(0.4) >= 0.4 * math.pi / rate_radps
    assert room(OUTBOARD).carried_m(-0.4) == 0.0, "it comes from ahead"
    assert room(OTTER).carried_m(0.4) == 0.0


def test_where_no_way_leads_on_it_stops_the_sooner_in_a_stream_from_astern() -> None:
    ring = [(20.0 * math.cos(a), 20.0 * math.sin(a), 1.0) for a in np.linspace(0.0, math.tau, 60, endpoint=False)]
    speeds = []
    for stream_mps in (0.0, 0.4):
        bridge, mode = Bridge(*ring, config=OUTBOARD), Sailing([(0.0, 0.0), (60.0, 0.0)], goes_round=True)
        bridge.parameters.set("DP_WATCH_R", CIRCLE_M)
        nav = {**motion(1.0, 0.0), "current_north_mps": stream_mps, "current_east_mps": 0.0}
        for _ in range(4):
            got = bridge.steer(PathSetpoint(0.0, surge_mps=1.0), mode, 0.6, **{**nav, "north_m": 8.0})
        assert isinstance(got, PathSetpoint)
        speeds.append(got.surge_mps)
    assert speeds[1] < 0.6 * speeds[0]


def test_in_hold_it_is_not_kept_from_its_way_back_by_what_it_is_carried_to() -> None:
    """A launch that the wind set onto a stone abeam was told to stop, for half a minute, until it lay on the stone."""
    yaw_rad, mps = 2.3, 0.4
    carried = {"surge_mps": mps * math.sin(yaw_rad), "sway_mps": mps * math.cos(yaw_rad), "east_mps": mps}
    back = PathSetpoint(yaw_rad, surge_mps=0.5)
    for drifts in (True, False):
        bridge = Bridge((1.0, 5.8, 1.0), config=OUTBOARD)
        got = bridge.steer(back, Sailing(drifts=drifts), **carried, yaw_rad=yaw_rad)
        assert isinstance(got, PathSetpoint)
        assert (got.surge_mps == back.surge_mps) is drifts
