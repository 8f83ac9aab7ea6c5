"""Reading and writing `QGC WPL 110`."""

import math
from dataclasses import replace

import pytest

from companion.mission import waypoints
from companion.mission.plan import PlanItem
from companion.mission.plan_file import PlanFile, PlanFileError

MISSION_PLANNER = """\
QGC WPL 110\r
0\t1\t0\t16\t0\t0\t0\t0\t60.43\t22.16\t5.210000\t1\r
1\t0\t3\t16\t0.000000\t0.000000\t0.000000\t0.000000\t60.4312345\t22.1612345\t100.000000\t1\r
# a comment of MAVProxy\r
2\t0\t3\t16\t12.500000\t0.000000\t0.000000\tnan\t-33.8567844\t-151.2152967\t100.000000\t1\r
\r
3\t0\t2\t177\t1\t-1\t0\t0\t0\t0\t0\t1\r
4\t0\t2\t206\t25\t0\t1\t0\t0\t0\t0\t0\r
"""


def test_as_mission_planner_writes_it() -> None:
    plan = waypoints.read("a.waypoints", MISSION_PLANNER)
    assert plan.home == (60.43, 22.16, 5.21)
    first, second, jump, camera = plan.mission
    assert first == PlanItem(0, 16, 3, 0.0, 0.0, 0.0, 0.0, 604312345, 221612345, 100.0)
    assert (second.x, second.y, second.param1) == (-338567844, -1512152967, 12.5)
    assert math.isnan(second.param4)
    assert (jump.command, jump.param1, jump.param2) == (177, 0.0, -1.0)  # line 1 has sequence number 0
    assert (camera.seq, camera.autocontinue) == (3, 0)


def test_written_by_columns() -> None:
    item = PlanItem(0, 16, 3, 1.5, 0.0, 0.0, 90.0, 634389000, 103990000, 50.0)
    jump = PlanItem(1, 177, 2, 0.0, 3.0, 0.0, 0.0, 0, 0, 0.0)
    text = waypoints.write("a.waypoints", PlanFile((item, jump), home=(63.4, 10.4, 2.0)))
    assert text.splitlines() == [
        "QGC WPL 110",
        "0\t1\t0\t16\t0\t0\t0\t0\t63.4\t10.4\t2\t1",
        "1\t0\t3\t16\t1.5\t0\t0\t90\t63.4389\t10.399\t50\t1",
        "2\t0\t2\t177\t1\t3\t0\t0\t0\t0\t0\t1",
    ]


def test_without_a_home() -> None:
    plan = PlanFile((PlanItem(0, 20, 2, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0),))
    assert waypoints.read("a", waypoints.write("a", plan)) == plan


def test_a_fence_is_not_dropped_silently() -> None:
    circle = PlanItem(0, 5003, 0, 10.0, 0.0, 0.0, 0.0, 1, 1, 0.0)
    for plan in (PlanFile((), fence=(circle,)), PlanFile((), rally=(replace(circle, command=5100),))):
        with pytest.raises(PlanFileError, match=r"b\.waypoints: .*\.plan"):
            waypoints.write("b.waypoints", plan)


def test_all_bad_lines_at_once() -> None:
    text = "\n".join(
        [
            "QGC WPL 110",
            "0\t1\t0\t16\t0\t0\t0\t0\t60\t22\t0\t1",
            "1\t0\t3\t16\t0\t0\t0\t0\t91\t22\t0\t1",
            "2\t0\t3\t16\t0\t0\t0\t0\t60\t22\t0",
            "3\t0\t3\t16\tten\t0\t0\t0\t60\t22\t0\t1",
            "5\t0\t3\t16\t0\t0\t0\t0\t60\t22\t0\t1",
            "5\t0\t3\t177\t0\t1\t0\t0\t0\t0\t0\t1",
            "6\t0\t3\t70000\t0\t1\t0\t0\t0\t0\t0\t1",
            "7\t0\t3\t16\t1e39\t1\t0\t0\t0\t0\t0\t1",
            "8\t0\t2\t206\t1\t1\t0\t0\t3e9\t0\t0\t1",
        ]
    )
    with pytest.raises(PlanFileError) as caught:
        waypoints.read("tour.waypoints", text)
    expected = ("latitude", "11 columns", "ten", "so this one 4", "which is home", "70000", "32 bits", "32 bits")
    assert len(caught.value.problems) == len(expected)
    for number, (problem, words) in enumerate(zip(caught.value.problems, expected, strict=True), start=3):
        assert problem.startswith(f"tour.waypoints:{number}: ")
        assert words in problem


@pytest.mark.parametrize("text", ["", "QGC WPL 100\n", "{}", "\x00"])
def test_other_files(text: str) -> None:
    with pytest.raises(PlanFileError, match="QGC WPL 110"):
        waypoints.read("a.waypoints", text)


@pytest.mark.parametrize("target", ["nan", "inf", "-inf"])
def test_a_jump_to_no_number_is_told_with_its_line(target: str) -> None:
    home = "0\t1\t0\t16\t0\t0\t0\t0\t60\t22\t0\t1"
    text = f"QGC WPL 110\n{home}\n1\t0\t2\t177\t{target}\t1\t0\t0\t0\t0\t0\t1\n"
    with pytest.raises(PlanFileError) as caught:
        waypoints.read("tour.waypoints", text)
    assert caught.value.problems == [f"tour.waypoints:3: DO_JUMP to {target}; give the number of an item"]
