"""Named scenarios. A new one is one file and one row here, under its subject."""

from __future__ import annotations

from sitl.scenarios import (
    ahrs,
    approach,
    bow_hold,
    circle,
    colreg,
    cross_current,
    docking,
    endurance,
    fence_stop,
    follow,
    four_corner,
    gnss_dropout,
    harbour,
    hold,
    homecoming,
    honest_senses,
    identify,
    lever_arm,
    link_loss,
    lying_senses,
    mission_square,
    obstacles,
    offboard,
    pictures,
    reroute,
    route,
    shore_compass,
    station_change,
    station_keeping,
    sway_demand,
    two_followers,
    watch_circle,
    wave_hold,
    wild_points,
)
from sitl.scenarios.scenario import Scenario

BY_SUBJECT: dict[str, tuple[Scenario, ...]] = {
    "Holding a point": (
        hold.SCENARIO,
        four_corner.SCENARIO,
        station_keeping.SCENARIO,
        station_keeping.THRUSTER_FAILURE,
        watch_circle.SCENARIO,
        bow_hold.SCENARIO,
        endurance.SCENARIO,
        wave_hold.SCENARIO,
        docking.SCENARIO,
    ),
    "Under way": (
        mission_square.SCENARIO,
        cross_current.SCENARIO,
        reroute.SCENARIO,
        homecoming.SCENARIO,
        route.SCENARIO,
        route.SURVEY,
        pictures.SCENARIO,
        circle.SCENARIO,
        offboard.SCENARIO,
    ),
    "Behind a lead boat": (
        follow.SCENARIO,
        approach.SCENARIO,
        link_loss.SCENARIO,
        link_loss.LEADER_GNSS_LOSS,
        station_change.SCENARIO,
        two_followers.SCENARIO,
    ),
    "Keeping clear": (fence_stop.SCENARIO, colreg.SCENARIO, obstacles.SCENARIO, harbour.SCENARIO),
    "Senses and estimate": (
        gnss_dropout.SCENARIO,
        wild_points.SCENARIO,
        lying_senses.SCENARIO,
        honest_senses.SCENARIO,
        lever_arm.SCENARIO,
        ahrs.SCENARIO,
        shore_compass.SCENARIO,
    ),
    "The boat's model": (identify.SCENARIO, sway_demand.SCENARIO),
}
SCENARIOS: dict[str, Scenario] = {
    scenario.name: scenario for scenarios in BY_SUBJECT.values() for scenario in scenarios
}
