"""Guidance, control, allocation and gate together on a boat whose inertia and damping are not what the controller
believes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import pytest

from companion.allocation.allocator import Allocator
from companion.baselines.controller_choice import controller_with_baselines
from companion.core.actuation import ZERO_WRENCH
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.setpoint import Setpoint
from companion.guidance.path_tracking import PathProgress, PathTracker
from companion.guidance.reference import ReferenceGenerator
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from companion.safety import Gate
from tests.unit.control.simple_boat import BOW_DOWN, REVOLT, SimpleBoat

DT_S = 0.1
SQUARE = [(20.0, 0.0), (20.0, 20.0), (0.0, 20.0), (0.0, 0.0)]


class Stack:
    """One boat under control."""

    def __init__(self, boat: SimpleBoat) -> None:
        self.boat = boat
        self.parameters = Parameters(REVOLT.parameters)
        self.reference = ReferenceGenerator(self.parameters)
        self.tracker = PathTracker(self.parameters, can_sway=True)
        self._controller = controller_with_baselines(REVOLT, self.parameters)
        self._allocator = Allocator(REVOLT, self.parameters)
        self._gate = Gate(REVOLT)
        self._achieved = ZERO_WRENCH
        self.gated = 0

    def cycle(self, guide: Callable[[NavState], Setpoint]) -> Setpoint:
        nav = self.boat.nav()
        setpoint = guide(nav)
        wrench = self._controller.update(setpoint, nav, self._achieved, DT_S)
        allocation = self._allocator.update(wrench, DT_S)
        self._achieved = allocation.achieved
        command = self._gate.update(allocation, True, self.boat.t_s, DT_S, True, BOW_DOWN)
        self.gated += len(command.gated)
        self.boat.sail(command, DT_S)
        return setpoint

    def position(self, seconds: float) -> list[tuple[float, float]]:
        """Dynamic positioning for that long; (distance, heading error) to the reference after each step."""
        errors = []
        for _ in range(round(seconds / DT_S)):
            s = self.cycle(lambda nav: self.reference.update(DT_S))
            errors.append(
                (
                    math.hypot(self.boat.north_m - s.north_m, self.boat.east_m - s.east_m),
                    abs(wrap_pi(self.boat.yaw_rad - s.yaw_rad)),
                )
            )
        return errors


@pytest.mark.parametrize("factor", [0.8, 1.0, 1.2])
def test_a_step_of_position_and_heading_is_followed_and_held(factor: float) -> None:
    stack = Stack(SimpleBoat(factor=factor))
    stack.reference.start(0.0, 0.0, 0.0)
    stack.reference.retarget(5.0, -5.0, math.radians(-45.0))
    under_way = stack.position(70.0)
    assert stack.reference.arrived
    assert max(e for e, _ in under_way) < 0.25
    assert max(e for _, e in under_way) < math.radians(4.0)
    settled = stack.position(60.0)[-100:]
    assert max(e for e, _ in settled) < 0.05
    assert max(e for _, e in settled) < math.radians(0.5)
    assert stack.gated == 0


@pytest.mark.parametrize("factor", [0.8, 1.2])
def test_a_constant_force_is_learnt_and_countered(factor: float) -> None:
    stack = Stack(SimpleBoat(factor=factor, force_ned=(-4.0, 5.0), moment_nm=3.0))
    stack.reference.start(0.0, 0.0, 0.5)
    stack.boat.yaw_rad = 0.5
    stack.position(150.0)
    held = stack.position(60.0)
    assert max(e for e, _ in held) < 0.03
    assert max(e for _, e in held) < math.radians(0.5)


def test_a_force_beyond_the_thrusters_leaves_no_windup() -> None:
    stack = Stack(SimpleBoat(force_ned=(0.0, 40.0)))
    stack.reference.start(0.0, 0.0, 0.0)
    stack.position(60.0)
    assert stack.boat.east_m > 1.0, "the gale carries the boat off"
    stack.boat.force_ned = (0.0, 0.0)
    back = stack.position(120.0)
    assert min(stack.boat.east_m, 0.0) > -0.3
    assert back[-1][0] < 0.1


def sail(stack: Stack, points: list[tuple[float, float]], seconds: float) -> list[tuple[PathProgress, float, float]]:
    """Follow `points` at 0.6 m/s; (progress, north, east) of each step."""
    stack.tracker.start([Waypoint(n, e) for n, e in points], stack.boat.nav())
    track: list[tuple[PathProgress, float, float]] = []

    def guide(nav: NavState) -> Setpoint:
        track.append((stack.tracker.update(nav, 0.6, DT_S), stack.boat.north_m, stack.boat.east_m))
        return track[-1][0].setpoint

    while stack.boat.t_s < seconds and not (track and track[-1][0].finished):
        stack.cycle(guide)
    return track


@pytest.mark.parametrize(("factor", "current"), [(1.0, (0.0, 0.0)), (0.8, (0.1, 0.15)), (1.2, (0.0, 0.2))])
def test_a_square_is_sailed_in_a_current(factor: float, current: tuple[float, float]) -> None:
    stack = Stack(SimpleBoat(factor=factor, current=current))
    track = sail(stack, SQUARE, 300.0)
    assert track[-1][0].finished and track[-1][0].passed == 4
    errors = [p.setpoint.progress.cross_track_error_m or 0.0 for p, _, _ in track]
    assert math.sqrt(sum(e * e for e in errors) / len(errors)) < 0.5
    for waypoint in SQUARE:
        assert min(math.dist(waypoint, (n, e)) for _, n, e in track) < 1.0


def test_no_waypoint_is_circled_in_the_strongest_current_that_the_boat_can_stem() -> None:
    stack = Stack(SimpleBoat(current=(0.0, 0.45)))
    track = sail(stack, [(20.0, 0.0), (20.0, 10.0), (0.0, 10.0)], 400.0)
    assert track[-1][0].finished
    turned = sum(
        abs(wrap_pi((b.setpoint.progress.course_rad or 0.0) - (a.setpoint.progress.course_rad or 0.0)))
        for (a, _, _), (b, _, _) in itertools.pairwise(track)
    )
    assert turned < math.radians(200.0), "the path's own two right angles and no more"


def test_from_path_to_point_there_is_no_bump() -> None:
    stack = Stack(SimpleBoat(force_ned=(0.0, 6.0)))
    sail(stack, [(12.0, 0.0)], 100.0)
    nav = stack.boat.nav()
    stack.reference.start(nav.north_m, nav.east_m, nav.yaw_rad, nav.surge_mps, nav.sway_mps, nav.yaw_rate_radps)
    assert max(e for e, _ in stack.position(60.0)) < 0.35
