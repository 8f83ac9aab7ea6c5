"""A boat without way gets out of the way of what comes, judged by where an Otter goes that obeys."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from shapely.geometry import box

from companion.config.vessel import find, load
from companion.core.angles import wrap_pi
from companion.core.estimate import Contact, NavState
from companion.core.events import EventLog
from companion.core.setpoint import PathSetpoint
from companion.guidance.coasting import Coasting
from companion.obstacles.braking import Braking
from companion.obstacles.chart_water import ChartKeeper
from companion.obstacles.keeping_off import KeepingOff
from companion.obstacles.ways_out import Choices, WaysOut
from companion.params.store import Parameters
from companion.params.table import table_of
from tests.unit.estimates import AT_REST
from tests.unit.obstacles.charted import FRAME, feature
from tests.unit.obstacles.stubs import no_fence

OTTER, JET = load(find("otter")), load(find("rescuerunner"))
DT_S = 0.2
RADIUS_M, SPEED_MPS = 1.6, 0.5
NEAR_M = 4.5  # between the middles, when what comes is noticed


@dataclass
class Otter:
    """A boat that obeys: its speed with the speed loop's bandwidth, its heading at PATH_YAW_RATE."""

    nav: NavState

    def go(self, asked: PathSetpoint, parameters: Parameters) -> None:
        turn = wrap_pi(asked.yaw_rad - self.nav.yaw_rad)
        most = math.radians(parameters["PATH_YAW_RATE"]) * DT_S
        yaw = wrap_pi(self.nav.yaw_rad + max(-most, min(most, turn)))
        speed = self.nav.surge_mps + DT_S * parameters["PATH_BW_SURGE"] * (asked.surge_mps - self.nav.surge_mps)
        north_mps, east_mps = speed * math.cos(yaw), speed * math.sin(yaw)
        self.nav = replace(
            self.nav,
            yaw_rad=yaw,
            surge_mps=speed,
            north_mps=north_mps,
            east_mps=east_mps,
            north_m=self.nav.north_m + DT_S * north_mps,
            east_m=self.nav.east_m + DT_S * east_mps,
        )


def least_water_m(from_rad: float, beside_m: float) -> float:
    """Water between the circles of boat and mover, which comes from a direction and would pass at a distance."""
    parameters = Parameters(OTTER.parameters)
    keeping = KeepingOff(OTTER, parameters, no_fence(OTTER, parameters), Braking(OTTER, parameters), EventLog())
    otter = Otter(AT_REST)
    c, s = math.cos(from_rad), math.sin(from_rad)
    place = NEAR_M * c - beside_m * s, NEAR_M * s + beside_m * c
    least_m = math.inf
    for k in range(round(25.0 / DT_S)):
        north_m, east_m = place[0] - k * DT_S * SPEED_MPS * c, place[1] - k * DT_S * SPEED_MPS * s
        mover = Contact(-1, "mover 1", north_m, east_m, -SPEED_MPS * c, -SPEED_MPS * s, RADIUS_M, None)
        water: Any = SimpleNamespace(circles=np.zeros((0, 3)), chart=None)
        asked = keeping.update(PathSetpoint(otter.nav.yaw_rad), [mover], water, otter.nav, 1.0, k * DT_S)
        otter.go(asked or PathSetpoint(otter.nav.yaw_rad), parameters)
        gap_m = math.dist((north_m, east_m), (otter.nav.north_m, otter.nav.east_m))
        least_m = min(least_m, gap_m - RADIUS_M - 0.5 * OTTER.length_m)
    return least_m


@pytest.mark.parametrize("from_deg", range(0, 360, 30))
def test_it_clears_what_comes_late_from_any_side(from_deg: int) -> None:
    """There are 1.9 m of water when it is noticed. Ahead and astern alone, a boat went along the other's track, and kept
    half of that."""
    assert min(least_water_m(math.radians(from_deg), beside_m) for beside_m in (-1.0, 0.0, 1.0, 2.0)) > 1.5


def test_it_goes_on_until_what_comes_is_past() -> None:
    """As fast as it goes out of the way, it no longer counted as a boat that makes no way: a Heron left off every other
    second, along the course of what came, until that ran it over."""
    parameters = Parameters(OTTER.parameters)
    keeping = KeepingOff(OTTER, parameters, no_fence(OTTER, parameters), Braking(OTTER, parameters), EventLog())
    water: Any = SimpleNamespace(circles=np.zeros((0, 3)), chart=None)
    comes, route = Contact(-1, "mover 1", 0.5, 6.0, 0.0, -0.7, RADIUS_M, None), PathSetpoint(1.6, surge_mps=0.2)
    asked = keeping.update(route, [comes], water, AT_REST, 1.0, 0.0)
    assert asked is not None
    surge_mps = math.copysign(0.6, asked.surge_mps)
    fast = replace(AT_REST, yaw_rad=asked.yaw_rad, surge_mps=surge_mps, north_mps=surge_mps * math.cos(asked.yaw_rad))
    fast = replace(fast, east_mps=surge_mps * math.sin(asked.yaw_rad))
    assert keeping.update(route, [comes], water, fast, 1.0, 1.0) is not None


def test_what_passes_behind_a_boat_that_goes_on_meets_one_that_has_to_stop() -> None:
    """Slowed down before a stone, it was expected to go on through it, out of the way of what came."""
    parameters = Parameters(OTTER.parameters)
    water: Any = SimpleNamespace(circles=np.zeros((0, 3)), chart=None)
    slow, route = replace(AT_REST, surge_mps=0.2, north_mps=0.2), PathSetpoint(0.0, surge_mps=0.2)
    comes = Contact(-1, "mover 1", -3.4, -8.0, 0.0, 0.8, RADIUS_M, None)

    def goes(way_m: float) -> PathSetpoint | None:
        keeping = KeepingOff(OTTER, parameters, no_fence(OTTER, parameters), Braking(OTTER, parameters), EventLog())
        return keeping.update(route, [comes], water, slow, 1.0, 0.0, way_m=way_m)

    assert goes(math.inf) is None and goes(0.5) is not None


def test_a_boat_without_thrust_astern_turns_away_from_what_it_cannot_stop_for() -> None:
    """A stone a little to port, nearer than it coasts."""
    parameters = Parameters(JET.parameters)
    keeping = KeepingOff(JET, parameters, no_fence(JET, parameters), Braking(JET, parameters), EventLog())
    water: Any = SimpleNamespace(circles=np.array([(9.0, -1.0, 1.0)]), chart=None)
    nav = replace(AT_REST, surge_mps=2.0, north_mps=2.0)
    away = keeping.update(PathSetpoint(0.0, surge_mps=0.3), [], water, nav, 1.0, 0.0)
    assert away is not None and 0.1 < wrap_pi(away.yaw_rad) < 2.0, "to starboard"


def test_a_boat_without_thrust_astern_is_expected_to_go_as_far_as_it_coasts() -> None:
    stops = Choices(np.zeros(1), np.zeros(1), np.full(1, math.inf))
    nav = replace(AT_REST, surge_mps=1.5, north_mps=1.5)
    north, _ = WaysOut(JET, Parameters(JET.parameters)).places(stops, nav)
    assert north[0, -1] == pytest.approx(Coasting(JET.hull, 5.0).way_m(1.5), rel=0.15)
    north, _ = WaysOut(OTTER, Parameters(OTTER.parameters)).places(stops, nav)
    assert north[0, -1] < 4.0, "an Otter reverses"


def jet_beside(stone: tuple[float, float, float], nav: NavState, asked: PathSetpoint) -> PathSetpoint | None:
    """What a jet boat about a point that it cannot keep does near a stone (north_m, east_m, radius_m)."""
    parameters = Parameters(JET.parameters)
    keeping = KeepingOff(JET, parameters, no_fence(JET, parameters), Braking(JET, parameters), EventLog())
    water: Any = SimpleNamespace(circles=np.array([stone]), chart=None)
    return keeping.update(asked, [], water, nav, 1.0, 0.0, drifts=True)


def test_a_jet_that_cannot_turn_round_before_a_stone_coasts() -> None:
    """The thrust of its turn drove it on from 1.3 to 2 m/s, and onto the stone."""
    nav = replace(AT_REST, surge_mps=1.2, north_mps=1.2)
    away = jet_beside((12.0, -3.0, 2.5), nav, PathSetpoint(math.radians(-168.0), surge_mps=0.5))
    assert away is not None and away.surge_mps == 0.0
    assert jet_beside((30.0, -3.0, 2.5), nav, PathSetpoint(math.radians(-168.0), surge_mps=0.5)) is None


def test_a_jet_that_turns_fast_is_not_sent_back() -> None:
    """It was told to turn the other way, went on turning and straightened out towards the stone."""
    nav = replace(AT_REST, surge_mps=2.0, sway_mps=0.7, north_mps=2.0, east_mps=0.7, yaw_rate_radps=-0.55)
    assert jet_beside((7.0, -2.0, 2.0), nav, PathSetpoint(math.radians(-97.0), surge_mps=0.5)) is None, "it turns past"


def test_a_jet_that_coasts_may_give_up_its_mission() -> None:
    """At rest without room to turn round it would wait for ever."""
    parameters = Parameters(JET.parameters)
    keeping = KeepingOff(JET, parameters, no_fence(JET, parameters), Braking(JET, parameters), EventLog())
    water: Any = SimpleNamespace(circles=np.array([(6.0, -1.5, 1.5)]), chart=None)
    asked = keeping.update(PathSetpoint(math.radians(-168.0), surge_mps=0.5), [], water, AT_REST, 1.0, 0.0, drifts=True)
    assert asked is not None and asked.surge_mps == 0.0 and not keeping.lasts


def test_what_a_jet_can_do_in_free_water_is_predicted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """All 27 ways out were predicted again, as far and as fast as what lies leaves way for them, where it leaves all."""
    predicted: list[int] = []
    places = WaysOut.places

    def counted(ways: WaysOut, choices: Choices, nav: NavState) -> tuple[np.ndarray, np.ndarray]:
        predicted.append(len(choices.yaw_rad))
        return places(ways, choices, nav)

    monkeypatch.setattr(WaysOut, "places", counted)
    nav = replace(AT_REST, surge_mps=1.2, north_mps=1.2)
    assert jet_beside((12.0, -3.0, 2.5), nav, PathSetpoint(math.radians(-168.0), surge_mps=0.5)) is not None
    assert predicted[:2] == [1, 27] and sum(predicted[2:]) < 14


@pytest.mark.parametrize(("away_m", "keeps_off"), [(4.25, True), (4.6, False)])
def test_the_corners_of_a_hull_that_is_half_as_wide_as_long_count(away_m: float, keeps_off: bool) -> None:
    """A WAM-V that turned beside a stone onto which a stream set it came within 0.2 m with a corner of its stern: half
    its length is 2.4 m, half its diagonal 2.7 m."""
    wamv = load(find("wamv16"))
    parameters = Parameters(wamv.parameters, table_of(wamv))
    keeping = KeepingOff(wamv, parameters, no_fence(wamv, parameters), Braking(wamv, parameters), EventLog())
    water: Any = SimpleNamespace(circles=np.array([(0.0, 2.0 + away_m, 2.0)]), chart=None)
    nav = replace(AT_REST, sway_mps=0.2, east_mps=0.2, current_north_mps=0.0, current_east_mps=0.2)
    asked = keeping.update(PathSetpoint(0.0), [], water, nav, 1.0, 0.0, drifts=True)
    assert (asked is not None) == keeps_off


@pytest.mark.parametrize("off_m", [3.2, 3.6, 4.6])
def test_it_backs_out_at_speed_where_the_stream_brings_what_lies_nearer_anyway(off_m: float) -> None:
    """A WAM-V that drifted at 0.5 m/s onto a stone ahead crept, ahead or astern, as slowly as one that could stop short
    of it, and touched it."""
    asked = wamv_set_north(0.5, 0.7, PathSetpoint(2.5), off_m, drifts=True)
    assert asked is not None
    assert -math.cos(asked.yaw_rad) * asked.surge_mps > 0.4, "south, away from the stone"


def test_what_carries_a_boat_aside_fast_is_no_way_that_it_makes() -> None:
    """A WAM-V across a stream of 0.6 m/s did nothing until it had been told to stop."""
    asked = wamv_set_north(0.6, 0.9, PathSetpoint(0.9, surge_mps=0.3), 6.0)
    assert asked is not None and asked.surge_mps < 0.0


@pytest.mark.parametrize(("turn_deg", "keeps_off"), [(0.0, False), (160.0, True)])
def test_before_a_long_turn_in_a_stream_it_makes_room_for_it(turn_deg: float, keeps_off: bool) -> None:
    """It turned, was set near what lies, backed, and turned again, all the while carried on."""
    asked = wamv_set_north(0.4, 0.7, PathSetpoint(0.7 + math.radians(turn_deg)), 6.6, drifts=True)
    assert (asked is not None) == keeps_off


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_it_keeps_off_a_chart_s_shore_on_the_side_where_that_lies(way: float) -> None:
    """The shore was looked for as far away on the other side of the boat."""
    wamv = load(find("wamv16"))
    parameters = Parameters(wamv.parameters, table_of(wamv))
    keeping = KeepingOff(wamv, parameters, no_fence(wamv, parameters), Braking(wamv, parameters), EventLog())
    chart = ChartKeeper(wamv, parameters, lambda: FRAME)
    chart.load([feature("quay", box(4.6, -30.0, 8.0, 30.0))])
    water: Any = SimpleNamespace(circles=np.zeros((0, 3)), chart=chart.water)
    nav = replace(AT_REST, north_mps=way * 0.5, surge_mps=way * 0.5, current_north_mps=way * 0.5, current_east_mps=0.1)
    asked = keeping.update(PathSetpoint(2.5), [], water, nav, 1.0, 0.0, drifts=True)
    assert (asked is not None) == (way > 0.0), "the quay lies to the north"
    assert asked is None or math.cos(asked.yaw_rad) * asked.surge_mps < -0.4


def wamv_set_north(
    mps: float, yaw_rad: float, setpoint: PathSetpoint, off_m: float, drifts: bool = False
) -> PathSetpoint | None:
    """What a WAM-V does that a stream carries onto a stone of 1 m radius, whose middle lies `off_m` north of it."""
    wamv = load(find("wamv16"))
    parameters = Parameters(wamv.parameters, table_of(wamv))
    keeping = KeepingOff(wamv, parameters, no_fence(wamv, parameters), Braking(wamv, parameters), EventLog())
    water: Any = SimpleNamespace(circles=np.array([(off_m, 0.0, 1.0)]), chart=None)
    ahead_mps, side_mps = mps * math.cos(yaw_rad), -mps * math.sin(yaw_rad)
    nav = replace(AT_REST, yaw_rad=yaw_rad, north_mps=mps, surge_mps=ahead_mps, sway_mps=side_mps)
    nav = replace(nav, current_north_mps=mps, current_east_mps=0.0)
    return keeping.update(setpoint, [], water, nav, 1.0, 0.0, drifts)
