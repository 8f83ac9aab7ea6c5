"""Why the boat left its mode: the helm remembers the cause of each change."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.core.decision import ModeId
from companion.core.readings import Wish
from companion.mission.plan import PlanItem, PlanKind
from companion.supervisor.mode_changes import Cause
from tests.unit.following.lead_boat import LeadBoat

NAN = math.nan


def sailing(boat: Any, mode: ModeId) -> None:
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()


def broken(*_: Any) -> Any:
    raise RuntimeError("broken")


def test_people_and_the_safe_switch(boat: Any) -> None:
    assert boat.supervisor.mode_cause is None
    sailing(boat, ModeId.HOLD)
    assert boat.supervisor.mode_cause is Cause.OPERATOR
    boat.rc = (0.0, 0.0, 0.0, 0.0, 1.0)
    boat.step()
    assert boat.status.mode is ModeId.MANUAL and boat.supervisor.mode_cause is Cause.SAFE_SWITCH


def test_a_failsafe_and_the_way_back(boat: Any) -> None:
    lead = LeadBoat(boat)
    lead.run(2.0)
    lead.press(Wish.AUTONOMOUS)
    lead.run(0.2)
    assert boat.status.mode is ModeId.FOLLOW and boat.supervisor.mode_cause is Cause.LEAD_BOAT
    assert boat.supervisor.arm(boat.now_s).accepted
    lead.run(1.0)
    lead.on = False
    lead.run(2.0)
    assert boat.status.mode is ModeId.HOLD and boat.supervisor.mode_cause is Cause.FAILSAFE
    lead.on = True
    lead.run(5.0)
    assert boat.status.mode is ModeId.FOLLOW and boat.supervisor.mode_cause is Cause.FAILSAFE_OVER


@pytest.mark.parametrize("leader", [True, False])
def test_a_mission_and_its_end(boat: Any, leader: bool) -> None:
    lead = LeadBoat(boat)
    lead.on = leader
    item = PlanItem(0, 32, 2, -1.0, NAN, NAN, NAN, 0, 0, 0.0)
    boat.upload((10.0, 0.0), (10.0, 20.0), commands={1: item})
    lead.run(1.0)
    sailing(boat, ModeId.MISSION)
    while boat.status.mode is ModeId.MISSION:
        lead.tick()
    cause = Cause.MISSION_ITEM if leader else Cause.MISSION_ITEM_REFUSED
    assert boat.supervisor.mode_cause is cause
    assert boat.supervisor.resume(boat.now_s).accepted
    boat.step()
    boat.until(lambda: boat.status.mode is ModeId.HOLD)
    assert boat.supervisor.mode_cause is Cause.MISSION_END


def test_a_new_fence(boat: Any) -> None:
    boat.upload((60.0, 0.0), (60.0, 20.0))
    sailing(boat, ModeId.MISSION)
    boat.step(3.0)
    fence = [PlanItem(i, 5001, 3, 4.0, 0.0, 0.0, 0.0, *point(boat, n, e), 0.0) for i, (n, e) in enumerate(SQUARE)]
    boat.plans.replace(PlanKind.FENCE, fence)
    boat.step(1.0)
    assert boat.status.mode is ModeId.HOLD and boat.supervisor.mode_cause is Cause.FENCE


SQUARE = ((-30.0, -30.0), (30.0, -30.0), (30.0, 30.0), (-30.0, 30.0))


def point(boat: Any, north_m: float, east_m: float) -> tuple[int, int]:
    lat_deg, lon_deg = boat.point(north_m, east_m)
    return round(lat_deg * 1e7), round(lon_deg * 1e7)


def test_errors_of_the_program(boat: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    boat.upload((60.0, 0.0), (60.0, 20.0))
    sailing(boat, ModeId.MISSION)
    with monkeypatch.context() as patch:
        patch.setattr(boat.supervisor.parts.traffic_guard, "steer", broken)
        boat.step()
    assert boat.supervisor.mode_cause is Cause.GUARD_FAILED
    boat.step()
    assert boat.status.mode is ModeId.HOLD
    monkeypatch.setattr(boat.supervisor.parts.helm.modes[ModeId.HOLD], "update", broken)
    boat.step()
    assert boat.supervisor.mode_cause is Cause.MODE_FAILED


def test_a_restart(make_boat: Any) -> None:
    boat = make_boat(ready=False)
    boat.upload((60.0, 0.0), (60.0, 20.0))
    boat.executor.begin()
    boat.step()
    assert boat.status.mode is ModeId.HOLD and boat.supervisor.mode_cause is Cause.RESTART
