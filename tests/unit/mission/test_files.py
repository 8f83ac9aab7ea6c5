"""Formats by suffix."""

import pytest

from companion.mission import files
from companion.mission.plan import PlanItem


def test_the_suffix_tells_the_format() -> None:
    plan = files.PlanFile((PlanItem(0, 16, 3, 0.0, 0.0, 0.0, 0.0, 634389000, 103990000, 0.0),), home=(63.4, 10.3, 0.0))
    for name in ("a.plan", "A.PLAN", "b.waypoints"):
        assert files.read(name, files.write(name, plan)) == plan
    assert files.write("a.plan", plan).startswith("{")
    assert files.write("b.waypoints", plan).startswith("QGC WPL 110\n")


@pytest.mark.parametrize("name", ["a.txt", "plan", "", ".plan"])
def test_unknown_suffixes_are_refused_with_the_known_ones(name: str) -> None:
    with pytest.raises(files.PlanFileError, match=r"use one of \.plan, \.waypoints, \.gpx"):
        files.read(name, "")
    with pytest.raises(files.PlanFileError):
        files.write(name, files.PlanFile(()))
