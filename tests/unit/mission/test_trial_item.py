"""MAV_CMD_USER_5: a sea trial in a mission."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.core.decision import MissionState, ModeId
from companion.mission.cursor import Cursor
from companion.mission.itinerary import task_at
from companion.mission.plan import PlanItem, PlanKind, PlanResult
from companion.mission.summary import format_summary, summarise
from companion.mission.tasks import Sail, SeaTrial
from companion.mission.validation import check_item, check_plan
from companion.modes.trial.mode import COMPLETE, TrialMode
from tests.unit.conftest import Boat

TRIAL = PlanItem(0, 31014, 2, 30.0, 0.0, 0.0, 0.0, 0, 0, 0.0)
WAYPOINT = PlanItem(0, 16, 3, 0.0, 0.0, 0.0, math.nan, 634_390_000, 103_990_000, 50.0)


@pytest.mark.parametrize("changes", [{}, {"param1": 0.0}, {"param1": math.nan}, {"param2": math.nan}])
def test_taken(changes: dict[str, float]) -> None:
    item = replace(TRIAL, **changes)
    assert check_item(PlanKind.MISSION, item) is None and check_plan(PlanKind.MISSION, [item]) is None


@pytest.mark.parametrize(
    ("changes", "result"),
    [({"param1": -1.0}, PlanResult.INVALID_PARAM1), ({"param2": 1.0}, PlanResult.INVALID_PARAM2)],
)
def test_refused(changes: dict[str, float], result: PlanResult) -> None:
    refusal = check_item(PlanKind.MISSION, replace(TRIAL, **changes))
    assert refusal is not None and refusal.result is result


def test_the_boat_comes_to_rest_before_it() -> None:
    items = (WAYPOINT, replace(TRIAL, seq=1), replace(WAYPOINT, seq=2))
    task = task_at(Cursor(items), arrived=False)
    assert isinstance(task, Sail) and task.stop
    assert task_at(Cursor(items, 1), arrived=False) == SeaTrial(1, 30.0)
    assert task_at(Cursor((replace(TRIAL, param1=0.0),)), arrived=False) == SeaTrial(0, None)


def underway(boat: Boat, radius_m: float) -> None:
    """Sails a point, a trial and another point, as far as the trial."""
    boat.upload((10.0, 0.0), (20.0, 0.0), commands={1: replace(TRIAL, param1=radius_m)})
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.until(lambda: boat.status.mission.seq == 1)
    boat.step(1.0)


def test_the_mission_goes_on_after_it(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    underway(boat, 30.0)
    assert boat.status.mode is ModeId.TRIAL and boat.status.mission.state is MissionState.PAUSED
    assert boat.status.orbit is not None and boat.status.orbit.radius_m == 30.0
    with monkeypatch.context() as patch:
        patch.setattr(TrialMode, "ended", COMPLETE)
        boat.step()
    assert "Mission item 2 reached" in boat.texts()
    boat.until(lambda: boat.status.mission.state is MissionState.COMPLETE)
    assert boat.away_m(20.0, 0.0) < 1.5


def test_a_trial_that_gives_up_leaves_the_mission_at_its_item(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    underway(boat, 30.0)
    monkeypatch.setattr(TrialMode, "ended", "carried out of the circle again and again")
    boat.step(0.2)
    assert boat.status.mode is ModeId.HOLD and boat.status.mission.seq == 1


def test_one_that_the_operator_chose_again_does_not_go_on_with_the_mission(
    boat: Boat, monkeypatch: pytest.MonkeyPatch
) -> None:
    underway(boat, 30.0)
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    assert boat.supervisor.request_mode(ModeId.TRIAL, boat.now_s).accepted
    monkeypatch.setattr(TrialMode, "ended", COMPLETE)
    boat.step(0.2)
    assert boat.status.mode is ModeId.HOLD


def test_a_trial_that_is_refused_holds_with_the_reason(boat: Boat) -> None:
    underway(boat, 5.0)
    assert boat.status.mode is ModeId.HOLD and boat.status.mission.seq == 1
    assert "Item 2: Trial refused: circle of 5 m: this boat needs 12 m" in boat.texts()


def test_the_summary_names_it() -> None:
    assert "item 2 is a sea trial: not counted" in format_summary(summarise([WAYPOINT, replace(TRIAL, seq=1)], 1.0))
