"""Holding a point without sideways thrust: where the bow points, and what brings the boat back."""

import itertools
import math
from dataclasses import replace
from typing import cast

import pytest

from companion.config.vessel import find, load
from companion.core.actuation import ZERO_WRENCH
from companion.core.angles import wrap_pi
from companion.core.estimate import NO_ESTIMATE, NavState, WaveMotion
from companion.core.setpoint import PathSetpoint, WrenchSetpoint
from companion.fence.guard import FenceGuard
from companion.params.store import Parameters
from companion.params.table import table_of
from companion.positioning.bow_keeper import BowKeeper
from sitl.hull import Hull
from tests.unit.positioning.kept import kept, moving
from tests.unit.rudder_boat import SKIFF

OTTER = load(find("otter"))


def parameters() -> Parameters:
    return Parameters(OTTER.parameters, table_of(OTTER))


def at(
    north_m: float = 0.0, east_m: float = 0.0, yaw_rad: float = 0.0, current: tuple[float, float] | None = None
) -> NavState:
    still = replace(NO_ESTIMATE, north_m=north_m, east_m=east_m, yaw_rad=yaw_rad)
    if current is None:
        return still
    return replace(still, current_north_mps=current[0], current_east_mps=current[1], current_accuracy_mps=0.02)


def held(nav: NavState) -> BowKeeper:
    keeper = BowKeeper(OTTER, parameters())
    keeper.start(nav)
    keeper.hold(0.0, 0.0, nav.yaw_rad, None)
    return keeper


def test_the_bow_points_upstream_and_to_the_side_of_the_point() -> None:
    set_north = (0.4, 0.0)
    keeper = held(at(current=set_north))
    assert abs(keeper.update(at(current=set_north), None, 1.0, 0.1).yaw_rad) == pytest.approx(math.pi, abs=0.01)
    east_of_it = keeper.update(at(east_m=0.5, current=set_north), None, 1.0, 0.1)
    assert 0.0 < wrap_pi(east_of_it.yaw_rad - math.pi) < 0.8  # west of south: the stream carries it back


def test_an_offset_that_stays_turns_the_heading_to_lie_at() -> None:
    stream = (0.4, 0.0)
    keeper = held(at(current=stream))
    for _ in range(300):
        keeper.update(at(east_m=0.3, yaw_rad=math.pi, current=stream), None, 1.0, 0.1)
    assert wrap_pi(keeper.target[2] - math.pi) > math.radians(5.0)


def test_waves_turn_the_bow_nowhere() -> None:
    """The heading swung by 20° with each wave, and a lone outboard changed the sign of its thrust 42 times a minute."""
    stream = (0.4, 0.0)
    still = at(yaw_rad=math.pi, current=stream)
    keeper, yaws = held(still), []
    for i in range(100):
        east_mps = 0.4 * math.sin(0.3 * i)
        waves = WaveMotion(3.0, 0.0, 0.0, 0.0, 0.0, east_mps, 0.0)
        asked = keeper.update(replace(still, east_mps=east_mps, sway_mps=-east_mps, waves=waves), None, 1.0, 0.1)
        assert isinstance(asked, PathSetpoint) and asked.keeps_place
        yaws.append(wrap_pi(asked.yaw_rad - math.pi))
    assert max(yaws) - min(yaws) < math.radians(1.0)


def test_a_boat_that_lies_stern_to_the_stream_turns_round() -> None:
    keeper = held(at())
    for _ in range(900):
        setpoint = keeper.update(at(current=(0.4, 0.0)), None, 1.0, 0.1)
    assert abs(setpoint.yaw_rad) == pytest.approx(math.pi, abs=math.radians(30.0))


@pytest.mark.parametrize("north_m", [2.0, 20.0])
def test_a_boat_that_must_turn_round_does_not_brake_against_the_stream(north_m: float) -> None:
    """In a flow from astern the weather holds the bow of a boat with two fixed thrusters."""
    stream = (0.4, 0.0)
    keeper = held(at(current=stream))
    for _ in range(5):
        asked = keeper.update(at(north_m, current=stream), None, 1.0, 0.1)
        assert isinstance(asked, PathSetpoint) and asked.surge_mps == pytest.approx(0.4, abs=0.01)
    bow_to_it = keeper.update(at(north_m, yaw_rad=math.pi, current=stream), None, 1.0, 0.1)
    assert isinstance(bow_to_it, PathSetpoint) and abs(wrap_pi(bow_to_it.yaw_rad - math.pi)) < 0.1


def sliding(east_mps: float) -> NavState:
    """South of the point, with the bow to it, and sliding round it."""
    return replace(at(north_m=-2.0), east_mps=east_mps)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_lone_outboard_that_goes_round_its_point_stops_pushing_until_the_water_has_slowed_it(side: float) -> None:
    """A boat of 900 kg went round its point at 0.85 m/s for five minutes, with three quarters of its thrust."""
    motor = replace(load(find("aboat")).thrusters[1], azimuth_min_rad=-0.6, azimuth_max_rad=0.6)
    keeper = BowKeeper(replace(OTTER, thrusters=(motor,)), parameters())
    keeper.start(at())
    keeper.hold(0.0, 0.0, 0.0, None)

    def pushes(mps: float) -> bool:
        setpoint = keeper.update(sliding(side * mps), None, 1.0, 0.1)
        assert isinstance(setpoint, PathSetpoint) or (
            isinstance(setpoint, WrenchSetpoint) and setpoint.wrench == ZERO_WRENCH
        )
        return isinstance(setpoint, PathSetpoint)

    assert all(pushes(mps) for mps in (0.1, *[0.35] * 50))
    assert [pushes(0.6) for _ in range(40)].count(True) in (29, 30), "three seconds may be a turn"
    assert [pushes(mps) for mps in (0.35, 0.1, 0.35, 0.6)] == [False, True, True, True]


def test_a_boat_that_turns_on_the_spot_pushes_while_it_slides() -> None:
    keeper = held(at())
    assert all(isinstance(keeper.update(sliding(0.6), None, 1.0, 0.1), PathSetpoint) for _ in range(60))


def test_a_drift_is_no_slide() -> None:
    """The stream carries the boat round the point; it does not move through the water."""
    stream = (0.0, 0.6)
    keeper = BowKeeper(replace(OTTER, thrusters=OTTER.thrusters[:1]), parameters())
    keeper.start(replace(sliding(0.6), current_north_mps=stream[0], current_east_mps=stream[1]))
    keeper.hold(0.0, 0.0, 0.0, None)
    carried = replace(sliding(0.6), current_north_mps=stream[0], current_east_mps=stream[1], current_accuracy_mps=0.02)
    assert all(isinstance(keeper.update(carried, None, 1.0, 0.1), PathSetpoint) for _ in range(60))


def test_a_boat_that_the_wind_keeps_where_a_stream_sets_it_aside_is_no_slide() -> None:
    """It moves through the water, and not over ground. A kayak in rough water stopped pushing there; the waves turned
    it across, and it was 15 m off."""
    keeper = BowKeeper(replace(OTTER, thrusters=OTTER.thrusters[:1]), parameters())
    kept_there = at(north_m=-0.5, current=(0.0, 0.6))
    keeper.start(kept_there)
    keeper.hold(0.0, 0.0, 0.0, None)
    assert all(isinstance(keeper.update(kept_there, None, 1.0, 0.1), PathSetpoint) for _ in range(60))


def test_without_drift_the_boat_keeps_its_heading_near_the_point_and_sails_back_from_afar() -> None:
    keeper = held(at(yaw_rad=1.0))
    assert keeper.update(at(east_m=0.5, yaw_rad=1.0), None, 1.0, 0.1).yaw_rad == pytest.approx(1.0)
    back = keeper.update(at(east_m=2.5, yaw_rad=1.0), None, 1.0, 0.1)
    assert back.yaw_rad == pytest.approx(-math.pi / 2) and back.surge_mps == 0.0  # first it turns on the spot
    assert keeper.update(at(east_m=2.5, yaw_rad=-math.pi / 2), None, 1.0, 0.1).surge_mps > 0.2


def test_a_drift_about_as_large_as_it_is_sure_does_not_come_and_go() -> None:
    """Its accuracy goes up and down with each fix: a skiff's propeller ran in every other tick."""
    keeper, asked = BowKeeper(SKIFF, Parameters(SKIFF.parameters)), []
    off = at(north_m=-0.7 * Parameters(SKIFF.parameters)["DP_WATCH_R"], current=(0.1, 0.0))
    keeper.start(off)
    keeper.hold(0.0, 0.0, 0.0, None)
    for i in range(100):
        setpoint = keeper.update(replace(off, current_accuracy_mps=0.095 if i % 2 else 0.105), None, 1.0, 0.1)
        asked.append(type(setpoint))
    assert sum(a is not b for a, b in itertools.pairwise(asked)) <= 1


def test_a_drift_that_is_less_sure_as_the_boat_answers_it_does_not_turn_the_bow_to_and_fro() -> None:
    """Thrust makes the current less sure: a RIB's outboard steered in every other tick."""
    off = at(north_m=0.5, yaw_rad=1.5, current=(0.11, 0.0))
    keeper, last_rad, turns = held(at(north_m=0.5, yaw_rad=1.5)), 1.5, 0
    answered = False
    for _ in range(900):
        nav = replace(off, current_accuracy_mps=0.2 if answered else 0.105)
        heading_rad = keeper.update(nav, None, 1.0, 0.1).yaw_rad
        answered = abs(wrap_pi(heading_rad - last_rad)) > 0.1
        last_rad, turns = heading_rad, turns + answered
    assert turns <= 2


def test_the_speed_keeps_within_the_limits_of_positioning() -> None:
    keeper, limits = held(at(current=(0.4, 0.0))), parameters()
    far = keeper.update(at(north_m=2.6, yaw_rad=math.pi, current=(0.4, 0.0)), None, 5.0, 0.1)
    assert far.surge_mps <= limits["DP_SPEED_AHEAD"]
    ahead_of_it = keeper.update(at(north_m=-2.6, yaw_rad=math.pi, current=(0.4, 0.0)), None, 5.0, 0.1)
    assert ahead_of_it.surge_mps == pytest.approx(-limits["DP_SPEED_ASTERN"])


def sailed(current_north_mps: float, yaw_rad: float, duration_s: float) -> list[tuple[float, float]]:
    """(distance from the point, heading) of the Otter's published plant with a perfect estimate, each tenth of a
    second."""
    assert OTTER.sitl is not None
    plant, stream = OTTER.sitl.plants["fossen"], (current_north_mps, 0.0)
    hull, keeper = Hull(plant.hull), held(at(yaw_rad=yaw_rad))
    hull.set_current(*stream)
    hull.place(0.0, 0.0, yaw_rad)
    return kept(
        OTTER, keeper, lambda _: moving(at(current=stream), hull), hull, hull.step, plant.thruster_lag_s, duration_s
    )


def test_from_stern_to_the_stream_the_otter_turns_and_then_stays() -> None:
    track = sailed(0.4, 0.3, 150.0)
    assert max(distance for distance, _ in track) < 6.0
    late = track[-300:]
    assert max(distance for distance, _ in late) < 0.5
    assert all(abs(wrap_pi(yaw - math.pi)) < 0.35 for _, yaw in late)


def test_a_boat_that_drifts_away_turns_to_its_point_while_still_inside_the_circle() -> None:
    """The heading against a drift that is not yet known well does not stop it."""
    stream = (0.4, 0.0)
    keeper = held(at(current=stream))
    carried = replace(at(east_m=1.0, yaw_rad=math.pi, current=stream), east_mps=0.5)
    yaw_rad = keeper.update(carried, None, 1.0, 0.1).yaw_rad
    assert yaw_rad is not None and math.cos(yaw_rad + 0.5 * math.pi) > 0.5
    near = replace(at(east_m=1.0, yaw_rad=math.pi, current=stream), east_mps=0.1)
    assert abs(held(at(current=stream)).update(near, None, 1.0, 0.1).yaw_rad) > math.radians(130.0)


def test_in_a_calm_a_boat_that_passes_beside_its_point_does_not_turn_after_it() -> None:
    """A canoe with an outboard went round its point for minutes: it always pointed there, and slid by."""
    keeper = held(at())
    for north_m in (4.0, 3.0, 2.0, 1.2, 0.6):
        going = replace(at(north_m, 1.0, math.pi), north_mps=-0.5)
        keeper.update(going, None, 1.0, 0.1)
    for north_m in (-0.1, -0.3, -0.5):
        setpoint = keeper.update(replace(at(north_m, 1.0, math.pi), north_mps=-0.5), None, 1.0, 0.1)
        assert abs(wrap_pi(setpoint.yaw_rad - math.pi)) < math.radians(1.0)


def test_carried_off_beside_its_point_the_bow_points_upstream_and_not_to_the_point() -> None:
    """A barge half a metre beside its point turned across the stream to it, and lost 10 m."""
    stream = (1.1, 0.0)
    keeper = held(at(current=stream))
    carried = replace(at(north_m=0.3, east_m=0.4, yaw_rad=math.pi, current=stream), north_mps=1.0)
    yaw_rad = keeper.update(carried, None, 1.0, 0.1).yaw_rad
    assert yaw_rad is not None and abs(wrap_pi(yaw_rad - math.pi)) < math.radians(15.0)


class Line:
    """A fence that runs across, so far north."""

    def __init__(self, north_m: float) -> None:
        self._north_m = north_m

    def room_m(self, place: tuple[float, float], course_rad: float) -> float:
        return self._north_m - place[0] if math.cos(course_rad) > 0.5 else math.inf

    def held_place(self, place: tuple[float, float]) -> tuple[float, float]:
        return place


def before(line_m: float) -> BowKeeper:
    keeper = BowKeeper(OTTER, parameters(), cast(FenceGuard, Line(line_m)))
    keeper.start(at(current=(0.6, 0.0)))
    return keeper


def test_with_its_bow_down_the_stream_before_a_fence_it_goes_astern_for_room_to_turn() -> None:
    """It turned at once, and was carried over the line."""
    keeper, stream = before(4.0), (0.6, 0.0)
    astern = keeper.update(at(current=stream), None, 1.0, 0.1)
    assert isinstance(astern, PathSetpoint)
    assert astern.surge_mps < 0.0 and astern.yaw_rad == pytest.approx(0.0)
    further = keeper.update(at(-2.0, current=stream), None, 1.0, 0.1)
    assert isinstance(further, PathSetpoint) and further.surge_mps < 0.0
    turning = keeper.update(at(-8.0, current=stream), None, 1.0, 0.1)
    assert abs(wrap_pi(turning.yaw_rad)) > math.radians(120.0)
    assert keeper.target[0] == -2.0, "it holds where it had not yet room, not nearer to the line"


def test_far_from_a_fence_or_at_a_point_that_was_asked_for() -> None:
    stream = (0.6, 0.0)
    assert abs(wrap_pi(before(30.0).update(at(current=stream), None, 1.0, 0.1).yaw_rad)) > math.radians(120.0)
    keeper = before(4.0)
    keeper.hold(1.0, 0.0, 0.0, None)
    assert keeper.update(at(current=stream), None, 1.0, 0.1).yaw_rad == pytest.approx(0.0)
    assert keeper.target[:2] == (1.0, 0.0)
