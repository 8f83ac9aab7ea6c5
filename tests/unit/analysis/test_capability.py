"""The wind that a boat holds against, by the balance of forces."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from companion.analysis.capability import MOST_MPS, capability
from companion.app import load_vessel
from companion.cli.main import main
from companion.config.vessel import ConfigError

REVOLT = load_vessel("revolt")
PRESSURE = 0.5 * 1.225


def test_from_ahead_it_is_the_limit_over_the_frontal_area() -> None:
    found = capability(REVOLT, directions=2)
    w = REVOLT.windage
    assert found.wind_mps[0] == pytest.approx(math.sqrt(50.0 / (PRESSURE * w.cx * w.frontal_m2)), abs=0.2)
    assert found.wind_mps[1] == pytest.approx(found.wind_mps[0], abs=0.2)


def test_from_the_side_it_is_the_side_force() -> None:
    found = capability(REVOLT, directions=4)
    w = REVOLT.windage
    assert found.wind_mps[1] == pytest.approx(
        math.sqrt(REVOLT.limits.sway_n / (PRESSURE * w.cy * w.lateral_m2)), abs=0.5
    )
    assert found.least_mps == min(found.wind_mps)


def test_a_lost_thruster_and_a_current_take_some_of_it() -> None:
    whole, lost = (capability(REVOLT, names, directions=4) for names in ((), ("bow",)))
    assert lost.wind_mps[1] < 0.7 * whole.wind_mps[1] and lost.lost == ("bow",)
    carried = capability(REVOLT, (), 0.5, directions=4)
    assert carried.wind_mps[0] < whole.wind_mps[0]
    assert capability(REVOLT, (), 3.0, directions=2).wind_mps == (0.0, 0.0)


def test_the_solver_allocates_as_the_vessels_file_says() -> None:
    """The pseudo-inverse, cut to the limits, leaves thrust unused; the constrained one was asked for any file."""
    inverse = replace(REVOLT, parameters={**REVOLT.parameters, "ALLOC_KIND": 1.0})
    best, cut = (capability(boat, directions=4).least_mps for boat in (REVOLT, inverse))
    assert cut < 0.95 * best


def test_a_light_breeze_on_a_small_area_is_always_held() -> None:
    small = replace(REVOLT, windage=replace(REVOLT.windage, frontal_m2=1e-4, lateral_m2=1e-4))
    assert capability(small, directions=3).wind_mps == (MOST_MPS,) * 3


def test_a_boat_without_sideways_thrust_holds_against_none_from_the_side(capsys: pytest.CaptureFixture[str]) -> None:
    """It was said to hold against 2 m/s from every direction, which the solver's tolerance alone gave."""
    ahead, *aside, astern = capability(load_vessel("blueboat"), directions=4).wind_mps[:3]
    assert ahead > 10.0 and aside == [0.0] and astern > 10.0
    assert main(["capability", "blueboat"]) == 0
    said = capsys.readouterr().out
    assert "from every direction" not in said and "it turns its bow to the wind" in said


def test_what_cannot_be_asked() -> None:
    for vessel, lost, said in (
        (REVOLT, ("keel",), "no thruster named keel"),
        (load_vessel("rescuerunner"), (), "a jet pushes only ahead"),
        (load_vessel("cybership2"), (), "gives no areas"),
    ):
        with pytest.raises(ConfigError, match=said):
            capability(vessel, lost)


def test_the_command_prints_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["capability", "aboat", "--lost", "bow", "--current", "0.3"]) == 0
    assert "wind held at a fixed heading without bow, current 0.3 m/s" in capsys.readouterr().out
