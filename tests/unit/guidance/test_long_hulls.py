"""Straight legs of a launch that turns slowly and slides outwards: its course follows its bow 5 m late."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

import pytest

from companion.cli.new_file import Answers, file_text
from companion.config.vessel import VesselConfig, parse
from companion.core.angles import wrap_pi
from companion.core.estimate import NO_ESTIMATE, NavState
from companion.guidance.path_tracking import PathProgress, PathTracker
from companion.guidance.turning import Turning, turning_of
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from sitl.hull import dynamics
from tests.unit.control.simple_boat import nav_state

ANSWERS = Answers(
    "launch", "Launch", "monohull", 7.2, 2.4, 1800.0, None, None, None, "rudder", "1200", None, 0.0, "microcontroller",
    "one", 63.442, 10.4,
)  # fmt: skip
LAUNCH = parse(file_text(ANSWERS), "launch.toml")
SHIP_ANSWERS = replace(
    ANSWERS, name="ship", length_m=12.0, beam_m=3.6, mass_kg=14000.0, layout="rudder-bow", motor="9000",
    bow_motor="1500",
)  # fmt: skip
SHIP = parse(file_text(SHIP_ANSWERS), "ship.toml")
SHIP_TURNING = turning_of(SHIP, on_the_spot=True)
DT_S = 0.1
RUDDER_LAG_S = 0.5


ACC_MPS2 = 0.3


def sailing(guide: PathTracker, parameters: Parameters, nav: NavState) -> Iterator[tuple[NavState, PathProgress]]:
    """The launch on its track in still water, tick by tick, until it has finished."""
    accelerations, rudder = dynamics(LAUNCH.hull), LAUNCH.thrusters[0]
    bandwidth, speed, most_nm = parameters["PATH_BW_YAW"], parameters["WP_SPEED"], LAUNCH.limits.yaw_nm
    moment_nm = 0.0
    while True:
        u, v, r = nav.surge_mps, nav.sway_mps, nav.yaw_rate_radps
        north = u * math.cos(nav.yaw_rad) - v * math.sin(nav.yaw_rad)
        east = u * math.sin(nav.yaw_rad) + v * math.cos(nav.yaw_rad)
        nav = replace(nav, north_mps=north, east_mps=east)
        progress = guide.update(nav, speed, DT_S)
        yield nav, progress
        if progress.finished:
            return
        asked = progress.setpoint
        assert asked.yaw_rad is not None
        turn = 1.5 * bandwidth * (asked.yaw_rate_radps - r) + bandwidth**2 * wrap_pi(asked.yaw_rad - nav.yaw_rad)
        damping = LAUNCH.hull.damping
        wanted_nm = LAUNCH.hull.m33_kgm2 * turn + (damping.n_r + damping.n_ur * u) * r
        wanted_nm = min(most_nm, max(-most_nm, wanted_nm))
        moment_nm += (wanted_nm - moment_nm) * DT_S / RUDDER_LAG_S
        _, dv, dr = accelerations(u, v, r, 0.0, moment_nm / rudder.x_m, moment_nm)
        u += min(ACC_MPS2 * DT_S, max(-ACC_MPS2 * DT_S, asked.surge_mps - u))
        v, r = v + dv * DT_S, r + dr * DT_S
        yaw = wrap_pi(nav.yaw_rad + r * DT_S)
        place = {"north_m": nav.north_m + north * DT_S, "east_m": nav.east_m + east * DT_S, "yaw_rad": yaw}
        nav = replace(nav, surge_mps=u, sway_mps=v, yaw_rate_radps=r, **place)


def largest_off_m(current_mps: float | None = 0.0, **values: float) -> float:
    """Largest distance from a straight leg in its last 100 of 300 m in still water, from 2 m beside it. `current_mps`:
    what is known of it."""
    parameters = Parameters({**LAUNCH.parameters, **values})
    guide = PathTracker(parameters, can_sway=False, turning=turning_of(LAUNCH, on_the_spot=False))
    nav = replace(NO_ESTIMATE, east_m=2.0, surge_mps=parameters["WP_SPEED"])
    nav = replace(nav, current_north_mps=current_mps, current_east_mps=current_mps)
    guide.start([Waypoint(0.0, 0.0), Waypoint(300.0, 0.0)], nav, stop_at_end=False, from_here=False)
    return max(abs(nav.east_m) for nav, _ in sailing(guide, parameters, nav) if nav.north_m > 200.0)


def test_it_looks_as_far_ahead_as_its_course_follows_its_bow_late() -> None:
    """With the look-ahead of small boats it snaked by 5 m in still water."""
    assert largest_off_m() < 0.3
    assert largest_off_m(PATH_LOOKAHEAD=3.0) > 1.0


def test_it_learns_no_drift_from_its_own_turns() -> None:
    """Where no current is known it took its sideslip for drift, and weaved ever wider: by 35 m here."""
    assert largest_off_m(current_mps=None) < 0.3


@pytest.mark.parametrize("astern_m", [6.0, 10.0, 15.0])
def test_a_short_first_leg_astern_does_not_lead_it_away(astern_m: float) -> None:
    """Its course is taken some 8 m ahead, which was beyond the first waypoint: the bow turned to and fro between the
    two legs, and the launch sailed 120 m away until it held for want of headway."""
    parameters = Parameters({**LAUNCH.parameters, "NAV_ACC_RAD": 1.0})
    guide = PathTracker(parameters, can_sway=False, turning=turning_of(LAUNCH, on_the_spot=False))
    nav = replace(NO_ESTIMATE, current_north_mps=0.0, current_east_mps=0.0)
    guide.start([Waypoint(-astern_m, 0.0), Waypoint(0.0, 0.0), Waypoint(100.0, 0.0)], nav)
    far_m = 0.0
    for ticks, (there, progress) in enumerate(sailing(guide, parameters, nav)):
        assert ticks < 3000, f"{progress.passed} waypoints passed after 5 minutes, {far_m:.0f} m away"
        if progress.passed < 2:
            far_m = max(far_m, math.hypot(there.north_m, there.east_m))
    assert far_m < 40.0


def back_and_forth(turning: Turning, parameters: Parameters) -> PathTracker:
    """A guide to 30 m astern of home and back."""
    guide = PathTracker(parameters, can_sway=False, turning=turning)
    guide.start([Waypoint(-30.0, 0.0), Waypoint(40.0, 0.0)], nav_state(yaw_rad=math.pi, surge_mps=1.4))
    guide.turns_against(5.0)
    return guide


def test_a_ship_blown_off_as_it_turns_round_keeps_to_the_leg_that_it_has_to_sail() -> None:
    """A ship with a thruster across its bow begins its turns 6 s early, and a wind blew it back as it turned to a first
    leg of 8 m astern. Its course was now that of this leg, now that of the next: the heading asked for changed its side
    every 1.5 s, the ship never came round, and held for want of headway."""
    parameters = Parameters({**SHIP.parameters, "NAV_ACC_RAD": 1.0})
    guide = PathTracker(parameters, can_sway=False, turning=SHIP_TURNING)
    guide.start([Waypoint(-8.0, 0.0), Waypoint(0.0, 0.0), Waypoint(30.0, 0.0)], nav_state())
    guide.turns_against(3.0)
    asked: list[float] = []
    for i in range(400):
        swing = math.sin(0.2 * i)
        nav = nav_state(0.05 * i, -0.02 * i, -math.radians(10.0 + 0.1 * i), 0.45 + 0.25 * swing, 0.05, 0.02 * swing)
        yaw = guide.update(nav, parameters["WP_SPEED"], DT_S).setpoint.yaw_rad
        assert yaw is not None
        asked.append(yaw)
    turned = [wrap_pi(b - a) for a, b in itertools.pairwise(asked)]
    sides = [turn > 0.0 for turn in turned if abs(turn) > math.radians(0.5)]
    assert sum(a is not b for a, b in itertools.pairwise(sides)) <= 1
    assert abs(wrap_pi(asked[-1] - math.pi)) < math.radians(60.0)


@pytest.mark.parametrize(("config", "turning"), [(LAUNCH, turning_of(LAUNCH, on_the_spot=False)), (SHIP, SHIP_TURNING)])
def test_blown_back_before_the_tip_it_has_turned_back(config: VesselConfig, turning: Turning) -> None:
    """It begins its turn back before the tip. Blown away from that, it counted its distance from the leg before, and
    leant away from the track for ever."""
    parameters = Parameters({**config.parameters, "NAV_ACC_RAD": 1.0})
    guide = back_and_forth(turning, parameters)
    north_m, turns_rad = 0.0, 0.0
    while turns_rad < math.radians(3.0):
        assert north_m > -28.0, "it turns no earlier"
        north_m -= 1.4 * DT_S
        asked = guide.update(nav_state(north_m, 0.0, math.pi, 1.4), 1.4, DT_S).setpoint.yaw_rad
        turns_rad = abs(wrap_pi((asked or 0.0) - math.pi))
    assert north_m < -15.0, "it has sailed its leg"
    for i in range(400):  # blown to the north-west
        turned = max(-0.5 * math.pi, -math.pi + 0.02 * i)
        nav = nav_state(north_m + 0.03 * i, -0.015 * i, turned, 0.2, 0.3)
        progress = guide.update(nav, 1.4, DT_S)
    assert progress.passed == 1
    assert progress.setpoint.yaw_rad is not None and 0.0 < progress.setpoint.yaw_rad < math.radians(80.0)
