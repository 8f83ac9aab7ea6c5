"""Named scenarios. A new one is one file and one row here."""

from __future__ import annotations

from sitl.scenarios import docking, hold, mission_square
from sitl.scenarios.scenario import Scenario

SCENARIOS: dict[str, Scenario] = {scenario.name: scenario for scenario in (docking.SCENARIO, hold.SCENARIO, mission_square.SCENARIO)}
