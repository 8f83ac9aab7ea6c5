"""Named scenarios. A new one is one file and one row here."""

from __future__ import annotations

from sitl.scenarios import (
    ahrs,
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
    mission_square,
    reroute,
    route,
    station_keeping,
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
    gnss_dropout.SCENARIO,
    wild_points.SCENARIO,
    lever_arm.SCENARIO,
    identify.SCENARIO,
    ahrs.SCENARIO,
    route.SCENARIO,
    route.SURVEY,
)
SCENARIOS: dict[str, Scenario] = {scenario.name: scenario for scenario in _ALL}
