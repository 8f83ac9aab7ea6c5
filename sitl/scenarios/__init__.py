"""Named scenarios. A new one is one file and one row here."""

from __future__ import annotations

from sitl.scenarios import four_corner, hold, mission_square, station_keeping
from sitl.scenarios.scenario import Scenario

_ALL = (hold.SCENARIO, mission_square.SCENARIO, four_corner.SCENARIO, station_keeping.SCENARIO, station_keeping.THRUSTER_FAILURE)
SCENARIOS: dict[str, Scenario] = {scenario.name: scenario for scenario in _ALL}
