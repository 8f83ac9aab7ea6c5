"""Clearance by itself, and boats that their rudder alone turns: they step aside by nothing, and astern they do not
steer."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import pytest

from companion.config.vessel import find, load
from companion.core.angles import wrap_pi
from companion.core.estimate import Leader, NavState
from companion.core.setpoint import PathSetpoint, WrenchSetpoint
from companion.following.clearance import Clearance
from companion.following.law import FollowLaw
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST
from tests.unit.following.leaders import DT_S, Lead, RudderBoat, leader_at
from tests.unit.following.test_law import ASTERN, LEAST_M, Chase
from tests.unit.guidance.test_long_hulls import LAUNCH

JET = load(find("rescuerunner"))
BEHIND = (20.0, math.pi)


def clearance() -> Clearance:
    return Clearance(JET, Parameters(JET.parameters), can_reverse=False)


def going(nav: NavState, speed_mps: float) -> NavState:
    return replace(
        nav,
        surge_mps=speed_mps,
        north_mps=speed_mps * math.cos(nav.yaw_rad),
        east_mps=speed_mps * math.sin(nav.yaw_rad),
    )


def steady(course_rad: float, speed_mps: float) -> Callable[[float, float, float, float], tuple[float, float]]:
    return lambda _north, _east, _leader_north, _leader_east: (course_rad, speed_mps)


def evasion(leader: Leader, speed_mps: float) -> object:
    return clearance().update(0.0, speed_mps, 20.0, going(AT_REST, speed_mps), leader, steady(0.0, speed_mps))


def test_clearance_acts_only_where_the_boat_would_come_too_near() -> None:
    assert evasion(leader_at(20.0, speed_mps=8.0), 8.0) is None, "both go on alike"
    assert evasion(leader_at(300.0), 8.0) is None, "far away"
    assert evasion(leader_at(40.0), 8.0) is not None, "it stands in the way"
    assert evasion(leader_at(60.0, speed_mps=-6.0), 6.0) is not None, "it comes astern"
    assert evasion(leader_at(30.0, 40.0, speed_mps=6.0, course_rad=-1.5), 8.0) is not None, "it crosses"


def test_the_least_change_of_course_that_keeps_clear_is_pushed_for_whatever_the_heading() -> None:
    """By rounding, the boat now pushed for it and now coasted."""
    law = FollowLaw(JET, Parameters(JET.parameters), can_reverse=False)
    leader = leader_at(19.0)
    law.start(AT_REST, leader, ASTERN, 0.0)
    motion = replace(law.update(AT_REST, leader, ASTERN, 0.1), speed_mps=0.0, evading=True, resting=False)
    for heading_deg in range(-180, 180, 7):
        yaw = math.radians(heading_deg)
        aside = replace(motion, course_rad=wrap_pi(yaw + math.radians(20.0)))
        assert isinstance(law.setpoint(aside, going(replace(AT_REST, yaw_rad=yaw), 0.7), DT_S), PathSetpoint)


@pytest.mark.parametrize(
    ("bearing_deg", "distance_m", "heading_deg", "wanted_deg"),
    [(-170.0, 15.4, -116.0, 30.0), (-75.0, 18.8, -2.0, 131.0), (146.0, 19.5, -81.0, 53.0)],
)
def test_a_turn_right_round_is_made_to_one_side(
    bearing_deg: float, distance_m: float, heading_deg: float, wanted_deg: float
) -> None:
    """Near a leader that had stopped, a jet was to turn right round, to port and to starboard by turns: it did neither,
    and came to 9.9 m."""
    keeping, leader, bearing = clearance(), leader_at(0.0), math.radians(bearing_deg)
    place = replace(AT_REST, north_m=distance_m * math.cos(bearing), east_m=distance_m * math.sin(bearing))
    boat = going(replace(place, yaw_rad=math.radians(heading_deg)), 2.1)
    sides = []
    for _ in range(40):
        found = keeping.update(math.radians(wanted_deg), 2.0, 20.0, boat, leader, None)
        if found is None:
            break
        off = wrap_pi(found.course_rad - boat.yaw_rad)
        if abs(off) > math.radians(100.0):
            sides.append(off > 0.0)
        rate = boat.yaw_rate_radps + 0.1 * (math.copysign(min(abs(off), 0.5), off) - boat.yaw_rate_radps)
        yaw = wrap_pi(boat.yaw_rad + rate * DT_S)
        moved = boat.north_m + 0.21 * math.cos(yaw), boat.east_m + 0.21 * math.sin(yaw)
        boat = replace(boat, north_m=moved[0], east_m=moved[1], yaw_rad=yaw, yaw_rate_radps=rate)
        boat = going(boat, 2.1)
    assert sides and sum(a is not b for a, b in pairwise(sides)) <= 1, sides


def test_a_jet_that_turns_aside_slides_outwards_meanwhile() -> None:
    """By the sideways inertia of its hull: 5 m were predicted where it took 6."""
    slippery = replace(JET, hull=replace(JET.hull, damping=replace(JET.hull.damping, y_v=0.0, y_uv=50.0, y_vv=50.0)))
    gripping = replace(JET, hull=replace(JET.hull, damping=replace(JET.hull.damping, y_v=20_000.0)))
    slides, grips = (
        Clearance(config, Parameters(JET.parameters), can_reverse=False).nearer_m(2.0)
        for config in (slippery, gripping)
    )
    assert slides > grips + 0.7


@pytest.mark.parametrize("heading_deg", [0.0, 10.0])
def test_a_boat_that_turns_by_its_jet_is_predicted_with_the_way_that_makes(heading_deg: float) -> None:
    """It drifted near a leader at rest, and turned by 20 degrees a second time and again as if that took no thrust: to
    2.5 m/s."""
    yaw = math.radians(heading_deg)
    boat = going(replace(AT_REST, north_m=-19.0, yaw_rad=yaw), 0.7)
    found = clearance().update(yaw, 0.0, 20.0, boat, leader_at(0.0), None)
    assert found is not None and abs(wrap_pi(found.course_rad - yaw)) != pytest.approx(math.radians(20.0))


def launch_at(north_m: float, east_m: float, yaw_rad: float) -> Chase:
    """Its leader rests at the origin and points north."""
    return Chase(RudderBoat(LAUNCH, north_m, east_m, yaw_rad), Lead(0.0, 0.0), LAUNCH)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_launch_gets_out_of_the_way_while_the_leader_still_turns_back(side: float) -> None:
    """It stopped and waited until the leader headed for it, and came to 9 m."""
    chase = launch_at(-20.0, 0.0, 0.0)
    chase.sail(60.0, 1.0, follow_position=BEHIND)
    chase.sail(math.pi / 0.26, 1.0, side * 0.26, follow_position=BEHIND)
    chase.sail(40.0, 1.0, follow_position=BEHIND)
    assert chase.least_m > LEAST_M + 1.0


@pytest.mark.parametrize("speed", [0.25, 0.6])
def test_a_launch_backs_from_a_leader_that_comes_astern(speed: float) -> None:
    """It turned away instead, ahead and so towards the leader, as if that were there at once: to 9.4 m."""
    chase = launch_at(-16.0, 2.0, 0.5)
    chase.sail(1.0, 0.0, follow_position=BEHIND)
    chase.sail(25.0, -speed, follow_position=BEHIND)
    assert chase.least_m > LEAST_M + 1.0


@pytest.mark.parametrize(
    ("north_m", "east_m", "yaw_deg"), [(18.0, 3.0, 170.0), (19.0, -2.0, 100.0), (17.0, 8.0, -150.0)]
)
def test_a_launch_does_not_lie_where_a_leader_that_starts_runs_into_it(
    north_m: float, east_m: float, yaw_deg: float
) -> None:
    """Ahead of one at rest it waited for good, and had no way out when that went on: 9 m."""
    chase = launch_at(north_m, east_m, math.radians(yaw_deg))
    chase.sail(50.0, 0.0, follow_position=BEHIND)
    chase.sail(30.0, 1.0, follow_position=BEHIND)
    assert chase.least_m > LEAST_M


def test_a_launch_that_waits_brakes_and_does_not_steer() -> None:
    """Its heading was held by its rudder, and so by its propeller: it crept 8 m nearer to the leader in 40 s."""
    law = FollowLaw(LAUNCH, Parameters(LAUNCH.parameters), can_reverse=True)
    leader = leader_at(19.0)
    law.start(AT_REST, leader, ASTERN, 0.0)
    waits = replace(
        law.update(AT_REST, leader, ASTERN, 0.1), course_rad=0.0, speed_mps=0.0, evading=True, resting=False
    )
    setpoint = law.setpoint(waits, replace(going(AT_REST, 0.4), yaw_rate_radps=0.1), DT_S)
    assert isinstance(setpoint, WrenchSetpoint)
    assert setpoint.wrench.surge_n < -0.1 * LAUNCH.hull.m11_kg and setpoint.wrench.yaw_nm == 0.0


def test_the_course_chosen_does_not_turn_with_the_boat() -> None:
    """The nearest of the courses on offer, all of them off the bow, was another one each tick: a boat that turned chased
    its own course."""
    otter = load(find("otter"))
    keeping, chosen = Clearance(otter, Parameters(otter.parameters), can_reverse=True), set()
    for tick in range(18):
        boat = replace(AT_REST, yaw_rad=0.028 * tick, yaw_rate_radps=0.28)
        leader = leader_at(16.0 - 0.1 * tick, 8.0, speed_mps=1.0, course_rad=math.pi)
        found = keeping.update(0.0, 1.0, 20.0, boat, leader, None)
        assert found is not None
        chosen.add(round(found.course_rad, 6))
    assert len(chosen) <= 4, chosen


def test_while_it_keeps_clear_the_bow_turns_to_its_course_by_the_shorter_way() -> None:
    """From a heading asked for far ahead of the bow it went on the long way, 250 degrees: an Otter spun beside a leader
    that came back at it, to 11.2 m of 12."""
    otter = load(find("otter"))
    law, leader = FollowLaw(otter, Parameters(otter.parameters), can_reverse=True), leader_at(19.0)
    law.start(AT_REST, leader, ASTERN, 0.0)
    motion = replace(law.update(AT_REST, leader, ASTERN, 0.1), evading=True, resting=False)
    law.setpoint(replace(motion, course_rad=math.radians(80.0), speed_mps=0.0), AT_REST, DT_S)
    for _ in range(20):
        asked = law.setpoint(replace(motion, course_rad=math.radians(-115.0), speed_mps=1.7), AT_REST, DT_S)
    assert isinstance(asked, PathSetpoint) and math.radians(-115.0) <= asked.yaw_rad < math.radians(-30.0)


def test_while_it_keeps_clear_a_heading_asked_for_a_little_too_far_is_not_dropped() -> None:
    """It is what turns the bow: begun again at the bow each time, it let an Otter drift onto a leader that backed."""
    otter = load(find("otter"))
    law, leader = FollowLaw(otter, Parameters(otter.parameters), can_reverse=True), leader_at(19.0)
    law.start(AT_REST, leader, ASTERN, 0.0)
    motion = replace(law.update(AT_REST, leader, ASTERN, 0.1), evading=True, resting=False)
    law.setpoint(replace(motion, course_rad=0.7, speed_mps=0.0), AT_REST, DT_S)
    asked = law.setpoint(replace(motion, course_rad=0.3, speed_mps=1.0), AT_REST, DT_S)
    assert isinstance(asked, PathSetpoint) and asked.yaw_rad > 0.6
