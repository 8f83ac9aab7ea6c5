"""Each broken plan is refused with its code, its item and a remedy; what ground stations really send is taken."""

import math
from dataclasses import replace

import pytest

from companion.mission.commands import RULES, Role
from companion.mission.plan import PlanItem, PlanKind, PlanResult
from companion.mission.validation import CAPACITY, check_item, check_plan

_NAN = math.nan
_LAT, _LON = 634389000, 103990000


def _item(
    command: int, *params: float, seq: int = 0, frame: int = 3, x: int = _LAT, y: int = _LON, z: float = 50.0
) -> PlanItem:
    p1, p2, p3, p4 = (*params, 0.0, 0.0, 0.0, _NAN)[: len(params)] + (0.0, 0.0, 0.0, _NAN)[len(params) :]
    return PlanItem(seq, command, frame, p1, p2, p3, p4, x, y, z)


def _plan(*items: PlanItem) -> list[PlanItem]:
    return [replace(item, seq=seq) for seq, item in enumerate(items)]


WAYPOINT = _item(16)


@pytest.mark.parametrize(
    "item",
    [
        WAYPOINT,
        _item(16, 0.0, _NAN, _NAN, _NAN, z=_NAN),
        _item(16, 30.0, 2.5, 0.0, -90.0, z=-1e9),
        *(_item(16, frame=frame) for frame in (0, 3, 5, 6, 10, 11)),
        _item(16, x=-900_000_000, y=1_800_000_000),
        _item(17, 0.0, 0.0, 10.0, 360.0),
        _item(19, 20.0),
        _item(20, frame=2, x=0, y=0),
        _item(93, 5.0, -1.0, -1.0, -1.0, frame=2),
        _item(93, -1.0, 14.0, -1.0, 0.0, frame=2),
        _item(115, 90.0, 0.0, -1.0, 1.0, frame=2),
        _item(177, 0.0, -1.0, frame=2),
        _item(178, 1.0, 2.0, -1.0, 0.0, frame=2),
        _item(178, 1.0, -2.0, -1.0, 0.0, frame=0, x=5_000_000_00, y=0),
        _item(179, 1.0, frame=2, x=0, y=0),
        _item(179, 0.0),
    ],
)
def test_accepted_in_a_mission(item: PlanItem) -> None:
    assert check_item(PlanKind.MISSION, item) is None


@pytest.mark.parametrize("command", [command for command, rule in RULES.items() if rule.role is Role.IGNORED])
def test_camera_commands_are_accepted_with_any_parameters(command: int) -> None:
    assert check_item(PlanKind.MISSION, _item(command, _NAN, -7.0, math.inf, _NAN, frame=2, x=2**31 - 1, y=-5)) is None


@pytest.mark.parametrize(
    ("item", "result", "words"),
    [
        (_item(23), PlanResult.UNSUPPORTED, "command 23 is not supported"),
        (_item(211), PlanResult.UNSUPPORTED, "remove"),
        (_item(5001, 3.0), PlanResult.UNSUPPORTED, "belongs to the fence"),
        (_item(16, frame=1), PlanResult.UNSUPPORTED_FRAME, "frame 1"),
        (_item(16, frame=2), PlanResult.UNSUPPORTED_FRAME, "global frame"),
        (_item(16, -1.0), PlanResult.INVALID_PARAM1, "hold time (param1) is -1"),
        (_item(16, _NAN), PlanResult.INVALID_PARAM1, "nan"),
        (_item(16, math.inf), PlanResult.INVALID_PARAM1, "inf"),
        (_item(16, 0.0, -2.0), PlanResult.INVALID_PARAM2, "acceptance radius"),
        (_item(16, 0.0, 0.0, 0.0, 361.0), PlanResult.INVALID_PARAM4, "heading"),
        (_item(16, 0.0, 0.0, 0.0, math.inf), PlanResult.INVALID_PARAM4, "NaN for none"),
        (_item(16, x=900_000_001), PlanResult.INVALID_PARAM5_X, "90.0000001"),
        (_item(16, x=2**31 - 1), PlanResult.INVALID_PARAM5_X, "latitude"),
        (_item(16, y=-1_800_000_001), PlanResult.INVALID_PARAM6_Y, "longitude"),
        (_item(19, _NAN), PlanResult.INVALID_PARAM1, "time"),
        (_item(93, -0.5), PlanResult.INVALID_PARAM1, "time of day"),
        (_item(93, -1.0, 24.0, 0.0, 0.0), PlanResult.INVALID_PARAM2, "hour"),
        (_item(93, -1.0, 12.0, _NAN, 0.0), PlanResult.INVALID_PARAM3, "minute"),
        (_item(93, -1.0, 12.0, 0.0, 1.5), PlanResult.INVALID_PARAM4, "second"),
        (_item(93, -1.0, -1.0, -1.0, -1.0), PlanResult.INVALID_PARAM2, "has no time to wait for"),
        (_item(115, 400.0, 0.0, 0.0, 0.0), PlanResult.INVALID_PARAM1, "angle"),
        (_item(115, 10.0, 0.0, 2.0, 0.0), PlanResult.INVALID_PARAM3, "direction"),
        (_item(115, 10.0, 0.0, 0.0, 0.5), PlanResult.INVALID_PARAM4, "relative"),
        (_item(177, 1.5, 1.0), PlanResult.INVALID_PARAM1, "target"),
        (_item(177, 1.0, -2.0), PlanResult.INVALID_PARAM2, "repeat"),
        (_item(177, 1.0, 0.5), PlanResult.INVALID_PARAM2, "repeat"),
        (_item(178, 3.0, 1.0), PlanResult.INVALID_PARAM1, "ground speed"),
        (_item(178, 1.0, 0.0), PlanResult.INVALID_PARAM2, "more than 0"),
        (_item(178, 1.0, _NAN), PlanResult.INVALID_PARAM2, "speed"),
        (_item(179, 2.0), PlanResult.INVALID_PARAM1, "current position"),
        (_item(179, 0.0, frame=2), PlanResult.UNSUPPORTED_FRAME, "frame 2"),
        (_item(179, 0.0, x=2**31 - 1), PlanResult.INVALID_PARAM5_X, "latitude"),
        (_item(31, frame=2), PlanResult.UNSUPPORTED_FRAME, "global frame"),
        (_item(82, -1.0), PlanResult.INVALID_PARAM1, "hold time"),
        (_item(112, -1.0), PlanResult.INVALID_PARAM1, "delay"),
        (_item(114, _NAN), PlanResult.INVALID_PARAM1, "distance"),
        (_item(181, 0.0, 0.5), PlanResult.INVALID_PARAM2, "1 (on) or 0 (off)"),
        (_item(181, -1.0, 1.0), PlanResult.INVALID_PARAM1, "number of a relay"),
        (_item(182, 0.0, 0.0, 1.0), PlanResult.INVALID_PARAM2, "count"),
        (_item(182, 0.0, 1.0, 0.0), PlanResult.INVALID_PARAM3, "cycle time"),
        (_item(183, 0.0, 1500.0), PlanResult.INVALID_PARAM1, "servo output, 1 or more"),
        (_item(183, 1.0, 0.5), PlanResult.INVALID_PARAM2, "500 to 2500 µs"),
        (_item(184, 1.0, 1500.0, 1.5, 1.0), PlanResult.INVALID_PARAM3, "count"),
        (_item(184, 1.0, 1500.0, 2.0, _NAN), PlanResult.INVALID_PARAM4, "cycle time"),
        (_item(187, 0.0, 0.0, 1.5, 0.0), PlanResult.INVALID_PARAM3, "actuator 3"),
        (_item(187, 0.0, 0.0, 0.0, 0.0, x=1), PlanResult.INVALID_PARAM5_X, "use 1 to 4"),
    ],
)
def test_refused_from_a_mission(item: PlanItem, result: PlanResult, words: str) -> None:
    refusal = check_item(PlanKind.MISSION, replace(item, seq=7))
    assert refusal is not None
    assert (refusal.result, refusal.seq) == (result, 7)
    assert str(refusal).startswith("item 8: ")
    assert words in refusal.text


@pytest.mark.parametrize(
    ("kind", "item", "result"),
    [
        (PlanKind.FENCE, _item(5001, 3.0, 0.0), None),
        (PlanKind.FENCE, _item(5001, 2.0, 0.0), PlanResult.INVALID_PARAM1),
        (PlanKind.FENCE, _item(5002, 3.5, 0.0), PlanResult.INVALID_PARAM1),
        (PlanKind.FENCE, _item(5002, _NAN, 0.0), PlanResult.INVALID_PARAM1),
        (PlanKind.FENCE, _item(5002, 3.0, -1.0), PlanResult.INVALID_PARAM2),
        (PlanKind.FENCE, _item(5003, 50.0, 2.0), None),
        (PlanKind.FENCE, _item(5003, 0.0, 0.0), None),
        (PlanKind.FENCE, _item(5004, -5.0, 0.0), PlanResult.INVALID_PARAM1),
        (PlanKind.FENCE, _item(5003, 3.0e38, 0.0), PlanResult.INVALID_PARAM1),
        (PlanKind.FENCE, _item(5003, 2.0e7, 0.0), None),
        (PlanKind.FENCE, _item(5004, 5.0, 0.0, frame=2), PlanResult.UNSUPPORTED_FRAME),
        (PlanKind.FENCE, _item(5000, z=_NAN), None),
        (PlanKind.FENCE, WAYPOINT, PlanResult.UNSUPPORTED),
        (PlanKind.RALLY, _item(5100, z=-30.0), None),
        (PlanKind.RALLY, _item(5100, y=1_900_000_000), PlanResult.INVALID_PARAM6_Y),
        (PlanKind.RALLY, WAYPOINT, PlanResult.UNSUPPORTED),
    ],
)
def test_items_of_fence_and_rally_points(kind: PlanKind, item: PlanItem, result: PlanResult | None) -> None:
    refusal = check_item(kind, item)
    assert (refusal and refusal.result) == result


def _vertices(
    *corners: tuple[int, int], count: int | None = None, command: int = 5001, group: float = 0.0
) -> list[PlanItem]:
    return [_item(command, float(count or len(corners)), group, frame=0, x=_LAT + x, y=_LON + y) for x, y in corners]


SQUARE = ((0, 0), (0, 9000), (9000, 9000), (9000, 0))
BOW_TIE = ((0, 0), (9000, 9000), (0, 9000), (9000, 0))
DO_NOTHING = _item(206, 0.0, frame=2)
FOR_EVER = -1.0

BROKEN = [
    (
        PlanKind.MISSION,
        _plan(*[WAYPOINT] * 7, _item(177, 12.0, 1.0), WAYPOINT, WAYPOINT),
        PlanResult.INVALID_PARAM1,
        7,
        "DO_JUMP to item 13, but the plan has 10 items",
    ),
    (PlanKind.MISSION, _plan(WAYPOINT, _item(177, 1.0, 1.0)), PlanResult.INVALID_PARAM1, 1, "to itself"),
    (
        PlanKind.MISSION,
        _plan(WAYPOINT, DO_NOTHING, DO_NOTHING, _item(177, 1.0, FOR_EVER)),
        PlanResult.INVALID_PARAM1,
        3,
        "for ever",
    ),
    (
        PlanKind.MISSION,
        _plan(_item(177, 2.0, FOR_EVER), WAYPOINT, DO_NOTHING, _item(177, 0.0, FOR_EVER)),
        PlanResult.INVALID_PARAM1,
        0,
        "for ever",
    ),
    (PlanKind.MISSION, [WAYPOINT, replace(WAYPOINT, seq=2)], PlanResult.INVALID_SEQUENCE, 1, "without gaps"),
    (PlanKind.MISSION, _plan(DO_NOTHING, _item(178, 1.0, 1.0)), PlanResult.INVALID, None, "add a waypoint"),
    (PlanKind.MISSION, _plan(*[WAYPOINT] * (CAPACITY + 1)), PlanResult.NO_SPACE, None, "10000"),
    (PlanKind.FENCE, _plan(*_vertices(*SQUARE, count=5)), PlanResult.INVALID_PARAM1, 0, "4 of its 5"),
    (
        PlanKind.FENCE,
        _plan(*_vertices(*SQUARE[:2], count=4), *_vertices(*SQUARE[2:], count=3)),
        PlanResult.INVALID_PARAM1,
        2,
        "same count",
    ),
    (
        PlanKind.FENCE,
        _plan(*_vertices(*SQUARE[:2], count=4), *_vertices(*SQUARE[2:], count=4, group=1.0)),
        PlanResult.INVALID_PARAM2,
        2,
        "same group",
    ),
    (
        PlanKind.FENCE,
        _plan(*_vertices(*SQUARE[:2], count=4), _item(5003, 9.0, 0.0), *_vertices(*SQUARE[2:], count=4)),
        PlanResult.INVALID,
        2,
        "one after the other",
    ),
    (
        PlanKind.FENCE,
        _plan(_item(5003, 99.0, 0.0), *_vertices(*BOW_TIE, command=5002)),
        PlanResult.INVALID,
        1,
        "sides 2–3 and 4–5",
    ),
    (
        PlanKind.FENCE,
        _plan(_item(5000), _item(5003, 9.0, 0.0), _item(5000)),
        PlanResult.INVALID,
        2,
        "second return point",
    ),
    (PlanKind.FENCE, _plan(*_vertices(*SQUARE, count=5000)), PlanResult.NO_SPACE, 0, "1000 or fewer"),
    (PlanKind.RALLY, [replace(_item(5100), seq=3)], PlanResult.INVALID_SEQUENCE, 0, "without gaps"),
]


@pytest.mark.parametrize(("kind", "items", "result", "seq", "words"), BROKEN)
def test_broken_plans(kind: PlanKind, items: list[PlanItem], result: PlanResult, seq: int | None, words: str) -> None:
    refusal = check_plan(kind, items)
    assert refusal is not None
    assert (refusal.result, refusal.seq) == (result, seq)
    assert words in refusal.text


@pytest.mark.parametrize(
    ("kind", "items"),
    [
        *((kind, []) for kind in PlanKind),
        (PlanKind.MISSION, _plan(WAYPOINT, _item(177, 0.0, FOR_EVER))),
        (PlanKind.MISSION, _plan(DO_NOTHING, WAYPOINT, DO_NOTHING, _item(177, 0.0, FOR_EVER), DO_NOTHING)),
        (PlanKind.MISSION, _plan(DO_NOTHING, _item(177, 0.0, 3.0), WAYPOINT)),
        (PlanKind.MISSION, _plan(*[WAYPOINT] * CAPACITY)),
        (
            PlanKind.FENCE,
            _plan(*_vertices(*SQUARE), *_vertices(*SQUARE[:3], group=1.0), _item(5003, 9.0, 0.0), _item(5000)),
        ),
        (PlanKind.RALLY, _plan(_item(5100), _item(5100))),
    ],
)
def test_whole_plans_that_are_accepted(kind: PlanKind, items: list[PlanItem]) -> None:
    assert [check_item(kind, item) for item in items if check_item(kind, item)] == []
    assert check_plan(kind, items) is None


@pytest.mark.parametrize("value", [_NAN, math.inf, -math.inf, 0.0, -1.0, 1e30])
@pytest.mark.parametrize(("kind", "command"), [(PlanKind.MISSION, 177), (PlanKind.FENCE, 5001), (PlanKind.FENCE, 5004)])
def test_a_plan_of_unchecked_items_causes_no_error(kind: PlanKind, command: int, value: float) -> None:
    check_plan(kind, _plan(_item(command, value, value), WAYPOINT if kind is PlanKind.MISSION else _item(5000)))


@pytest.mark.parametrize(
    ("item", "result", "words"),
    [
        (_item(183, 3.0, 1500.0), PlanResult.INVALID_PARAM1, "there is no servo output 3: this boat has 1 to 2"),
        (_item(184, 3.0, 1500.0, 1.0, 1.0), PlanResult.INVALID_PARAM1, "no servo output 3"),
        (_item(181, 1.0, 1.0), PlanResult.INVALID_PARAM1, "there is no relay 1: this boat has 0 to 0"),
        (_item(187, 0.0, _NAN, 0.0, _NAN), PlanResult.INVALID_PARAM3, "no servo output 3"),
    ],
)
def test_outputs_that_the_boat_does_not_have(item: PlanItem, result: PlanResult, words: str) -> None:
    items = _plan(WAYPOINT, replace(item, x=0, y=0, z=0.0))
    assert check_item(PlanKind.MISSION, items[1]) is None and check_plan(PlanKind.MISSION, items) is None
    refusal = check_plan(PlanKind.MISSION, items, servos=2, relays=1)
    assert refusal is not None
    assert (
        (refusal.result, refusal.seq) == (result, 1) and words in refusal.text and str(refusal).startswith("item 2: ")
    )
    assert check_plan(PlanKind.MISSION, items, servos=4, relays=2) is None
