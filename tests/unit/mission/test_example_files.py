"""The example missions are what their README says, and the boat would take them."""

import math
from itertools import pairwise
from pathlib import Path

import pytest

from companion.core.geodesy import LocalFrame
from companion.mission import files
from companion.mission.plan import PlanKind
from companion.mission.summary import summarise
from companion.mission.validation import check_item, check_plan

FOLDER = Path(__file__).parents[3] / "mission_files"
NAMES = sorted(path.name for path in FOLDER.iterdir() if path.suffix != ".md")
FROM_GROUND_STATIONS = {
    "doubled_points.plan": 12,
    "harbour_survey.plan": 402,
    "laps.plan": 12,
    "mixed_frames.plan": 16,
    "river_corridor.plan": 20,
}
HOME = (63.4389, 10.399)
REVOLT_MPS = 0.6
OWN = ["trondheim_square.plan", "trondheim_tour.waypoints"]


def _read(name: str) -> files.PlanFile:
    return files.read(name, (FOLDER / name).read_text(encoding="utf-8"))


def test_the_readme_names_each() -> None:
    readme = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert sorted(["trondheim_square.plan", "trondheim_tour.waypoints", *FROM_GROUND_STATIONS]) == NAMES
    assert all(f"| `{name}` |" in readme for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_the_boat_would_take_it(name: str) -> None:
    plan = _read(name)
    assert plan.home is not None
    assert plan.home[:2] == HOME
    for kind, items in ((PlanKind.MISSION, plan.mission), (PlanKind.FENCE, plan.fence), (PlanKind.RALLY, plan.rally)):
        assert [refusal for item in items if (refusal := check_item(kind, item))] == []
        assert check_plan(kind, items) is None
    if name != "harbour_survey.plan":
        assert summarise(plan.mission, REVOLT_MPS, plan.home).time_s < 480.0


@pytest.mark.parametrize(("name", "count"), FROM_GROUND_STATIONS.items())
def test_as_ground_stations_write_them(name: str, count: int) -> None:
    plan = _read(name)
    assert [item.seq for item in plan.mission] == list(range(count))
    assert (FOLDER / name).stat().st_size < 60_000
    again = files.read("again.plan", files.write("again.plan", plan))
    assert repr(again.mission) == repr(plan.mission) and repr(again.fence) == repr(plan.fence) and repr(again.rally) == repr(plan.rally)


def test_the_survey_has_200_transects() -> None:
    plan = _read("harbour_survey.plan")
    frame = LocalFrame(*HOME)
    points = [frame.to_ned(item.lat_deg, item.lon_deg) for item in plan.mission if item.command == 16]
    across = [math.dist(a, b) for a, b in zip(points[::2], points[1::2], strict=True)]
    assert len(across) == 200 and across == [pytest.approx(6.0, abs=0.02)] * 200


def test_what_the_others_are_there_for() -> None:
    assert {item.frame for item in _read("mixed_frames.plan").mission} == {0, 2, 3, 10}
    laps = [item.param1 for item in _read("laps.plan").mission if item.command == 177]
    assert laps == [0.0, 8.0], "doJumpIds are items of the list"
    points = [(item.x, item.y) for item in _read("doubled_points.plan").mission]
    assert sum(a == b for a, b in pairwise(points)) == 5
    assert sum(item.command == 206 for item in _read("river_corridor.plan").mission) == 6


@pytest.mark.parametrize("name", OWN)
def test_written_again_it_is_the_same_text(name: str) -> None:
    assert files.write(name, _read(name)) == (FOLDER / name).read_text(encoding="utf-8")


def test_the_square() -> None:
    plan = _read("trondheim_square.plan")
    frame = LocalFrame(*HOME)
    corners = [frame.to_ned(item.lat_deg, item.lon_deg) for item in plan.mission]
    for corner, expected in zip(corners, [(20, 0), (20, 20), (0, 20), (0, 0)], strict=True):
        assert corner == pytest.approx(expected, abs=0.01)
    assert {item.command for item in plan.fence} == {5001, 5004}
    assert len(plan.rally) == 2
    circle = plan.fence[-1]
    clear_of = frame.to_ned(circle.lat_deg, circle.lon_deg)
    for place in (*corners, *(frame.to_ned(item.lat_deg, item.lon_deg) for item in plan.rally)):
        assert -40 < place[0] < 60 and -40 < place[1] < 60
        assert math.dist(place, clear_of) > circle.param1 + 10


def test_the_tour() -> None:
    plan = _read("trondheim_tour.waypoints")
    assert [item.command for item in plan.mission] == [16, 16, 16, 178, 16, 16, 19, 178, 16, 16, 177, 20]
    assert plan.mission[10].param1 == 8.0
    summary = summarise(plan.mission, REVOLT_MPS, plan.home)
    assert [leg.seq for leg in summary.legs] == [0, 1, 2, 4, 5, 6, 8, 9, 8, 9, 11]
    assert summary.length_m == pytest.approx(153, abs=1)
