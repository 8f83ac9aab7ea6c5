"""What a plan does with a camera: transects, spacing, number of pictures."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from companion.cli.mission import find_plan, read_plan
from companion.core.geodesy import LocalFrame
from companion.core.payload import PayloadPart
from companion.mission.plan import PlanItem
from companion.mission.survey import has_payload, needs_part, survey_of, without_camera

FRAME = LocalFrame(63.4389, 10.399)


def at(north_m: float, east_m: float, command: int = 16, hold_s: float = 0.0) -> PlanItem:
    x, y = (round(1e7 * degrees) for degrees in FRAME.to_geodetic(north_m, east_m))
    return PlanItem(0, command, 3, hold_s, 0.0, 0.0, math.nan, x, y, 0.0)


def do(command: int, *params: float) -> PlanItem:
    padded = (*params, *(0.0 for _ in range(4 - len(params))))
    return PlanItem(0, command, 2, *padded, 0, 0, 0.0)


def plan(*items: PlanItem) -> list[PlanItem]:
    return [
        PlanItem(i, n.command, n.frame, n.param1, n.param2, n.param3, n.param4, n.x, n.y, n.z)
        for i, n in enumerate(items)
    ]


def lawn(count: int, spacing_m: float) -> list[PlanItem]:
    """Transects of 100 m, each with a picture at both ends."""
    items: list[PlanItem] = []
    for i in range(count):
        ends = (0.0, 100.0) if i % 2 == 0 else (100.0, 0.0)
        items += [at(ends[0], 10.0 * i), do(206, spacing_m, 0, 1), at(ends[1], 10.0 * i), do(206, 0, 0, 1)]
    return plan(*items)


@pytest.mark.parametrize(("count", "spacing_m"), [(1, 5.0), (6, 5.0), (3, 7.0)])
def test_transects_with_a_picture_at_both_ends(count: int, spacing_m: float) -> None:
    survey = survey_of(lawn(count, spacing_m), 1.0)
    assert survey is not None
    assert (survey.transects, survey.spacings_m) == (count, (spacing_m,))
    assert survey.pictures == pytest.approx(count * (int(100.0 / spacing_m) + 2), abs=count)
    transects = "1 transect" if count == 1 else f"{count} transects"
    assert survey.text == f"Survey: {transects}, every {spacing_m:g} m, about {survey.pictures} pictures"


def test_points_along_a_straight_line_are_one_transect() -> None:
    items = plan(do(206, 10.0), at(0, 0), at(50, 0), at(100, 1), at(100, 100))
    survey = survey_of(items, 1.0)
    assert survey is not None and (survey.transects, survey.pictures) == (2, 19)


def test_by_time_at_the_speed_of_each_leg_and_while_it_stays() -> None:
    items = plan(at(0, 0), do(2000, 0, 2.0, 0), at(100, 0), do(178, 1, 2.0), at(100, 100, 19, 20.0), do(2001), at(0, 0))
    survey = survey_of(items, 1.0)
    assert survey is not None and survey.intervals_s == (2.0,)
    assert survey.pictures == pytest.approx(1 + 50 + 25 + 10, abs=1)
    assert "every 2 s" in survey.text


def test_single_pictures_are_no_survey() -> None:
    items = plan(at(0, 0, 19, 2.0), do(2000, 0, 0, 1), at(10, 0, 19, 2.0), do(2000, 0, 1.0, 4))
    survey = survey_of(items, 1.0)
    assert survey is not None and survey.text == "Mission: about 5 pictures"


def test_laps_count_and_endless_ones_once() -> None:
    counted = survey_of(plan(do(206, 10.0), at(0, 0), at(100, 0), do(177, 1, 2)), 1.0)
    endless = survey_of(plan(do(206, 10.0), at(0, 0), at(100, 0), do(177, 1, -1)), 1.0)
    assert counted is not None and endless is not None
    assert (counted.pictures, endless.pictures) == (50, 10)


def test_a_plan_without_pictures_is_no_survey() -> None:
    assert survey_of(plan(at(0, 0), do(205, -90.0)), 1.0) is None
    assert has_payload(plan(at(0, 0), do(205, -90.0))) and not has_payload(plan(at(0, 0), do(181, 0, 1)))


def test_what_a_boat_lacks_is_named_by_its_items() -> None:
    items = plan(at(0, 0), do(206, 5.0), do(205, -90.0), do(1000), do(531), do(206, 0))
    assert without_camera(items) == "No camera for DO_SET_CAM_TRIGG_DIST, item 2 and 1 more"
    assert needs_part(items, PayloadPart.GIMBAL) == "DO_MOUNT_CONTROL, item 3 and 1 more: needs a gimbal on a link"
    assert needs_part(items, PayloadPart.CAMERA) == "SET_CAMERA_ZOOM, item 5: needs a camera on a link"
    assert without_camera(items[:1]) is None and needs_part(items[:2], PayloadPart.GIMBAL) is None


@pytest.mark.parametrize(("name", "transects"), [("harbour_survey.plan", 195), ("river_corridor.plan", 3)])
def test_surveys_that_qgroundcontrol_wrote(name: str, transects: int) -> None:
    survey = survey_of(read_plan(find_plan(Path(name))).mission, 1.0)
    assert survey is not None and survey.spacings_m == (2.0,)
    assert survey.transects == pytest.approx(transects, rel=0.2) and survey.pictures > 20
