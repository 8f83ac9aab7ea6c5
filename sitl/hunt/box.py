"""The box that a hunt searches in: weather, faults and differences that a boat should survive (`boxes.toml`)."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Protocol

from pydantic import Field, TypeAdapter

from companion.config.fields import STRICT
from companion.config.vessel import VesselConfig
from sitl.faults import known
from sitl.scenarios.scenario import Scenario
from sitl.sweep.design import RangeConfig, text_of
from sitl.sweep.plan import Run

_FILE = Path(__file__).with_name("boxes.toml")
_THRUSTER = "thruster_"
_SEEDS = 10
_MOST_FAULTS = 2
_STEP_DEG = 5
_SHARE = 0.5  # of the wind, left where waves are at their most


@dataclass(frozen=True, slots=True)
class WeatherBox:
    """The strongest weather, as shares of what a boat can do; see the file."""

    __pydantic_config__ = STRICT
    held: float
    current: float
    waves: float
    most_wind_mps: float
    most_current_mps: float


@dataclass(frozen=True, slots=True)
class SailingBox:
    """The weather of a boat under sail; `current`: as a share of the wind."""

    __pydantic_config__ = STRICT
    least_wind_mps: float
    most_wind_mps: float
    current: float


@dataclass(frozen=True, slots=True)
class ScenarioBox:
    """What of a scenario's own settings is varied, and what is fixed."""

    __pydantic_config__ = STRICT
    choices: dict[str, tuple[str, ...]] = field(default_factory=dict)
    ranges: dict[str, RangeConfig] = field(default_factory=dict)
    fixed: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Boxes:
    """The whole file."""

    __pydantic_config__ = STRICT
    weather: WeatherBox
    sailing: SailingBox
    errors: dict[str, float]
    faults: dict[str, float]
    scenarios: Annotated[dict[str, ScenarioBox], Field(alias="scenario")]


class Strength(Protocol):
    """What a boat can do, by its own file."""

    @property
    def top_speed_mps(self) -> float:
        """Through calm water."""
        ...

    def current_mps(self, most_mps: float, lost: frozenset[str]) -> float:
        """The current, up to that one, that it holds against in a calm without these thrusters."""
        ...

    def wind_mps(self, current_mps: float, lost: frozenset[str]) -> float:
        """The wind that it holds against in that current, without these thrusters; 0 where it holds against none."""
        ...


class Choices(Protocol):
    """Who chooses each value; optuna's Trial is one."""

    def suggest_float(self, name: str, low: float, high: float, *, log: bool = False) -> float:
        """A number."""
        ...

    def suggest_int(self, name: str, low: int, high: int) -> int:
        """A whole number."""
        ...

    def suggest_categorical(self, name: str, choices: Sequence[str]) -> Any:
        """One of these."""
        ...


@cache
def boxes() -> Boxes:
    """The file's contents."""
    return TypeAdapter(Boxes).validate_python(tomllib.loads(_FILE.read_text(encoding="utf-8")))


class Box:
    """The box of a scenario with a vessel. `faults`: whether there are any; `first_seed`: of ten."""

    def __init__(
        self,
        scenario: Scenario,
        vessel: str,
        config: VesselConfig,
        strength: Strength,
        *,
        faults: bool = True,
        first_seed: int = 0,
    ) -> None:
        self._scenario, self._vessel, self._strength = scenario, vessel, strength
        self._own = boxes().scenarios.get(scenario.name, ScenarioBox())
        self._first_seed, self._length_m, self._sails = first_seed, config.length_m, config.has_sail
        self.defaults: Mapping[str, str] = {**scenario.defaults, **scenario.by_vessel.get(vessel, {})}
        self.faults: Mapping[str, float] = dict(_faults_of(config, strength)) if faults else {}

    def draw(self, choices: Choices) -> Run:
        """A run of the box."""
        faults = [self._fault(choices, number) for number in range(self._count(choices))]
        lost = frozenset(name for fault in faults if (name := thruster_of(fault)))
        settings = {**self._own.fixed, **self._weather(choices, lost), **dict(self._differences(choices))}
        for name, words in self._own.choices.items():
            settings[name] = str(choices.suggest_categorical(name, words))
        for name, limits in self._own.ranges.items():
            settings[name] = text_of(round(choices.suggest_float(name, limits.low, limits.high), limits.digits))
        seed = self._first_seed + choices.suggest_int("seed", 0, _SEEDS - 1)
        return run_of(self._scenario.name, self._vessel, seed, settings, faults, self.defaults)

    def _count(self, choices: Choices) -> int:
        return choices.suggest_int("faults", 0, _MOST_FAULTS) if self.faults else 0

    def _fault(self, choices: Choices, number: int) -> str:
        name = str(choices.suggest_categorical(f"fault{number}", tuple(self.faults)))
        at_s = choices.suggest_int(f"at{number}", 3, round(self._scenario.lasts_s))
        lasts = choices.suggest_float(f"lasts{number}", 0.0, 1.0)
        return f"{name}@{at_s}+{max(1, round(self.faults[name] ** lasts))}"

    def _weather(self, choices: Choices, lost: frozenset[str]) -> dict[str, str]:
        """Wind, current and waves with their directions, together within what the boat can do."""
        limits, has = boxes().weather, self._scenario.defaults
        found: dict[str, str] = {}
        current_mps = waves = 0.0
        if "current" in has:
            current_mps = int(100.0 * choices.suggest_float("current", 0.0, 1.0) * self._most_current_mps(lost)) / 100.0
            found["current"] = _directed(current_mps, _direction(choices, "current_to"))
        if "waves" in has:
            waves = choices.suggest_float("waves", 0.0, 1.0)
            height_m = round(waves * limits.waves * self._length_m, 2)
            found["waves"] = _directed(height_m, _direction(choices, "waves_from"))
        if "wind" in has:
            wind_mps = self._wind_mps(choices.suggest_float("wind", 0.0, 1.0), current_mps, waves, lost)
            found["wind"] = _directed(int(10.0 * wind_mps) / 10.0, _direction(choices, "wind_from"))
        return found

    def _most_current_mps(self, lost: frozenset[str]) -> float:
        """The strongest current of the box; a boat under sail has it in the strongest wind."""
        limits, sailing = boxes().weather, boxes().sailing
        if self._sails:
            return sailing.current * sailing.most_wind_mps
        most_mps = min(limits.current * self._strength.top_speed_mps, limits.most_current_mps)
        return limits.held * self._strength.current_mps(most_mps, lost)

    def _wind_mps(self, share: float, current_mps: float, waves: float, lost: frozenset[str]) -> float:
        """The wind at that share of the box, in that current and that share of the highest waves. A boat under sail
        has at least what it needs for the current."""
        limits, sailing = boxes().weather, boxes().sailing
        if self._sails:
            least_mps = max(sailing.least_wind_mps, current_mps / sailing.current)
            return least_mps + share * (sailing.most_wind_mps - least_mps)
        most_mps = min(limits.held * self._strength.wind_mps(current_mps, lost), limits.most_wind_mps)
        return share * most_mps * (1.0 - (1.0 - _SHARE) * waves)

    def _differences(self, choices: Choices) -> Iterator[tuple[str, str]]:
        for name, most in boxes().errors.items():
            if name in self._scenario.defaults:
                low = -most if name == "model_error" else 0.0
                yield name, text_of(round(choices.suggest_float(name, low, most), 2))


def run_of(
    scenario: str,
    vessel: str,
    seed: int,
    settings: Mapping[str, str],
    faults: Sequence[str],
    defaults: Mapping[str, str],
) -> Run:
    """A run whose settings are only those that differ from the scenario's own."""
    changed = tuple(sorted((key, text) for key, text in settings.items() if text != defaults.get(key)))
    return Run(scenario, vessel, seed, changed, f"{scenario} {vessel}", {}, tuple(sorted(faults)))


def thruster_of(fault: str) -> str:
    """The thruster that a fault takes; empty where it takes none."""
    name = fault.partition("@")[0]
    return name.removeprefix(_THRUSTER).rpartition("_")[0] if name.startswith(_THRUSTER) else ""


def _directed(amount: float, degrees: int) -> str:
    """`2.5@90`; nothing where there is none of it."""
    return f"{text_of(amount)}@{degrees}" if amount else ""


def _direction(choices: Choices, name: str) -> int:
    return _STEP_DEG * choices.suggest_int(name, 0, 360 // _STEP_DEG - 1)


def _faults_of(config: VesselConfig, strength: Strength) -> Iterator[tuple[str, float]]:
    """Names of the faults that the box has for a vessel, with the longest time of each."""
    names = known(config)
    places = {
        "{sensor}": [sensor.name for sensor in config.sensors],
        "{board}": [bridge.name for bridge in config.actuators],
        "{thruster}": [one.name for one in config.thrusters if strength.wind_mps(0.0, frozenset({one.name})) > 0.0],
    }
    for pattern, most_s in boxes().faults.items():
        place = next((place for place in places if place in pattern), "")
        for device in places[place] if place else [""]:
            name = pattern.replace(place, device) if place else pattern
            if name in names:
                yield name, most_s
