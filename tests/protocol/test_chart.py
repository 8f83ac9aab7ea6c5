"""A chart as a ground station meets it: what is refused at upload, and the way round that is sailed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from shapely.geometry import Point, box

from companion.config.chart import ChartFeature
from companion.io.mavlink.wire import messages as mavlink
from companion.mission.plan import PlanResult
from tests.protocol.desk import Desk
from tests.protocol.test_fence import away_m, fence_items, sail_until
from tests.protocol.test_found_faults import desk_in
from tests.protocol.test_qgroundcontrol import ARM, MISSION, item
from tests.unit.obstacles.charted import feature

ISLAND = box(18.0, -12.0, 26.0, 12.0)
RING = box(40.0, -20.0, 80.0, 20.0).difference(box(50.0, -10.0, 70.0, 10.0))
BOX = ((-60.0, -60.0), (100.0, -60.0), (100.0, 60.0), (-60.0, 60.0))


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    desk = desk_in(tmp_path)
    yield desk
    desk.close()


def chart(desk: Desk, *shapes: Any) -> None:
    frame = desk.vessel.frame
    features: Sequence[ChartFeature] = [feature("land", shape, frame=frame) for shape in shapes]
    desk.vessel.supervisor.parts.chart.load(features)


def mission(*places: tuple[float, float]) -> list[Any]:
    return [item(seq, 16, *place) for seq, place in enumerate(places)]


@pytest.mark.parametrize("rounds", [0.0, 1.0])
def test_an_item_in_an_obstacle_refuses_the_mission(desk: Desk, rounds: float) -> None:
    chart(desk, ISLAND)
    desk.vessel.parameters.set("MIS_ROUND", rounds)
    assert desk.upload(mission((5.0, 0.0), (22.0, 0.0))) == PlanResult.INVALID_PARAM5_X
    assert desk.upload(mission((5.0, 0.0), (5.0, 20.0), (16.0, 0.0))) == PlanResult.INVALID_PARAM5_X
    desk.tick(2)
    assert "mission item 2: in a chart obstacle; move it" in desk.texts()
    assert "mission item 3: too near a chart obstacle; move it" in desk.texts()
    assert desk.upload(mission((5.0, 0.0), (5.0, 30.0), (40.0, 30.0))) == mavlink.MAV_MISSION_ACCEPTED


def test_a_leg_across_an_obstacle_is_refused_where_ways_round_are_not_wanted(desk: Desk) -> None:
    chart(desk, ISLAND)
    desk.vessel.parameters.set("MIS_ROUND", 0.0)
    assert desk.upload(mission((5.0, 0.0), (40.0, 0.0))) == PlanResult.INVALID_PARAM5_X
    desk.tick(2)
    assert any(text.startswith("mission item 2: way crosses a chart obstacle") for text in desk.texts())


def test_an_item_that_no_way_leads_to_is_refused(desk: Desk) -> None:
    chart(desk, RING)
    assert desk.upload(mission((5.0, 0.0), (60.0, 0.0))) == PlanResult.INVALID_PARAM5_X
    desk.tick(2)
    assert any("item 2: no way round a chart obstacle" in text for text in desk.texts())


@pytest.mark.parametrize("fenced", [False, True])
def test_the_planned_way_is_what_is_laid(desk: Desk, fenced: bool) -> None:
    """From the first tick on."""
    chart(desk, ISLAND)
    if fenced:
        assert desk.upload(fence_items([BOX]), 1) == mavlink.MAV_MISSION_ACCEPTED
    assert desk.upload(mission((5.0, 0.0), (40.0, 0.0))) == mavlink.MAV_MISSION_ACCEPTED
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, MISSION))
    assert desk.result(ARM, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    desk.tick(2)
    way = desk.vessel.supervisor.parts.mission.way_ahead()
    assert len(way) > 2 and min(ISLAND.distance(Point(*place)) for place in way) > 4.0


@pytest.mark.sweep
def test_the_planned_way_is_sailed(desk: Desk) -> None:
    chart(desk, ISLAND)
    assert desk.upload(mission((5.0, 0.0), (40.0, 0.0))) == mavlink.MAV_MISSION_ACCEPTED
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, MISSION))
    assert desk.result(ARM, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    truth, least_m = desk.rig.world.truth, 99.0

    def arrived() -> bool:
        nonlocal least_m
        least_m = min(least_m, ISLAND.distance(Point(truth.north_m, truth.east_m)))
        return away_m(desk, 40.0, 0.0) < 2.0

    sail_until(desk, arrived, 400.0)
    assert least_m > 3.0
    assert not [text for text in desk.texts() if text.startswith("Obstacle ahead")]
