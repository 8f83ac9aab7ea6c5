"""Straight legs of a launch that turns slowly and slides outwards: its course follows its bow 5 m late."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.cli.new_file import Answers, file_text
from companion.config.vessel import parse
from companion.core.angles import wrap_pi
from companion.core.estimate import NO_ESTIMATE
from companion.guidance.path_tracking import PathTracker
from companion.guidance.turning import turning_of
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from sitl.hull import dynamics

ANSWERS = Answers(
    "launch", "Launch", "monohull", 7.2, 2.4, 1800.0, None, None, None, "rudder", "1200", None, 0.0, "microcontroller",
    "one", 63.442, 10.4,
)  # fmt: skip
LAUNCH = parse(file_text(ANSWERS), "launch.toml")
DT_S = 0.1
RUDDER_LAG_S = 0.5


def largest_off_m(current_mps: float | None = 0.0, **values: float) -> float:
    """Largest distance from a straight leg in its last 100 of 300 m in still water, from 2 m beside it. `current_mps`:
    what is known of it."""
    parameters = Parameters({**LAUNCH.parameters, **values})
    guide = PathTracker(parameters, can_sway=False, turning=turning_of(LAUNCH, on_the_spot=False))
    accelerations, rudder = dynamics(LAUNCH.hull), LAUNCH.thrusters[0]
    bandwidth, speed, most_nm = parameters["PATH_BW_YAW"], parameters["WP_SPEED"], LAUNCH.limits.yaw_nm
    u, v, r, moment_nm = speed, 0.0, 0.0, 0.0
    nav = replace(NO_ESTIMATE, east_m=2.0, current_north_mps=current_mps, current_east_mps=current_mps)
    guide.start([Waypoint(0.0, 0.0), Waypoint(300.0, 0.0)], nav, from_here=False)
    farthest = 0.0
    while nav.north_m < 299.0:
        north = u * math.cos(nav.yaw_rad) - v * math.sin(nav.yaw_rad)
        east = u * math.sin(nav.yaw_rad) + v * math.cos(nav.yaw_rad)
        nav = replace(nav, surge_mps=u, sway_mps=v, yaw_rate_radps=r, north_mps=north, east_mps=east)
        asked = guide.update(nav, speed, DT_S).setpoint
        assert asked.yaw_rad is not None
        turn = 1.5 * bandwidth * (asked.yaw_rate_radps - r) + bandwidth**2 * wrap_pi(asked.yaw_rad - nav.yaw_rad)
        damping = LAUNCH.hull.damping
        wanted_nm = LAUNCH.hull.m33_kgm2 * turn + (damping.n_r + damping.n_ur * u) * r
        wanted_nm = min(most_nm, max(-most_nm, wanted_nm))
        moment_nm += (wanted_nm - moment_nm) * DT_S / RUDDER_LAG_S
        _, dv, dr = accelerations(u, v, r, 0.0, moment_nm / rudder.x_m, moment_nm)
        v, r = v + dv * DT_S, r + dr * DT_S
        yaw = wrap_pi(nav.yaw_rad + r * DT_S)
        nav = replace(nav, north_m=nav.north_m + north * DT_S, east_m=nav.east_m + east * DT_S, yaw_rad=yaw)
        if nav.north_m > 200.0:
            farthest = max(farthest, abs(nav.east_m))
    return farthest


def test_it_looks_as_far_ahead_as_its_course_follows_its_bow_late() -> None:
    """With the look-ahead of small boats it snaked by 5 m in still water."""
    assert largest_off_m() < 0.3
    assert largest_off_m(PATH_LOOKAHEAD=3.0) > 1.0


def test_it_learns_no_drift_from_its_own_turns() -> None:
    """Where no current is known it took its sideslip for drift, and weaved ever wider: by 35 m here."""
    assert largest_off_m(current_mps=None) < 0.3
