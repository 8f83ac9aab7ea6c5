"""Missions replaced under way, sections of a route, and turns back: the place on the track and the setpoint go on
without a jump."""

from __future__ import annotations

import itertools
import math
from dataclasses import astuple

import pytest

from companion.config.vessel import find, load
from companion.guidance.agility import agility_of
from companion.guidance.path_tracking import PathProgress, PathTracker
from companion.params.store import Parameters
from tests.unit.guidance.test_path_tracking import DT_S, Puppet, points, tracker


def jumps(progress: list[PathProgress]) -> tuple[float, float, float]:
    """Largest steps of the desired position, heading and surge from one tick to the next."""
    pairs = list(itertools.pairwise(p.setpoint for p in progress))
    return (
        max(math.dist(astuple(a.progress.place), astuple(b.progress.place)) for a, b in pairs),
        max(abs(math.remainder((b.yaw_rad or 0.0) - (a.yaw_rad or 0.0), 2.0 * math.pi)) for a, b in pairs),
        max(abs(b.surge_mps - a.surge_mps) for a, b in pairs),
    )


SMOOTH = (0.15, math.radians(1.3), 0.04)


@pytest.mark.parametrize(
    "route", [((40, 10),), ((20, 30), (0, 30)), ((-20, 0),), ((20.5, 0.2), (40, 0)), ((0, -20), (0, -40))]
)
def test_replaced_under_way_the_setpoint_does_not_jump(route: tuple[tuple[float, float], ...]) -> None:
    boat = Puppet(tracker(), current=(0.0, 0.1))
    boat.tracker.start(points((50, 0)), boat.nav())
    progress = boat.sail(40.0)
    boat.tracker.replace(points(*route), boat.nav())
    progress += boat.sail(250.0)
    assert progress[-1].finished and progress[-1].passed == len(route)
    assert all(step <= most for step, most in zip(jumps(progress), SMOOTH, strict=True)), jumps(progress)


def test_replaced_every_second_it_still_gets_there() -> None:
    boat = Puppet(tracker())
    boat.tracker.start(points((50, 0)), boat.nav())
    progress = boat.sail(20.0)
    for k in range(40):
        boat.tracker.replace(points((40, 20 + 0.1 * k)), boat.nav())
        progress += boat.sail(1.0)
    progress += boat.sail(100.0)
    assert progress[-1].finished
    assert math.hypot(boat.north_m - 40.0, boat.east_m - 23.9) < 0.5
    assert all(step <= most for step, most in zip(jumps(progress), SMOOTH, strict=True)), jumps(progress)


@pytest.mark.parametrize("kind", [0, 1, 2, 3])
def test_section_by_section_is_the_same_as_the_whole(kind: int) -> None:
    route = [(15.0 * k, 8.0 * math.sin(1.3 * k)) for k in range(1, 9)]
    whole = Puppet(tracker(PATH_KIND=kind))
    whole.tracker.start(points(*route), whole.nav())
    at_once = whole.sail(400.0)
    parts = Puppet(tracker(PATH_KIND=kind))
    parts.tracker.start(points(*route[:4]), parts.nav(), stop_at_end=False, beyond=points(*route[4:]))
    by_parts = parts.sail(400.0)
    assert by_parts[-1].finished and by_parts[-1].passed == 4
    parts.tracker.go_on(points(*route[4:]), parts.nav())
    by_parts = [*by_parts[:-1], *parts.sail(400.0)]
    assert by_parts[-1].finished and by_parts[-1].passed == 4
    assert len(by_parts) == pytest.approx(len(at_once), abs=2)
    for a, b in zip(at_once, by_parts, strict=False):
        assert (*astuple(b.setpoint.progress.place), b.setpoint.yaw_rad) == pytest.approx(
            (*astuple(a.setpoint.progress.place), a.setpoint.yaw_rad), abs=0.02
        )


def test_the_boat_slows_for_a_turn_back_and_the_setpoint_does_not_jump() -> None:
    boat = Puppet(tracker())
    boat.tracker.start(points((30, 0), (0, 0)), boat.nav())
    progress = boat.sail(300.0)
    assert progress[-1].finished
    assert all(step <= most for step, most in zip(jumps(progress), SMOOTH, strict=True)), jumps(progress)
    tip = max(range(len(progress)), key=lambda i: progress[i].setpoint.progress.place.north_m)
    assert progress[tip].setpoint.surge_mps < 0.3
    assert max(p.setpoint.progress.place.north_m for p in progress) > 29.0


def paces(progress: list[PathProgress]) -> list[float]:
    """How fast the place on the track goes on from tick to tick, in boat speeds."""
    return [
        math.dist(astuple(a.progress.place), astuple(b.progress.place))
        / (DT_S * math.hypot(a.surge_mps, a.sway_mps or 0.0))
        for a, b in itertools.pairwise(p.setpoint for p in progress)
    ]


def test_led_back_the_place_on_the_track_goes_on_once_in_a_tick() -> None:
    """By projection and by itself besides, it made 3.2 boat speeds in the first tick of the way round the tip."""
    boat = Puppet(tracker(can_sway=False, PATH_YAW_RATE=30.0, WP_SPEED=1.8, MPC_XY_VEL_MAX=2.5, NAV_ACC_RAD=3.0))
    boat.tracker.start(points((60, 0)), boat.nav())
    boat.sail(15.0, 1.8)
    boat.tracker.replace(points((0, -3)), boat.nav())
    assert max(paces(boat.sail(6.0, 1.8))) <= 2.0


def test_led_back_the_place_on_a_planned_track_goes_on_once_in_a_tick() -> None:
    """As above; with the place, the heading jumped, of a model tug by 7.7 deg in a tick."""
    assert max(paces(led_back_to(10.0, 3.0).sail(12.0, 1.2))) < 1.6


def test_in_the_midst_of_a_tip_the_place_on_a_planned_track_goes_on_to_its_end() -> None:
    """Where the bend is less sharp for a moment, the place waited for a boat that turned nearly on the spot: asked to
    turn on meanwhile, a vectored catamaran was spun round twice, 12 m off its track."""
    boat = led_back_to(5.0, -8.0)
    boat.sail(3.5, 1.2)
    boat.speed_mps = boat.sway_mps = 0.0
    held = [boat.tracker.update(boat.nav(), 1.2, DT_S) for _ in range(60)]
    assert held[-1].setpoint.progress.course_rad < math.radians(-120.0)


def led_back_to(north_m: float, east_m: float) -> Puppet:
    """A boat with a plan, under way to the north, whose mission was just replaced by one to a point behind it."""
    config = load(find("aboat"))
    guide = PathTracker(Parameters(dict(config.parameters)), True, agility=agility_of(config))
    boat = Puppet(guide, sways=True)
    boat.tracker.start(points((60, 0)), boat.nav())
    boat.sail(15.0, 1.2)
    boat.tracker.replace(points((north_m, east_m)), boat.nav())
    return boat
