"""What a current that is known takes of a boat that holds or turns: the laws counter it by the model, at once."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.control.bias import BiasForce
from companion.control.controller import Controller
from companion.control.dynamic_positioning import DynamicPositioning
from companion.control.heading import YawLoop
from companion.control.model import damping, force_for, in_current
from companion.control.path_control import PathControl
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.frames import ned_to_body
from companion.core.setpoint import PathSetpoint, PoseSetpoint
from companion.params.store import Parameters
from companion.params.table import table_of
from tests.unit.control.simple_boat import nav_state
from tests.unit.estimates import AT_REST

ABOAT = load(find("aboat"))
PARAMETERS = Parameters(ABOAT.parameters)
CALM = replace(AT_REST, wind_speed_mps=0.0, wind_from_rad=0.0)  # measured


def forces(wrench: Wrench) -> tuple[float, float, float]:
    return wrench.surge_n, wrench.sway_n, wrench.yaw_nm


def test_a_boat_that_turns_as_the_water_carries_it_only_turns() -> None:
    """Its velocity over ground is constant in NED, and so changes in its axes."""
    x, y, r = 0.3, -0.2, 0.4
    over_ground = force_for(ABOAT.hull, x, y, r, r * y, -r * x, 0.0)
    more = in_current(ABOAT.hull, x, y, r, x, y)
    whole = [a + b for a, b in zip(forces(over_ground), forces(more), strict=True)]
    assert whole == pytest.approx(forces(force_for(ABOAT.hull, 0.0, 0.0, r, 0.0, 0.0, 0.0)), abs=1e-9)


@pytest.mark.parametrize(("north", "east"), [(0.3, 0.0), (-0.3, 0.0), (0.0, 0.3), (-0.2, -0.2)])
def test_a_planned_turn_takes_the_same_forces_in_a_current(north: float, east: float) -> None:
    """The same turn through the water. Left out, the water's share of the turn is 14 N here, and takes the boat 0.1 m
    off a corner."""
    law = PathControl(ABOAT, PARAMETERS, YawLoop(ABOAT, PARAMETERS))
    u, r = 0.7, 0.35
    still = law.update(
        PathSetpoint(0.0, u, 0.0, r, exact=True), replace(CALM, surge_mps=u, yaw_rate_radps=r), fresh_bias(), 0.1
    )
    law.restart()
    setpoint = PathSetpoint(0.0, u + north, east, r, r * east, sway_mps2=-r * north, exact=True)
    nav = replace(
        CALM,
        surge_mps=u + north,
        sway_mps=east,
        yaw_rate_radps=r,
        current_north_mps=north,
        current_east_mps=east,
    )
    assert forces(law.update(setpoint, nav, fresh_bias(), 0.1)) == pytest.approx(forces(still), abs=1.0)


def test_a_steady_force_is_given_where_the_thrust_finds_the_bow() -> None:
    """In a turn of 20° a second the bow is 8° further when a command has become thrust."""
    law = PathControl(ABOAT, PARAMETERS, YawLoop(ABOAT, PARAMETERS))
    bias = fresh_bias()
    bias.grow(80.0, 0.0, 0.0, 0.0, 1.0)
    r = math.radians(20.0)
    nav = replace(CALM, yaw_rate_radps=r)
    with_it = law.update(PathSetpoint(0.0, 0.0, 0.0, r, exact=True), nav, bias, 0.1)
    law.restart()
    without = law.update(PathSetpoint(0.0, 0.0, 0.0, r, exact=True), nav, fresh_bias(), 0.1)
    x, y = with_it.surge_n - without.surge_n, with_it.sway_n - without.sway_n
    assert math.degrees(math.atan2(y, x)) == pytest.approx(-8.0, abs=0.1)
    assert math.hypot(x, y) == pytest.approx(80.0)


def test_a_current_that_becomes_known_does_not_change_the_thrust_at_once() -> None:
    """The integral has learnt it until then, or what the estimate takes for one. ReVolt, braking before a fence with
    its model wrong by 0.4, was pushed ahead by 15 N, and came 0.2 m over the line."""
    law, setpoint = Controller(ABOAT, PARAMETERS), PathSetpoint(0.0, 0.7, exact=True)
    unknown = replace(CALM, surge_mps=0.7)
    known = replace(unknown, current_north_mps=-0.4, current_east_mps=0.0)
    slowed, achieved = replace(unknown, surge_mps=0.6), ZERO_WRENCH
    while achieved.surge_n < 113.0 + 20.0:  # with 0.1 m/s missing; the drag at 1.1 m/s is 113 N
        achieved = law.update(setpoint, slowed, achieved, 0.1)
    before = law.update(setpoint, unknown, achieved, 0.01)
    for nav in (known, known, unknown, known):
        achieved = law.update(setpoint, nav, achieved, 0.01)
        assert achieved.surge_n == pytest.approx(before.surge_n, abs=10.0)


def test_a_current_that_becomes_known_before_the_integral_has_learnt_it_counts_at_once() -> None:
    law, setpoint = Controller(ABOAT, PARAMETERS), PathSetpoint(0.0, 0.7, exact=True)
    unknown = replace(CALM, surge_mps=0.7)
    before = law.update(setpoint, unknown, ZERO_WRENCH, 0.01)
    after = law.update(setpoint, replace(unknown, current_north_mps=-0.4, current_east_mps=0.0), before, 0.01)
    more = damping(ABOAT.hull, 1.1, 0.0, 0.0)[0] - damping(ABOAT.hull, 0.7, 0.0, 0.0)[0]
    assert after.surge_n - before.surge_n == pytest.approx(more, abs=1.0)


def test_a_known_current_is_held_against_from_the_first_cycle() -> None:
    nav = replace(CALM, yaw_rad=0.5, current_north_mps=0.1, current_east_mps=-0.3)
    law = DynamicPositioning(ABOAT, PARAMETERS)
    wrench = law.update(PoseSetpoint(0.0, 0.0, 0.5), nav, fresh_bias(), 0.1)
    c, s = math.cos(0.5), math.sin(0.5)
    x, y = -(0.1 * c - 0.3 * s), -(-0.3 * c - 0.1 * s)
    assert (wrench.surge_n, wrench.sway_n) == pytest.approx(damping(ABOAT.hull, x, y, 0.0)[:2])


def test_what_may_be_the_push_of_a_wind_that_nobody_measures_is_left_to_the_integral() -> None:
    """CyberShip II, pushed by 1.5 N, turned its bow by 8 degrees against the Munk moment of a stream that was none."""
    law, nav = DynamicPositioning(ABOAT, PARAMETERS), replace(AT_REST, current_north_mps=-0.5, current_east_mps=0.2)
    assert forces(law.update(PoseSetpoint(0.0, 0.0, 0.5), replace(nav, yaw_rad=0.5), fresh_bias(), 0.1)) == (0, 0, 0)


def test_what_the_estimate_of_the_current_wanders_by_hardly_moves_the_thrusters() -> None:
    law, setpoint = DynamicPositioning(ABOAT, PARAMETERS), PoseSetpoint(0.0, 0.0, 0.0)
    nav = replace(CALM, current_north_mps=0.0, current_east_mps=0.3)
    for _ in range(700):
        before = law.update(setpoint, nav, fresh_bias(), 0.1)
    after = law.update(setpoint, replace(nav, current_east_mps=0.4), fresh_bias(), 0.1)
    assert abs(after.sway_n - before.sway_n) < 0.1
    unknown = replace(nav, current_north_mps=None, current_east_mps=None)
    assert law.update(setpoint, unknown, fresh_bias(), 0.1) == after, "the last mean counts on"


def fresh_bias() -> BiasForce:
    return BiasForce(ABOAT.limits)


def worst_error_mps(over_ground: bool, known: bool) -> float:
    """Of the speed ahead of a boat without sideways thrust that turns in a stream by 2 degrees a second, once the
    first turn has shown the law what there is to learn."""
    boat = load(find("otter"))
    parameters, hull = Parameters(boat.parameters, table_of(boat)), boat.hull
    law, bias = PathControl(boat, parameters, YawLoop(boat, parameters)), BiasForce(boat.limits)
    stream, rate, surge_mps, worst = (0.4, 0.0), math.radians(2.0), 1.0, 0.0
    for step in range(3600):
        yaw_rad = 0.1 * rate * step
        nav = nav_state(yaw_rad=yaw_rad, surge_mps=surge_mps, yaw_rate_radps=rate, current=stream if known else None)
        setpoint = PathSetpoint(yaw_rad, 1.0, yaw_rate_radps=rate, over_ground=over_ground)
        force_n = law.update(setpoint, nav, bias, 0.1).surge_n
        along_mps, across_mps = ned_to_body(*stream, yaw_rad)
        drag_n = damping(hull, surge_mps - along_mps, 0.0, 0.0)[0]
        surge_mps += 0.1 * ((force_n - drag_n) / hull.m11_kg + rate * across_mps)
        if step > 1800:
            worst = max(worst, abs(surge_mps - 1.0))
    return worst


def test_the_speed_of_a_boat_that_turns_in_a_stream_is_kept_without_a_track() -> None:
    """The integral alone comes too late for a stream that turns round the boat."""
    assert worst_error_mps(over_ground=False, known=True) > 0.06
    assert worst_error_mps(over_ground=True, known=False) < 0.04
    assert worst_error_mps(over_ground=True, known=True) < 0.006


def test_a_current_that_is_known_in_every_other_tick_does_not_rock_the_thrust() -> None:
    """Its uncertainty can hover about the limit of use. Taken as it came, it swung a boat's thrust by 12 N a tick."""
    boat = load(find("heron"))
    parameters = Parameters(boat.parameters, table_of(boat))
    law, bias = PathControl(boat, parameters, YawLoop(boat, parameters)), BiasForce(boat.limits)
    forces_n = []
    for step in range(600):
        nav = nav_state(surge_mps=0.84, current=None if step % 2 else (-0.6, 0.0))
        forces_n.append(law.update(PathSetpoint(0.0, 0.84, over_ground=True), nav, bias, 0.1).surge_n)
    steps_n = [abs(b - a) for a, b in itertools.pairwise(forces_n)]
    assert forces_n[-1] - forces_n[0] > 5.0 and max(steps_n) < 0.3
