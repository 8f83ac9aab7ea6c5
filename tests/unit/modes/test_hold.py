"""What Hold tells the guards of the boat that it holds."""

from __future__ import annotations

import pytest

from companion.config.vessel import find, load
from companion.core.events import EventLog
from companion.modes.hold import HoldMode
from companion.params.store import Parameters
from tests.unit.obstacles.stubs import no_fence


@pytest.mark.parametrize(
    ("vessel", "drifts"),
    [("revolt", False), ("aboat", False), ("otter", True), ("rescuerunner", True), ("sailbot", False)],
)
def test_a_boat_with_a_motor_and_without_sideways_thrust_moves_about_its_point(vessel: str, drifts: bool) -> None:
    config = load(find(vessel))
    parameters = Parameters(config.parameters)
    assert HoldMode(config, parameters, EventLog(), no_fence(config, parameters)).drifts == drifts
