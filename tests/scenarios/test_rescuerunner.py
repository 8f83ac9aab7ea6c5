"""The jet boat whole: missions at planing speed, Hold without way astern, and three vessels in one process."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import run
from sitl.shared_sea import LeadBoatConfig


def sail(name: str, folder: Path, seed: int, **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS[name], LockstepRig, folder, seed=seed, vessel="rescuerunner", changes=changes)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"
    return dict(outcome.metrics)


def test_square_at_planing_speed(tmp_path: Path) -> None:
    """With a good receiver, so that what is left is the boat's own, and a jet and hull much worse than believed: the
    speed is kept all the same."""
    metrics = sail("mission_square", tmp_path, 1, waves="0.3", gnss="rtk", limit="1.5", plant="worn", side="110")
    assert metrics["speed_max_mps"] > 7.9 and metrics["time_s"] < 100.0


def test_hold_inside_the_watch_circle(tmp_path: Path) -> None:
    metrics = sail("watch_circle", tmp_path, 1, wind="10", time="80")
    assert metrics["running_share"] > 0.02, "it does sail back"


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(16))
@pytest.mark.parametrize("plant", ["as_estimated", "worn"])
@pytest.mark.parametrize(
    "weather",
    [{"wind": "4"}, {"wind": "12"}, {"wind": "6", "current": "0.5", "waves": "0.4"}],
    ids=["breeze", "blow", "stream"],
)
def test_watch_circle_sweep(tmp_path: Path, weather: dict[str, str], plant: str, seed: int) -> None:
    sail("watch_circle", tmp_path, seed, plant=plant, **weather)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(16))
@pytest.mark.parametrize("waves", ["", "0.4"])
def test_square_sweep(tmp_path: Path, waves: str, seed: int) -> None:
    sail("mission_square", tmp_path, seed, waves=waves)


def test_three_vessels_in_one_process(tmp_path: Path) -> None:
    """Two boats of ours around a lead boat, ticked in turn: all at one time, each with its own errors, and the leader
    moves once."""
    leader = LeadBoatConfig("leader", "straight@8.2", (30.0, 0.0, 0.0), 1.0)
    conditions = Conditions("rescuerunner", seed=1, gnss="standalone", lead_boats=(leader,), gnss_common=0.5)
    first = LockstepRig(conditions, tmp_path / "first")
    second = first.second_vessel(replace(conditions, seed=2, start=(0.0, 20.0, 0.0)), "second")
    third = GroundStation(second)
    for _ in range(20 * 12):
        first.step()
        third.step()
    assert [second.now_s, first.world.t_s, second.world.t_s] == pytest.approx([first.now_s] * 3)
    assert first.world.shared_sea is second.world.shared_sea and first.world.shared_sea is not None
    boat = first.world.shared_sea.boats[0]
    assert boat.t_s == pytest.approx(first.now_s, abs=0.02) and 60.0 < boat.hull.north_m < 120.0
    assert second.world.truth.east_m == pytest.approx(20.0, abs=0.5)
    errors = []
    for rig in (first, second):
        nav, truth = rig.vessel.last_tick.nav, rig.world.truth  # type: ignore[union-attr]
        errors.append((nav.north_m - truth.north_m, nav.east_m - truth.east_m))
    assert all(0.05 < math.hypot(*error) < 6.0 for error in errors) and errors[0] != errors[1]
    first.close()
    second.close()
    assert (tmp_path / "first" / "second" / "truth.csv").is_file()
