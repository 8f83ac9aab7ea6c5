"""What scenarios judge, by tracks whose answers are known by hand: each criterion measures what its words say."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pytest

from sitl.scenarios import SCENARIOS
from sitl.scenarios.measure import Check

REST = {"surge_mps": 0.0, "sway_mps": 0.0, "yaw_rate_radps": 0.0, "yaw_rad": 0.0, "north_m": 0.0, "east_m": 0.0}


def write(file: Path, rows: Iterable[Mapping[str, Any]]) -> None:
    """One row a second."""
    every = [{"t_s": float(t_s), **row} for t_s, row in enumerate(rows)]
    with file.open("w", encoding="utf-8", newline="") as target:
        writer = csv.DictWriter(target, list(every[0]))
        writer.writeheader()
        writer.writerows(every)


def judged(name: str, folder: Path, asked: dict[str, Any], **settings: str) -> dict[str, Check]:
    scenario = SCENARIOS[name]
    _, checks = scenario.measure(folder, asked, {**scenario.defaults, **settings})
    return {check.name: check for check in checks}


@pytest.mark.parametrize("yaw_deg", [0.0, 40.0, 90.0, -130.0])
def test_a_hull_that_lies_across_reaches_to_the_line_with_its_side(yaw_deg: float, tmp_path: Path) -> None:
    yaw_rad = math.radians(yaw_deg)
    write(tmp_path / "truth.csv", ({**REST, "yaw_rad": yaw_rad, "north_m": 8.0} for _ in range(20)))
    asked = {
        "from_s": 0.0, "line_m": 10.0, "length_m": 3.0, "beam_m": 2.0, "beyond_m": 0.0, "needs_m": 5.0, "breaches": 0,
        "fast_mps": 1.0, "drifts": False, "rest_mps": 0.1,
    }  # fmt: skip
    corners = [1.5 * along * math.cos(yaw_rad) - across * math.sin(yaw_rad) for along in (-1, 1) for across in (-1, 1)]
    check = judged("fence_stop", tmp_path, asked)["the hull stays short of the line"]
    assert check.value == pytest.approx(2.0 - max(corners))
    assert f"{check.limit:g}" == "0", "it said: at least -0"


@pytest.mark.parametrize(
    ("north_m", "mode", "failed"),
    [
        (60.0, "RTL", set()),
        (71.0, "RTL", {"the hull stays inside the fence"}),
        (60.0, "Hold", {"time in RTL"}),
    ],
)
def test_a_boat_comes_home_by_rtl_and_inside_its_fence(
    north_m: float, mode: str, failed: set[str], tmp_path: Path
) -> None:
    places = [north_m, 30.0, *[0.0] * 98]
    write(tmp_path / "truth.csv", ({**REST, "north_m": place} for place in places))
    write(tmp_path / "ticks.csv", ({"mode": mode} for _ in places))
    asked = {"silent_s": 0.0, "to_s": 99.0, "near_m": 6.0, "fence_m": (72.0, 12.0), "hull_m": (3.0, 1.0)}
    checks = judged("homecoming", tmp_path, asked)
    assert {name for name, check in checks.items() if not check.ok} == failed


def test_waypoints_are_passed_inside_the_radius_that_they_were_uploaded_with(tmp_path: Path) -> None:
    corners = [(20.0, 0.0), (20.0, 19.0), (0.0, 20.0), (0.0, 0.0)]  # the second is missed by a metre
    write(tmp_path / "truth.csv", ({**REST, "north_m": north, "east_m": east} for north, east in corners))
    asked = {
        "side_m": 20.0, "limit_m": 0.5, "start": (0.0, 0.0), "started_s": 0.0, "finished_s": 3.0, "beats_m": 0.0,
        "reached": [0, 1, 2, 3], "config": None,
    }  # fmt: skip
    for radius_m, inside in ((1.5, True), (0.5, False)):
        checks = judged("mission_square", tmp_path, {**asked, "radius_m": radius_m})
        assert checks["every waypoint was passed inside its radius"].ok == inside


def test_a_boat_that_keeps_a_heading_near_south_has_not_turned(tmp_path: Path) -> None:
    rows = [{**REST, "yaw_rad": math.copysign(math.pi - 0.01, -1.0 if t_s % 2 else 1.0)} for t_s in range(60)]
    for file in ("truth.csv", "ticks.csv"):
        write(tmp_path / file, rows)
    check = judged("lever_arm", tmp_path, {"from_s": 0.0})["the boat has turned"]
    assert check.value == pytest.approx(math.degrees(0.02))
