"""DO_SET_REVERSE: which legs of a mission are sailed stern first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import pytest

from companion.core.decision import MissionState
from companion.mission.cursor import Cursor
from companion.mission.executor import MissionExecutor
from companion.mission.itinerary import LONGEST_ROUTE, task_at
from companion.mission.plan import PlanItem, PlanKind, PlanResult, Plans
from companion.mission.tasks import Complete, Orbit, Sail, Stay, Task
from companion.mission.validation import check_item, check_plan

WAYPOINT = PlanItem(0, 16, 3, 0.0, 0.0, 0.0, math.nan, 634_390_000, 103_990_000, 50.0)
ASTERN = PlanItem(0, 194, 2, 1.0, 0.0, 0.0, 0.0, 0, 0, 0.0)
AHEAD = replace(ASTERN, param1=0.0)
STAY = replace(WAYPOINT, command=19, param1=5.0)
ORBIT = replace(WAYPOINT, command=18, param1=1.0)


def plan(*items: PlanItem) -> tuple[PlanItem, ...]:
    return tuple(replace(item, seq=seq) for seq, item in enumerate(items))


def started(*items: PlanItem) -> MissionExecutor:
    plans = Plans()
    plans.replace(PlanKind.MISSION, plan(*items))
    executor = MissionExecutor(plans)
    assert executor.begin() is None
    return executor


def sails(tasks: Sequence[Task]) -> list[tuple[int, bool, bool]]:
    """(points, stern first, stop) of each."""
    return [(len(task.route), task.astern, task.stop) for task in tasks if isinstance(task, Sail)]


def test_the_boat_comes_to_rest_where_it_changes() -> None:
    executor = started(WAYPOINT, WAYPOINT, ASTERN, WAYPOINT, WAYPOINT, AHEAD, WAYPOINT)
    assert sails(list(executor.ahead())) == [(2, False, True), (2, True, True), (1, False, True)]
    task = executor.task
    assert isinstance(task, Sail) and task.beyond == ()


def test_an_item_that_changes_nothing_does_not_stop_the_boat() -> None:
    assert sails(list(started(WAYPOINT, AHEAD, WAYPOINT).ahead())) == [(2, False, True)]
    assert sails(list(started(ASTERN, WAYPOINT, ASTERN, WAYPOINT).ahead())) == [(2, True, True)]


def test_a_stay_and_a_long_route_stern_first() -> None:
    tasks = list(started(ASTERN, WAYPOINT, STAY, WAYPOINT).ahead())
    assert sails(tasks) == [(2, True, True), (1, True, True)] and any(isinstance(task, Stay) for task in tasks)
    first = task_at(_settled(ASTERN, *[WAYPOINT] * (LONGEST_ROUTE + 3), AHEAD, WAYPOINT), False)
    assert isinstance(first, Sail) and first.astern and not first.stop and len(first.beyond) == 3


def test_no_route_stern_first_goes_on_into_an_orbit() -> None:
    tasks = list(started(ASTERN, WAYPOINT, ORBIT).ahead())
    assert sails(tasks) == [(1, True, True)] and isinstance(tasks[1], Orbit)
    assert sails(list(started(WAYPOINT, ORBIT).ahead())) == [(1, False, False)]


def test_a_change_at_the_greatest_length_stops_too() -> None:
    task = task_at(_settled(*[WAYPOINT] * LONGEST_ROUTE, ASTERN, WAYPOINT), False)
    assert isinstance(task, Sail) and task.stop and task.beyond == ()


def test_a_condition_does_not_hold_it_back() -> None:
    delay = PlanItem(0, 112, 2, 30.0, 0.0, 0.0, 0.0, 0, 0, 0.0)
    assert sails(list(started(WAYPOINT, delay, ASTERN, WAYPOINT).ahead())) == [(1, False, True), (1, True, True)]


def test_a_pause_ends_it_and_so_does_a_new_beginning() -> None:
    executor = started(ASTERN, WAYPOINT, WAYPOINT)
    assert isinstance(executor.task, Sail) and executor.task.astern
    executor.pause()
    assert executor.begin() is None and isinstance(executor.task, Sail) and not executor.task.astern
    assert executor.begin(0) is None and isinstance(executor.task, Sail) and executor.task.astern, "by the item again"


def test_by_command() -> None:
    executor = started(WAYPOINT, WAYPOINT)
    before = executor.task
    executor.sail_astern(False)
    assert executor.task is before
    executor.sail_astern(True)
    assert executor.task == replace(before, astern=True)  # type: ignore[type-var]
    executor.complete(0)
    executor.complete(1)
    assert executor.progress.state is MissionState.COMPLETE and isinstance(executor.task, Complete)


def test_a_plan_that_goes_on_keeps_it() -> None:
    plans = Plans()
    plans.replace(PlanKind.MISSION, plan(ASTERN, WAYPOINT, WAYPOINT))
    executor = MissionExecutor(plans)
    assert executor.begin() is None
    plans.replace(PlanKind.MISSION, plan(ASTERN, WAYPOINT, WAYPOINT, STAY))
    assert isinstance(executor.task, Sail) and executor.task.astern


@pytest.mark.parametrize("param1", [2.0, -1.0, 0.5, math.nan])
def test_other_values_are_refused(param1: float) -> None:
    refusal = check_item(PlanKind.MISSION, replace(ASTERN, param1=param1))
    assert refusal is not None and refusal.result is PlanResult.INVALID_PARAM1


def test_refused_where_the_boat_cannot() -> None:
    items = plan(WAYPOINT, ASTERN, WAYPOINT)
    assert check_plan(PlanKind.MISSION, items) is None
    refusal = check_plan(PlanKind.MISSION, items, no_astern="this boat has no way astern")
    assert refusal is not None and refusal.result is PlanResult.INVALID_PARAM1
    assert str(refusal) == "item 2: DO_SET_REVERSE 1 is stern first, but this boat has no way astern; remove it"
    ahead = plan(WAYPOINT, AHEAD, WAYPOINT)
    assert check_plan(PlanKind.MISSION, ahead, no_astern="this boat has no way astern") is None


def _settled(*items: PlanItem) -> Cursor:
    cursor = Cursor(plan(*items))
    cursor.settle()
    return cursor
