"""NAV_LOITER_TURNS: a circle in a mission."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.mission.cursor import Cursor
from companion.mission.executor import MissionExecutor
from companion.mission.itinerary import task_at
from companion.mission.plan import PlanItem, PlanKind, PlanResult, Plans
from companion.mission.tasks import Orbit, Sail
from companion.mission.validation import check_item, check_plan

ORBIT = PlanItem(0, 18, 3, 2.0, 0.0, -12.0, 1.0, 634_387_501, 103_986_009, 50.0)
WAYPOINT = PlanItem(0, 16, 3, 0.0, 0.0, 0.0, math.nan, 634_390_000, 103_990_000, 50.0)


@pytest.mark.parametrize(
    "changes", [{}, {"param1": 0.5}, {"param2": 1.0}, {"param3": 0.0}, {"param3": math.nan}, {"param4": math.nan}]
)
def test_taken(changes: dict[str, float]) -> None:
    assert check_item(PlanKind.MISSION, replace(ORBIT, **changes)) is None


@pytest.mark.parametrize(
    ("changes", "result"),
    [
        ({"param1": -1.0}, PlanResult.INVALID_PARAM1),
        ({"param1": math.nan}, PlanResult.INVALID_PARAM1),
        ({"param2": 2.0}, PlanResult.INVALID_PARAM2),
        ({"param3": math.inf}, PlanResult.INVALID_PARAM3),
        ({"x": 2**31 - 1}, PlanResult.INVALID_PARAM5_X),
    ],
)
def test_refused(changes: dict[str, float], result: PlanResult) -> None:
    refusal = check_item(PlanKind.MISSION, replace(ORBIT, **changes))
    assert refusal is not None and refusal.result is result


def test_refused_where_the_boat_cannot_turn_so_tightly() -> None:
    refusal = check_plan(PlanKind.MISSION, [WAYPOINT, replace(ORBIT, seq=1)], least_radius_m=15.0)
    assert refusal is not None and refusal.result is PlanResult.INVALID_PARAM3 and refusal.seq == 1
    assert str(refusal) == "item 2: NAV_LOITER_TURNS radius (param3) is -12 m; this boat needs 15.0 m or more"
    assert check_plan(PlanKind.MISSION, [ORBIT], least_radius_m=12.0) is None
    assert check_plan(PlanKind.MISSION, [replace(ORBIT, param3=0.0)], least_radius_m=15.0) is None


def test_the_way_to_it_does_not_stop() -> None:
    way = task_at(Cursor((WAYPOINT, replace(ORBIT, seq=1))), arrived=False)
    assert isinstance(way, Sail) and not way.stop and len(way.route) == 1


def test_the_task() -> None:
    lat_deg, lon_deg = pytest.approx(63.4387501), pytest.approx(10.3986009)
    assert task_at(Cursor((ORBIT,)), arrived=False) == Orbit(0, lat_deg, lon_deg, 12.0, False, 2.0, None)
    own = task_at(Cursor((replace(ORBIT, param3=0.0),)), arrived=False)
    assert own == Orbit(0, lat_deg, lon_deg, None, None, 2.0, None)


def test_where_it_is_left_to() -> None:
    leaving = replace(ORBIT, param2=1.0)
    task = task_at(Cursor((leaving, replace(WAYPOINT, seq=1))), arrived=False)
    assert isinstance(task, Orbit) and task.leave_to == pytest.approx((63.439, 10.399))
    last = task_at(Cursor((leaving,)), arrived=False)
    assert isinstance(last, Orbit) and last.leave_to is None


def test_reached_when_done() -> None:
    plans = Plans()
    plans.replace(PlanKind.MISSION, [ORBIT, replace(WAYPOINT, seq=1)])
    executor = MissionExecutor(plans)
    assert executor.next_place == (0, pytest.approx(63.4387501), pytest.approx(10.3986009))
    assert executor.begin() is None and isinstance(executor.task, Orbit)
    assert [type(task) for task in executor.ahead()] == [Orbit, Sail]
    executor.complete(0)
    assert executor.progress.reached_seq == 0 and isinstance(executor.task, Sail)
