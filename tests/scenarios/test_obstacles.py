"""Obstacles that only sensors know, judged by raw truth: nothing is touched, the route is completed or given up."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from companion.cli.new_file import Answers, file_text
from companion.cli.rig import LockstepRig
from sitl.obstacles import Obstacles, RoundObstacle, Shoal, Wall
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run


def sail(name: str, folder: Path, seed: int, **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS[name], LockstepRig, folder, seed=seed, changes=changes)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"
    return dict(outcome.metrics)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(16))
@pytest.mark.parametrize("name", ["obstacles", "harbour"])
def test_nothing_is_touched(tmp_path: Path, name: str, seed: int) -> None:
    sail(name, tmp_path, seed)


@pytest.mark.sweep
@pytest.mark.parametrize("vessel_speed", ["0.6", "1.5"])
def test_nothing_is_touched_at_other_speeds(tmp_path: Path, vessel_speed: str) -> None:
    sail("obstacles", tmp_path, 3, speed=vessel_speed)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("vessel", ["blueboat", "revolt"])
def test_other_vessels_touch_nothing(tmp_path: Path, vessel: str, seed: int) -> None:
    outcome = run(SCENARIOS["obstacles"], LockstepRig, tmp_path, seed=seed, vessel=vessel)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"


@pytest.mark.sweep
def test_a_jet_gives_up_where_gaps_are_narrow_before_it_touches(tmp_path: Path) -> None:
    weather = {"wind": "4@97", "current": "0@32"}
    outcome = run(SCENARIOS["obstacles"], LockstepRig, tmp_path, seed=691101, vessel="rescuerunner", changes=weather)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"


@pytest.mark.sweep
@pytest.mark.parametrize("seed", [711249, 723001])
def test_a_jet_that_finds_no_way_among_stones_comes_to_rest(tmp_path: Path, seed: int) -> None:
    """Sent back round, it drove itself on by the thrust of its turn, changed its mind half way, and struck a stone."""
    outcome = run(SCENARIOS["obstacles"], LockstepRig, tmp_path, seed=seed, vessel="rescuerunner")
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"


@pytest.mark.sweep
def test_a_boat_that_tries_one_side_and_the_other_comes_through_or_gives_up(tmp_path: Path) -> None:
    """What it has seen on one side it forgets while it tries the other. Once it went to and fro for ever."""
    outcome = run(SCENARIOS["obstacles"], LockstepRig, tmp_path, seed=100, vessel="revolt")
    assert outcome.ok and outcome.metrics["reached"] + outcome.metrics["declared_impossible"] == 1.0, outcome.error


LAUNCH = Answers(
    "launch", "Launch", "monohull", 9.0, 2.8, 4500.0, None, None, None, "rudder", "3500", None, 0.0, "microcontroller",
    "one", 63.442, 10.4,
)  # fmt: skip


@pytest.mark.parametrize(
    ("seed", "wind", "current"),
    [
        (711285, "2.95@232", "0.01@312"),
        pytest.param(711286, "2.53@300", "0.19@345", marks=pytest.mark.sweep),
        pytest.param(711280, "0.09@338", "0.24@50", marks=pytest.mark.sweep),
    ],
)
def test_a_long_launch_stays_out_of_gaps_in_which_it_cannot_turn(
    tmp_path: Path, seed: int, wind: str, current: str
) -> None:
    """It was led into them, turned for minutes while wind and current set it on, and lay on one stone after another."""
    file, weather = tmp_path / "launch.toml", {"wind": wind, "current": current}
    file.write_text(file_text(LAUNCH), encoding="utf-8")
    outcome = run(SCENARIOS["obstacles"], LockstepRig, tmp_path / "log", seed=seed, vessel=str(file), changes=weather)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"


@pytest.mark.sweep
def test_a_jet_that_turns_tightly_at_this_speed_takes_the_entrance_of_a_harbour(tmp_path: Path) -> None:
    """Judged by the radius of its waypoints, it could not have sailed into it, and went round all of the quay."""
    weather = {"wind": "2.5", "current": "0.1"}
    outcome = run(SCENARIOS["harbour"], LockstepRig, tmp_path, seed=711667, vessel="rescuerunner", changes=weather)
    assert outcome.ok and outcome.metrics["reached"] == 1.0, f"{outcome.error or outcome.metrics}"


CATAMARAN = replace(
    LAUNCH, name="catamaran", title="Catamaran", form="catamaran", length_m=7.0, beam_m=3.0, mass_kg=2200.0,
    hull_beam_m=0.7, layout="two-azimuths", motor="1500",
)  # fmt: skip


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("answers", "seed", "wind", "current", "ends"),
    [
        (CATAMARAN, 727206, "2.0@127", "0.09@62", "reached"),
        (LAUNCH, 727202, "1.3@309", "0.18@298", "declared_impossible"),
    ],
    ids=["a catamaran that fits takes it", "a launch too long for it gives up in time"],
)
def test_the_entrance_of_a_harbour(
    tmp_path: Path, answers: Answers, seed: int, wind: str, current: str, ends: str
) -> None:
    """The catamaran lay 200 s before the way past a shoal, and gave up; the launch found each side of the quays closed,
    had forgotten the first by then, and tried that again until the scenario ended."""
    file, weather = tmp_path / "boat.toml", {"wind": wind, "current": current}
    file.write_text(file_text(answers), encoding="utf-8")
    outcome = run(SCENARIOS["harbour"], LockstepRig, tmp_path / "log", seed=seed, vessel=str(file), changes=weather)
    assert outcome.ok and outcome.metrics[ends] == 1.0, f"{outcome.error or outcome.metrics}"


def test_a_boat_that_does_nothing_fails(tmp_path: Path) -> None:
    """The truth of a boat that sails through everything."""
    rows = [f"{t * 0.5:.3f},{t * 0.5:.5f},0.0,0.0,1.0,0.0" for t in range(201)]
    header = "t_s,north_m,east_m,yaw_rad,surge_mps,sway_mps"
    (tmp_path / "truth.csv").write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    (tmp_path / "events.csv").write_text("t_s,time_unix_ns,severity,name,text\n", encoding="utf-8")
    world = Obstacles()
    world.round.append(RoundObstacle(50.0, 0.0, 1.0))
    world.walls.append(Wall((80.0, -5.0), (80.0, 5.0)))
    world.shoals.append(Shoal(30.0, 0.0, 40.0, 0.0))
    asked = {
        "obstacles": world,
        "started_s": 0.0,
        "ended_s": 100.0,
        "reached": False,
        "length_m": 2.0,
        "beam_m": 1.0,
        "beside_m": 30.0,
        "drifts_m": None,
    }
    for name, failing in (
        ("obstacles", {"water between hull and obstacles", "route completed, or declared impossible"}),
        ("harbour", {"water between hull and quays", "depth of water under the hull"}),
    ):
        _, checks = SCENARIOS[name].measure(tmp_path, asked, {})
        assert {check.name for check in checks if not check.ok} >= failing
