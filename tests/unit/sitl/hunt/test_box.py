"""What a hunt's box holds: fair weather, fair faults, settings that the scenario has."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import Any

import pytest

from companion.config.vessel import find, load
from sitl.faults import parse
from sitl.hunt.box import Box, boxes, thruster_of
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import settings_for
from sitl.sweep.plan import Run
from tests.unit.sitl.hunt.made import Strong, box


class Dice:
    """Chooses at random; a `Choices`."""

    def __init__(self, seed: int) -> None:
        self._random = Random(seed)

    def suggest_float(self, name: str, low: float, high: float, *, log: bool = False) -> float:
        return self._random.uniform(low, high)

    def suggest_int(self, name: str, low: int, high: int) -> int:
        return self._random.randint(low, high)

    def suggest_categorical(self, name: str, choices: Sequence[str]) -> Any:
        return self._random.choice(choices)


def drawn(name: str, count: int = 60, vessel: str | None = None) -> list[Run]:
    made = box(name, vessel or SCENARIOS[name].vessel)
    return [made.draw(Dice(seed)) for seed in range(count)]


def amount(run: Run, key: str) -> float:
    return float(dict(run.settings).get(key, SCENARIOS[run.scenario].defaults[key]).partition("@")[0] or 0.0)


@pytest.mark.parametrize("name", sorted({*boxes().scenarios, "hold", "docking", "homecoming"}))
def test_every_run_can_be_asked_for(name: str) -> None:
    scenario, config = SCENARIOS[name], load(find(SCENARIOS[name].vessel))
    for run in drawn(name, 30):
        assert set(settings_for(scenario, run.vessel, config, dict(run.settings))) == set(scenario.defaults)
        for fault in run.faults:
            assert parse(fault, config).end_s < 1e4
        assert all(text != scenario.defaults[key] for key, text in run.settings)


def test_weather_is_within_what_the_boat_holds_with_what_it_has_left() -> None:
    runs = drawn("hold", 400)
    whole = [amount(run, "wind") for run in runs if not any(map(thruster_of, run.faults))]
    crippled = [amount(run, "wind") for run in runs if any(map(thruster_of, run.faults))]
    assert 6.0 < max(whole) <= 8.0 and 3.0 < max(crippled) <= 4.0
    assert 0.15 < max(amount(run, "current") for run in runs) <= 0.24
    assert max(amount(run, "waves") for run in runs) <= 0.09


def test_a_boat_under_sail_has_the_wind_that_it_needs() -> None:
    runs = drawn("sail_triangle", 200)
    winds = [amount(run, "wind") for run in runs]
    assert 3.0 <= min(winds) < 4.0 and 7.0 < max(winds) <= 8.0
    assert max(amount(run, "current") for run in runs) > 0.15
    assert all(amount(run, "current") <= 0.03 * (amount(run, "wind") + 0.1) for run in runs)


def test_no_fault_lasts_longer_than_is_fair() -> None:
    most = box().faults
    for run in drawn("hold", 200):
        for fault in run.faults:
            name, _, times = fault.partition("@")
            assert 1 <= int(times.partition("+")[2]) <= most[name]


def test_a_boat_that_needs_every_thruster_loses_none() -> None:
    class Weak(Strong):
        def wind_mps(self, current_mps: float, lost: frozenset[str]) -> float:
            return 0.0 if lost else 10.0

    config = load(find("otter"))
    faults = Box(SCENARIOS["bow_hold"], "otter", config, Weak()).faults
    assert faults and not any(map(thruster_of, faults))
    assert any(map(thruster_of, box("bow_hold", "otter").faults))


def test_without_faults_there_are_none() -> None:
    made = box(faults=False)
    assert not any(made.draw(Dice(seed)).faults for seed in range(30))


def test_the_file_names_scenarios_and_settings_that_there_are() -> None:
    for name, own in boxes().scenarios.items():
        assert {*own.choices, *own.ranges, *own.fixed} <= SCENARIOS[name].defaults.keys()
