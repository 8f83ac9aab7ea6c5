"""NAV_LAND: a berth in a mission."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.mission.cursor import Cursor
from companion.mission.executor import MissionExecutor
from companion.mission.itinerary import task_at
from companion.mission.plan import PlanItem, PlanKind, PlanResult, Plans
from companion.mission.tasks import Dock, Sail
from companion.mission.validation import check_item, check_plan

LANDING = PlanItem(0, 21, 3, 0.0, 0.0, 0.0, 320.0, 634_387_501, 103_986_009, 50.0)
WAYPOINT = PlanItem(0, 16, 3, 0.0, 0.0, 0.0, math.nan, 634_390_000, 103_990_000, 50.0)


@pytest.mark.parametrize("heading", [0.0, 320.0, math.nan])
def test_accepted_with_a_heading_as_a_berth_and_without_as_a_place_to_hold(heading: float) -> None:
    item = replace(LANDING, param4=heading)
    assert check_item(PlanKind.MISSION, item) is None
    assert check_plan(PlanKind.MISSION, [item]) is None


@pytest.mark.parametrize("heading", [math.inf, 400.0])
def test_refused_with_a_heading_that_is_none(heading: float) -> None:
    refusal = check_item(PlanKind.MISSION, replace(LANDING, param4=heading))
    assert refusal is not None and refusal.result is PlanResult.INVALID_PARAM4 and "berth" in refusal.text


def test_a_take_off_is_taken_unless_told_otherwise() -> None:
    items = [replace(LANDING, command=22), replace(WAYPOINT, seq=1)]
    assert check_item(PlanKind.MISSION, items[0]) is None
    assert check_plan(PlanKind.MISSION, items) is None
    refusal = check_plan(PlanKind.MISSION, items, takes_off=False)
    assert refusal is not None and refusal.result is PlanResult.UNSUPPORTED and refusal.seq == 0
    assert "COM_TAKEOFF_OK" in refusal.text


def test_the_task_and_the_way_to_it() -> None:
    items = (WAYPOINT, replace(LANDING, seq=1))
    way = task_at(Cursor(items), arrived=False)
    assert isinstance(way, Sail) and not way.stop and len(way.route) == 1
    task = task_at(Cursor(items, 1), arrived=False)
    assert task == Dock(1, pytest.approx(63.4387501), pytest.approx(10.3986009), pytest.approx(math.radians(-40.0)))


def test_without_a_heading_the_task_has_no_berth() -> None:
    task = task_at(Cursor((replace(LANDING, param4=math.nan),)), arrived=False)
    assert isinstance(task, Dock) and task.yaw_rad is None


def test_reached_when_done() -> None:
    plans = Plans()
    plans.replace(PlanKind.MISSION, [LANDING])
    executor = MissionExecutor(plans)
    assert executor.begin() is None and isinstance(executor.task, Dock)
    executor.complete(0)
    assert executor.progress.reached_seq == 0
