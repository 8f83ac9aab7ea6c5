"""Named scenarios. A new one is one file and one row here."""

from __future__ import annotations

from sitl.scenarios import docking, gnss_dropout, hold, identify, lever_arm, mission_square, wild_points
from sitl.scenarios.scenario import Scenario

SCENARIOS: dict[str, Scenario] = {
    scenario.name: scenario
    for scenario in (
        hold.SCENARIO,
        mission_square.SCENARIO,
        docking.SCENARIO,
        gnss_dropout.SCENARIO,
        wild_points.SCENARIO,
        lever_arm.SCENARIO,
        identify.SCENARIO,
    )
}
