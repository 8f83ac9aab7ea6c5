"""The example missions are what their README says, and the boat would take them."""

import itertools
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

from companion.core.geodesy import LocalFrame
from companion.guidance.path import PathKind, build_path
from companion.mission import files
from companion.mission.plan import PlanKind
from companion.mission.summary import summarise
from companion.mission.validation import check_item, check_plan
from sitl.scenarios.routes import ROUTES

FOLDER = Path(__file__).parents[3] / "mission_files"
NAMES = sorted(path.name for path in FOLDER.iterdir() if path.suffix != ".md")
FROM_GROUND_STATIONS = {
    "doubled_points.plan": 12,
    "harbour_survey.plan": 402,
    "laps.plan": 12,
    "mixed_frames.plan": 16,
    "orbits.plan": 5,
    "river_corridor.plan": 20,
}
HOME = (63.4389, 10.399)
RUISSALO = (60.41, 22.07)
SPEED_MPS = {HOME: 0.6, RUISSALO: 1.2}
ABOAT = {
    "aboat_route_1.plan": "1",
    "aboat_route_2.plan": "2",
    "aboat_route_3.plan": "3",
    "aboat_route_4.plan": "4",
    "aboat_island.plan": "island",
}
OWN = ["trondheim_square.plan", "trondheim_tour.waypoints", *ABOAT]


def _read(name: str) -> files.PlanFile:
    return files.read(name, (FOLDER / name).read_text(encoding="utf-8"))


def test_the_readme_names_each() -> None:
    readme = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert sorted(["trondheim_square.plan", "trondheim_tour.waypoints", *ABOAT, *FROM_GROUND_STATIONS]) == NAMES
    assert all(f"| `{name}` |" in readme for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_the_boat_accepts_it(name: str) -> None:
    plan = _read(name)
    assert plan.home is not None
    home = RUISSALO if name in ABOAT else HOME
    assert plan.home[:2] == home
    for kind, items in ((PlanKind.MISSION, plan.mission), (PlanKind.FENCE, plan.fence), (PlanKind.RALLY, plan.rally)):
        assert [refusal for item in items if (refusal := check_item(kind, item))] == []
        assert check_plan(kind, items) is None
    if name != "harbour_survey.plan":
        assert summarise(plan.mission, SPEED_MPS[home], plan.home).time_s < 480.0


@pytest.mark.parametrize(("name", "count"), FROM_GROUND_STATIONS.items())
def test_as_ground_stations_write_them(name: str, count: int) -> None:
    plan = _read(name)
    assert [item.seq for item in plan.mission] == list(range(count))
    assert (FOLDER / name).stat().st_size < 60_000
    again = files.read("again.plan", files.write("again.plan", plan))
    assert (
        repr(again.mission) == repr(plan.mission)
        and repr(again.fence) == repr(plan.fence)
        and repr(again.rally) == repr(plan.rally)
    )


def test_the_survey_has_200_transects() -> None:
    plan = _read("harbour_survey.plan")
    frame = LocalFrame(*HOME)
    points = [frame.to_ned(item.lat_deg, item.lon_deg) for item in plan.mission if item.command == 16]
    across = [math.dist(a, b) for a, b in zip(points[::2], points[1::2], strict=True)]
    assert len(across) == 200 and across == [pytest.approx(6.0, abs=0.02)] * 200


def test_what_each_example_shows() -> None:
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
    summary = summarise(plan.mission, SPEED_MPS[HOME], plan.home)
    assert [leg.seq for leg in summary.legs] == [0, 1, 2, 4, 5, 6, 8, 9, 8, 9, 11]
    assert summary.length_m == pytest.approx(153, abs=1)


@pytest.mark.parametrize("name", sorted(ABOAT))
def test_the_aboat_routes_are_those_of_the_scenario(name: str) -> None:
    frame = LocalFrame(*RUISSALO)
    places = [frame.to_ned(item.lat_deg, item.lon_deg) for item in _read(name).mission]
    assert places == [pytest.approx(point, abs=0.02) for point in ROUTES[ABOAT[name]].points]


@pytest.mark.parametrize(
    ("name", "count", "length_m"), [("aboat_route_3.plan", 6, 308.0), ("aboat_route_4.plan", 11, 500.0)]
)
def test_the_long_routes_are_as_long_as_in_the_thesis(name: str, count: int, length_m: float) -> None:
    mission = _read(name).mission
    frame = LocalFrame(*RUISSALO)
    places = [frame.to_ned(item.lat_deg, item.lon_deg) for item in mission]
    assert len(mission) == count
    assert sum(math.dist(a, b) for a, b in itertools.pairwise(places)) == pytest.approx(length_m, abs=0.2)


def turns_deg(name: str) -> list[float]:
    frame = LocalFrame(*RUISSALO)
    places = [(0.0, 0.0), *(frame.to_ned(item.lat_deg, item.lon_deg) for item in _read(name).mission)]
    courses = [math.degrees(math.atan2(b[1] - a[1], b[0] - a[0])) for a, b in itertools.pairwise(places)]
    return [abs(math.remainder(b - a, 360.0)) for a, b in itertools.pairwise(courses)][1:]


def test_the_short_routes_turn_as_in_the_thesis() -> None:
    assert turns_deg("aboat_route_1.plan") == pytest.approx([90.0, 90.0, 90.0], abs=0.1)
    assert all(turn > 120.0 for turn in turns_deg("aboat_route_2.plan"))
    assert all(turn < 60.0 for name in ("aboat_route_3.plan", "aboat_route_4.plan") for turn in turns_deg(name))


def beyond_m(curve: object, knots: list[float], places: list[tuple[float, float]]) -> float:
    """How far a curve leaves the span of the two waypoints that it runs between, in north or east."""
    worst = 0.0
    for i, (a, b) in enumerate(itertools.pairwise(places)):
        points = curve(np.linspace(knots[i], knots[i + 1], 400))  # type: ignore[operator]
        worst = max(worst, float(np.max(np.maximum(np.minimum(a, b) - points, points - np.maximum(a, b)))))
    return worst


def test_between_the_islands_a_cubic_spline_swings_out_and_pchip_does_not() -> None:
    frame = LocalFrame(*RUISSALO)
    places = [(0.0, 0.0), *(frame.to_ned(item.lat_deg, item.lon_deg) for item in _read("aboat_island.plan").mission)]
    knots = [0.0, *itertools.accumulate(math.dist(a, b) for a, b in itertools.pairwise(places))]
    assert beyond_m(CubicSpline(knots, places), knots, places) > 5.0
    assert beyond_m(PchipInterpolator(knots, places), knots, places) < 1.0e-6
    for kind, reference in (
        (PathKind.PCHIP, PchipInterpolator(knots, places)),
        (PathKind.CUBIC, CubicSpline(knots, places)),
    ):
        path = build_path(places, kind)
        assert [path.position(s) for s in path.waypoint_s_m] == [pytest.approx(place, abs=1e-6) for place in places]
        north, east = path.samples(0.5)
        fine = reference(np.linspace(0.0, knots[-1], 20_000))
        assert (
            max(float(np.min(np.hypot(fine[:, 0] - n, fine[:, 1] - e))) for n, e in zip(north, east, strict=True))
            < 0.02
        )
