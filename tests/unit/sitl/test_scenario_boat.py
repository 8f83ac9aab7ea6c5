"""A scenario sails the boat of the file, and refuses one that cannot do it."""

from pathlib import Path
from typing import Any

import pytest

from companion.config.vessel import find, load
from sitl.scenarios import SCENARIOS
from sitl.scenarios.boat import sailed_with
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import ScenarioError, run, settings_for


def no_rig(conditions: Conditions, folder: Path) -> Any:
    raise AssertionError("the scenario must not start")


@pytest.mark.parametrize("name", ["docking", "hold", "four_corner", "station_keeping", "thruster_failure"])
def test_a_boat_without_sideways_thrust_is_refused_in_a_sentence(name: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=f"{name} is not for otter: it needs sideways thrust"):
        run(SCENARIOS[name], no_rig, tmp_path, vessel="otter")


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


@pytest.mark.parametrize("name", sorted(name for name, one in SCENARIOS.items() if "leader" in one.defaults))
def test_a_boat_that_its_leader_would_leave_behind_is_told_so(name: str, tmp_path: Path) -> None:
    with pytest.raises(
        ScenarioError, match=r"is not for heron: its leader sails [\d.]+ m/s.*try --set leader=\w+@1\.4"
    ):
        run(SCENARIOS[name], no_rig, tmp_path, vessel="heron")
    with pytest.raises(AssertionError, match="must not start"):
        run(SCENARIOS[name], no_rig, tmp_path, vessel="heron", changes={"leader": "straight@1.4"})
