"""Named scenarios. A new one is one file and one row here."""

from __future__ import annotations

from sitl.scenarios import (
    ahrs,
    approach,
    colreg,
    cross_current,
    docking,
    fence_stop,
    follow,
    four_corner,
    gnss_dropout,
    hold,
    identify,
    lever_arm,
    link_loss,
    mission_square,
    offboard,
    reroute,
    route,
    station_change,
    station_keeping,
    two_followers,
    watch_circle,
    wild_points,
)
from sitl.scenarios.scenario import Scenario

_ALL = (
    hold.SCENARIO,
    mission_square.SCENARIO,
    cross_current.SCENARIO,
    reroute.SCENARIO,
    four_corner.SCENARIO,
    station_keeping.SCENARIO,
    station_keeping.THRUSTER_FAILURE,
    watch_circle.SCENARIO,
    docking.SCENARIO,
    fence_stop.SCENARIO,
    colreg.SCENARIO,
    follow.SCENARIO,
    approach.SCENARIO,
    link_loss.SCENARIO,
    link_loss.LEADER_GNSS_LOSS,
    station_change.SCENARIO,
    two_followers.SCENARIO,
    offboard.SCENARIO,
    gnss_dropout.SCENARIO,
    wild_points.SCENARIO,
    lever_arm.SCENARIO,
    identify.SCENARIO,
    ahrs.SCENARIO,
    route.SCENARIO,
    route.SURVEY,
)
SCENARIOS: dict[str, Scenario] = {scenario.name: scenario for scenario in _ALL}
