"""The fence switched off and on by command and by a mission."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from companion.core.decision import ModeId
from companion.mission.plan import PlanItem, PlanKind
from companion.modes.parts.mission_terms import unfenced
from tests.unit.conftest import Boat

FENCE = ((-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0))
WAYPOINT, ENABLE = 16, 207


def item(seq: int, command: int, param1: float = 0.0) -> PlanItem:
    return PlanItem(seq, command, 3, param1, 0.0, 0.0, math.nan, 0, 0, 0.0)


@pytest.fixture
def boat(make_boat: Callable[..., Boat]) -> Boat:
    boat = make_boat()
    corners = [boat.point(*corner) for corner in FENCE]
    zone = [PlanItem(i, 5001, 3, 4, 0, 0, 0, round(a * 1e7), round(b * 1e7), 0) for i, (a, b) in enumerate(corners)]
    boat.plans.replace(PlanKind.FENCE, zone)
    boat.step()
    return boat


def test_off_lies_between_a_zero_and_the_next_one() -> None:
    plan = ((WAYPOINT, 0), (ENABLE, 0), (WAYPOINT, 0), (ENABLE, 2), (WAYPOINT, 0), (ENABLE, 1), (WAYPOINT, 0))
    found = unfenced([item(seq, *row) for seq, row in enumerate(plan)])
    assert found == {1, 2, 3, 4}, "a floor switches nothing"
    assert not unfenced([]) and not unfenced([item(0, WAYPOINT)])


def test_a_mission_leaves_the_fence_that_it_has_switched_off_and_comes_back(boat: Boat) -> None:
    out = [(30.0, 0.0), (100.0, 0.0), (30.0, 0.0), (0.0, 0.0)]
    boat.upload(*out)
    assert not boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted, "the fence is in the way"
    boat.upload(*out, commands={1: item(0, ENABLE, 0.0), 4: item(0, ENABLE, 1.0)})
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()
    assert boat.status.fence is not None, "the first leg is inside"
    boat.until(lambda: boat.away_m(100.0, 0.0) < 3.0)
    assert boat.status.fence is None and boat.texts().count("Fence off until switched on or disarmed") == 1
    boat.until(lambda: "Mission complete" in boat.texts())
    assert "Fence on" in boat.texts() and boat.status.fence is not None and not boat.status.fence.breached


def test_ways_before_the_fence_is_off_and_after_it_is_on_are_checked(boat: Boat) -> None:
    boat.upload((30.0, 0.0), (100.0, 0.0), (30.0, 0.0), commands={1: item(0, ENABLE, 0.0), 2: item(0, ENABLE, 1.0)})
    assert not boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted


def test_switched_on_again_outside_the_boat_may_come_in(boat: Boat) -> None:
    boat.supervisor.switch_fence(False, boat.now_s)
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    assert boat.supervisor.go_to(*boat.point(90.0, 0.0), None, None, boat.now_s).accepted
    boat.until(lambda: boat.away_m(90.0, 0.0) < 2.0)
    boat.supervisor.switch_fence(True, boat.now_s)
    boat.step(1.0)
    assert any(text.startswith("Outside the new fence by") for text in boat.texts())
    assert boat.supervisor.go_to(*boat.point(0.0, 0.0), None, None, boat.now_s).accepted


def test_switching_to_what_it_is_says_nothing_and_without_a_fence_it_is_told(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat()
    boat.supervisor.switch_fence(True, boat.now_s)
    boat.step()
    assert "fence_switched" not in boat.names()
    boat.supervisor.switch_fence(False, boat.now_s)
    boat.supervisor.switch_fence(True, boat.now_s)
    boat.step()
    assert boat.texts()[-1] == "Fence on, but there is none, or GF_ACTION is 0"
