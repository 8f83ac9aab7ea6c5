"""The guard stops the boat in time, looks for a way round, and gives up where there is none."""

from __future__ import annotations

import math
from concurrent.futures import Future
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import LineString, Point, box

from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.decision import ModeInputs
from companion.core.estimate import Contact
from companion.core.events import EventLog
from companion.core.setpoint import HeadingSetpoint, PathSetpoint, PoseSetpoint, Setpoint, WrenchSetpoint
from companion.fence.allowed import Way
from companion.obstacles.chart_water import ChartKeeper
from companion.obstacles.guard import ObstacleGuard
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST
from tests.unit.obstacles.charted import FRAME, feature
from tests.unit.obstacles.stubs import NoTraffic, Sailing, Seen, no_fence

OTTER, JET = load(find("otter")), load(find("rescuerunner"))
STOP_M = math.hypot(1.0, 0.54) + 0.3 * 3.0  # from the middle of the boat: to a corner, and the share of CP_DIST


class Bridge:
    """One guard, its surroundings and its time."""

    def __init__(self, *circles: tuple[float, float, float], config: VesselConfig = OTTER) -> None:
        self.parameters = Parameters()
        self.seen = Seen(np.array(circles, dtype=float).reshape(-1, 3))
        self.events = EventLog()
        self.chart = ChartKeeper(config, self.parameters, lambda: FRAME)
        fence = no_fence(config, self.parameters)
        around: Any = self.seen
        self.guard = ObstacleGuard(config, self.parameters, around, fence, self.events, self.chart)
        self.now_s = 0.0

    def steer(
        self, setpoint: Setpoint, mode: Sailing, dt_s: float = 0.5, unasked: bool = False, **nav: float
    ) -> Setpoint:
        self.now_s += dt_s
        inputs = ModeInputs(replace(AT_REST, **nav), None, None, 1.0, self.now_s, dt_s)
        return self.guard.steer(setpoint, mode, inputs, NoTraffic(), unasked)

    def texts(self) -> list[str]:
        return [event.text for event in self.events.drain()]


def closed_form_mps(way_m: float, parameters: Parameters) -> float:
    """v t + v²/2a = way, with all of the braking that paths ask for."""
    a, t = 1.5 * parameters["PATH_ACC"], 1.5 / parameters["PATH_BW_SURGE"] + parameters["CP_DELAY"]
    return a * (math.sqrt(t * t + 2.0 * max(0.0, way_m) / a) - t)


def motion(speed_mps: float, course_rad: float) -> dict[str, float]:
    return {
        "surge_mps": speed_mps,
        "yaw_rad": course_rad,
        "north_mps": speed_mps * math.cos(course_rad),
        "east_mps": speed_mps * math.sin(course_rad),
    }


circles = st.tuples(st.floats(-40.0, 40.0), st.floats(-40.0, 40.0), st.floats(0.25, 3.0))


@given(st.lists(circles, min_size=1, max_size=15), st.floats(-3.1, 3.1), st.floats(0.2, 2.0))
def test_the_speed_is_at_most_the_one_from_which_it_stops_in_time(
    things: list[tuple[float, float, float]], course_rad: float, speed_mps: float
) -> None:
    """The way to the nearest thing ahead by shapely, the speed by the closed form."""
    bridge = Bridge(*things)
    asked = PathSetpoint(course_rad, surge_mps=speed_mps)
    got = bridge.steer(asked, Sailing(), **motion(speed_mps, course_rad))
    assert isinstance(got, PathSetpoint)
    ray = LineString([(0.0, 0.0), (100.0 * math.cos(course_rad), 100.0 * math.sin(course_rad))])
    way_m = math.inf
    for north_m, east_m, radius_m in things:
        kept = Point(north_m, east_m).buffer(radius_m + STOP_M, quad_segs=128)
        ahead = north_m * math.cos(course_rad) + east_m * math.sin(course_rad) > 0.0
        if ahead and kept.intersects(ray):
            way_m = min(way_m, 0.0 if kept.contains(Point(0.0, 0.0)) else Point(0.0, 0.0).distance(kept & ray))
    limit = math.inf if math.isinf(way_m) else closed_form_mps(way_m, bridge.parameters)
    assert got.surge_mps == pytest.approx(min(speed_mps, limit), abs=0.03)
    assert got.surge_mps <= speed_mps


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_boat_that_obeys_comes_to_rest_short_of_it(way: float) -> None:
    """The speed follows its setpoint as the speed loop does, with its feed-forward. Stern first (`way` −1) too."""
    bridge, place, speed = Bridge((30.0, 0.0, 1.0)), 0.0, 1.0
    yaw_rad = 0.0 if way > 0.0 else math.pi
    for _ in range(1200):
        nav = {"north_m": place, "north_mps": speed, "yaw_rad": yaw_rad, "surge_mps": way * speed}
        got = bridge.steer(PathSetpoint(yaw_rad, surge_mps=way), Sailing(), 0.1, **nav)
        assert isinstance(got, PathSetpoint)
        ahead_mps, gain_mps2 = way * got.surge_mps, way * got.surge_mps2
        speed += 0.1 * (bridge.parameters["PATH_BW_SURGE"] * (ahead_mps - speed) + gain_mps2)
        place += 0.1 * speed
    assert speed < 0.03
    assert 30.0 - 1.0 - STOP_M - 1.0 < place < 30.0 - 1.0 - STOP_M + 0.15


def test_a_chart_stops_the_boat_as_what_is_seen_does() -> None:
    bridge = Bridge()
    bridge.chart.load([feature("quay", box(10.0, -30.0, 12.0, 30.0))])
    got = bridge.steer(PathSetpoint(0.0, surge_mps=2.0), Sailing(), **motion(2.0, 0.0))
    assert isinstance(got, PathSetpoint)
    assert got.surge_mps == pytest.approx(closed_form_mps(10.0 - STOP_M, bridge.parameters), abs=0.03)
    away = bridge.steer(PathSetpoint(math.pi, surge_mps=2.0), Sailing(), **motion(2.0, math.pi))
    assert away == PathSetpoint(math.pi, surge_mps=2.0)


def test_the_stick_in_heading_is_governed() -> None:
    bridge = Bridge((4.0, 0.0, 1.0))
    full = HeadingSetpoint(0.0, Wrench(200.0, 0.0, 0.0))
    got = bridge.steer(full, Sailing(), **motion(1.0, 0.0))
    assert isinstance(got, HeadingSetpoint) and got.wrench.surge_n < 0.0
    astern = HeadingSetpoint(0.0, Wrench(-50.0, 0.0, 0.0))
    assert bridge.steer(astern, Sailing(), **motion(0.0, 0.0)) == astern


def test_without_a_position_heading_says_once_that_obstacles_are_not_minded() -> None:
    """The boat ran on at a stone that it saw, without a word."""
    bridge = Bridge((4.0, 0.0, 1.0))
    full = HeadingSetpoint(0.0, Wrench(200.0, 0.0, 0.0))
    blind = {"position_valid": False, **motion(1.0, 0.0)}
    for _ in range(3):
        assert bridge.steer(full, Sailing(), **blind) == full
    assert bridge.texts() == ["No position: obstacles are not avoided"]
    bridge.seen.heard = False
    bridge.steer(full, Sailing(), **motion(1.0, 0.0))
    bridge.steer(full, Sailing(), **blind)
    assert not bridge.texts(), "no sensor looks for any"


def test_the_stick_aside_is_governed_where_there_is_thrust_aside() -> None:
    """A stone abeam: only the force ahead was limited."""
    bridge = Bridge((0.0, 5.0, 1.0), config=load(find("aboat")))
    aside = HeadingSetpoint(0.0, Wrench(20.0, 150.0, 0.0))
    got = bridge.steer(aside, Sailing(), sway_mps=1.0, east_mps=1.0)
    assert isinstance(got, HeadingSetpoint) and got.wrench.sway_n < 0.0
    assert got.wrench.surge_n == pytest.approx(20.0)
    away = HeadingSetpoint(0.0, Wrench(0.0, -150.0, 0.0))
    assert bridge.steer(away, Sailing()) == away


def test_in_a_mode_that_leads_round_nothing_a_stopped_boat_holds_until_the_way_is_free() -> None:
    """An Otter that a stone had stopped on its circle was carried onto it by the wind."""
    bridge = Bridge((2.4, 0.0, 1.0))
    asked, mode = PathSetpoint(0.0, surge_mps=1.0), Sailing()
    for _ in range(8):
        bridge.steer(asked, mode)
    assert bridge.texts() == ["Obstacle ahead: slowing down", "Obstacle ahead: stopped"]
    held = bridge.steer(asked, mode, north_m=0.5, east_m=0.5).progress.place
    assert held is not None and (held.north_m, held.east_m) == (0.0, 0.0)
    set_on = {"north_m": 0.2, "north_mps": 0.2, "surge_mps": 0.2, "current_north_mps": 0.2, "current_east_mps": 0.0}
    away = bridge.steer(asked, mode, **set_on)
    assert isinstance(away, PathSetpoint) and away.surge_mps < 0.0, "a stream sets it onto the stone"
    bridge.seen.circles = np.zeros((0, 3))
    assert bridge.steer(asked, mode) is asked


def test_dynamic_positioning_at_a_velocity_stops_in_time() -> None:
    """A boat with two azimuths in Offboard began its stop at 0.7 m/s where that was a third too late, and lay with its
    bow on the stone."""
    boat = load(find("aboat"))
    bridge, mode = Bridge((12.0, 0.0, 1.0), config=boat), Sailing()
    assert bridge.parameters.set("PATH_ACC", 0.5) is None  # five times DP_ACC_SURGE
    north_m, speed_mps = 0.0, 0.5
    for tick in range(600):  # it goes as it is told
        asked = PoseSetpoint(0.05 * tick, 0.0, 0.0, 0.5)
        got = bridge.steer(asked, mode, 0.1, north_m=north_m, **motion(speed_mps, 0.0))
        assert isinstance(got, PoseSetpoint)
        north_m, speed_mps = got.north_m, got.surge_mps
    assert bridge.texts() == ["Obstacle ahead: stopped"] and speed_mps == pytest.approx(0.0, abs=1e-3)
    assert 4.0 < north_m < 12.0 - 1.0 - 0.5 * boat.length_m - 0.5


@pytest.mark.parametrize("of", ["the operator", "a mode with a way"])
def test_others_do_not_hold_there(of: str) -> None:
    bridge = Bridge((2.4, 0.0, 1.0))
    mode = Sailing(by_stick=of == "the operator", goes_round=of != "the operator")
    for _ in range(8):
        got = bridge.steer(PathSetpoint(0.0, surge_mps=1.0), mode)
    assert got.progress.place is None and "Obstacle ahead: stopped" not in bridge.texts()


@pytest.mark.parametrize("case", ["off", "docking", "blind"])
def test_it_keeps_out_of_the_way(case: str) -> None:
    bridge = Bridge((4.0, 0.0, 1.0))
    bridge.seen.on = case != "off"
    asked = PathSetpoint(0.0, surge_mps=2.0)
    mode = Sailing(docking=case == "docking")
    assert bridge.steer(asked, mode, position_valid=case != "blind", **motion(2.0, 0.0)) is asked


def test_positioning_stops_before_what_is_in_its_way_and_goes_on_when_it_is_gone() -> None:
    bridge = Bridge((8.0, 0.0, 1.0))
    pose = PoseSetpoint(20.0, 0.0, 0.0, surge_mps=0.6)
    near = {"north_m": 4.5, **motion(0.6, 0.0)}
    held = bridge.steer(pose, Sailing(), **near)
    assert held is not pose and isinstance(held, PathSetpoint | PoseSetpoint)
    assert "Obstacle ahead: stopped" in bridge.texts()
    bridge.seen.circles = np.zeros((0, 3))
    assert bridge.steer(pose, Sailing(), **near) is pose


def test_a_blocked_way_is_laid_round() -> None:
    bridge, mode = Bridge((30.0, 0.0, 1.0)), Sailing([(0.0, 0.0), (60.0, 0.0)], goes_round=True)
    for _ in range(3):
        bridge.steer(PathSetpoint(0.0, surge_mps=1.0), mode, **motion(1.0, 0.0))
    (way,) = mode.laid
    assert isinstance(way, Way) and len(way.points) > 2
    assert LineString(way.points).distance(Point(30.0, 0.0)) > 1.0 + 3.0
    assert "Obstacle ahead: going round" in bridge.texts()


def test_a_free_way_on_which_the_boat_is_stopped_is_laid_anew_from_where_it_stands() -> None:
    """It bends away from what lies ahead of the boat, which stands before the bend."""
    bridge = Bridge((3.0, 0.0, 1.0))
    mode = Sailing(((0.0, 0.0), (0.0, 20.0)), goes_round=True, found=Way(((0.0, 0.0), (0.0, 20.0)), 20.0))
    for _ in range(20):
        bridge.steer(PathSetpoint(0.0, surge_mps=1.0), mode)
    assert "Obstacle ahead: going round" in bridge.texts()


def test_a_way_is_looked_for_beside_and_laid_when_it_is_found() -> None:
    class Later:
        """A worker that takes its time."""

        def __init__(self) -> None:
            self.jobs: list[tuple[Any, Future[Any]]] = []

        def submit(self, work: Any, urgent: bool = False) -> Future[Any]:
            self.jobs.append((work, Future()))
            return self.jobs[-1][1]

    bridge, mode, worker = Bridge((30.0, 0.0, 1.0)), Sailing([(0.0, 0.0), (60.0, 0.0)], goes_round=True), Later()
    bridge.guard.work_with(worker)
    for _ in range(20):
        bridge.steer(PathSetpoint(0.0, surge_mps=1.0), mode, **motion(1.0, 0.0))
    assert len(worker.jobs) == 1 and not mode.laid, "one search at a time"
    work, future = worker.jobs[0]
    future.set_result(work())
    bridge.steer(PathSetpoint(0.0, surge_mps=1.0), mode, **motion(1.0, 0.0))
    assert len(mode.laid) == 1


def test_without_a_way_it_waits_and_then_gives_up() -> None:
    ring = [(20.0 + 8.0 * math.cos(a), 8.0 * math.sin(a), 3.0) for a in np.linspace(0.0, math.tau, 12, endpoint=False)]
    bridge, mode = Bridge(*ring), Sailing([(0.0, 0.0), (20.0, 0.0)], goes_round=True)
    waited_s = 0.0
    while bridge.guard.impossible is None:
        assert waited_s < 60.0
        bridge.steer(PathSetpoint(0.0, surge_mps=0.0), mode, **motion(0.0, 0.0))
        waited_s += 0.5
    assert waited_s > bridge.parameters["CP_WAIT"] and set(mode.laid) == {None}
    assert bridge.guard.impossible == "no open water"


def mover(north_m: float, east_m: float, north_mps: float, east_mps: float) -> Contact:
    return Contact(-1, "mover 1", north_m, east_m, north_mps, east_mps, 1.0, None)


def test_a_boat_at_rest_gets_out_of_the_way_of_what_comes() -> None:
    bridge = Bridge()
    bridge.seen.moving = [mover(0.5, -8.0, 0.0, 0.8)]
    bridge.seen.circles = np.array([(0.5, -8.0, 1.0)])
    mode = Sailing([(0.0, 0.0), (60.0, 0.0)], goes_round=True)
    got = bridge.steer(PathSetpoint(0.0), mode)
    assert isinstance(got, PathSetpoint) and abs(got.surge_mps) >= 0.5 and mode.excused
    assert "Obstacle comes near: out of its way" in bridge.texts()


@pytest.mark.parametrize("drifts", [True, False])
def test_in_a_hold_that_nobody_asked_for_it_gets_out_of_the_way_too(drifts: bool) -> None:
    """After a mission that was given up. Where a person chose Hold, it would flee the dinghy that fetches it."""
    for unasked in (True, False):
        bridge, mode = Bridge(), Sailing(drifts=drifts)
        bridge.seen.moving = [mover(0.5, -8.0, 0.0, 0.8)]
        bridge.seen.circles = np.array([(0.5, -8.0, 1.0)])
        got = bridge.steer(PoseSetpoint(0.0, 0.0, 0.0), mode, unasked=unasked)
        assert isinstance(got, PathSetpoint) == unasked


def test_it_does_not_give_up_while_something_comes() -> None:
    """What comes after it, Hold, would stay where it is."""
    ring = [(20.0 + 8.0 * math.cos(a), 8.0 * math.sin(a), 3.0) for a in np.linspace(0.0, math.tau, 12, endpoint=False)]
    bridge, mode = Bridge(*ring), Sailing([(0.0, 0.0), (20.0, 0.0)], goes_round=True)
    # for ever as near: the boat of this test never moves; and what is still too far away for it to do something
    for coming in (mover(0.5, -8.0, 0.0, 0.8), mover(0.5, -15.0, 0.0, 0.8)):
        for _ in range(int(4.0 * bridge.parameters["CP_WAIT"])):
            bridge.seen.moving = [coming]
            bridge.steer(PathSetpoint(0.0), mode)
        assert bridge.guard.impossible is None
    bridge.seen.moving = []
    while bridge.guard.impossible is None:
        bridge.steer(PathSetpoint(0.0), mode)
    assert bridge.guard.impossible == "no open water"


def test_a_boat_that_drifts_onto_what_lies_keeps_off() -> None:
    """To starboard by a current, onto a stone abeam of its bow: astern is the way out."""
    bridge = Bridge((0.9, 3.2, 0.7))
    mode = Sailing([(0.0, 0.0), (60.0, 0.0)], goes_round=True)
    drift = {"sway_mps": 0.3, "east_mps": 0.3, "current_north_mps": 0.0, "current_east_mps": 0.3}
    got = bridge.steer(PathSetpoint(0.0), mode, **drift)
    assert isinstance(got, PathSetpoint) and got.surge_mps < -0.1
    still = Bridge((0.9, 3.2, 0.7))
    assert still.steer(PathSetpoint(0.0), mode) == PathSetpoint(0.0)


def test_in_hold_a_boat_that_cannot_keep_its_point_keeps_off_what_lies_in_its_watch_circle() -> None:
    """It lets itself be carried, without thrust: kayaks, dinghies and launches drifted onto stones that they saw."""
    carried, drift = WrenchSetpoint(ZERO_WRENCH), {"sway_mps": 0.15, "east_mps": 0.15}
    for mode, keeps_off in ((Sailing(drifts=True), True), (Sailing(), False)):
        got = Bridge((0.9, 2.4, 0.7)).steer(carried, mode, **drift)
        assert isinstance(got, PathSetpoint) == keeps_off, "one that keeps its point stays there"


def test_a_jet_that_would_turn_onto_a_stone_gives_no_thrust() -> None:
    """A heading would cost thrust, which would drive it on."""
    bridge = Bridge((12.0, -3.0, 2.5), config=JET)
    asked = PathSetpoint(math.radians(-168.0), surge_mps=0.5)
    assert bridge.steer(asked, Sailing(drifts=True), **motion(1.2, 0.0)) == WrenchSetpoint(ZERO_WRENCH)


def test_without_thrust_astern_and_without_a_way_a_boat_coasts() -> None:
    """Thrust that turns it along its old way would speed it up, and it could not stop."""
    ring = [(24.0 + 8.0 * math.cos(a), 8.0 * math.sin(a), 3.0) for a in np.linspace(0.0, math.tau, 12, endpoint=False)]
    bridge = Bridge(*ring, config=JET)
    mode = Sailing([(0.0, 0.0), (24.0, 0.0)], goes_round=True)
    asked = PathSetpoint(0.3, surge_mps=2.0)
    got = [bridge.steer(asked, mode, **motion(2.0, 0.0)) for _ in range(6)]
    assert isinstance(got[0], PathSetpoint) and 0.0 < got[0].surge_mps < 2.0, "a way may still be found"
    assert got[-1] == WrenchSetpoint(ZERO_WRENCH)
