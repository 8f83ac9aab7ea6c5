"""The mission's state machine, step by step."""

import json
import math
from dataclasses import replace

import pytest

from companion.core.decision import MissionState
from companion.mission.executor import MissionExecutor, Replaced
from companion.mission.itinerary import LONGEST_ROUTE
from companion.mission.plan import PlanItem, PlanKind, Plans
from companion.mission.tasks import (
    Complete,
    DoCondition,
    ReturnHome,
    RoutePoint,
    Sail,
    SetActuators,
    SetHome,
    SetRelay,
    SetServo,
    SetSpeed,
    Stay,
    Turn,
    Wait,
)

_NAN = math.nan


def _item(command: int, *params: float, north: int = 0) -> PlanItem:
    p1, p2, p3, p4 = (*params, *(0.0, 0.0, 0.0, _NAN)[len(params) :])
    frame = 3 if command in (16, 17, 19) else 2
    return PlanItem(0, command, frame, p1, p2, p3, p4, 634389000 + north, 103990000, 50.0)


def _plan(*items: PlanItem) -> tuple[PlanItem, ...]:
    return tuple(replace(item, seq=seq) for seq, item in enumerate(items))


def _executor(*items: PlanItem) -> tuple[MissionExecutor, Plans]:
    plans = Plans()
    executor = MissionExecutor(plans)
    plans.replace(PlanKind.MISSION, _plan(*items))
    return executor, plans


WAYPOINT = _item(16)
FAST = _item(178, 1.0, 2.5)
USUAL = _item(178, 1.0, -2.0)
UNCHANGED = _item(178, 1.0, -1.0)


def _route(executor: MissionExecutor) -> list[int]:
    assert isinstance(executor.task, Sail)
    return [point.seq for point in executor.task.route]


def test_nothing_to_begin() -> None:
    executor, _ = _executor()
    assert executor.progress.state is MissionState.NO_MISSION
    assert executor.task is None
    assert executor.begin() == "no mission: upload one first"
    assert executor.set_current(0) == "no mission: upload one first"
    assert executor.complete(0) == ()


def test_a_square_from_start_to_end() -> None:
    executor, _ = _executor(*[_item(16, 0.0, 2.0, north=n) for n in range(3)])
    assert executor.progress.state is MissionState.NOT_STARTED
    assert executor.task is None
    assert executor.begin() is None
    task = executor.task
    assert isinstance(task, Sail)
    assert task.route[2] == RoutePoint(2, pytest.approx(63.4389002), pytest.approx(10.399), 2.0, None)
    assert task.stop
    for seq in range(3):
        assert executor.progress.seq == seq
        assert executor.task is task
        assert executor.complete(seq) == ()
        assert (executor.progress.reached, executor.progress.reached_seq) == (seq + 1, seq)
    assert executor.progress.state is MissionState.COMPLETE
    assert executor.progress.seq == 2
    assert isinstance(executor.task, Complete)


def test_a_hold_counts_once_on_arrival() -> None:
    executor, _ = _executor(WAYPOINT, _item(16, 10.0, 0.0, 0.0, 90.0), WAYPOINT)
    executor.begin()
    assert _route(executor) == [0, 1]
    assert executor.task.stop  # type: ignore[union-attr]
    executor.complete(0)
    executor.complete(1)
    assert executor.progress.reached == 2
    stay = executor.task
    assert stay == Stay(1, pytest.approx(63.4389), pytest.approx(10.399), pytest.approx(math.pi / 2), 10.0)
    assert executor.progress.seq == 1
    executor.complete(1)
    assert executor.progress.reached == 2
    assert _route(executor) == [2]


def test_a_heading_alone_makes_a_stay() -> None:
    executor, _ = _executor(_item(16, 0.0, 0.0, 0.0, 45.0), WAYPOINT)
    executor.begin()
    executor.complete(0)
    assert isinstance(executor.task, Stay)
    assert executor.task.duration_s == 0.0


def test_loiter_time_counts_when_the_time_is_over_and_loiter_unlimited_on_arrival() -> None:
    executor, _ = _executor(_item(19, 30.0), _item(17))
    executor.begin()
    executor.complete(0)
    assert executor.task == Stay(0, pytest.approx(63.4389), pytest.approx(10.399), None, 30.0)
    assert executor.progress.reached == 0
    executor.complete(0)
    assert (executor.progress.reached, executor.progress.reached_seq) == (1, 0)
    executor.complete(1)
    assert (executor.progress.reached, executor.progress.reached_seq) == (2, 1)
    assert isinstance(executor.task, Stay)
    assert executor.task.duration_s is None


def test_waiting_turning_and_going_home() -> None:
    executor, _ = _executor(
        _item(93, 7.0),
        _item(115, 270.0, 0.0, 1.0, 0.0),
        _item(115, 30.0, 0.0, -1.0, 1.0),
        _item(93, -1.0, 14.0, 5.0, -1.0),
        _item(20),
    )
    executor.begin()
    for seq, task in enumerate(
        (
            Wait(0, 7.0),
            Turn(1, pytest.approx(-math.pi / 2), False, 1),
            Turn(2, pytest.approx(math.pi / 6), True, -1),
            Wait(3, math.inf, (14, 5, -1)),
            ReturnHome(4),
        )
    ):
        assert executor.task == task
        assert executor.task is executor.task
        executor.complete(seq)
    assert executor.progress.reached == 5
    assert executor.progress.state is MissionState.COMPLETE


def test_the_boat_stops_before_a_wait_and_not_before_the_way_home() -> None:
    waiting, _ = _executor(WAYPOINT, _item(93, 1.0))
    waiting.begin()
    assert waiting.task.stop  # type: ignore[union-attr]
    returning, _ = _executor(WAYPOINT, FAST, _item(20))
    returning.begin()
    assert not returning.task.stop  # type: ignore[union-attr]


def test_a_speed_applies_from_its_place_in_the_plan() -> None:
    executor, _ = _executor(WAYPOINT, FAST, WAYPOINT, UNCHANGED, WAYPOINT, USUAL, WAYPOINT)
    executor.begin()
    task = executor.task
    assert isinstance(task, Sail)
    assert [point.speed_mps for point in task.route] == [None, 2.5, 2.5, None]
    assert executor.complete(0) == (SetSpeed(2.5),)
    assert executor.complete(2) == ()
    assert executor.complete(4) == (SetSpeed(None),)


def test_items_before_the_first_waypoint_take_effect_at_the_start() -> None:
    executor, _ = _executor(FAST, _item(179, 1.0), WAYPOINT, _item(179, 0.0), WAYPOINT)
    executor.begin()
    assert executor.progress.seq == 2
    assert executor.take_actions() == (SetSpeed(2.5), SetHome(None, None))
    assert executor.take_actions() == ()
    assert executor.complete(2) == (SetHome(pytest.approx(63.4389), pytest.approx(10.399)),)


def test_pending_actions_come_with_the_next_item_in_order() -> None:
    executor, _ = _executor(FAST, WAYPOINT, USUAL, WAYPOINT)
    executor.begin()
    assert executor.complete(1) == (SetSpeed(2.5), SetSpeed(None))


def test_a_counted_jump() -> None:
    executor, _ = _executor(WAYPOINT, _item(16, north=9), _item(177, 0.0, 2.0), WAYPOINT)
    executor.begin()
    assert _route(executor) == [0, 1, 0, 1, 0, 1, 3]
    for seq in (0, 1, 0, 1, 0, 1, 3):
        assert executor.progress.seq == seq
        executor.complete(seq)
    assert executor.progress.state is MissionState.COMPLETE
    executor.begin()
    assert len(_route(executor)) == 7


def test_endless_laps_come_in_long_routes() -> None:
    executor, _ = _executor(WAYPOINT, _item(16, north=9), _item(16, north=18), _item(177, 0.0, -1.0))
    executor.begin()
    for lap in range(300):
        task = executor.task
        assert isinstance(task, Sail)
        assert len(task.route) == LONGEST_ROUTE
        assert not task.stop
        for seq in range(3):
            assert executor.progress.seq == seq, lap
            executor.complete(seq)
    assert executor.progress.reached == 900


def test_a_waypoint_reported_twice_is_counted_once() -> None:
    executor, _ = _executor(WAYPOINT, _item(16, north=9), _item(16, north=18), _item(177, 0.0, -1.0))
    executor.begin()
    for number in range(2 * LONGEST_ROUTE):
        executor.complete(number % 3)
        executor.complete(number % 3)
        assert executor.progress.reached == number + 1


def test_skipped_points_count_as_passed() -> None:
    executor, _ = _executor(*[WAYPOINT] * 5)
    executor.begin()
    executor.complete(3)
    assert (executor.progress.seq, executor.progress.reached, executor.progress.reached_seq) == (4, 4, 3)
    executor.complete(1)
    executor.complete(77)
    assert executor.progress.reached == 4


def test_a_single_waypoint_for_ever_makes_no_route_of_equal_points() -> None:
    executor, _ = _executor(WAYPOINT, _item(177, 0.0, -1.0))
    executor.begin()
    assert _route(executor) == [0]
    executor.complete(0)
    assert _route(executor) == [0]
    assert executor.progress.reached == 1


def test_a_long_mission_goes_on_seamlessly() -> None:
    executor, _ = _executor(*[WAYPOINT] * 450)
    executor.begin()
    lengths = []
    while executor.progress.state is MissionState.ACTIVE:
        route = _route(executor)
        lengths.append((len(route), executor.task.stop))  # type: ignore[union-attr]
        for seq in route:
            executor.complete(seq)
    assert sum(length for length, _ in lengths) == 450
    assert {length for length, _ in lengths[:-1]} == {LONGEST_ROUTE} and [stop for _, stop in lengths] == [False] * (
        len(lengths) - 1
    ) + [True]


def test_pause_and_resume_at_the_current_item() -> None:
    executor, _ = _executor(*[WAYPOINT] * 3)
    executor.pause()
    assert executor.progress.state is MissionState.NOT_STARTED
    executor.begin()
    executor.complete(0)
    executor.pause()
    assert executor.progress.state is MissionState.PAUSED
    assert executor.task is None
    assert executor.complete(1) == ()
    assert executor.begin() is None
    assert _route(executor) == [1, 2]


def test_an_active_mission_that_begins_again_goes_on_at_the_current_item() -> None:
    executor, _ = _executor(*[WAYPOINT] * 4)
    executor.begin()
    executor.complete(1)
    assert executor.begin() is None
    assert _route(executor) == [2, 3]
    assert executor.progress.reached == 2


def test_a_stay_is_resumed_and_not_counted_again() -> None:
    executor, _ = _executor(_item(16, 10.0), WAYPOINT)
    executor.begin()
    executor.complete(0)
    executor.pause()
    executor.begin()
    assert isinstance(executor.task, Stay)
    executor.complete(0)
    assert executor.progress.reached == 1


def test_begin_at_an_item_starts_afresh_there() -> None:
    executor, _ = _executor(WAYPOINT, WAYPOINT, _item(177, 0.0, 1.0))
    executor.begin()
    for seq in (0, 1, 0):
        executor.complete(seq)
    assert _route(executor)[executor.progress.reached :] == [1]
    assert executor.begin(1) is None
    assert _route(executor) == [1, 0, 1]
    assert executor.begin(3) == "the mission has items 1 to 3"


def test_nothing_left_to_sail_to() -> None:
    executor, _ = _executor(WAYPOINT, FAST)
    assert executor.begin(1) == "nothing to sail to from item 2 on"
    assert executor.progress.state is MissionState.NOT_STARTED
    assert executor.take_actions() == ()


def test_starting_over_goes_back_to_the_vessels_own_speed() -> None:
    executor, _ = _executor(WAYPOINT, FAST, WAYPOINT)
    executor.begin()
    executor.complete(0)
    executor.complete(2)
    executor.begin()
    assert executor.take_actions() == (SetSpeed(None),)


def test_set_current() -> None:
    executor, _ = _executor(WAYPOINT, WAYPOINT, _item(177, 0.0, 1.0), WAYPOINT)
    assert executor.set_current(4) == "the mission has items 1 to 4"
    assert executor.set_current(-1) is not None
    assert executor.set_current(1) is None
    assert (executor.progress.state, executor.progress.seq) == (MissionState.NOT_STARTED, 1)
    executor.begin()
    assert _route(executor) == [1, 0, 1, 3]
    executor.complete(1)
    assert executor.set_current(1) is None
    assert _route(executor) == [1, 3]  # the jump has been taken
    assert executor.set_current(1, reset=True) is None
    assert _route(executor) == [1, 0, 1, 3]
    executor.pause()
    assert executor.set_current(3) is None
    assert (executor.progress.state, executor.progress.seq) == (MissionState.PAUSED, 3)
    executor.begin()
    executor.complete(3)
    assert executor.progress.state is MissionState.COMPLETE
    assert executor.set_current(0, reset=True) is None
    assert executor.progress.state is MissionState.NOT_STARTED
    executor.begin()
    assert _route(executor) == [0, 1, 0, 1, 3]


def test_set_current_to_a_jump_of_an_active_mission_takes_it() -> None:
    executor, _ = _executor(WAYPOINT, WAYPOINT, _item(177, 0.0, 1.0))
    executor.begin()
    executor.set_current(2)
    assert executor.progress.seq == 0
    executor.set_current(2)
    assert executor.progress.state is MissionState.COMPLETE


class TestReplacedPlan:
    def test_continues_if_the_plan_is_the_same_up_to_the_current_item(self) -> None:
        executor, plans = _executor(*[_item(16, north=n) for n in range(4)])
        executor.begin()
        executor.complete(0)
        plans.replace(PlanKind.MISSION, _plan(*[_item(16, north=n) for n in (0, 1, 50)]))
        assert executor.replaced is Replaced.CONTINUED
        assert executor.progress.state is MissionState.ACTIVE
        assert _route(executor) == [1, 2]
        executor.complete(1)
        assert executor.replaced is None

    def test_restarts_if_the_plan_differs_before_it(self) -> None:
        executor, plans = _executor(*[_item(16, north=n) for n in range(4)])
        executor.begin()
        executor.complete(0)
        before = executor.task
        plans.replace(PlanKind.MISSION, _plan(*[_item(16, north=n) for n in (7, 1, 2, 3)]))
        assert executor.replaced is Replaced.RESTARTED
        assert executor.task is not before
        assert _route(executor) == [0, 1, 2, 3]
        assert executor.progress.reached == 1

    def test_restarts_if_the_plan_is_too_short(self) -> None:
        executor, plans = _executor(WAYPOINT, WAYPOINT)
        executor.begin()
        executor.complete(0)
        plans.replace(PlanKind.MISSION, _plan(WAYPOINT))
        assert executor.replaced is Replaced.RESTARTED
        assert _route(executor) == [0]

    def test_keeps_the_counts_of_jumps_behind_and_forgets_those_ahead(self) -> None:
        lap = (WAYPOINT, _item(177, 0.0, 1.0), WAYPOINT)
        executor, plans = _executor(*lap, _item(177, 2.0, 1.0), WAYPOINT)
        executor.begin()
        for seq in (0, 0, 2, 2, 4):
            executor.complete(seq)
        executor.set_current(2)
        executor.begin()
        plans.replace(PlanKind.MISSION, _plan(*lap, _item(177, 0.0, 1.0), WAYPOINT))
        assert _route(executor) == [2, 0, 2, 4]

    def test_paused(self) -> None:
        executor, plans = _executor(WAYPOINT, WAYPOINT)
        executor.begin()
        executor.complete(0)
        executor.pause()
        plans.replace(PlanKind.MISSION, _plan(WAYPOINT, WAYPOINT, WAYPOINT))
        assert (executor.progress.state, executor.progress.seq) == (MissionState.PAUSED, 1)
        plans.replace(PlanKind.MISSION, _plan(_item(16, north=5)))
        assert (executor.progress.state, executor.progress.seq) == (MissionState.NOT_STARTED, 0)

    def test_cleared(self) -> None:
        executor, plans = _executor(WAYPOINT)
        executor.begin()
        plans.replace(PlanKind.MISSION, ())
        assert executor.progress.state is MissionState.NO_MISSION
        assert executor.task is None

    def test_complete_becomes_not_started(self) -> None:
        executor, plans = _executor(WAYPOINT)
        executor.begin()
        executor.complete(0)
        plans.replace(PlanKind.MISSION, _plan(WAYPOINT))
        assert executor.progress.state is MissionState.NOT_STARTED
        assert executor.replaced is None

    def test_a_new_fence_changes_nothing(self) -> None:
        executor, plans = _executor(WAYPOINT)
        executor.begin()
        task = executor.task
        plans.replace(PlanKind.FENCE, ())
        assert executor.task is task


class TestConditions:
    """A delay or a distance holds back the "do" items after it, while the boat sails on."""

    ON, OFF = _item(181, 0.0, 1.0), _item(181, 0.0, 0.0)

    def test_held_items_run_condition_by_condition(self) -> None:
        executor, _ = _executor(
            WAYPOINT, FAST, _item(112, 5.0), self.ON, USUAL, _item(114, 3.0), self.OFF, WAYPOINT, WAYPOINT
        )
        executor.begin()
        assert executor.gate is None
        assert executor.complete(0) == (SetSpeed(2.5),)
        first = executor.gate
        assert first is not None and (first.seq, first.delay_s, first.distance_m) == (2, 5.0, None)
        assert executor.open_gate() == (SetRelay(0, True), SetSpeed(None))
        second = executor.gate
        assert (
            second is not None and (second.seq, second.delay_s, second.distance_m) == (5, None, 3.0) and second != first
        )
        assert executor.open_gate() == (SetRelay(0, False),)
        assert executor.gate is None and executor.open_gate() == ()

    def test_at_the_end_of_the_leg_all_held_items_run(self) -> None:
        executor, _ = _executor(WAYPOINT, _item(112, 1e6), FAST, self.ON, WAYPOINT, UNCHANGED, WAYPOINT)
        executor.begin()
        executor.complete(0)
        assert executor.complete(4) == (SetSpeed(2.5), SetRelay(0, True))
        assert executor.gate is None

    def test_the_leg_may_be_sailed_at_the_faster_of_both_speeds(self) -> None:
        slow = _item(178, 1.0, 0.5)
        executor, _ = _executor(FAST, WAYPOINT, _item(114, 10.0), slow, WAYPOINT, WAYPOINT)
        executor.begin()
        assert isinstance(executor.task, Sail)
        assert [point.speed_mps for point in executor.task.route] == [2.5, 2.5, 0.5]

    def test_a_lap_meets_the_same_condition_anew(self) -> None:
        executor, _ = _executor(WAYPOINT, _item(112, 5.0), self.ON, WAYPOINT, _item(177, 0.0, 1.0))
        executor.begin()
        executor.complete(0)
        first = executor.gate
        executor.complete(3)
        executor.complete(0)
        assert executor.gate is not None and first is not None
        assert executor.gate.seq == first.seq and executor.gate != first

    def test_after_the_last_task_no_item_is_held(self) -> None:
        executor, _ = _executor(WAYPOINT, _item(114, 1.0), self.ON)
        executor.begin()
        assert executor.complete(0) == (SetRelay(0, True),)
        assert executor.progress.state is MissionState.COMPLETE and executor.gate is None

    def test_it_survives_a_restart_and_a_new_plan_that_goes_on_but_not_another_item(self) -> None:
        items = (WAYPOINT, _item(112, 5.0), self.ON, WAYPOINT, WAYPOINT)
        executor, plans = _executor(*items)
        executor.begin()
        executor.complete(0)
        other, _ = _executor(*items)
        assert other.restore(json.loads(json.dumps(executor.snapshot()))) is None
        assert other.gate is not None and other.gate.seq == 1
        plans.replace(PlanKind.MISSION, _plan(*items, WAYPOINT))
        assert executor.gate is not None and executor.open_gate() == (SetRelay(0, True),)
        other.set_current(0)
        assert other.gate is None

    def test_while_paused_no_held_item_runs(self) -> None:
        executor, _ = _executor(WAYPOINT, _item(112, 5.0), self.ON, WAYPOINT)
        executor.begin()
        executor.complete(0)
        executor.pause()
        assert executor.gate is None
        executor.begin()
        assert executor.gate == DoCondition(1, executor.gate.serial, 5.0, None)  # type: ignore[union-attr]


def test_servos_and_relays() -> None:
    executor, _ = _executor(
        _item(183, 2.0, 1900.0),
        _item(184, 1.0, 1100.0, 3.0, 2.0),
        _item(182, 1.0, 4.0, 0.5),
        _item(187, 0.5, _NAN, -1.0, _NAN),
        WAYPOINT,
        _item(181, 1.0, 0.0),
    )
    executor.begin()
    assert executor.take_actions() == (
        SetServo(2, 1900.0),
        SetServo(1, 1100.0, 3, 2.0),
        SetRelay(1, None, 4, 0.5),
        SetActuators((0.5, None, -1.0, None)),
    )
    assert executor.complete(4) == (SetRelay(1, False),)


def test_points_to_pass_by_other_names_and_what_a_boat_has_done_already() -> None:
    spline, altitude = replace(_item(82, 0.0), frame=3), replace(_item(31, 1.0, 30.0, 0.0, 1.0), frame=3)
    executor, _ = _executor(_item(22, 15.0), spline, altitude, _item(189), WAYPOINT)
    executor.begin()
    assert _route(executor) == [1, 2, 4]
    assert isinstance(executor.task, Sail)
    assert {(point.radius_m, point.yaw_rad) for point in executor.task.route} == {(None, None)}


class TestSnapshot:
    def test_a_restart_in_mid_mission(self) -> None:
        items = (FAST, WAYPOINT, _item(16, 10.0), _item(177, 1.0, 3.0), WAYPOINT)
        executor, _ = _executor(*items)
        executor.begin()
        for seq in (1, 2, 2, 1, 2):
            executor.complete(seq)
        kept = json.loads(json.dumps(executor.snapshot()))
        other, _ = _executor(*items)
        assert other.restore(kept) is None
        assert other.progress == executor.progress
        assert other.task == executor.task
        assert isinstance(other.task, Stay)
        assert other.snapshot() == kept
        for seq in (2, 1, 2, 2, 1, 2, 2):
            assert other.complete(seq) == executor.complete(seq)
            assert other.task == executor.task
        assert _route(other) == [4]

    def test_complete(self) -> None:
        executor, _ = _executor(WAYPOINT)
        executor.begin()
        executor.complete(0)
        other, _ = _executor(WAYPOINT)
        assert other.restore(executor.snapshot()) is None
        assert other.progress == executor.progress

    def test_a_snapshot_without_a_stay_in_the_plan(self) -> None:
        executor, _ = _executor(WAYPOINT)
        executor.begin()
        assert executor.restore(executor.snapshot() | {"arrived": True}) is None
        assert isinstance(executor.task, Sail)

    def test_of_another_mission(self) -> None:
        executor, _ = _executor(WAYPOINT)
        other, _ = _executor(WAYPOINT, WAYPOINT)
        assert other.restore(executor.snapshot()) == "it belongs to another mission"
        assert other.progress.state is MissionState.NOT_STARTED

    @pytest.mark.parametrize(
        "change",
        [
            {"seq": 3},
            {"seq": -1},
            {"seq": "0"},
            {"seq": None},
            {"state": 9},
            {"state": 1},
            {"jumps": [1]},
            {"jumps": {"a": 1}},
            {"jumps": {"1": -1}},
            {"speed_mps": "fast"},
            {"speed_mps": -3.0},
            {"speed_mps": math.nan},
            {"reached": 1.5},
            {"reached_seq": "x"},
            {"held": [2]},
            {"held": ["x"]},
            {"held": 3},
        ],
    )
    def test_damaged(self, change: dict[str, object]) -> None:
        executor, _ = _executor(WAYPOINT, WAYPOINT)
        executor.begin()
        before = executor.progress
        assert executor.restore(executor.snapshot() | change) is not None
        assert executor.progress == before

    def test_incomplete(self) -> None:
        executor, plans = _executor(WAYPOINT)
        assert executor.restore({}) is not None
        assert executor.restore({"plan_id": plans.plan_id(PlanKind.MISSION)}) is not None


def test_a_long_route_knows_what_comes_beyond_it() -> None:
    executor, _ = _executor(*(_item(16, north=10 * n) for n in range(LONGEST_ROUTE + 30)))
    assert executor.begin() is None
    first = executor.task
    assert isinstance(first, Sail) and not first.stop
    executor.complete(first.route[-1].seq)
    second = executor.task
    assert isinstance(second, Sail) and second.stop
    assert first.beyond == second.route[: len(first.beyond)] and len(first.beyond) == 16
    assert second.beyond == ()


def test_a_plan_that_was_prepared_is_not_compared_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 10,000 items that takes longer than a tick has."""
    executor, plans = _executor(*(_item(16, north=n) for n in range(4)))
    items = plans.items(PlanKind.MISSION)
    assert executor.begin() is None
    executor.complete(0)
    same = (*items[:3], replace(items[3], x=77))
    plans.prepared(PlanKind.MISSION, same)()()
    monkeypatch.setattr("companion.mission.executor.shared_items", None)
    plans.replace(PlanKind.MISSION, same)
    assert executor.replaced is Replaced.CONTINUED and executor.progress.seq == 1
