"""Position or heading that nothing measures any more are told, once, unless a lie was told already."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.core.decision import Severity
from companion.core.estimate import Distrust
from tests.unit.conftest import Boat


def under_way(boat: Boat) -> Boat:
    assert boat.supervisor.arm(boat.now_s).accepted
    return boat


@pytest.mark.parametrize("sense", ["position", "heading"])
def test_it_is_told_and_told_again_when_it_is_back(boat: Boat, sense: str) -> None:
    under_way(boat)
    for age_s, event in ((1.4, ""), (1.6, f"{sense}_unmeasured"), (2.5, ""), (0.1, f"{sense}_unmeasured_over")):
        boat.said.clear()
        boat.nav = replace(boat.nav, **{f"{sense}_age_s": age_s})
        boat.step()
        assert [name for name, _ in boat.said if "unmeasured" in name] == ([event] if event else [])
    assert boat.severities[f"{sense}_unmeasured"] is Severity.WARNING


def test_nothing_is_told_of_a_boat_that_is_disarmed(boat: Boat) -> None:
    boat.nav = replace(boat.nav, position_age_s=9.0)
    boat.step()
    assert "position_unmeasured" not in boat.names()


def test_a_sensor_that_lies_was_told_already(boat: Boat) -> None:
    under_way(boat)
    lie = Distrust("position", "gnss", "jumped 50 m", 0.0, excluded=True, asks=True)
    boat.nav = replace(boat.nav, position_age_s=9.0, distrusted=(lie,))
    boat.step()
    assert "position_unmeasured" not in boat.names()
    boat.nav = replace(boat.nav, distrusted=())
    boat.step()
    assert "position_unmeasured" not in boat.names()  # its next value is on the way
    for _ in range(20):
        boat.step()
    assert "position_unmeasured" in boat.names()
