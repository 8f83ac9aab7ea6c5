"""`companion mission`: summary, conversion, picture, and what is wrong with a file."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest

from companion.analysis.mission_plot import curve, legs_of
from companion.cli.main import main
from companion.config.vessel import find
from companion.core.geodesy import LocalFrame
from companion.guidance.path import PathKind
from companion.mission import files
from companion.mission.plan import PlanItem
from companion.params.store import Parameters

MISSIONS = Path(__file__).parents[3] / "mission_files"
SQUARE = MISSIONS / "trondheim_square.plan"
TOUR = MISSIONS / "trondheim_tour.waypoints"
HOME = LocalFrame(63.4389, 10.3990)


def square() -> files.PlanFile:
    return files.read(SQUARE.name, SQUARE.read_text(encoding="utf-8"))


def test_a_summary(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["mission", str(SQUARE), "--vessel", "revolt"]) == 0
    said = capsys.readouterr()
    assert "length 80.0 m, time 2:13" in said.out and "fence: 5 items, rally points: 2" in said.out and not said.err


def test_a_survey_says_what_it_does_and_what_it_needs(capsys: pytest.CaptureFixture[str]) -> None:
    survey = str(MISSIONS / "harbour_survey.plan")
    assert main(["mission", survey]) == 0
    alone = capsys.readouterr().out
    assert "Survey: 200 transects, every 2 m, about" in alone and "No camera" not in alone
    assert main(["mission", survey, "--vessel", "revolt"]) == 0
    assert "note: No camera for DO_SET_CAM_TRIGG_DIST, item 2 and 1 more" in capsys.readouterr().out


def test_a_boat_without_sideways_thrust_holds_at_a_berth(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "berth.plan"
    berth = PlanItem(0, 21, 3, 0.0, 0.0, 0.0, 90.0, 634_391_000, 103_990_000, 0.0)
    file.write_text(files.write(file.name, files.PlanFile((berth,), home=(63.4389, 10.399, 0.0))), encoding="utf-8")
    for vessel, told in (("revolt", "comes alongside"), ("blueboat", "holds there, and does not dock")):
        assert main(["mission", str(file), "--vessel", vessel]) == 0
        assert f"note: item 1 {told}" in capsys.readouterr().out


def far(tmp_path: Path, north_m: float) -> str:
    file = tmp_path / "far.plan"
    north = [
        PlanItem(seq, 16, 3, 0.0, 0.0, 0.0, 0.0, round(HOME.to_geodetic(d, 0.0)[0] * 1e7), 103_990_000, 0.0)
        for seq, d in enumerate((north_m, 0.0))
    ]
    file.write_text(files.write(file.name, files.PlanFile(tuple(north), home=(63.4389, 10.399, 0.0))), encoding="utf-8")
    return str(file)


def test_a_long_first_leg_and_a_battery_that_does_not_last_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In the words of the boat."""
    assert main(["mission", far(tmp_path, 20_000.0), "--vessel", "revolt"]) == 0
    said = capsys.readouterr().out
    assert "the boat would warn: Item 1 is 20.0 km away, 9:16 h (MIS_DIST_1WP)\n" in said
    assert "the boat would warn: Mission: 40.0 km, 18:31 h; battery lasts 6:10 h\n" in said
    assert main(["mission", far(tmp_path, 900.0), "--vessel", "revolt"]) == 0
    assert "would warn" not in capsys.readouterr().out


def test_a_waypoint_at_0_0_would_be_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "null.waypoints"
    nowhere = PlanItem(0, 16, 3, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0)
    file.write_text(files.write(file.name, files.PlanFile((nowhere,))), encoding="utf-8")
    assert main(["mission", str(file)]) == 1
    assert "item 1: NAV_WAYPOINT is at latitude 0, longitude 0" in capsys.readouterr().err


def test_converted_there_and_back_it_is_the_same(tmp_path: Path) -> None:
    there, back = tmp_path / "tour.plan", tmp_path / "tour.waypoints"
    assert main(["mission", str(TOUR), "--convert", str(there)]) == 0
    assert main(["mission", str(there), "--convert", str(back)]) == 0
    assert back.read_text(encoding="utf-8") == TOUR.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "content", "problems"),
    [
        (
            "a.gpx",
            b"<gpx><wpt lat='99' lon='0'/><wpt lon='0'/></gpx>",
            ["a.gpx:1: latitude is 99", "a.gpx:1: no latitude"],
        ),
        ("a.plan", b"\xff\xfe\x00", ["not text in UTF-8"]),
        ("a.txt", b"", ["use one of .plan, .waypoints, .gpx"]),
    ],
)
def test_a_file_that_cannot_be_read(
    name: str, content: bytes, problems: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / name
    file.write_bytes(content)
    assert main(["mission", str(file)]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == len(problems) and all(problem in line for problem, line in zip(problems, lines, strict=True))


def test_what_the_boat_would_refuse_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.waypoints"
    file.write_text(
        "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t63.4\t10.3\t0\t1\n1\t0\t3\t16\t-5\t0\t0\t0\t63.4\t10.3\t0\t1\n",
        encoding="utf-8",
    )
    assert main(["mission", str(file), "--plot", str(tmp_path / "a.png")]) == 1
    assert "item 1: NAV_WAYPOINT hold time (param1) is -5" in capsys.readouterr().err
    assert not (tmp_path / "a.png").exists()


def test_what_that_boat_would_refuse_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, vessel = tmp_path / "a.waypoints", tmp_path / "revolt.toml"
    lines = (
        "QGC WPL 110",
        "0\t1\t0\t16\t0\t0\t0\t0\t63.4389\t10.399\t0\t1",
        "1\t0\t3\t22\t0\t0\t0\t0\t63.4389\t10.399\t0\t1",
        "2\t0\t3\t18\t1\t0\t0.5\t0\t63.439\t10.399\t0\t1",
    )
    file.write_text("\n".join(lines), encoding="utf-8")
    assert main(["mission", str(file)]) == 0
    assert main(["mission", str(file), "--vessel", "revolt"]) == 1
    assert "NAV_LOITER_TURNS radius (param3) is 0.5 m; this boat needs" in capsys.readouterr().err
    text = find("revolt").read_text(encoding="utf-8")
    vessel.write_text(text.replace("[parameters]", "[parameters]\nCOM_TAKEOFF_OK = 0"), encoding="utf-8")
    assert main(["mission", str(file), "--vessel", str(vessel)]) == 1
    assert "item 1: NAV_TAKEOFF is not for a boat (COM_TAKEOFF_OK)" in capsys.readouterr().err


def test_a_conversion_that_would_lose_something_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "tour.gpx"
    assert main(["mission", str(TOUR), "--convert", str(out)]) == 2
    assert "item 11: DO_JUMP has no place in a GPX route" in capsys.readouterr().err and not out.exists()


def test_the_curves_of_a_square() -> None:
    legs = legs_of(square(), HOME, 0.6)
    assert (
        [len(leg.waypoints) for leg in legs] == [4]
        and legs[0].stop
        and legs[0].begin == pytest.approx((0.0, 0.0), abs=1e-3)
    )
    drawn = {kind: curve(legs, Parameters(), kind) for kind in PathKind}
    for kind, result in drawn.items():
        (east, north), (along, bend), (way, speed) = result.track, result.curvature, result.speed
        assert len(east) == len(north) == len(along) == len(bend)
        length = sum(
            math.dist(a, b)
            for a, b in zip(zip(north, east, strict=True), list(zip(north, east, strict=True))[1:], strict=False)
        )
        assert along[-1] == pytest.approx(length, rel=2e-3)
        for corner in ((20.0, 0.0), (20.0, 20.0), (0.0, 20.0)):
            assert min(math.dist(corner, place) for place in zip(north, east, strict=True)) < 0.01, (
                f"{kind.name} passes each waypoint"
            )
        assert max(speed) == pytest.approx(0.6, abs=0.01) and speed[-1] == 0.0 and way == sorted(way)
    inside = [-0.01 <= value <= 20.01 for axis in drawn[PathKind.PCHIP].track for value in axis]
    assert all(inside), "PCHIP never leaves the square"
    assert max(drawn[PathKind.CUBIC].track[0]) > 22.0, "the spline does"
    corners = [speed for way, speed in zip(*drawn[PathKind.LINEAR].speed, strict=True) if 17.0 < way < 21.0]
    assert min(corners) < 0.4, "slower around a right angle"


def test_a_jump_without_end_and_a_stay_without_end_are_drawn_all_the_same() -> None:
    plan = square()
    assert plan.home is not None
    text = files.write("a.waypoints", files.PlanFile(plan.mission, home=plan.home))
    for last in ("5\t0\t2\t177\t1\t-1\t0\t0\t0\t0\t0\t1\n", "5\t0\t3\t17\t0\t0\t0\t0\t63.4390\t10.3990\t0\t1\n"):
        legs = legs_of(files.read("a.waypoints", text + last), HOME, 0.6)
        assert legs and sum(len(leg.waypoints) for leg in legs) < 4000


def test_a_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / "square.png"
    assert main(["mission", str(SQUARE), "--plot", str(out)]) == 0
    assert out.read_bytes().startswith(b"\x89PNG") and f"written: {out}" in capsys.readouterr().out


def test_without_matplotlib_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["mission", str(SQUARE), "--plot", str(tmp_path / "a.png")]) == 2
    assert "pip install 'usv-companion[report]'" in capsys.readouterr().err


def test_the_circle_around_home_is_told_drawn_and_checked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = find("revolt").read_text(encoding="utf-8")
    assert "[parameters]" in text
    for radius_m, code in ((500, 0), (20, 1)):
        vessel = tmp_path / "near.toml"
        vessel.write_text(text.replace("[parameters]", f"[parameters]\nGF_MAX_HOR_DIST = {radius_m}"), encoding="utf-8")
        picture = tmp_path / f"{radius_m}.png"
        assert main(["mission", str(SQUARE), "--vessel", str(vessel), "--plot", str(picture)]) == code
        said = capsys.readouterr()
        assert f"fence: a circle of {radius_m} m around home (GF_MAX_HOR_DIST)" in said.out
        assert picture.exists() is (code == 0)
    assert "the boat would refuse: item 2: 28 m from home; GF_MAX_HOR_DIST is 20 m" in said.err
