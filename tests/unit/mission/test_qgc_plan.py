"""Reading and writing QGroundControl's `.plan`."""

import json
import math
from dataclasses import replace
from typing import Any

import pytest

from companion.mission import qgc_plan
from companion.mission.plan import PlanItem
from companion.mission.plan_file import PlanFile, PlanFileError


def _simple(command: int, params: list[Any], jump_id: int, frame: int = 3) -> dict[str, Any]:
    """With the altitude keys that QGroundControl adds."""
    return {
        "AMSLAltAboveTerrain": None,
        "Altitude": 50,
        "AltitudeMode": 1,
        "autoContinue": True,
        "command": command,
        "doJumpId": jump_id,
        "frame": frame,
        "params": params,
        "type": "SimpleItem",
    }


def _content(items: list[Any], **more: Any) -> dict[str, Any]:
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": 2,
            "firmwareType": 12,
            "vehicleType": 11,
            "plannedHomePosition": [63.4389, 10.399, 1.5],
            "cruiseSpeed": 0.6,
            "hoverSpeed": 5,
            "items": items,
        },
        "geoFence": {"version": 2, "polygons": [], "circles": []},
        "rallyPoints": {"version": 2, "points": []},
    } | more


def _read(content: Any) -> PlanFile:
    return qgc_plan.read("a.plan", json.dumps(content))


def _problems(content: Any) -> list[str]:
    with pytest.raises(PlanFileError) as caught:
        _read(content)
    return caught.value.problems


WAYPOINT = _simple(16, [0, 0, 0, None, 63.439, 10.4, 50], 1)
CORRIDOR = {
    "type": "ComplexItem",
    "complexItemType": "CorridorScan",
    "TransectStyleComplexItem": {
        "Items": [
            _simple(16, [0, 0, 0, None, 63.44, 10.41, 50], 2),
            _simple(206, [25, 0, 1, 0, 0, 0, 0], 3, frame=2),
            _simple(16, [0, 0, 0, None, 63.44, 10.42, 50], 4),
        ],
        "VisualTransectPoints": [[63.44, 10.41]],
    },
}


def test_simple_items() -> None:
    plan = _read(_content([WAYPOINT, _simple(20, [0, 0, 0, 0, 0, 0, 0], 2, frame=2)]))
    assert plan.home == (63.4389, 10.399, 1.5)
    assert plan.cruise_speed_mps == 0.6
    waypoint, back = plan.mission
    assert (waypoint.seq, waypoint.x, waypoint.y, waypoint.z, waypoint.frame) == (0, 634390000, 104000000, 50.0, 3)
    assert math.isnan(waypoint.param4)
    assert (back.seq, back.command, back.frame) == (1, 20, 2)


def test_a_survey_is_read_as_the_items_it_expands_to() -> None:
    jump = _simple(177, [4, 2, 0, 0, 0, 0, 0], 5, frame=2)
    plan = _read(_content([WAYPOINT, CORRIDOR, jump]))
    assert [(item.seq, item.command) for item in plan.mission] == [(0, 16), (1, 16), (2, 206), (3, 16), (4, 177)]
    assert plan.mission[4].param1 == 3.0
    assert plan.mission[2].param1 == 25.0


def test_a_jump_goes_to_the_item_of_its_id() -> None:
    """Ids are names: they need not count up."""
    items = [
        _simple(16, [0, 0, 0, None, 63.4, 10.4, 0], 7),
        _simple(16, [0, 0, 0, None, 63.5, 10.4, 0], 3),
        _simple(177, [3, 1, 0, 0, 0, 0, 0], 9),
    ]
    assert _read(_content(items)).mission[2].param1 == 1.0


def test_the_fence_in_the_order_in_which_it_is_sent() -> None:
    triangle = [[63.0, 10.0], [63.0, 10.1], [63.1, 10.1]]
    fence = {
        "version": 2,
        "circles": [{"version": 1, "inclusion": False, "circle": {"center": [63.05, 10.05], "radius": 25.5}}],
        "polygons": [{"version": 1, "inclusion": True, "polygon": triangle}, {"inclusion": False, "polygon": triangle}],
        "breachReturn": [63.01, 10.09, 5],
    }
    plan = _read(_content([], geoFence=fence, rallyPoints={"version": 2, "points": [[63.02, 10.08, 3]]}))
    assert [(item.command, item.param1) for item in plan.fence] == [(5001, 3)] * 3 + [(5002, 3)] * 3 + [
        (5004, 25.5),
        (5000, 0),
    ]
    assert [item.seq for item in plan.fence] == list(range(8))
    assert {item.frame for item in plan.fence[:7]} == {0}
    assert (plan.fence[7].frame, plan.fence[7].x, plan.fence[7].z) == (3, 630100000, 5.0)
    assert plan.rally == (PlanItem(0, 5100, 3, 0.0, 0.0, 0.0, 0.0, 630200000, 100800000, 3.0),)


def test_what_the_loader_of_qgroundcontrol_requires_is_written() -> None:
    item = PlanItem(0, 16, 6, 0.0, 0.0, 0.0, math.nan, 634390000, 104000000, 0.0)
    jump = PlanItem(1, 177, 2, 0.0, 3.0, 0.0, 0.0, 0, 0, 0.0)
    content = json.loads(qgc_plan.write("a.plan", PlanFile((item, jump))))
    assert (content["fileType"], content["version"], content["groundStation"]) == ("Plan", 1, "QGroundControl")
    assert content["mission"]["version"] == content["geoFence"]["version"] == content["rallyPoints"]["version"] == 2
    assert content["mission"]["plannedHomePosition"] == [63.439, 10.4, 0.0]
    first, second = content["mission"]["items"]
    assert first["params"] == [0, 0, 0, None, 63.439, 10.4, 0]
    assert first["frame"] == 3
    assert (first["doJumpId"], second["params"][0]) == (1, 1)


def test_a_group_that_the_format_cannot_hold() -> None:
    circle = PlanItem(0, 5003, 0, 10.0, 0.0, 0.0, 0.0, 1, 1, 0.0)
    with pytest.raises(PlanFileError, match=r"a\.plan: fence item 2: a .plan file cannot hold inclusion group 2"):
        qgc_plan.write("a.plan", PlanFile((), fence=(circle, replace(circle, seq=1, param2=2.0))))


def test_all_problems_at_once() -> None:
    content = _content(
        [
            WAYPOINT,
            7,
            _simple(16, [0, 0, 0, None, 95.0, 10.4, 50], 2),
            _simple(16, [0, 0, 0], 3),
            _simple(177, [99, 1, 0, 0, 0, 0, 0], 4, frame=2),
            {"type": "ComplexItem", "complexItemType": "survey", "polygon": []},
            {"type": "SimpleItem", "command": "WAYPOINT", "params": [0] * 7},
        ],
        geoFence={
            "polygons": [{"polygon": [[63.0, 10.0], [63.0]]}, 5],
            "circles": [{"circle": {"center": [1, 2]}}],
            "breachReturn": "home",
        },
        rallyPoints={"points": [[63.0, 200.0, 0.0]]},
    )
    content["mission"]["cruiseSpeed"] = 0
    content["mission"]["plannedHomePosition"] = [1]
    problems = _problems(content)
    assert all(problem.startswith("a.plan: ") for problem in problems)
    for words in (
        "mission item 2: not an object",
        "mission item 3: latitude",
        "mission item 4: params",
        "mission item 5: DO_JUMP to doJumpId 99",
        "mission item 6: survey without",
        "mission item 7: command 'WAYPOINT'",
        "geoFence: polygon 1",
        "geoFence: polygon 1",
        "geoFence: circle 1",
        "geoFence: breachReturn",
        "rallyPoints: point 1",
        "cruiseSpeed",
        "plannedHomePosition",
    ):
        assert sum(words in problem for problem in problems) == 1, words
    assert len(problems) == 13


@pytest.mark.parametrize(
    ("kind", "remedy"),
    [
        ("survey", "open the plan in QGroundControl and save it again"),
        ("StructureScan", "a .plan file never holds them: upload it from QGroundControl, or remove it"),
        ("fwLandingPattern", "a .plan file never holds them: upload it from QGroundControl, or remove it"),
    ],
)
def test_the_remedy_for_a_complex_item_without_its_items(kind: str, remedy: str) -> None:
    (problem,) = _problems(_content([WAYPOINT, {"type": "ComplexItem", "complexItemType": kind, "polygon": []}]))
    assert problem == f"a.plan: mission item 2: {kind} without its items; {remedy}"


def test_a_place_in_a_broken_file() -> None:
    with pytest.raises(PlanFileError, match=r"a\.plan:2:\d+: "):
        qgc_plan.read("a.plan", '{"fileType":\n "Plan" "mission"}')


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "null",
        '{"fileType": "Mission"}',
        '{"fileType": "Plan", "mission": []}',
        "[" * 100_000,
        '{"fileType": NaN}',
        '"\ud800"',
    ],
)
def test_other_files(text: str) -> None:
    with pytest.raises(PlanFileError):
        qgc_plan.read("a.plan", text)


@pytest.mark.parametrize(
    "value",
    [
        "x",
        None,
        True,
        [],
        {},
        -1,
        1e300,
        pytest.param(10**400, id="10**400"),
        [None] * 7,
        [[1]],
        {"items": 3},
        [{"type": "ComplexItem"}],
        [{"doJumpId": []}],
    ],
)
def test_any_value_in_any_place_is_read_or_refused(value: Any) -> None:
    """Every value of the file in turn, replaced by something else."""
    circle = {"inclusion": True, "circle": {"center": [63.05, 10.05], "radius": 25.5}}
    fence = {
        "polygons": [{"polygon": [[63.0, 10.0], [63.0, 10.1], [63.1, 10.1]]}],
        "circles": [circle],
        "breachReturn": [63, 10, 0],
    }
    jump = _simple(177, [1, 1, 0, 0, 0, 0, 0], 9, frame=2)
    whole = _content([WAYPOINT, CORRIDOR, jump], geoFence=fence, rallyPoints={"points": [[63, 10, 0]]})
    tried = 0
    for changed in _with_each_replaced(whole, value):
        try:
            _read(changed)
        except PlanFileError as error:
            assert error.problems
        tried += 1
    assert tried > 100


def _with_each_replaced(node: Any, value: Any) -> Any:
    yield value
    if isinstance(node, dict):
        for key in node:
            for changed in _with_each_replaced(node[key], value):
                yield node | {key: changed}
    elif isinstance(node, list):
        for i in range(len(node)):
            for changed in _with_each_replaced(node[i], value):
                yield [*node[:i], changed, *node[i + 1 :]]
