"""A named scenario: what it sets up, what it does as a ground station, what it measures and checks."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from sitl.scenarios.measure import Check
from sitl.scenarios.rig import Composer, Conditions
from sitl.scenarios.station import Station, StationTimeout

Settings = Mapping[str, str]


class ScenarioError(Exception):
    """A scenario that cannot be run as asked: an unknown name or key, a value that is none."""


@dataclass(frozen=True, slots=True)
class Scenario:
    """`sail` plays the ground station and returns what `measure` needs to know of what was asked of the boat."""

    name: str
    text: str
    vessel: str
    defaults: Mapping[str, str]
    sail: Callable[[Station, Settings], dict[str, Any]]
    measure: Callable[[Path, dict[str, Any], Settings], tuple[dict[str, float], Sequence[Check]]]


@dataclass(frozen=True, slots=True)
class Outcome:
    scenario: str
    ok: bool
    metrics: Mapping[str, float]
    checks: Sequence[Check]
    error: str | None


def run(
    scenario: Scenario, compose: Composer, folder: Path, seed: int = 0, vessel: str | None = None, changes: Settings | None = None
) -> Outcome:
    """Sail it, measure it, write result.json beside the log. Raises ScenarioError for settings that the scenario does not have."""
    settings = {**scenario.defaults, **(changes or {})}
    unknown = set(settings) - set(scenario.defaults)
    if unknown:
        raise ScenarioError(f"{scenario.name} has no setting {', '.join(sorted(unknown))}; it has {', '.join(sorted(scenario.defaults))}")
    conditions = replace(_conditions(settings), vessel=vessel or scenario.vessel, seed=seed)
    rig = compose(conditions, folder)
    error: str | None = None
    asked: dict[str, Any] = {}
    try:
        asked = scenario.sail(Station(rig), settings)
    except StationTimeout as timeout:
        error = str(timeout)
    finally:
        rig.close()
    metrics: dict[str, float] = {}
    checks: Sequence[Check] = ()
    if error is None:
        metrics, checks = scenario.measure(folder, asked, settings)
    outcome = Outcome(scenario.name, error is None and all(check.ok for check in checks), metrics, checks, error)
    _write(folder, outcome, conditions, settings)
    return outcome


def _conditions(settings: Settings) -> Conditions:
    path_kinds = {"linear": 0, "pchip": 1, "makima": 2, "cubic": 3}
    parameters: dict[str, float] = {}
    if "path" in settings:
        if settings["path"] not in path_kinds:
            raise ScenarioError(f"path={settings['path']}: one of {', '.join(path_kinds)}")
        parameters["PATH_KIND"] = path_kinds[settings["path"]]
    return Conditions(
        vessel="",
        wind=settings.get("wind") or None,
        current=settings.get("current") or None,
        gnss=settings.get("gnss", "rtk"),
        waves_m=_number(settings, "waves"),
        model_error=_number(settings, "model_error"),
        hull=settings.get("hull") or None,
        parameters=parameters,
    )


def _number(settings: Settings, key: str) -> float:
    try:
        return float(settings.get(key) or 0.0)
    except ValueError as error:
        raise ScenarioError(f"{key}={settings[key]}: not a number") from error


def _write(folder: Path, outcome: Outcome, conditions: Conditions, settings: Settings) -> None:
    result = {
        "scenario": outcome.scenario,
        "vessel": conditions.vessel,
        "seed": conditions.seed,
        "settings": dict(settings),
        "ok": outcome.ok,
        "error": outcome.error,
        "metrics": dict(outcome.metrics),
        "checks": [check.row() for check in outcome.checks],
    }
    (folder / "result.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
