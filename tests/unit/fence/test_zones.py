"""Zones from the items of a fence, and the part of a mission that lies ahead."""

from __future__ import annotations

import itertools
from dataclasses import replace

from companion.fence.zones import FenceZone, fence_zones
from companion.mission.executor import MissionExecutor
from companion.mission.plan import PlanItem, PlanKind, Plans
from companion.mission.tasks import Complete, ReturnHome, Sail, Stay
from companion.mission.validation import check_item, check_plan


def _item(seq: int, command: int, param1: float = 0.0, param2: float = 0.0) -> PlanItem:
    return PlanItem(seq, command, 3, param1, param2, 0.0, float("nan"), 634_389_000 + 1000 * seq, 103_990_000, 0.0)


def test_polygons_circles_groups_and_a_return_point() -> None:
    items = [
        *(_item(n, 5001, 3.0, 2.0) for n in range(3)),
        _item(3, 5000),
        _item(4, 5004, 7.5),
        _item(5, 5003, 90.0, 1.0),
    ]
    polygon, hole, circle = fence_zones(items)
    assert (polygon.seq, polygon.inclusion, polygon.group, polygon.radius_m, len(polygon.points)) == (
        0,
        True,
        2,
        None,
        3,
    )
    assert hole == FenceZone(4, False, 0, ((items[4].lat_deg, items[4].lon_deg),), 7.5)
    assert (circle.inclusion, circle.group, circle.radius_m) == (True, 1, 90.0)
    assert fence_zones(()) == ()


def test_what_lies_ahead_is_what_comes() -> None:
    plans = Plans()
    executor = MissionExecutor(plans)
    items = [_item(0, 16), _item(1, 16), _item(2, 19, 5.0), _item(3, 16), _item(4, 177, 1.0, 1.0), _item(5, 20)]
    plans.replace(PlanKind.MISSION, items)
    told = list(executor.ahead())
    executor.begin()
    done = []
    while not isinstance(task := executor.task, Complete):
        assert task is not None
        done.append(task)
        for seq in [point.seq for point in task.route] if isinstance(task, Sail) else [task.seq]:
            executor.complete(seq)
    assert told == done
    assert [type(task) for task in told] == [Sail, Stay, Sail, Stay, Sail, ReturnHome]


def test_what_lies_ahead_of_a_round_has_no_end() -> None:
    plans = Plans()
    executor = MissionExecutor(plans)
    plans.replace(PlanKind.MISSION, [_item(0, 19, 5.0), _item(1, 19, 5.0), _item(2, 177, 0.0, -1.0)])
    assert len(list(itertools.islice(executor.ahead(), 50))) == 50
    assert executor.progress.seq == 0


def test_a_circle_of_radius_0_is_none() -> None:
    """MAVSDK's fences always hold a circle; one of radius 0 at 0, 0 stands for none."""
    none = PlanItem(3, 5003, 5, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0)
    assert check_item(PlanKind.FENCE, none) is None
    polygon = [_item(n, 5001, 3.0) for n in range(3)]
    assert check_plan(PlanKind.FENCE, [replace(none, seq=0)], home=(63.44, 10.4)) is None
    assert fence_zones([*polygon, none]) == fence_zones(polygon)
    refusal = check_item(PlanKind.FENCE, _item(3, 5003, -1.0))
    assert refusal is not None and "radius" in refusal.text
