"""Where a boat without sideways thrust holds after a stop."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import cast

import pytest

from companion.cli.new_file import file_text
from companion.config.vessel import VesselConfig, find, load, parse
from companion.core.angles import wrap_pi
from companion.core.estimate import NO_ESTIMATE, NavState, WaveMotion
from companion.core.setpoint import PathSetpoint, WrenchSetpoint
from companion.fence.guard import FenceGuard
from companion.guidance.coasting import Coasting
from companion.params.store import Parameters
from companion.params.table import table_of
from companion.positioning.bow_keeper import BowKeeper
from companion.positioning.drift import DriftKeeper
from companion.positioning.stop import Stop
from tests.unit.rudder_boat import ANSWERS, SKIFF

REST_MPS = 0.2


def at(north_m: float, surge_mps: float, yaw_rad: float = 0.0) -> NavState:
    return replace(
        NO_ESTIMATE,
        north_m=north_m,
        yaw_rad=yaw_rad,
        surge_mps=surge_mps,
        north_mps=surge_mps * math.cos(yaw_rad),
        east_mps=surge_mps * math.sin(yaw_rad),
    )


def begun(planned_m: float, surge_mps: float = 2.0) -> Stop:
    stop = Stop(REST_MPS)
    stop.begin(at(0.0, surge_mps), (planned_m, 0.0))
    return stop


def test_the_place_of_rest_is_held() -> None:
    stop = begun(20.0)
    assert stop.place(at(2.0, 1.0)) is None and stop.lasts
    assert stop.place(at(3.0, 0.1)) == (3.0, 0.0) and not stop.lasts


def test_where_the_boat_does_not_rest_in_time_the_planned_point_is_held() -> None:
    stop = begun(5.0)
    assert stop.place(at(5.5, 1.0)) == (5.0, 0.0) and not stop.lasts


def test_a_boat_that_is_fast_where_it_should_rest_brakes_before_it_turns() -> None:
    """A RIB told of a fence 15 m ahead turned round at 8 m/s, with thrust ahead: 20 m beyond the line."""
    stop = Stop(REST_MPS)
    stop.begin(at(0.0, 8.0), (0.0, 0.0), turns_mps=0.5)
    assert stop.place(at(5.0, 6.0)) is None
    assert stop.place(at(9.0, 0.4)) == (0.0, 0.0)


def test_a_boat_carried_aside_does_not_stop_for_ever() -> None:
    stop = begun(5.0)
    assert stop.place(replace(at(0.0, 1.0), east_m=6.0)) == (5.0, 0.0)


def test_a_stop_from_sailing_astern() -> None:
    stop = begun(-20.0, surge_mps=-2.0)
    assert stop.place(at(-2.0, -1.0)) is None
    assert stop.place(at(-3.0, -0.1)) == (-3.0, 0.0)


def test_a_boat_at_rest_has_nothing_to_stop() -> None:
    assert not begun(0.1, surge_mps=0.1).lasts


def test_what_the_stream_carries_has_no_way_of_its_own() -> None:
    """A dinghy braked for six seconds against the stream that carried it, before it turned its bow."""
    stop = begun(20.0)
    assert stop.place(at(2.0, 0.9), carried_mps=0.6) is None
    assert stop.place(at(3.0, 0.75), carried_mps=0.6) == (3.0, 0.0)


def test_against_the_stream_the_boat_still_comes_to_rest_over_ground() -> None:
    assert begun(20.0).place(at(2.0, 0.3), carried_mps=-0.6) is None


class LineAhead:
    """A fence to the north: the boat holds 8 m south of the line at the most."""

    line_m = 12.0

    def held_place(self, place: tuple[float, float]) -> tuple[float, float]:
        return min(place[0], self.line_m - 8.0), place[1]

    def room_m(self, place: tuple[float, float], course_rad: float) -> float:
        ahead = math.cos(course_rad)
        return (self.line_m - place[0]) / ahead if ahead > 0.0 else math.inf


def fenced(config: VesselConfig) -> BowKeeper:
    return BowKeeper(config, Parameters(config.parameters, table_of(config)), cast(FenceGuard, LineAhead()))


def test_near_a_fence_the_place_to_hold_lies_further_inside() -> None:
    keeper = fenced(load(find("otter")))
    keeper.start(at(0.0, 2.0))
    keeper.update(at(6.0, 0.1), None, 1.0, 0.1)
    assert keeper.target[:2] == (4.0, 0.0)


def test_a_fence_too_near_to_stop_is_no_reason_to_turn_at_speed() -> None:
    keeper = fenced(load(find("otter")))
    fast = at(6.0, 2.4)
    keeper.start(fast, fitted=replace(fast, surge_mps=0.0, north_mps=0.0))
    braking = keeper.update(at(6.2, 2.3), None, 1.0, 0.1)
    assert isinstance(braking, PathSetpoint) and braking.surge_mps == 0.0 and braking.yaw_rad == 0.0
    keeper.update(at(7.5, 0.1), None, 1.0, 0.1)
    assert keeper.target[:2] == (4.0, 0.0)


def test_braking_that_is_taken_for_waves_ends_with_the_boats_own_rest() -> None:
    """A kayak at rest braked for 20 s, since the estimate took half a metre a second of its braking for waves."""
    keeper = otter()
    keeper.start(at(0.0, 1.5))
    waves = WaveMotion(3.0, 0.0, 0.0, 0.0, -0.5, 0.0, 0.0)
    keeper.update(replace(at(2.0, 0.1), waves=waves), None, 1.0, 0.1)
    assert keeper.target[:2] == (2.0, 0.0) and keeper.arrived


def test_an_outboard_with_the_fence_ahead_goes_astern_before_it_turns_round() -> None:
    """A launch at rest 2 m from its fence turned round, and its outboard pushed it over."""
    answers = replace(ANSWERS, name="launch", length_m=5.2, beam_m=1.7, mass_kg=750.0, layout="azimuth", motor="320")
    keeper = fenced(parse(file_text(answers), "launch.toml"))
    keeper.start(at(11.0, 0.0))
    keeper.hold(-20.0, 0.0, 0.0, None)
    near = keeper.update(at(11.0, 0.0), None, 1.0, 0.1)
    assert isinstance(near, PathSetpoint) and near.surge_mps < 0.0 and near.yaw_rad == 0.0
    clear = keeper.update(at(12.0 - 1.6 * 5.2, 0.0), None, 1.0, 0.1)
    assert isinstance(clear, PathSetpoint) and abs(wrap_pi((clear.yaw_rad or 0.0) - math.pi)) < 0.1


def test_between_two_lines_a_boat_goes_no_further_astern_than_to_the_middle() -> None:
    class Lane(LineAhead):
        def room_m(self, place: tuple[float, float], course_rad: float) -> float:
            return self.line_m - place[0] if math.cos(course_rad) > 0.0 else place[0] - 8.0

    keeper = BowKeeper(SKIFF, Parameters(SKIFF.parameters, table_of(SKIFF)), cast(FenceGuard, Lane()))
    keeper.start(at(11.0, 0.0))
    keeper.hold(-20.0, 0.0, 0.0, None)
    assert isinstance(keeper.update(at(11.0, 0.0), None, 1.0, 0.1), WrenchSetpoint)
    assert isinstance(keeper.update(at(9.9, 0.0), None, 1.0, 0.1), PathSetpoint)


def test_a_rudder_with_the_fence_ahead_goes_astern_before_it_turns_round() -> None:
    """A launch turned its bow in 17 m, with 10 m left."""
    keeper = fenced(SKIFF)
    keeper.start(at(11.0, 0.0))
    keeper.hold(-20.0, 0.0, 0.0, None)
    near = keeper.update(at(11.0, 0.0), None, 1.0, 0.1)
    assert isinstance(near, WrenchSetpoint) and near.wrench.surge_n < 0.0, "a rudder that steers pushes ahead"
    assert near.wrench.yaw_nm == 0.0 and near.progress.yaw_rad == 0.0
    clear = keeper.update(at(12.0 - 3.1 * SKIFF.length_m, 0.0), None, 1.0, 0.1)
    assert isinstance(clear, PathSetpoint) and abs(wrap_pi((clear.yaw_rad or 0.0) - math.pi)) < 0.1


def test_a_boat_that_brakes_across_the_stream_turns_its_bow_into_it_meanwhile() -> None:
    keeper = otter()
    stream = {"current_north_mps": 0.8, "current_east_mps": 0.0}
    keeper.start(replace(at(0.0, -1.2, yaw_rad=2.4), **stream))
    braking = keeper.update(replace(at(0.5, -1.1, yaw_rad=2.4), **stream), None, 1.0, 0.1)
    assert isinstance(braking, PathSetpoint) and abs(wrap_pi((braking.yaw_rad or 0.0) - math.pi)) < 0.05
    keeper.start(replace(at(0.0, 2.5, yaw_rad=0.0), **stream))
    ahead = keeper.update(replace(at(0.5, 2.4, yaw_rad=0.0), **stream), None, 1.0, 0.1)
    assert isinstance(ahead, PathSetpoint) and ahead.yaw_rad == 0.0, "with the stream it brakes as it came"


def test_a_jet_that_would_coast_to_the_fence_turns_back_at_once() -> None:
    config = load(find("rescuerunner"))
    keeper = DriftKeeper(config, Parameters(config.parameters), cast(FenceGuard, LineAhead()))
    keeper.start(at(0.0, 5.0))
    turning = keeper.update(at(0.2, 5.0), None, 8.0, 0.05)
    assert keeper.target[0] == 4.0 and isinstance(turning, PathSetpoint)
    assert turning.yaw_rad == pytest.approx(math.pi) and turning.surge_mps > 0.0


def otter() -> BowKeeper:
    config = load(find("otter"))
    return BowKeeper(config, Parameters(config.parameters, table_of(config)))


def test_two_motors_brake_with_all_they_have_and_hold_there() -> None:
    keeper = otter()
    keeper.start(at(0.0, 2.0, yaw_rad=0.0))
    braking = keeper.update(at(1.0, 1.5), None, 1.0, 0.1)
    assert isinstance(braking, PathSetpoint) and braking.surge_mps == 0.0 and braking.yaw_rad == 0.0
    assert not keeper.arrived
    keeper.update(at(2.0, 0.1), None, 1.0, 0.1)
    assert keeper.target[:2] == (2.0, 0.0) and keeper.arrived


@pytest.mark.parametrize(("yaw_rad", "surge_mps"), [(0.0, 0.8), (math.pi, -0.8)])
def test_a_boat_that_only_a_stream_carries_on_has_stopped(yaw_rad: float, surge_mps: float) -> None:
    """A skiff lay with its bow in the stream, and was carried over its fence stern first while it still braked."""
    keeper = otter()
    stream = {"current_north_mps": 0.9, "current_east_mps": 0.0}
    keeper.start(replace(at(0.0, 2.0), **stream))
    keeper.update(replace(at(1.0, surge_mps, yaw_rad=yaw_rad), **stream), None, 1.0, 0.1)
    assert keeper.target[0] == 1.0


def test_a_boat_that_only_drifts_aside_holds_where_it_is() -> None:
    """The point was planned 2.4 m on, by a braking aside that it has no thrust for: towards a fence."""
    keeper = otter()
    keeper.start(replace(at(0.0, 0.1), sway_mps=0.42, east_mps=0.42))
    assert keeper.target[:2] == (0.0, 0.0)


def test_a_point_that_is_given_is_held_at_once() -> None:
    keeper = otter()
    keeper.start(at(0.0, 2.0))
    keeper.hold(4.0, 0.0, 0.0, None)
    going = keeper.update(at(0.5, 2.0), None, 1.0, 0.1)
    assert isinstance(going, PathSetpoint) and going.surge_mps > 0.0 and keeper.target[:2] == (4.0, 0.0)


@pytest.mark.parametrize("rest_m", [40.0, 90.0])
def test_a_jet_holds_where_it_has_coasted_to(rest_m: float) -> None:
    config = load(find("rescuerunner"))
    keeper = DriftKeeper(config, Parameters(config.parameters))
    keeper.start(at(0.0, 16.0))
    planned_m = keeper.target[0]
    assert planned_m > 100.0
    for north_m in range(0, int(rest_m), 5):
        assert isinstance(keeper.update(at(float(north_m), 5.0), None, 8.0, 0.05), WrenchSetpoint)
    keeper.update(at(rest_m, 1.0), None, 8.0, 0.05)
    assert keeper.target[0] == pytest.approx(rest_m + Coasting(config.hull, 10.0).way_m(1.0), abs=0.1)


def test_a_rudder_is_not_asked_to_hold_the_heading_while_the_boat_brakes() -> None:
    """It would do so by thrust ahead: a barge drove on for 10 m, over its fence."""
    keeper = BowKeeper(SKIFF, Parameters(SKIFF.parameters))
    keeper.start(at(0.0, 1.4))
    turned = keeper.update(at(1.0, 1.0, yaw_rad=0.6), None, 1.0, 0.1)
    assert isinstance(turned, PathSetpoint) and turned.surge_mps == 0.0 and turned.yaw_rad == 0.6
