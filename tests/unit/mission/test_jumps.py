"""Jumps to marks: they lead where a jump by number would, and are refused where they lead nowhere."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.core.decision import MissionState
from companion.mission.commands import Command
from companion.mission.cursor import Cursor
from companion.mission.executor import MissionExecutor, Replaced
from companion.mission.jumps import marked, target_of
from companion.mission.plan import PlanItem, PlanKind, Plans
from companion.mission.tasks import Sail, SetSpeed, Stay
from companion.mission.validation import check_item, check_plan


def item(command: int, *params: float) -> PlanItem:
    four = (*params, 0.0, 0.0, 0.0, 0.0)[:4]
    place = (634389000, 103990000) if command == Command.NAV_WAYPOINT else (0, 0)
    return PlanItem(0, command, 6, *four, *place, 0.0)


def plan(*items: PlanItem) -> list[PlanItem]:
    return [replace(one, seq=seq) for seq, one in enumerate(items)]


WAYPOINT = item(Command.NAV_WAYPOINT)


def sailed(items: list[PlanItem], most: int = 50) -> list[int]:
    """Numbers of the tasks, in the order in which they are sailed."""
    cursor, seqs = Cursor(items), []
    cursor.settle()
    while cursor.item is not None and len(seqs) < most:
        seqs.append(cursor.seq)
        cursor.advance()
    return seqs


def test_a_lap_between_mark_and_jump() -> None:
    items = plan(WAYPOINT, item(Command.JUMP_TAG, 7), WAYPOINT, WAYPOINT, item(Command.DO_JUMP_TAG, 7, 2), WAYPOINT)
    assert check_plan(PlanKind.MISSION, items) is None and all(
        check_item(PlanKind.MISSION, one) is None for one in items
    )
    assert sailed(items) == [0, 2, 3, 2, 3, 2, 3, 5]


@given(
    st.lists(st.sampled_from("wm"), min_size=1, max_size=8),
    st.integers(0, 7),
    st.integers(-1, 3),
)
def test_it_leads_where_a_jump_by_number_does(shape: list[str], which: int, count: int) -> None:
    marks = [item(Command.JUMP_TAG, n) if kind == "m" else WAYPOINT for n, kind in enumerate(shape)]
    tags = [n for n, kind in enumerate(shape) if kind == "m"]
    if not tags:
        return
    tag = tags[which % len(tags)]
    by_tag = plan(*marks, item(Command.DO_JUMP_TAG, tag, count), WAYPOINT)
    by_number = plan(*marks, item(Command.DO_JUMP, tag, count), WAYPOINT)
    assert sailed(by_tag) == sailed(by_number)
    refusals = [check_plan(PlanKind.MISSION, items) for items in (by_tag, by_number)]
    assert (refusals[0] is None) == (refusals[1] is None)


@pytest.mark.parametrize(
    ("items", "seq", "text"),
    [
        (plan(WAYPOINT, item(Command.DO_JUMP_TAG, 3, 1)), 1, "DO_JUMP_TAG to mark 3, which no JUMP_TAG has; add one"),
        (
            plan(WAYPOINT, item(Command.JUMP_TAG, 3), item(Command.JUMP_TAG, 3)),
            2,
            "JUMP_TAG 3 is item 2 too; give each mark its own number",
        ),
        (
            plan(WAYPOINT, item(Command.JUMP_TAG, 3), item(Command.DO_JUMP_TAG, 3, -1)),
            2,
            "DO_JUMP_TAG to item 2 for ever, with nothing to do in between; add a waypoint to the loop",
        ),
    ],
)
def test_what_leads_nowhere_is_refused(items: list[PlanItem], seq: int, text: str) -> None:
    refusal = check_plan(PlanKind.MISSION, items)
    assert refusal is not None and (refusal.seq, refusal.text) == (seq, text)


@pytest.mark.parametrize("tag", [-1.0, 0.5, 65536.0, float("nan")])
def test_a_mark_is_a_whole_number(tag: float) -> None:
    for command in (Command.JUMP_TAG, Command.DO_JUMP_TAG):
        assert check_item(PlanKind.MISSION, item(command, tag, 1)) is not None


def test_the_place_of_a_mark() -> None:
    items = plan(WAYPOINT, item(Command.JUMP_TAG, 9), item(Command.DO_JUMP_TAG, 9, 1))
    assert marked(items, 9) == 1 and marked(items, 8) is None and target_of(items, items[2]) == 1


def begun(*items: PlanItem) -> tuple[MissionExecutor, Plans]:
    plans = Plans()
    executor = MissionExecutor(plans)
    plans.replace(PlanKind.MISSION, plan(*items))
    assert executor.begin() is None
    return executor, plans


def route(executor: MissionExecutor) -> list[int]:
    assert isinstance(executor.task, Sail)
    return [point.seq for point in executor.task.route]


def test_laps_go_on_where_a_point_is_added_behind_them() -> None:
    laps = (WAYPOINT, WAYPOINT, item(Command.DO_JUMP, 0, 3), WAYPOINT)
    executor, plans = begun(*laps)
    for seq in (0, 1, 0, 1):
        executor.complete(seq)
    plans.replace(PlanKind.MISSION, plan(*laps, WAYPOINT))
    assert executor.replaced is Replaced.CONTINUED
    assert route(executor) == [0, 1, 0, 1, 3, 4]
    plans.replace(PlanKind.MISSION, plan(*laps[:2], item(Command.DO_JUMP, 0, 1), WAYPOINT))  # another jump
    assert route(executor) == [0, 1, 0, 1, 3]


def test_the_present_item_goes_on_while_the_jumps_are_forgotten() -> None:
    stay = replace(item(Command.NAV_LOITER_TIME, 60.0), x=WAYPOINT.x, y=WAYPOINT.y)
    executor, _ = begun(WAYPOINT, item(Command.DO_JUMP, 0, 1), stay)
    for seq in (0, 0, 2):
        executor.complete(seq)
    staying = executor.task
    assert isinstance(staying, Stay)
    assert executor.set_current(None) is None and executor.set_current(None, reset=True) is None
    assert executor.task is staying


def test_the_present_item_of_a_route_a_gate_and_a_mission_that_is_over() -> None:
    slow = item(Command.DO_CHANGE_SPEED, 1.0, 0.5)
    executor, _ = begun(WAYPOINT, item(Command.CONDITION_DELAY, 5.0), slow, WAYPOINT, item(Command.DO_JUMP, 0, 1))
    for seq in (0, 3, 0):
        executor.complete(seq)
    assert executor.set_current(None, reset=True) is None
    assert route(executor) == [3, 0, 3]
    assert executor.gate is not None and executor.open_gate() == (SetSpeed(0.5),)
    for seq in (3, 0, 3):
        executor.complete(seq)
    assert executor.progress.state is MissionState.COMPLETE
    assert executor.set_current(None) is None
    assert (executor.progress.state, executor.progress.seq) == (MissionState.NOT_STARTED, 4)


def test_no_present_item_without_a_mission() -> None:
    assert MissionExecutor(Plans()).set_current(None) == "no mission: upload one first"
