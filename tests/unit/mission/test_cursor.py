"""Jumps, and loops in which there is nothing to do."""

import math
from dataclasses import replace

from companion.mission.cursor import Cursor
from companion.mission.plan import PlanItem
from companion.mission.tasks import FollowLeader, SetFollowPosition, SetSpeed


def _item(command: int, p1: float = 0.0, p2: float = 0.0) -> PlanItem:
    return PlanItem(0, command, 3, p1, p2, 0.0, math.nan, 0, 0, 0.0)


def _plan(*items: PlanItem) -> tuple[PlanItem, ...]:
    return tuple(replace(item, seq=seq) for seq, item in enumerate(items))


def test_an_endless_loop_without_a_task_is_left() -> None:
    cursor = Cursor(_plan(_item(178, 1.0, 2.0), _item(177, 0.0, -1.0), _item(16)))
    actions = cursor.settle()
    assert cursor.seq == 2
    assert set(actions) == {SetSpeed(2.0)}
    assert len(actions) <= 10_001


def test_a_counted_loop_without_a_task_runs_out() -> None:
    cursor = Cursor(_plan(_item(206), _item(177, 0.0, 5.0), _item(16)))
    cursor.settle()
    assert (cursor.seq, cursor.jumps) == (2, {1: 5})


def test_two_endless_jumps_at_each_other() -> None:
    cursor = Cursor(_plan(_item(177, 1.0, -1.0), _item(177, 0.0, -1.0)))
    cursor.settle()
    assert cursor.item is None


def test_a_jump_out_of_the_plan_is_ignored() -> None:
    for target in (5.0, -1.0, math.nan, math.inf):
        cursor = Cursor(_plan(_item(177, target, 1.0), _item(16)))
        cursor.settle()
        assert cursor.seq == 1


def test_a_copy_looks_ahead_without_moving_the_original() -> None:
    cursor = Cursor(_plan(_item(16), _item(177, 0.0, 1.0), _item(178, 1.0, 3.0), _item(16)))
    ahead = cursor.copy()
    ahead.advance()
    ahead.advance()
    assert (ahead.seq, ahead.speed_mps, ahead.jumps) == (3, 3.0, {1: 1})
    assert (cursor.seq, cursor.speed_mps, cursor.jumps) == (0, None, {})


def test_between_camera_commands_it_is_surveying() -> None:
    """As QGroundControl writes a survey: trigger distance at the begin of a transect, 0 at its end."""
    items = _plan(
        _item(16),
        _item(16),
        _item(206, 5.0),
        _item(16),
        _item(206, 0.0),
        _item(16),
        _item(2000),
        _item(16),
        _item(2001),
        _item(16),
    )
    cursor = Cursor(items)
    surveying = []
    while cursor.item is not None:
        surveying.append(cursor.surveying)
        cursor.advance()
    assert surveying == [False, False, True, False, True, False]
    cursor.stand_at(3)
    assert cursor.surveying and cursor.copy().surveying, "also when it was set to there"
    cursor.stand_at(5)
    assert not cursor.surveying


def test_items_about_the_lead_boat() -> None:
    items = _plan(
        _item(31012, -90.0, math.nan),
        _item(31012, math.nan, 30.0),
        _item(32, -1.0),
        _item(32, 7.0),
        _item(32, math.nan),
        _item(16),
    )
    cursor = Cursor(items)
    assert cursor.settle() == [
        SetFollowPosition(-math.pi / 2, None),
        SetFollowPosition(None, 30.0),
        FollowLeader(2, None),
        FollowLeader(3, 7),
        FollowLeader(4, None),
    ]
    assert cursor.seq == 5


def test_a_condition_holds_back_following_too() -> None:
    cursor = Cursor(_plan(_item(16), _item(112, 5.0), _item(32, -1.0), _item(16)))
    assert cursor.advance() == [] and cursor.seq == 3
    assert cursor.open_gate() == [FollowLeader(2, None)]


def test_the_speed_of_the_leg_outlasts_a_pause() -> None:
    """What a condition holds back slows the boat down once it is met, not when the boat goes on."""
    cursor = Cursor(_plan(_item(178, 1.0, 2.0), _item(16), _item(112, 60.0), _item(178, 1.0, 0.5), _item(16)))
    cursor.settle()
    cursor.advance()
    assert (cursor.speed_mps, cursor.leg_speed_mps) == (0.5, 2.0)
    assert cursor.settle() == [] and cursor.leg_speed_mps == 2.0
    assert cursor.open_gate() == [SetSpeed(0.5)]
    cursor.stand_at(4)
    assert cursor.leg_speed_mps == 0.5
