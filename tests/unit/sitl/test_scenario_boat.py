"""A scenario sails the boat of the file, and refuses one that cannot do it."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from companion.cli.rig import LockstepRig
from companion.config.actuators.mavlink_servo import MavlinkServoConfig
from companion.config.vessel import find, load, with_camera
from sitl.scenarios import SCENARIOS
from sitl.scenarios.boat import (
    fast_mps,
    holds_by_drifting,
    leeway_mps,
    sailed_with,
    stopping_room_m,
    way_to_rest_m,
)
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import ScenarioError, run, settings_for


def no_rig(conditions: Conditions, folder: Path) -> Any:
    raise AssertionError("the scenario must not start")


@pytest.mark.parametrize("name", ["docking", "hold", "four_corner", "station_keeping", "thruster_failure"])
def test_a_boat_without_sideways_thrust_is_refused_in_a_sentence(name: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=f"{name} is not for otter: it needs sideways thrust"):
        run(SCENARIOS[name], no_rig, tmp_path, vessel="otter")


@pytest.mark.parametrize(
    ("name", "vessel", "remedy"),
    [
        ("docking", "aboat", r"add a \[dock\] table"),
        ("ahrs", "blueboat", "no sensor of driver mtdata2; add one"),
        ("identify", "wamv16", "no.* of that name; try --set hull=as_modelled"),
        ("stern_first", "rescuerunner", "it needs way astern"),
        ("lever_arm", "rescuerunner", "it needs a turn on the spot"),
        ("route", "sailbot", "this boat sails; try sail_triangle"),
        ("watch_circle", "aboat", "stays at its point; try hold"),
        ("watch_circle", "otter", "stays at its point; try bow_hold"),
    ],
)
def test_a_boat_that_lacks_something_is_told_what_to_do(name: str, vessel: str, remedy: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=f"{name} is not for {vessel}: .*{remedy}"):
        run(SCENARIOS[name], no_rig, tmp_path, vessel=vessel)


@pytest.mark.parametrize(
    ("name", "key", "text", "remedy"),
    [
        ("hold", "time", "nan", "not a number"),
        ("hold", "time", "inf", "not a number"),
        ("hold", "time", "long", "not a number"),
        ("hold", "time", "-5", "must be above 0"),
        ("hold", "time", "0", "must be above 0"),
        ("hold", "time", "", "must be above 0"),
        ("gnss_dropout", "pause", "-1", "must be at least 0"),
        ("sail_triangle", "hold", "20", "must be above 30, the time before Hold is judged"),
        ("obstacles", "speed", "fast", "not a number"),
        ("obstacles", "count", "2.5", "write a whole number, at least 0"),
        ("survey", "transects", "0", "write a whole number, at least 1"),
        ("hold", "model_error", "nan", "not a number"),
        ("hold", "model_error", "-1", "a share above -1, as -0.3 or 0.3"),
    ],
)
def test_a_setting_of_which_nothing_would_be_judged_is_refused(
    name: str, key: str, text: str, remedy: str, tmp_path: Path
) -> None:
    with pytest.raises(ScenarioError, match=f"{key}={text}: {remedy}"):
        run(SCENARIOS[name], no_rig, tmp_path, changes={key: text})


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_scenario_s_own_settings_are_taken(name: str, tmp_path: Path) -> None:
    for vessel in ("", *SCENARIOS[name].by_vessel):
        with pytest.raises(AssertionError, match="must not start"):
            run(SCENARIOS[name], no_rig, tmp_path, vessel=vessel or None)


def test_the_remedies_help(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="must not start"):
        run(SCENARIOS["identify"], no_rig, tmp_path, vessel="wamv16", changes={"hull": "as_modelled"})


def test_a_run_that_lacks_what_is_measured_has_a_verdict(tmp_path: Path) -> None:
    def nothing(folder: Path, asked: dict[str, Any], settings: Any) -> Any:
        return {"most": max([])}, ()

    def a_second(gcs: GroundStation, settings: Any) -> dict[str, Any]:
        gcs.sail(1.0)
        return {}

    scenario = replace(SCENARIOS["full_stop"], sail=a_second, measure=nothing)
    outcome = run(scenario, LockstepRig, tmp_path, vessel="otter")
    assert not outcome.ok and "the run lacks what full_stop measures" in (outcome.error or "")
    assert '"ok": false' in (tmp_path / "result.json").read_text(encoding="utf-8")


def test_a_camera_finds_a_relay_of_an_autopilot_board_too() -> None:
    board = with_camera(load(find("blueboat"))).actuators[0]
    assert isinstance(board, MavlinkServoConfig) and board.mavlink is not None
    assert len(board.mavlink.relays) == len(board.relays) == len(set(board.mavlink.relays)) > 0


def test_the_room_for_a_stop_is_by_thrust_astern_or_by_a_turn() -> None:
    otter, jet = load(find("otter")), load(find("rescuerunner"))
    braked_m, coasted_m = way_to_rest_m(otter.hull, 2.4, 200.0), way_to_rest_m(otter.hull, 2.4, 0.0)
    assert 2.4**2 / 2.0 * otter.hull.m11_kg / 500.0 < braked_m < 0.7 * coasted_m
    assert 1.0 + 4.8 + 0.5 * braked_m < stopping_room_m(otter, 2.4) < 1.0 + 4.8 + 2.0 * braked_m
    assert stopping_room_m(jet, 10.0) < 22.0 + way_to_rest_m(jet.hull, 10.0, 0.0), "it turns sooner than it coasts"


def gnss(scenario: str, vessel: str, **changes: str) -> str:
    return settings_for(SCENARIOS[scenario], vessel, load(find(vessel)), changes)["gnss"]


def test_the_receiver_is_that_of_the_vessel_unless_it_is_set() -> None:
    assert gnss("mission_square", "blueboat") == "sbas" and gnss("mission_square", "wamv16") == "rtk"
    assert gnss("mission_square", "blueboat", gnss="rtk") == "rtk"


def test_every_scenario_sails_in_either_water() -> None:
    assert {scenario.defaults["water"] for scenario in SCENARIOS.values()} == {""}


def test_results_of_a_scenarios_own_boats_stay() -> None:
    assert gnss("mission_square", "revolt") == "rtk" and gnss("mission_square", "rescuerunner") == "standalone"
    assert gnss("four_corner", "cybership2") == "basin" and gnss("watch_circle", "rescuerunner") == "standalone"


def test_the_report_names_receiver_compass_plant_and_limits() -> None:
    text = sailed_with(load(find("otter")), Conditions("otter", gnss="sbas"))
    assert text == (
        "otter: receiver sbas, compass two antennas, plant fossen, usual water, limits 215.5 N ahead, 0 N sideways, 47.42 Nm"
    )
    assert "compass true, plant as_modelled" in sailed_with(load(find("blueboat")), Conditions("blueboat"))
    assert "plant strips, rough water" in sailed_with(load(find("otter")), Conditions("otter", water="rough"))
    assert "compass magnetic" in sailed_with(load(find("aboat")), Conditions("aboat")), (
        "its wind sensor has no antennas"
    )


@pytest.mark.parametrize("name", sorted(name for name, one in SCENARIOS.items() if "leader" in one.defaults))
def test_a_boat_that_its_leader_would_leave_behind_is_told_so(name: str, tmp_path: Path) -> None:
    with pytest.raises(
        ScenarioError, match=r"is not for heron: its leader sails [\d.]+ m/s.*try --set leader=\w+@1\.4"
    ):
        run(SCENARIOS[name], no_rig, tmp_path, vessel="heron")
    with pytest.raises(AssertionError, match="must not start"):
        run(SCENARIOS[name], no_rig, tmp_path, vessel="heron", changes={"leader": "straight@1.4"})


def test_a_boat_that_never_rests_is_not_asked_to_stand() -> None:
    drifts = {name: holds_by_drifting(load(find(name))) for name in ("rescuerunner", "sailbot", "otter", "aboat")}
    assert drifts == {"rescuerunner": True, "sailbot": True, "otter": False, "aboat": False}


def test_fast_is_no_faster_than_a_slow_boat_sails() -> None:
    assert fast_mps(load(find("otter")), 0.9) == 0.9
    assert fast_mps(load(find("cybership2")), 0.9) == pytest.approx(0.8 * 1.004, abs=0.001)


def test_fence_stop_begins_with_the_bow_at_the_line_wherever_home_points(tmp_path: Path) -> None:
    headings = []

    def looked(gcs: GroundStation, settings: Any) -> dict[str, Any]:
        headings.append((gcs.rig.config.home.yaw_rad, gcs.rig.world.truth.yaw_rad))
        gcs.sail(1.0)
        return {}

    run(
        replace(SCENARIOS["fence_stop"], sail=looked, measure=lambda *_: ({}, ())),
        LockstepRig,
        tmp_path,
        vessel="sailbot",
    )
    assert headings == [(pytest.approx(math.pi / 2.0), pytest.approx(0.0))]


def test_wind_from_astern_drives_a_boat_as_fast_as_its_drag_allows() -> None:
    """A boat without way astern never came to rest along its hull, and its stop counted as failed."""
    config = load(find("rescuerunner"))
    driven_mps = leeway_mps(config, 8.0)
    push_n = 0.5 * 1.225 * config.windage.cx * config.windage.frontal_m2 * (8.0 - driven_mps) ** 2
    assert 0.2 < driven_mps < 1.0 and config.hull.drag_n(driven_mps) == pytest.approx(push_n, rel=1e-3)
    assert leeway_mps(config, -8.0) == pytest.approx(0.0, abs=1e-6)
