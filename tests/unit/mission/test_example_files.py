"""The example missions are what their README says, and the boat would take them."""

import math
from pathlib import Path

import pytest

from companion.core.geodesy import LocalFrame
from companion.mission import files
from companion.mission.plan import PlanKind
from companion.mission.summary import summarise
from companion.mission.validation import check_item, check_plan

FOLDER = Path(__file__).parents[3] / "mission_files"
NAMES = sorted(path.name for path in FOLDER.iterdir() if path.suffix != ".md")
HOME = (63.4389, 10.399)
REVOLT_MPS = 0.6


def _read(name: str) -> files.PlanFile:
    return files.read(name, (FOLDER / name).read_text(encoding="utf-8"))


def test_the_readme_names_each() -> None:
    readme = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert NAMES == ["trondheim_square.plan", "trondheim_tour.waypoints"]
    assert all(f"| `{name}` |" in readme for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_the_boat_would_take_it(name: str) -> None:
    plan = _read(name)
    assert plan.home is not None
    assert plan.home[:2] == HOME
    for kind, items in ((PlanKind.MISSION, plan.mission), (PlanKind.FENCE, plan.fence), (PlanKind.RALLY, plan.rally)):
        assert [refusal for item in items if (refusal := check_item(kind, item))] == []
        assert check_plan(kind, items) is None
    assert summarise(plan.mission, REVOLT_MPS, plan.home).time_s < 480.0


@pytest.mark.parametrize("name", NAMES)
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
