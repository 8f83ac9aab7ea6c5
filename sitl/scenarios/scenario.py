"""A named scenario: its set-up, what its ground station does, what it measures and checks."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from companion.config.rough_water import ROUGH, USUAL
from companion.config.vessel import ConfigError, VesselConfig, find, load
from companion.core.nearest import did_you_mean
from sitl.environment import parse_directed
from sitl.scenarios.boat import Ability, magnetometer, other_hull, outrun, sailed_with
from sitl.scenarios.ground_station import GroundStation, GroundStationTimeout
from sitl.scenarios.measure import Check
from sitl.scenarios.rig import Composer, Conditions
from sitl.scenarios.safety import Margin, margins_of, violated
from sitl.scenarios.voyage import read_voyage
from sitl.sea_state import parse_sea
from sitl.tow import TowLeg

Settings = Mapping[str, str]

_OF_ALL: Settings = {"water": ""}
# Settings without which nothing would be sailed, or nothing judged.
_ABOVE_ZERO = frozenset(
    (
        "back", "box", "distance", "duration", "each", "end", "gap", "hold", "leg", "length", "line", "out", "outage",
        "run", "side", "spacing", "time", "turns", "wait", "watch",
    )
)  # fmt: skip
_NOT_BELOW_ZERO = frozenset(
    ("econ", "late", "latency", "loss", "onward", "pause", "radius", "rest", "settle", "speed", "stay")
)
_WHOLE = {"count": 0, "stones": 0, "transects": 1}  # the least


class ScenarioError(Exception):
    """A scenario that cannot be run as asked: an unknown name or key, an invalid value, or a boat that cannot do it."""


@dataclass(frozen=True, slots=True)
class Scenario:
    """`sail` plays the ground station, and returns what `measure` needs to know. `defaults`: the settings that it has,
    to which all scenarios' own are added; `by_vessel`: defaults for some vessels.

    `plot` draws into the folder, and raises ImportError without matplotlib. `tow`: legs along which the boat is towed.
    `prepare`: changes of the conditions beyond the settings that all scenarios share. `needs`: what it asks of a boat.
    `by_margins`: a run is good only where it violates no safety property, besides its checks. `lasts_s`: about how long
    it sails with its own settings; only for a display of the time that is left.
    """

    name: str
    text: str
    vessel: str
    defaults: Mapping[str, str]
    sail: Callable[[GroundStation, Settings], dict[str, Any]]
    measure: Callable[[Path, dict[str, Any], Settings], tuple[dict[str, float], Sequence[Check]]]
    by_vessel: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    plot: Callable[[Path, dict[str, Any], Settings], None] | None = None
    tow: Callable[[Settings], tuple[TowLeg, ...]] | None = None
    prepare: Callable[[Conditions, Settings], Conditions] | None = None
    needs: Sequence[Ability] = ()
    by_margins: bool = False
    lasts_s: float = 300.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "defaults", {**self.defaults, **_OF_ALL})


@dataclass(frozen=True, slots=True)
class ScenarioResult:
    """What a run gave; the same as in result.json. `hint`: what could not be drawn, and why. `margins`: of safety."""

    scenario: str
    ok: bool
    metrics: Mapping[str, float]
    checks: Sequence[Check]
    error: str | None
    hint: str = ""
    boat: str = ""  # which receiver, compass, plant and limits it was sailed with
    margins: Sequence[Margin] = ()


def run(
    scenario: Scenario,
    compose: Composer,
    folder: Path,
    seed: int = 0,
    vessel: str | None = None,
    changes: Settings | None = None,
    draw: bool = False,
    faults: Sequence[str] = (),
) -> ScenarioResult:
    """Run it, measure it, write result.json beside the log, and draw it if asked to.

    `faults`: more than the scenario's own, as `sitl.faults.parse` reads them. A run with them is good where no safety
    property is violated: its checks are about a boat without faults, and may not even be measured.

    Raises ScenarioError for settings that the scenario does not have, and for a boat that cannot do it; ConfigError for
    a fault that the boat cannot have.
    """
    config = load(find(vessel or scenario.vessel))
    settings = settings_for(scenario, vessel or scenario.vessel, config, changes or {})
    refused = refusal(scenario, config, settings)
    if refused is not None:
        raise ScenarioError(f"{scenario.name} is not for {config.name}: {refused}")
    unknown = set(settings) - set(scenario.defaults)
    if unknown:
        raise ScenarioError(
            f"{scenario.name} has no setting {', '.join(sorted(unknown))}; "
            f"it has {', '.join(sorted(scenario.defaults))}{did_you_mean(min(unknown), scenario.defaults)}"
        )
    _judge_numbers(scenario, settings)
    conditions = replace(
        _conditions(settings),
        vessel=vessel or scenario.vessel,
        seed=seed,
        tow=scenario.tow(settings) if scenario.tow else (),
    )
    if scenario.prepare is not None:
        conditions = scenario.prepare(conditions, settings)
    conditions = replace(conditions, faults=(*conditions.faults, *faults))
    rig = compose(conditions, folder)
    gcs = GroundStation(rig)
    error: str | None = None
    asked: dict[str, Any] = {}
    try:
        asked = scenario.sail(gcs, settings)
    except GroundStationTimeout as timeout:
        error = str(timeout)
    finally:
        rig.close()
    voyage = read_voyage(folder, rig, gcs.fences, gcs.ordered_s)
    margins = [] if voyage is None else margins_of(voyage)
    metrics, checks, error = ({}, (), error) if error else _measured(scenario, folder, asked, settings)
    hint = _draw(scenario, folder, asked, settings) if draw and error is None else ""
    safe, met = not violated(margins), error is None and all(check.ok for check in checks)
    good = safe if faults else met and (safe or not scenario.by_margins)
    outcome = ScenarioResult(
        scenario.name, good, metrics, checks, error, hint, sailed_with(config, conditions), margins
    )
    _write(folder, outcome, conditions, settings)
    return outcome


def refusal(scenario: Scenario, config: VesselConfig, settings: Settings) -> str | None:
    """Why the boat cannot do the scenario with these settings, in one sentence with the remedy; None where it can. A
    setting that is left out, since it is not known yet, refuses nothing. Raises ConfigError for a value that means
    nothing."""
    refused = next((text for ability in scenario.needs if (text := ability(config)) is not None), None)
    known = scenario.defaults.keys() & settings.keys()
    if refused is None and "leader" in known:
        refused = outrun(config, settings["leader"])
    if refused is None and "hull" in known:
        refused = other_hull(config, settings["hull"])
    if refused is None and settings.get("magnetometer"):
        refused = magnetometer(config)
    return refused


def _measured(
    scenario: Scenario, folder: Path, asked: dict[str, Any], settings: Settings
) -> tuple[dict[str, float], Sequence[Check], str | None]:
    """Metrics, checks, and why there are none: a run with faults, or of a boat that the scenario does not suit, may
    lack what it measures."""
    try:
        return *scenario.measure(folder, asked, settings), None
    except (ArithmeticError, LookupError, ValueError) as failure:
        missing = f"the run lacks what {scenario.name} measures ({failure!r}); its log shows what the boat did"
        return {}, (), f"not measured: {missing}"


def run_folder(folder: Path, name: str, seed: int) -> Path:
    """Where the run of one row of a table stays."""
    return folder / name.replace("/", " per ") / f"seed{seed}"


def settings_for(scenario: Scenario, vessel: str, config: VesselConfig, changes: Settings) -> dict[str, str]:
    """The settings in force. A boat that the scenario was not made for has the receiver of its own file."""
    own = scenario.by_vessel.get(vessel, {})
    settings = {**scenario.defaults, **own}
    if "gnss" in scenario.defaults and "gnss" not in own and vessel != scenario.vessel and config.sitl is not None:
        settings["gnss"] = config.sitl.gnss
    return {**settings, **changes}


def _draw(scenario: Scenario, folder: Path, asked: dict[str, Any], settings: Settings) -> str:
    """Draw. Returns a hint where matplotlib is not installed."""
    if scenario.plot is None:
        return ""
    try:
        scenario.plot(folder, asked, settings)
    except ImportError:
        return "no plot: matplotlib is not installed (pip install 'usv-companion[report]')"
    return ""


_CHOICES: Mapping[str, tuple[tuple[str, ...], Mapping[str, float]]] = {
    "path": (("PATH_KIND",), {"linear": 0, "pchip": 1, "makima": 2, "cubic": 3}),
    "law": (("DP_LAW", "WP_LAW", "FOLL_LAW"), {"companion": 0, "thesis": 1}),
    "control": (("PATH_CTRL",), {"pid": 0, "lqr": 1, "mpc": 2}),
    "ahrs": (("AHRS_LAW",), {"companion": 0, "thesis": 1}),
    "feedforward": (("DP_FF_KIND",), {"off": 0, "thesis": 1, "tuned": 2, "on": 3}),
    "action": (("CA_ACTION",), {"off": 0, "warn": 1, "slow": 2, "alter": 3}),
    "keeping": (("DP_UNDER",), {"bow": 0, "drift": 1}),
    "allocation": (("ALLOC_KIND",), {"constrained": 0, "unconstrained": 1}),
}

_THESIS_ALLOCATION = {"ALLOC_ITER": 1.0}  # one linearisation


def _conditions(settings: Settings) -> Conditions:
    parameters: dict[str, float] = {}
    for key, (names, values) in _CHOICES.items():
        if key in settings:
            parameters |= dict.fromkeys(names, _choice(settings, key, values))
    if settings.get("law") == "thesis" and "allocation" in settings:
        parameters |= _THESIS_ALLOCATION
    return Conditions(
        vessel="",
        wind=settings.get("wind") or None,
        current=settings.get("current") or None,
        gnss=settings.get("gnss", "rtk"),
        water=_word(settings, "water", ("", USUAL, ROUGH)) or None,
        waves=_waves(settings),
        wave_drift=bool(_choice(settings, "drift", {"off": 0, "on": 1})) if "drift" in settings else True,
        model_error=_model_error(settings),
        controller_model=settings.get("hull") or None,
        plant=settings.get("plant") or None,
        plant_error=number(settings, "plant_error"),
        windage_error=number(settings, "windage_error") if settings.get("windage_error") else None,
        push_ned_n=_push(settings),
        magnetometer=_word(settings, "magnetometer", ("", "calibrated", "raw")),
        wind_sensor=bool(_choice(settings, "anemometer", {"off": 0, "on": 1})) if "anemometer" in settings else False,
        ais="situation" in settings,
        rotating=("bow",) if "bow" in settings and _choice(settings, "bow", {"fixed": 0, "rotating": 1}) else (),
        parameters=parameters,
    )


def _choice(settings: Settings, key: str, values: Mapping[str, float]) -> float:
    """The number of a setting that is one of a few words. Empty words follow from the law and the route."""
    word = settings[key]
    if key == "path" and not word:  # as in the thesis
        word = "pchip" if settings.get("route") not in ("1", "2", None) else "linear"
    if key == "feedforward" and not word:
        word = "off" if settings.get("law") == "thesis" else "on"
    if word not in values:
        raise ScenarioError(f"{key}={word}: one of {', '.join(values)}")
    return values[word]


def _judge_numbers(scenario: Scenario, settings: Settings) -> None:
    """Raises ScenarioError for a setting that is no number, or one of which nothing would be sailed or judged. A
    setting that the scenario itself leaves out may be empty."""
    for key, text in settings.items():
        if key not in _ABOVE_ZERO | _NOT_BELOW_ZERO | _WHOLE.keys() or not (text or scenario.defaults[key]):
            continue
        if key in _WHOLE and not (text.isdecimal() and int(text) >= _WHOLE[key]):
            raise ScenarioError(f"{key}={text}: write a whole number, at least {_WHOLE[key]}")
        value = number(settings, key) if text else math.nan
        if not (value > 0.0 or (value == 0.0 and key not in _ABOVE_ZERO)):
            raise ScenarioError(f"{key}={text}: must be {'above' if key in _ABOVE_ZERO else 'at least'} 0")


def _model_error(settings: Settings) -> float:
    """Share by which the model is wrong: it keeps some inertia and damping."""
    share = number(settings, "model_error")
    if share <= -1.0:
        raise ScenarioError(f"model_error={settings['model_error']}: a share above -1, as -0.3 or 0.3")
    return share


def _word(settings: Settings, key: str, words: Sequence[str]) -> str:
    word = settings.get(key, "")
    if word not in words:
        raise ScenarioError(f"{key}={word}: one of {', '.join(filter(None, words))}, or nothing")
    return word


def _push(settings: Settings) -> tuple[float, float]:
    """Force towards (north, east) in N; `push=1.5@0` is 1.5 N from north."""
    text = settings.get("push")
    if not text:
        return 0.0, 0.0
    force_n, from_rad = parse_directed(text, "push")
    angle = from_rad or 0.0
    return -force_n * math.cos(angle), -force_n * math.sin(angle)


def _waves(settings: Settings) -> str | None:
    """The sea state, checked; None where it is left out: as the vessel's file says."""
    text = settings.get("waves") or None
    try:
        parse_sea(text or "")
    except ConfigError as error:
        raise ScenarioError(str(error)) from error
    return text


def number(settings: Settings, key: str) -> float:
    """The value of a setting that is a number; 0 where it is empty. Raises ScenarioError."""
    try:
        value = float(settings.get(key) or 0.0)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ScenarioError(f"{key}={settings[key]}: not a number")
    return value


def _write(folder: Path, outcome: ScenarioResult, conditions: Conditions, settings: Settings) -> None:
    result = {
        "scenario": outcome.scenario,
        "vessel": conditions.vessel,
        "boat": outcome.boat,
        "seed": conditions.seed,
        "settings": dict(settings),
        "faults": list(conditions.faults),
        "ok": outcome.ok,
        "error": outcome.error,
        "metrics": dict(outcome.metrics),
        "checks": [check.row() for check in outcome.checks],
        "margins": [margin.row() for margin in outcome.margins],
    }
    (folder / "result.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
