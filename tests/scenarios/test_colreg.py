"""Another vessel on a collision course, over situations and seeds, judged by raw truth with the hulls as rectangles."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from companion.cli.new_file import Answers, file_text
from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run
from sitl.traffic import ScriptedVessel

SITUATIONS = ("head_on", "crossing_starboard", "crossing_port", "overtaking", "overtaken", "standing")


def keep_clear(folder: Path, seed: int, **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS["colreg"], LockstepRig, folder, seed=seed, changes=changes)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"
    return dict(outcome.metrics)


def test_keeps_clear_of_a_vessel_from_starboard(tmp_path: Path) -> None:
    keep_clear(tmp_path, 1, situation="crossing_starboard", onward="90")


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(16))
@pytest.mark.parametrize("situation", SITUATIONS)
def test_keeps_clear_sweep(tmp_path: Path, situation: str, seed: int) -> None:
    keep_clear(tmp_path, seed, situation=situation)


@pytest.mark.sweep
@pytest.mark.parametrize("situation", SITUATIONS)
@pytest.mark.parametrize("vessel", ["rescuerunner", "otter", "revolt"])
def test_fast_boats_and_slow_ones_meet_another_at_their_own_speed(tmp_path: Path, vessel: str, situation: str) -> None:
    changes = {"situation": situation}
    outcome = run(SCENARIOS["colreg"], LockstepRig, tmp_path, seed=3, vessel=vessel, changes=changes)
    assert outcome.error is None and outcome.metrics["clear_water_m"] > 10.0


def jet(length_m: float, beam_m: float, mass_kg: float, pull_n: str) -> Answers:
    return Answers(
        "jet", "Jet", "planing", length_m, beam_m, mass_kg, None, None, None, "jet", pull_n, None, 0.0,
        "microcontroller", "one", 63.442, 10.4,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("boat", "seed", "wind"),
    [
        (jet(6.8, 2.4, 1500.0, "5000"), 712673, "2"),
        pytest.param(jet(5.0, 2.0, 800.0, "3000"), 712626, "", marks=pytest.mark.sweep),
    ],
)
def test_a_jet_is_not_run_over_by_one_that_overtakes_it(tmp_path: Path, boat: Answers, seed: int, wind: str) -> None:
    """Its detour led across the other's bow, which it took at half of its speed; then it swung to and fro between
    detours to either side."""
    file, changes = tmp_path / "jet.toml", {"situation": "overtaken", "wind": wind}
    file.write_text(file_text(boat), encoding="utf-8")
    outcome = run(SCENARIOS["colreg"], LockstepRig, tmp_path / "log", seed=seed, vessel=str(file), changes=changes)
    assert outcome.error is None and outcome.metrics["clear_water_m"] > 10.0


@pytest.mark.sweep
@pytest.mark.parametrize("situation", SITUATIONS)
@pytest.mark.parametrize("change", [{"wind": "5"}, {"current": "0.3@90"}, {"gnss": "rtk"}])
def test_keeps_clear_in_other_conditions(tmp_path: Path, situation: str, change: dict[str, str]) -> None:
    keep_clear(tmp_path, 3, situation=situation, **change)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4))
def test_waits_for_a_vessel_that_crosses(tmp_path: Path, seed: int) -> None:
    keep_clear(tmp_path, seed, situation="crossing_starboard", action="slow")


@pytest.mark.parametrize("situation", SITUATIONS)
def test_a_boat_that_does_nothing_fails(tmp_path: Path, situation: str) -> None:
    """The truth of a boat that sails on as if there were nobody."""
    rows = [f"{t * 0.5:.3f},{t * 0.6:.5f},0.0,0.0" for t in range(551)]
    (tmp_path / "truth.csv").write_text("\n".join(["t_s,north_m,east_m,yaw_rad", *rows, ""]), encoding="utf-8")
    (tmp_path / "events.csv").write_text("t_s,time_unix_ns,severity,name,text\n", encoding="utf-8")
    towards = {"head_on": math.pi, "crossing_starboard": -math.pi / 2, "crossing_port": math.pi / 2}.get(situation, 0.0)
    speed = {"overtaking": 0.5, "overtaken": 2.4, "standing": 0.0}.get(situation, 1.5)
    points = tuple(
        (t, 150.0 + speed * math.cos(towards) * (t - 125.0), speed * math.sin(towards) * (t - 125.0))
        for t in (0.0, 700.0)
    )
    asked: dict[str, Any] = {
        "vessel": ScriptedVessel(1, "NORA", points),
        "situation": situation,
        "started_s": 0.0,
        "meeting_s": 125.0,
        "finished_s": 275.0,
        "length_m": 3.75,
        "route_m": 330.0,
        "beam_m": 1.7,
    }
    metrics, checks = SCENARIOS["colreg"].measure(tmp_path, asked, {"gnss": "rtk"})
    assert metrics["clear_water_m"] == 0.0
    assert {check.name for check in checks if not check.ok} >= {
        "clear water between the hulls",
        "announcements that name the situation",
    }
