"""Waypoint tracking on a point that goes exactly where it is told, and on one that is carried off."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import pytest

from companion.config.vessel import find, load
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint, Setpoint
from companion.guidance import path_laying
from companion.guidance.agility import agility_of
from companion.guidance.path_plan import PathPlan
from companion.guidance.path_tracking import PathProgress, PathTracker
from companion.guidance.turning import Turning, turning_of
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import nav_state

DT_S = 0.1


class Puppet:
    """Takes heading and speed as told, at once, and drifts with `current` besides. `sways`: sideways speed too."""

    def __init__(
        self,
        tracker: PathTracker,
        north_m: float = 0.0,
        east_m: float = 0.0,
        current: tuple[float, float] = (0.0, 0.0),
        sways: bool = False,
    ) -> None:
        self.tracker, self.current, self.sways = tracker, current, sways
        self.north_m, self.east_m, self.yaw_rad, self.speed_mps, self.sway_mps = north_m, east_m, 0.0, 0.0, 0.0

    def nav(self) -> NavState:
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        vn = self.speed_mps * c - self.sway_mps * s + self.current[0]
        ve = self.speed_mps * s + self.sway_mps * c + self.current[1]
        return nav_state(self.north_m, self.east_m, self.yaw_rad, c * vn + s * ve, -s * vn + c * ve)

    def sail(self, seconds: float, speed_mps: float = 0.6) -> list[PathProgress]:
        progress: list[PathProgress] = []
        for _ in range(round(seconds / DT_S)):
            progress.append(self.tracker.update(self.nav(), speed_mps, DT_S))
            if progress[-1].finished:
                break
            setpoint = progress[-1].setpoint
            assert setpoint.yaw_rad is not None
            self.yaw_rad = setpoint.yaw_rad
            along = self.current[0] * math.cos(self.yaw_rad) + self.current[1] * math.sin(self.yaw_rad)
            self.speed_mps = setpoint.surge_mps - along
            across = self.current[1] * math.cos(self.yaw_rad) - self.current[0] * math.sin(self.yaw_rad)
            self.sway_mps = setpoint.sway_mps - across if self.sways else 0.0
            c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
            self.north_m += (self.speed_mps * c - self.sway_mps * s + self.current[0]) * DT_S
            self.east_m += (self.speed_mps * s + self.sway_mps * c + self.current[1]) * DT_S
        return progress


def tracker(can_sway: bool = True, **values: float) -> PathTracker:
    parameters = Parameters()
    for name, value in values.items():
        assert parameters.set(name, value) is None
    return PathTracker(parameters, can_sway)


def points(*pairs: tuple[float, float]) -> list[Waypoint]:
    return [Waypoint(n, e) for n, e in pairs]


def test_a_square_is_sailed_and_every_waypoint_counted_once() -> None:
    boat = Puppet(tracker())
    boat.tracker.start(points((20, 0), (20, 20), (0, 20), (0, 0)), boat.nav())
    progress = boat.sail(300.0)
    assert progress[-1].finished
    counts = [p.passed for p in progress]
    assert counts == sorted(counts) and counts[-1] == 4
    assert {b - a for a, b in itertools.pairwise(counts)} <= {0, 1}
    assert all(isinstance(p.setpoint, PathSetpoint) for p in progress)
    assert max(abs(p.setpoint.progress.cross_track_error_m or 0.0) for p in progress) < 0.35
    assert math.hypot(boat.north_m, boat.east_m) < 0.3, "it stops at the last waypoint"
    assert progress[-1].setpoint.surge_mps < 0.15
    assert [p.s_m for p in progress] == sorted(p.s_m for p in progress)


def test_the_target_is_the_next_waypoint_and_the_distance_to_it_shrinks() -> None:
    boat = Puppet(tracker())
    boat.tracker.start(points((20, 0), (20, 20)), boat.nav())
    first = boat.tracker.update(boat.nav(), 0.6, DT_S)
    assert (first.setpoint.progress.target.north_m, first.setpoint.progress.target.east_m) == (20.0, 0.0)
    assert first.setpoint.progress.distance_to_go_m == pytest.approx(20.0, abs=0.5)
    assert first.remaining_m == pytest.approx(39.4, abs=0.5)
    later = boat.sail(40.0)[-1]
    assert later.passed == 1
    assert (later.setpoint.progress.target.north_m, later.setpoint.progress.target.east_m) == (20.0, 20.0)


def test_legs_lead_on_from_the_boat_and_never_back_along_what_is_passed() -> None:
    boat = Puppet(tracker())
    boat.tracker.start(points((15, 0), (30, 0), (45, 0), (60, 0)), boat.nav())
    while boat.tracker.update(boat.nav(), 0.6, DT_S).passed < 3:
        boat.sail(1.0)
    legs = boat.tracker.legs
    assert len(legs) == 4, "one for each waypoint, as their items are counted"
    way = [north for leg in legs for north, _ in leg]
    assert way == sorted(way) and way[0] == pytest.approx(boat.north_m, abs=1.0) and way[-1] == pytest.approx(60.0)


def test_an_unknown_current_is_compensated_until_no_error_is_left() -> None:
    for can_sway in (True, False):
        boat = Puppet(tracker(can_sway), current=(0.0, 0.2))
        boat.tracker.start(points((60, 0)), boat.nav())
        boat.sail(70.0)
        last = boat.tracker.update(boat.nav(), 0.6, DT_S).setpoint
        assert abs(last.progress.cross_track_error_m or 0.0) < 0.05
        assert math.degrees(last.yaw_rad or 0.0) < -10.0


def settled(guide: PathTracker, nav: NavState, seconds: float = 10.0) -> Setpoint:
    """What is asked of a boat that stays where it is, once the heading asked for has turned."""
    for _ in range(round(seconds / DT_S)):
        setpoint = guide.update(nav, 0.6, DT_S).setpoint
    return setpoint


def test_a_known_current_is_compensated_at_once() -> None:
    guide = tracker()
    nav = nav_state(surge_mps=0.6, current=(0.0, 0.3))
    guide.start(points((50, 0)), nav)
    setpoint = settled(guide, nav)
    assert setpoint.yaw_rad == pytest.approx(-math.asin(0.3 / math.hypot(0.6, 0.3)), abs=0.03)


@pytest.mark.parametrize("vessel", ["revolt", "aboat"])
def test_slowed_down_by_a_guard_the_bow_does_not_turn_into_a_weak_current(vessel: str) -> None:
    """Wind that is taken for a current turned the bow by 40 deg on the last metres before a fence: the boat then lay
    across the wind, and was blown over the line."""
    config = load(find(vessel))
    on_way = PathTracker(Parameters(config.parameters), True, agility=agility_of(config))
    weak = (0.0, 0.09)
    on_way.start(points((40.0, 0.0)), nav_state(current=weak))
    headings = []
    for step in range(400):
        north_m = min(39.0, 0.1 * step)
        speed_mps = max(0.05, 1.0 - max(0.0, north_m - 20.0) / 18.0)
        nav = nav_state(north_m, 0.0, 0.0, speed_mps, 0.0, current=weak)
        headings.append(on_way.update(nav, speed_mps, DT_S).setpoint.yaw_rad or 0.0)
    assert max(abs(heading) for heading in headings) < math.radians(12.0)


def test_the_line_of_sight_steers_back_to_the_path() -> None:
    guide = tracker(PATH_INTEGRAL=0.0)
    guide.start(points((50, 0)), nav_state())
    setpoint = settled(guide, nav_state(5.0, 3.0))
    assert setpoint.progress.cross_track_error_m == pytest.approx(3.0)
    assert setpoint.yaw_rad == pytest.approx(-math.pi / 4.0, abs=0.02), "three metres off at three metres of look-ahead"
    assert setpoint.progress.course_rad == pytest.approx(0.0, abs=1e-9)


def test_a_missed_waypoint_is_left_behind() -> None:
    guide = tracker()
    nav = nav_state(0.0, 0.0)
    guide.start(points((10, 0), (30, 0)), nav)
    passed = 0
    for k in range(120):
        progress = guide.update(nav_state(0.1 * k, 4.0, surge_mps=0.6), 0.6, DT_S)
        assert abs(progress.setpoint.yaw_rad or 0.0) < math.radians(90.0)
        passed = progress.passed
        if 0.1 * k < 9.5:
            assert passed == 0
    assert passed == 1, "abeam of it, four metres off"


def test_a_waypoint_is_passed_inside_its_own_radius() -> None:
    guide = tracker()
    guide.start([Waypoint(10.0, 0.0, radius_m=4.0), Waypoint(30.0, 0.0)], nav_state())
    assert guide.update(nav_state(5.5, 0.0, surge_mps=0.6), 0.6, DT_S).passed == 0
    assert guide.update(nav_state(6.5, 0.0, surge_mps=0.6), 0.6, DT_S).passed == 1


def test_speeds_of_legs_and_of_the_command() -> None:
    boat = Puppet(tracker())
    boat.tracker.start([Waypoint(20.0, 0.0, speed_mps=0.3), Waypoint(50.0, 0.0)], boat.nav())
    progress = boat.sail(200.0)
    assert max(p.setpoint.surge_mps for p in progress if p.s_m < 19.0) == pytest.approx(0.3, abs=0.01)
    assert max(p.setpoint.surge_mps for p in progress) == pytest.approx(0.6, abs=0.01)
    speeds = [p.setpoint.surge_mps for p in progress]
    assert max(abs(b - a) for a, b in itertools.pairwise(speeds)) <= 1.9 * 0.08 * DT_S + 1e-6


def test_without_a_stop_the_last_waypoint_is_passed_at_speed() -> None:
    boat = Puppet(tracker())
    boat.tracker.start(points((20, 0)), boat.nav(), stop_at_end=False)
    progress = boat.sail(100.0)
    assert progress[-1].finished and progress[-1].setpoint.surge_mps == pytest.approx(0.6, abs=0.01)


def test_a_boat_that_does_not_come_nearer_to_the_end_has_arrived_inside_its_radius() -> None:
    """ÅBOAT lay 0.3 m before the end of its leg, asked to go on at 0.36 m/s, until a stream had carried it away."""
    boat = Puppet(tracker())
    boat.tracker.start(points((20, 0)), boat.nav())
    while boat.north_m < 19.2:
        assert not boat.sail(DT_S)[-1].finished
    rests = [boat.tracker.update(nav_state(19.2, 0.0), 0.6, DT_S) for _ in range(120)]
    assert rests[-1].setpoint.surge_mps > 0.2, "it is to go on"
    assert not rests[80].finished and rests[-1].finished


def test_a_boat_blown_past_the_end_has_finished() -> None:
    guide = tracker()
    guide.start(points((20, 0)), nav_state())
    for k in range(300):
        progress = guide.update(nav_state(0.1 * k, 3.0, surge_mps=1.0), 0.6, DT_S)
    assert progress.finished and progress.passed == 1


def test_started_in_the_middle_of_a_leg() -> None:
    guide = tracker()
    guide.start(points((0, 0), (20, 0), (20, 20)), nav_state(12.0, 0.5), from_here=False)
    progress = guide.update(nav_state(12.0, 0.5), 0.6, DT_S)
    assert progress.passed == 1
    assert progress.s_m == pytest.approx(12.0, abs=0.1)
    assert progress.setpoint.progress.cross_track_error_m == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("kind", [0, 1, 2, 3])
def test_routes_that_turn_back_are_sailed_to_their_end(kind: int) -> None:
    boat = Puppet(tracker(PATH_KIND=kind))
    boat.tracker.start(points((20, 0), (0, 0.5), (20, 1), (20, 1), (20.1, 1), (0, -5)), boat.nav())
    progress = boat.sail(400.0)
    assert progress[-1].finished and progress[-1].passed == 6
    assert boat.north_m == pytest.approx(0.0, abs=0.5)


def test_a_leg_straight_back_is_sailed() -> None:
    boat = Puppet(tracker())
    boat.tracker.start(points((20, 0), (0, 0)), boat.nav())
    progress = boat.sail(300.0)
    assert progress[-1].finished
    assert max(p.s_m for p in progress) > 38.0
    assert math.hypot(boat.north_m, boat.east_m) < 0.5


def test_at_the_only_waypoint_it_finishes() -> None:
    guide = tracker()
    guide.start(points((0, 0)), nav_state())
    assert guide.update(nav_state(), 0.6, DT_S).finished


def test_a_boat_that_needs_way_to_steer_keeps_some_while_it_turns() -> None:
    astern = nav_state(yaw_rad=math.pi)
    for can_sway, least in ((True, 0.0), (False, 0.1)):
        guide = tracker(can_sway)
        guide.start(points((50, 0)), astern)
        for _ in range(100):
            setpoint = guide.update(astern, 0.6, DT_S).setpoint
        assert setpoint.surge_mps >= least
        assert setpoint.surge_mps < 0.2


def test_misuse_is_refused() -> None:
    with pytest.raises(ValueError, match="waypoints"):
        tracker().start([], nav_state())
    with pytest.raises(ValueError, match="finite"):
        tracker().start(points((math.nan, 0.0)), nav_state())
    with pytest.raises(RuntimeError, match="start"):
        tracker().update(nav_state(), 0.6, DT_S)


def test_way_grows_as_the_boat_sails_and_not_while_it_is_set_back() -> None:
    guide = tracker()
    guide.start(points((50, 0)), nav_state())
    ways = [guide.update(nav_state(n, 0.0), 0.6, DT_S).way_m for n in (0.0, 1.0, 2.0, 1.5, 0.5, -5.0)]
    assert ways == pytest.approx([0.0, 1.0, 2.0, 1.5, 0.5, -5.0], abs=0.01)
    assert guide.update(nav_state(2.0, 3.0), 0.6, DT_S).way_m == pytest.approx(-1.0, abs=0.01)


def test_a_boat_that_cannot_sway_keeps_steerage_through_a_bend_in_a_current() -> None:
    def slowest(current: tuple[float, float], can_sway: bool) -> float:
        boat = Puppet(tracker(can_sway, PATH_ACC_LAT=0.05), current=current)
        boat.tracker.start(points((20, 0), (20, 20), (0, 20)), boat.nav())
        return min(math.hypot(p.setpoint.surge_mps, 0.0) for p in boat.sail(60.0)[100:] if p.passed == 1)

    assert slowest((0.0, 0.3), can_sway=False) > 1.2 * slowest((0.0, 0.3), can_sway=True)


def test_it_keeps_steerage_through_the_last_bend_too() -> None:
    """Within the radius of the last but one waypoint, WAM-V 16 crept round the corner, and was carried 2.7 m off."""
    boat = Puppet(tracker(False, PATH_KIND=0, PATH_ACC_LAT=0.02, NAV_ACC_RAD=4.0), current=(0.0, 0.2))
    boat.tracker.start(points((20, 0), (20, 20)), boat.nav())
    bend = [p.setpoint.surge_mps for p in boat.sail(60.0) if p.passed == 1 and p.remaining_m > 12.0]
    assert min(bend) > 1.5 * 0.2


def test_the_line_of_sight_learns_nothing_on_its_way_back_to_the_track() -> None:
    """It learnt a large error away, as after a corner, and passed to the other side of the track by an eighth of it."""
    boat = Puppet(tracker(False))
    boat.tracker.start(points((0, 0), (80, 0)), boat.nav(), from_here=False)
    boat.east_m = 2.0
    progress = boat.sail(60.0)
    assert min(p.setpoint.progress.cross_track_error_m for p in progress) > -0.05


def test_led_beside_its_track_the_line_of_sight_learns_nothing() -> None:
    """After 60 s on a way round traffic, 10 m aside, RescueRunner overshot its track by as much."""
    guided = tracker(False)
    guided.start(points((0, 0), (400, 0)), nav_state(0.0, 0.0, 0.0, 1.0), from_here=False)
    for i in range(600):
        guided.update(nav_state(0.1 * i, 3.0, 0.0, 1.0), 1.0, 0.1)
    back = [guided.update(nav_state(60.0 + 0.1 * i, 0.0, 0.0, 1.0), 1.0, 0.1).setpoint.yaw_rad for i in range(60)]
    assert back[-1] == pytest.approx(0.0, abs=0.1)


def test_a_boat_that_turns_slowly_on_the_spot_waits_for_its_bow() -> None:
    """WAM-V 16 turns at 8°/s; it gathered speed in the middle of its turns, and ran 3 m wide of the corners."""

    def surge_mps(off_deg: float, pivots: bool) -> float:
        values = {"PATH_YAW_RATE": 8.0, "PATH_INTEGRAL": 0.0}  # it stays where it is, and learns nothing from that
        guide = PathTracker(Parameters(values), can_sway=False, turning=Turning(on_the_spot=pivots))
        nav = nav_state(20.0, 0.0, math.radians(off_deg), 0.6)
        guide.start(points((0, 0), (50, 0)), nav, from_here=False)
        return settled(guide, nav).surge_mps

    for off_deg in (50.0, 70.0, 90.0):
        assert 0.03 < surge_mps(off_deg, pivots=True) < 0.6 * surge_mps(off_deg, pivots=False)
    assert surge_mps(10.0, pivots=True) == surge_mps(10.0, pivots=False)


@pytest.mark.parametrize("can_sway", [True, False])
def test_a_boat_whose_bow_points_back_is_not_pushed_ahead(can_sway: bool) -> None:
    """A catamaran of 1.3 m with sideways thrust lay bow on before its fence: RTL pushed it 0.7 m ahead as it turned."""
    guide = tracker(can_sway, PATH_ACC=0.8)
    nav = nav_state(yaw_rad=math.pi)
    guide.start(points((50, 0)), nav)
    gains = [guide.update(nav, 1.5, 0.1).setpoint.surge_mps2 for _ in range(20)]
    assert max(map(abs, gains)) <= (0.0 if can_sway else 0.3 * 1.25 * 0.8 + 1e-6)


def test_a_boat_that_is_carried_off_as_it_turns_sails_back_once_its_bow_points_there() -> None:
    """WAM-V 16 waited for a bow whose heading turned on as it was carried off: 4 m, at a corner of a square."""

    def surge_mps(east_m: float, to_the_track: bool) -> float:
        guide = PathTracker(Parameters({"PATH_YAW_RATE": 8.0}), can_sway=False, turning=Turning(on_the_spot=True))
        nav = nav_state(20.0, east_m, math.radians(-20.0 if to_the_track else 20.0))
        guide.start(points((0, 0), (50, 0)), nav, from_here=False)
        return settled(guide, nav).surge_mps

    assert surge_mps(3.0, to_the_track=True) > 2.0 * surge_mps(3.0, to_the_track=False)


def test_held_back_before_a_bend_the_speed_setpoint_rests() -> None:
    """Otter was asked for 0.3 and 0.4 m/s in turns, every tick, and for ±0.9 m/s² with it: its thrust went up and down,
    and a current carried it onto a stone astern (`obstacles --seed 3`)."""
    guide = tracker(False, PATH_ACC=0.75, PATH_ACC_LAT=0.75, PATH_YAW_RATE=30.0, MPC_XY_VEL_MAX=1.0)
    nav = nav_state(3.0, 1.0, 2.5, -0.12)
    guide.start(points((0, 0), (-0.25, -0.65), (3, -1), (40, 0)), nav, from_here=False)
    setpoints = [guide.update(nav, 1.0, 0.1).setpoint for _ in range(100)][50:]
    assert max(abs(a.surge_mps - b.surge_mps) for a, b in itertools.pairwise(setpoints)) < 0.005
    assert max(abs(one.surge_mps2) for one in setpoints) < 0.05


def skiff(**values: float) -> PathTracker:
    """Of a boat that a rudder turns."""
    return PathTracker(Parameters(values), can_sway=False, turning=Turning(arc=load(find("otter")).hull))


def test_a_boat_with_a_rudder_comes_back_to_the_track_no_steeper_than_it_can_turn_in() -> None:
    """A skiff of 2.4 m steered across the track at 60°, and weaved on straight legs."""

    def lean_rad(guide: PathTracker) -> float:
        nav = nav_state(20.0, -4.0, 0.0, 1.5)
        guide.start(points((0, 0), (90, 0)), nav, from_here=False)
        return max(guide.update(nav, 1.5, 0.1).setpoint.yaw_rad for _ in range(100))

    values = {
        "PATH_YAW_RATE": 10.0,
        "PATH_LOOKAHEAD": 3.0,
        "PATH_LOOK_TIME": 0.5,
        "PATH_INTEGRAL": 0.0,
        "MPC_XY_VEL_MAX": 1.5,
    }
    assert lean_rad(PathTracker(Parameters(values), can_sway=False)) == pytest.approx(math.atan(4.0 / 3.0), abs=0.01)
    assert math.radians(25.0) < lean_rad(skiff(**values)) < math.radians(42.0)


def test_its_heading_setpoint_says_how_fast_it_turns() -> None:
    values = {"PATH_YAW_RATE": 10.0, "WP_SPEED": 1.5, "MPC_XY_VEL_MAX": 1.5}
    nav = nav_state(20.0, 0.0, math.radians(90.0), 1.0)
    guide = skiff(**values)
    guide.start(points((0, 0), (90, 0)), nav, from_here=False)
    first = guide.update(nav, 1.5, 0.1).setpoint
    second = guide.update(nav, 1.5, 0.1).setpoint
    assert second.yaw_rate_radps == pytest.approx(math.radians(-10.0))
    assert second.yaw_rad - first.yaw_rad == pytest.approx(math.radians(-1.0))


def planner(**values: float) -> PathTracker:
    parameters = Parameters()
    for name, value in {"PATH_KIND": 0.0, "MPC_XY_VEL_MAX": 1.6, "PATH_EFFORT": 0.2, **values}.items():
        assert parameters.set(name, value) is None
    return PathTracker(parameters, True, agility=agility_of(load(find("aboat"))))


def test_a_planned_corner_passes_through_the_point_and_legs_at_full_speed() -> None:
    guide = planner()
    guide.start(points((30, 0), (30, 30)), nav_state())
    north = east = 0.0
    nearest, fastest = math.inf, 0.0
    ahead = 0.0
    for _ in range(1200):
        setpoint = guide.update(nav_state(north, east, ahead), 1.2, DT_S).setpoint
        assert setpoint.exact
        ahead = setpoint.progress.course_rad or 0.0
        north += setpoint.surge_mps * math.cos(ahead) * DT_S
        east += setpoint.surge_mps * math.sin(ahead) * DT_S
        nearest, fastest = min(nearest, math.hypot(north - 30.0, east)), max(fastest, setpoint.surge_mps)
    assert nearest < 0.2
    assert fastest == pytest.approx(1.2, abs=0.01)


def test_a_law_gets_the_setpoints_that_it_can_keep() -> None:
    """The regulator keeps no sideways speed: by a plan it was carried off its way. The MPC looks further ahead than
    the thrusters."""
    for law, exact, poses in ((0.0, True, 12), (1.0, False, 0), (2.0, True, 19)):
        guide = planner(PATH_CTRL=law)
        guide.start(points((30, 0), (30, 30)), nav_state())
        setpoint = guide.update(nav_state(), 1.2, DT_S).setpoint
        assert (setpoint.exact, len(setpoint.ahead)) == (exact, poses)


def test_rate_and_acceleration_of_a_planned_turn_are_those_of_its_heading() -> None:
    """Also where a current turns the bow off the course."""
    guide = planner()
    guide.start(points((30, 0), (30, 30)), nav_state())
    north = east = yaw = 0.0
    headings, rates = [], []
    for _ in range(450):
        nav = replace(nav_state(north, east, yaw), current_north_mps=0.0, current_east_mps=0.3)
        setpoint = guide.update(nav, 1.2, DT_S).setpoint
        yaw = setpoint.yaw_rad
        course = setpoint.progress.course_rad or 0.0
        speed = math.hypot(setpoint.surge_mps, setpoint.sway_mps)
        north, east = north + speed * math.cos(course) * DT_S, east + speed * math.sin(course) * DT_S
        headings.append(setpoint.yaw_rad)
        rates.append(setpoint.yaw_rate_radps)
    turned = wrap_pi(headings[-1] - headings[50])
    assert sum(rates[50:]) * DT_S == pytest.approx(turned, abs=0.15)
    assert abs(turned - math.pi / 2.0) > 0.1  # the current takes its part of the turn


def test_a_boat_that_is_too_fast_for_its_plan_is_not_told_to_stop_at_once() -> None:
    """Carried along by a stream, it went on at a speed asked for that sank slowly, with an acceleration asked for that
    would have stopped it at once."""
    guide = planner()
    guide.start(points((30, 0), (30, 30)), nav_state(surge_mps=1.2))
    asked = []
    for k in range(280):
        asked.append(guide.update(nav_state(0.12 * k, 0.0, 0.0, 1.2), 1.2, DT_S).setpoint)
    slowing = max((a.surge_mps - b.surge_mps) / DT_S for a, b in itertools.pairwise(asked))
    assert slowing > 0.3
    assert min(setpoint.surge_mps2 for setpoint in asked) > -1.1 * slowing


def test_the_plan_is_made_anew_for_other_weather_and_not_for_each_gust(monkeypatch: pytest.MonkeyPatch) -> None:
    made = 0

    def count(*given: Any) -> PathPlan:
        nonlocal made
        made += 1
        return PathPlan(*given)

    monkeypatch.setattr(path_laying, "PathPlan", count)
    guide = planner()
    guide.start(points((60, 0), (60, 60)), nav_state())
    for k in range(300):  # gusts of 2 m/s either way, and a current that is not quite sure
        wind, current = 6.0 + 2.0 * math.sin(0.2 * k), 0.225 + 0.03 * math.sin(0.9 * k)
        gusty = replace(nav_state(0.01 * k, 0.0), wind_speed_mps=wind, wind_from_rad=1.0, current_north_mps=current)
        guide.update(replace(gusty, current_east_mps=0.0), 1.2, DT_S)
    assert made == 1
    guide.update(replace(nav_state(3.0, 0.0), current_north_mps=-0.2, current_east_mps=0.0), 1.2, DT_S)
    guide.update(replace(nav_state(3.0, 0.0), current_north_mps=-0.2, current_east_mps=0.0), 0.8, DT_S)
    assert made == 3


def test_beside_the_tip_of_a_sharp_corner_the_plan_goes_on() -> None:
    """A boat that lies outside of the tip is as near to all of it, wherever it is to go next."""
    guide = planner()
    guide.start(points((30, 0), (0, 8)), nav_state())
    for x in range(298):
        guide.update(nav_state(0.1 * x, 0.0, 0.0), 1.2, DT_S)
    reached = [guide.update(nav_state(30.15, 0.05, 0.0), 1.2, DT_S).s_m for _ in range(100)]
    assert guide.update(nav_state(30.15, 0.05, 0.0), 1.2, DT_S).passed == 1
    assert reached[-1] > 29.9 and reached[-1] > reached[0]


def test_a_boat_that_a_stream_carries_past_its_end_turns_its_bow_into_it_before() -> None:
    """A barge turned only once it was there, and drifted 11 m over the fence behind its last waypoint."""
    boat = Puppet(tracker(can_sway=False, PATH_YAW_RATE=12.0), current=(0.5, 0.0))
    boat.tracker.start(points((60, 0)), boat.nav())

    def known() -> NavState:
        return replace(
            nav_state(boat.north_m, boat.east_m, boat.yaw_rad, *over_ground(boat)),
            current_north_mps=0.5,
            current_east_mps=0.0,
        )

    boat.nav = known  # type: ignore[method-assign]
    progress = boat.sail(200.0, 0.8)
    assert progress[-1].finished and abs(wrap_pi(boat.yaw_rad - math.pi)) < math.radians(20.0)
    assert math.hypot(boat.north_m - 60.0, boat.east_m) < 1.5
    assert abs(boat.speed_mps + 0.5 * math.cos(boat.yaw_rad)) < 0.2, "over ground"


def over_ground(boat: Puppet) -> tuple[float, float]:
    """Ahead and to starboard."""
    c, s = math.cos(boat.yaw_rad), math.sin(boat.yaw_rad)
    return boat.speed_mps + c * boat.current[0] + s * boat.current[1], c * boat.current[1] - s * boat.current[0]


@pytest.mark.parametrize("vessel", ["otter", "wamv16", "blueboat", "heron"])
def test_a_turn_begins_no_earlier_than_keeps_the_radius_that_the_plan_gives(vessel: str) -> None:
    """The Otter turned 1.2 s early, and cut points with a radius of 0.2 m by up to 0.7 m."""
    radius_m = 0.2
    config = load(find(vessel))
    parameters = Parameters({**config.parameters, "PATH_KIND": 0})
    guide = PathTracker(parameters, can_sway=False, turning=turning_of(config, on_the_spot=True))
    guide.start([Waypoint(20.0, 0.0, radius_m), Waypoint(20.0, 20.0, radius_m)], nav_state())
    north_m, speed_mps = 0.0, 0.0
    while True:
        setpoint = guide.update(nav_state(north_m, surge_mps=speed_mps), 1.0, DT_S).setpoint
        if abs(setpoint.yaw_rad) > math.radians(5.0):
            break
        speed_mps = setpoint.surge_mps
        north_m += speed_mps * DT_S
    early_s = (20.0 - north_m) / speed_mps
    inside_m = 0.5 * math.radians(parameters["PATH_YAW_RATE"]) * speed_mps * early_s**2
    assert inside_m <= radius_m


@pytest.mark.parametrize(
    ("vessel", "swings"), [("blueboat", True), ("heron", True), ("otter", False), ("wamv16", False)]
)
def test_a_boat_that_turns_fast_swings_through_a_waypoint_without_a_radius(vessel: str, swings: bool) -> None:
    """Boats without sideways thrust cut it by up to NAV_ACC_RAD. One that turns slowly still does: it would be carried
    off in the bend of the swing."""
    config = load(find(vessel))
    parameters = Parameters({**config.parameters, "PATH_KIND": 0})
    guide = PathTracker(parameters, can_sway=False, turning=turning_of(config, on_the_spot=True))
    assert (_miss_m(guide) < 0.2) is swings
    parameters.set("WP_CORNER", 0)
    assert _miss_m(guide) > 0.5
    assert _miss_m(guide, radius_m=0.4) < 0.4, "its own radius counts"


def test_a_boat_that_a_thruster_turns_by_pushing_it_aside_does_not_swing() -> None:
    """A dinghy with a trolling motor that turns ran 2.5 m wide in the bend."""
    config = load(find("blueboat"))
    outboard = replace(turning_of(config, on_the_spot=True), aside=True)
    guide = PathTracker(Parameters({**config.parameters, "PATH_KIND": 0}), can_sway=False, turning=outboard)
    assert _miss_m(guide) > 0.5


def _miss_m(guide: PathTracker, radius_m: float | None = None) -> float:
    """How near the track of a right angle passes its corner."""
    guide.start([Waypoint(20.0, 0.0, radius_m), Waypoint(20.0, 20.0)], nav_state())
    return min(math.dist(place, (20.0, 0.0)) for leg in guide.legs for place in leg)
