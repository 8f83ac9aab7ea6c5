"""Commands for cameras and gimbals: what each means, with the parameters of MAVLink's common.xml."""

from __future__ import annotations

import math

import pytest

from companion.core.payload import Forward, PayloadPart
from companion.mission.commands import RULES, Command, Role
from companion.mission.cursor import Cursor
from companion.mission.payload import PASSED_ON, PICTURES, payload_action, payload_of
from companion.mission.plan import PlanItem, PlanKind
from companion.mission.tasks import (
    ByDistance,
    ByTime,
    PayloadAction,
    StopPictures,
    TakePicture,
    TriggerAsBefore,
    TriggerControl,
)
from companion.mission.validation import check_item

NAN = math.nan
CAMERA, GIMBAL = PayloadPart.CAMERA, PayloadPart.GIMBAL


def do(command: int, *params: float, seq: int = 0, x: int = 0, frame: int = 2) -> PlanItem:
    padded = (*params, *(0.0 for _ in range(4 - len(params))))
    return PlanItem(seq, command, frame, *padded, x, 0, 0.0)


MEANINGS: list[tuple[int, tuple[float, ...], PayloadAction]] = [
    (203, (0, 0, 0, 0, 1, 0, 0), TakePicture()),
    (206, (5.0, 0, 1, 0, 0, 0, 0), ByDistance(0, 5.0, True)),
    (206, (0.0, 0, 1, 0, 0, 0, 0), ByDistance(0, 0.0, True)),
    (206, (2.5, NAN, NAN, 2, 0, 0, 0), ByDistance(2, 2.5)),
    (214, (1500.0, 0, 0, 0, 0, 0, 0), ByTime(0, 1.5)),
    (214, (-1.0, 0, 0, 0, 0, 0, 0), TriggerControl(None, None)),
    (2000, (0, 0, 1, 7, 0, 0, 0), TakePicture(0, 7)),
    (2000, (1, 2.0, 10, 0, 0, 0, 0), ByTime(1, 2.0, 10)),
    (2000, (0, 2.0, 0, 0, NAN, NAN, NAN), ByTime(0, 2.0)),
    (2000, (0, NAN, NAN, NAN, NAN, NAN, NAN), ByTime(0, 0.0)),
    (2001, (NAN, 0, 0, 0, 0, 0, 0), StopPictures()),
    (2003, (1, -1, 0, 0, 0, 0, 0), TriggerControl(True, False)),
    (2003, (-1, 1, NAN, 0, 0, 0, 0), TriggerControl(None, None, reset=True)),
]


@pytest.mark.parametrize(("command", "params", "action"), MEANINGS)
def test_what_takes_pictures(command: int, params: tuple[float, ...], action: PayloadAction) -> None:
    assert payload_action(command, params, None) == action


@pytest.mark.parametrize("command", sorted(PASSED_ON))
def test_all_else_is_passed_on_as_it_came(command: int) -> None:
    params = (0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    part = PASSED_ON[command]
    assert payload_action(command, params, None) == Forward(part, command, params, None, 0, -1)


@pytest.mark.parametrize(
    ("command", "params", "component"),
    [
        (1000, (0, 0, 0, 0, 0, 0, 154), 154),
        (1000, (0, 0, 0, 0, 0, 0, 1), 0),
        (195, (171, 0, 0, 0, 634, 103, 0), 171),
        (205, (154, 0, 0, 0, 0, 0, 2), 0),
        (530, (101, 0, 0, 0, 0, 0, 0), 101),
        (530, (NAN, 0, 0, 0, 0, 0, 0), 0),
    ],
)
def test_a_command_may_name_its_component(command: int, params: tuple[float, ...], component: int) -> None:
    action = payload_action(command, params, None)
    assert isinstance(action, Forward) and action.component == component


def test_a_place_keeps_its_frame_and_whole_numbers() -> None:
    item = PlanItem(4, 195, 3, 0.0, 0.0, 0.0, 0.0, 634389000, 103990000, 5.0)
    assert payload_of(item) == Forward(GIMBAL, 195, (0, 0, 0, 0, 634389000, 103990000, 5.0), 3, 0, 4)


def test_every_such_command_has_a_rule_and_every_rule_a_meaning() -> None:
    ruled = {command for command, rule in RULES.items() if rule.role is Role.PAYLOAD}
    assert ruled == PICTURES | set(PASSED_ON)
    for command in ruled:
        values = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
        assert payload_action(command, values, None) is not None
    assert payload_action(Command.DO_SET_RELAY, (0.0,) * 7, None) is None


@pytest.mark.parametrize(
    ("item", "refused"),
    [
        (do(206, 5.0, 0, 1), False),
        (do(206, 0.0, 0, 1), False),
        (do(206, -3.0), True),
        (do(206, NAN), True),
        (do(206, 0.01), True),
        (do(214, -1.0), False),
        (do(214, -7.0), True),
        (do(2000, 0, 1.0, 5, 0), False),
        (do(2000, 0, -1.0), True),
        (do(2000, 0, 1.0, 2.5), True),
        (do(205, -90.0, NAN, 30.0), False),
        (do(260, 5.0), True),
    ],
)
def test_parameters_are_checked_at_upload(item: PlanItem, refused: bool) -> None:
    assert (check_item(PlanKind.MISSION, item) is not None) == refused


def test_a_mission_that_begins_in_the_middle_does_what_the_items_before_say() -> None:
    items = [do(206, 5.0, 0, 1), do(16), do(2001), do(2000, 0, 2.0, 0), do(16), do(2000, 0, 1.0, 3), do(16)]
    found = [Cursor(items, seq).trigger_before() for seq in range(len(items))]
    on, off = TriggerAsBefore(ByDistance(0, 5.0)), TriggerAsBefore(None)
    timed = TriggerAsBefore(ByTime(0, 2.0))
    assert found == [[off], [on], [on], [off], [timed], [timed], [off]]
    assert Cursor([do(16), do(205)], 1).trigger_before() == []
