"""How docking is judged: in a sea that moves the hull with more force than the boat pushes with, by its mean place."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from sitl.scenarios import docking

DT_S, TOUCHED_S, END_S = 0.1, 50.0, 95.0
ASKED: dict[str, Any] = {"from_s": 0.0, "docked_s": 60.0, "to_s": END_S, "yaw_rad": 0.0, "inertia_kg": 300.0, "sea": True,
         "stands_off": False, "most_n": 25.0}  # fmt: skip
RADPS = 6.0
Gap = Callable[[float], float]


def wave_m(t_s: float) -> float:
    """Between 0 and 6 mm off the fenders, half of the time."""
    return max(0.0, 0.006 * math.sin(RADPS * t_s)) - 0.001


def judged(folder: Path, wave_mps: float, gap_m: Gap, sea: bool = True) -> dict[str, bool]:
    """The checks that differ by the sea. `wave_mps`: amplitude of the motion sideways before the touch; `gap_m`: after
    it, by time."""
    rows = []
    for i in range(round(END_S / DT_S) + 1):
        t_s = i * DT_S
        touched = t_s >= TOUCHED_S
        gap = gap_m(t_s) if touched else 1.0
        rows.append(
            {
                "t_s": t_s, "yaw_rad": 0.0, "sway_mps": -0.05 + wave_mps * math.sin(RADPS * t_s),
                "contact_n": 10.0 if gap < 0.0 else 0.0, "contact_gap_m": gap, "contact_surge_mps": 0.0 if touched else math.nan,
                "contact_sway_mps": -0.05 if touched else math.nan,
            }
        )  # fmt: skip
    with (folder / "truth.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    _, checks = docking.measure(folder, {**ASKED, "sea": sea}, {})
    return {check.name: check.ok for check in checks[4:]}


@pytest.mark.parametrize("sea", [True, False])
def test_where_the_waves_are_weaker_than_the_push_the_fenders_stay_pressed(tmp_path: Path, sea: bool) -> None:
    wave_mps = 0.0005 if sea else 0.02
    assert judged(tmp_path, wave_mps, lambda _: -0.001, sea) == {"share of that time in contact": True}
    assert judged(tmp_path, wave_mps, wave_m, sea) == {"share of that time in contact": False}


def test_where_they_are_stronger_each_wave_brings_the_boat_back(tmp_path: Path) -> None:
    assert all(judged(tmp_path, 0.02, wave_m).values())
    away = judged(tmp_path, 0.02, lambda t_s: 0.02 if 70.0 < t_s < 75.0 else wave_m(t_s))
    assert list(away.values()) == [False, False]
    hovering = judged(tmp_path, 0.02, lambda t_s: -0.001 if round(t_s, 1) % 1.0 == 0.0 else 0.008)
    assert list(hovering.values()) == [True, False], "it touches at times, and lies off in the mean"


@pytest.mark.parametrize(("until_s", "good"), [(95.0, True), (70.0, False)])
def test_a_boat_that_drifts_off_after_it_has_docked_is_no_more_alongside(
    tmp_path: Path, until_s: float, good: bool
) -> None:
    judged(tmp_path, 0.0, lambda t_s: -0.001 if t_s <= until_s else 0.04)
    _, checks = docking.measure(tmp_path, ASKED, {})
    assert {check.name: check.ok for check in checks}["from docked to the last contact"] == good


def test_speeds_at_contact_are_told_with_and_without_the_waves(tmp_path: Path) -> None:
    judged(tmp_path, 0.02, wave_m)
    metrics, _ = docking.measure(tmp_path, ASKED, {})
    assert metrics["contact_own_mps"] == pytest.approx(0.05, abs=0.003)
    assert metrics["wave_mps"] == pytest.approx(0.02 / math.sqrt(2.0), rel=0.15)
    assert metrics["wave_n"] == pytest.approx(300.0 * RADPS * 0.02 / math.sqrt(2.0), rel=0.15)


@pytest.mark.parametrize(
    ("wave_mps", "off_m", "good"),
    [(0.02, 2.0, [True, True]), (0.002, 2.0, [False, True]), (0.02, 0.3, [True, False])],
    ids=["as it should", "waves that it could have docked in", "too near"],
)
def test_a_boat_that_stands_off_had_a_reason_and_keeps_clear(
    tmp_path: Path, wave_mps: float, off_m: float, good: list[bool]
) -> None:
    judged(tmp_path, wave_mps, lambda _: off_m)
    rows = (tmp_path / "truth.csv").read_text(encoding="utf-8")
    (tmp_path / "truth.csv").write_text(rows.replace(",1.0,", f",{off_m},"), encoding="utf-8")
    metrics, checks = docking.measure(tmp_path, {**ASKED, "stands_off": True}, {})
    assert metrics["stood_off"] == 1.0 and [check.ok for check in checks] == good
