"""A sweep's TOML → frozen dataclasses: which scenarios, vessels, settings and seeds, with every error of the file at
once and its place.

A *factor* is what the design varies. Factors with `levels` are crossed: every level with every other. Factors with a
`range` are sampled together, by a Latin hypercube or a Sobol sequence. A factor that has the name of a scenario's
setting is that setting; any other stands in braces in the text of a setting, as `wind = "{speed}@{from}"`.
"""

from __future__ import annotations

import string
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal

from pydantic import Field

from companion.config.fields import STRICT, Name, Positive, means
from companion.config.vessel import ConfigError, VesselConfig, find, load, validated
from companion.core.nearest import did_you_mean
from sitl.scenarios.scenario import Scenario, refusal, settings_for

Value = str | float | int | bool
Problem = tuple[Sequence[str | int], str]


@dataclass(frozen=True, slots=True)
class RangeConfig:
    """A factor between two values, rounded to `digits` decimals: so a person can type what a run was sailed with."""

    __pydantic_config__ = STRICT
    low: Annotated[float, means("Lowest value.")]
    high: Annotated[float, means("Highest value.")]
    digits: Annotated[int, Field(ge=0, le=12), means("Decimals of a value.")] = 3


@dataclass(frozen=True, slots=True)
class PartConfig:
    """A part of a design: scenarios × vessels × levels × samples × seeds."""

    __pydantic_config__ = STRICT
    scenarios: Annotated[
        tuple[str, ...], Field(min_length=1), means("Names of scenarios, as `companion scenario list` shows them.")
    ]
    vessels: Annotated[
        tuple[str, ...],
        means("Bundled names or paths of TOML files. Left out: the one that each scenario is made for."),
    ] = ()
    seeds: Annotated[int | None, Field(ge=1), means("How many seeds. Left out: as of the whole design.")] = None
    first_seed: Annotated[int | None, Field(ge=0), means("The first seed. Left out: as of the whole design.")] = None
    settings: Annotated[
        dict[str, Value], Field(alias="set"), means("Settings that all runs share; `{name}` stands for a factor.")
    ] = field(default_factory=dict)
    levels: Annotated[
        dict[str, tuple[Value, ...]], means("Factors with a few values each; every one with every other.")
    ] = field(default_factory=dict)
    ranges: Annotated[
        dict[str, RangeConfig], Field(alias="range"), means("Factors that are sampled between two values.")
    ] = field(default_factory=dict)
    sampling: Annotated[Literal["latin_hypercube", "sobol"], means("How the ranges are sampled.")] = "latin_hypercube"
    samples: Annotated[
        int | None, Field(ge=1), means("How many points of the ranges; of a Sobol sequence a power of two.")
    ] = None
    sampling_seed: Annotated[int, Field(ge=0), means("Seed of the sampling.")] = 0


@dataclass(frozen=True, slots=True)
class DesignConfig:
    """A whole sweep."""

    __pydantic_config__ = STRICT
    name: Annotated[Name, means("Name of the sweep. Its folder has it.")]
    parts: Annotated[
        tuple[PartConfig, ...], Field(alias="part", min_length=1), means("What is sailed: one table or several.")
    ]
    text: Annotated[str, means("What it is for. The report shows it.")] = ""
    seeds: Annotated[int, Field(ge=1), means("How many seeds each point is sailed with.")] = 1
    first_seed: Annotated[int, Field(ge=0), means("The first seed.")] = 0
    minutes: Annotated[Positive | None, means("No run is begun after this time. Left out: no limit.")] = None


def parse_design(text: str, place: str, scenarios: Mapping[str, Scenario]) -> DesignConfig:
    """The design in `text`. `place` names the text in messages; `scenarios`: those that there are, by name. Raises
    ConfigError with every problem."""
    design, located = validated(DesignConfig, text, place)
    problems = [
        ((*("part", number), *loc), message)
        for number, part in enumerate(design.parts)
        for loc, message in _part_problems(part, scenarios)
    ]
    if problems:
        raise ConfigError([located(loc, message) for loc, message in problems])
    return design


def fields_in(text: str) -> list[str]:
    """Names in braces. Raises ValueError for braces that do not close, or that hold more than a name."""
    parts = [
        (name, form, conversion) for _, name, form, conversion in string.Formatter().parse(text) if name is not None
    ]
    if any(form or conversion for _, form, conversion in parts):
        raise ValueError("braces hold more than a name")
    return [name for name, _, _ in parts]


def text_of(value: Value) -> str:
    """A value as `--set KEY=VALUE` takes it."""
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:.12g}" if isinstance(value, float) else str(value)


# --- what is wrong with a part -------------------------------------------------------------------------------------


def _part_problems(part: PartConfig, scenarios: Mapping[str, Scenario]) -> Iterator[Problem]:
    yield from _range_problems(part)
    yield from _level_problems(part)
    vessels: dict[str, VesselConfig] = {}
    for vessel in part.vessels:
        try:
            vessels[vessel] = load(find(vessel))
        except ConfigError as error:
            yield from ((("vessels",), problem) for problem in error.problems)
    known: list[Scenario] = []
    for name in dict.fromkeys(part.scenarios):
        if name in scenarios:
            known.append(scenarios[name])
        else:
            yield (
                ("scenarios",),
                f"no scenario '{name}'; there is {', '.join(scenarios)}{did_you_mean(name, scenarios)}",
            )
    yield from _twice(part)
    yield from _setting_problems(part, known)
    for scenario in known:
        yield from _boat_problems(part, scenario, vessels)


def _range_problems(part: PartConfig) -> Iterator[Problem]:
    for name, limits in part.ranges.items():
        if limits.low >= limits.high:
            yield ("range", name, "high"), f"{limits.high:g} is not above low = {limits.low:g}"
        for key, end in (("low", limits.low), ("high", limits.high)):  # else rounding leaves the range
            if round(end, limits.digits) != end:
                yield ("range", name, key), f"{end:g} has more decimals than digits = {limits.digits}"
        if name in part.levels:
            yield ("range", name), "stands in levels too; a factor has either"
    yield from _sample_problems(part)


def _sample_problems(part: PartConfig) -> Iterator[Problem]:
    if part.ranges and part.samples is None:
        yield ("samples",), "is missing: how many points of the ranges are sampled"
    if not part.ranges and part.samples is not None:
        yield ("samples",), "there is no range to sample; add a [part.range] or leave this out"
    if part.sampling == "sobol" and part.samples is not None and part.samples & (part.samples - 1):
        above = 1 << part.samples.bit_length()
        yield (
            ("samples",),
            f"{part.samples} is no power of two, by which a Sobol sequence is balanced; take {above >> 1} or {above}",
        )


def _level_problems(part: PartConfig) -> Iterator[Problem]:
    for name, levels in part.levels.items():
        texts = [text_of(level) for level in levels]
        if not texts:
            yield ("levels", name), "needs at least one value"
        for text in dict.fromkeys(text for text in texts if texts.count(text) > 1):
            yield ("levels", name), f"'{text}' stands there twice"


def _twice(part: PartConfig) -> Iterator[Problem]:
    for key, names in (("scenarios", part.scenarios), ("vessels", part.vessels)):
        for name in dict.fromkeys(name for name in names if names.count(name) > 1):
            yield (key,), f"'{name}' stands there twice"


def _setting_problems(part: PartConfig, scenarios: Sequence[Scenario]) -> Iterator[Problem]:
    factors = {**dict.fromkeys(part.levels, "levels"), **dict.fromkeys(part.ranges, "range")}
    used: set[str] = set()
    for key, value in part.settings.items():
        if key in factors:
            yield ("set", key), f"is a factor in {factors[key]} too; leave one out"
        try:
            names = fields_in(text_of(value))
        except ValueError as error:
            yield ("set", key), f"{error}; write a factor as {{name}}"
            continue
        used |= set(names)
        strangers = [name for name in names if name not in factors]
        yield from ((("set", key), f"no factor '{n}' in levels or range{did_you_mean(n, factors)}") for n in strangers)
    own = {name: table for name, table in factors.items() if name not in used}
    for name, table in {**own, **dict.fromkeys(part.settings, "set")}.items():
        yield from (((table, name), problem) for problem in _unknown(name, scenarios, table))


def _unknown(name: str, scenarios: Sequence[Scenario], table: str) -> Iterator[str]:
    """Scenarios that do not have a setting of that name."""
    lacking = [scenario for scenario in scenarios if name not in scenario.defaults]
    if lacking:
        keys = lacking[0].defaults
        names = ", ".join(scenario.name for scenario in lacking)
        other = "" if table == "set" else f", and no setting has {{{name}}}"
        meant = did_you_mean(name, keys)
        yield f"{names} has no such setting{other}; {lacking[0].name} has {', '.join(sorted(keys))}{meant}"


def _boat_problems(part: PartConfig, scenario: Scenario, vessels: Mapping[str, VesselConfig]) -> Iterator[Problem]:
    """Boats that the scenario refuses, those of one reason in one line."""
    refused: dict[str, list[str]] = {}
    for vessel, config in (vessels or {scenario.vessel: load(find(scenario.vessel))}).items():
        text = _refusal_of_any(part, scenario, vessel, config)
        if text is not None:
            refused.setdefault(text, []).append(vessel)
    for text, names in refused.items():
        yield ("scenarios",), f"{scenario.name} is not for {', '.join(names)}: {text}"


def _refusal_of_any(part: PartConfig, scenario: Scenario, vessel: str, config: VesselConfig) -> str | None:
    """Why it refuses the boat with the settings, or with one of the levels, of the part."""
    settings = settings_for(scenario, vessel, config, {key: text_of(v) for key, v in part.settings.items()})
    varied = {*part.levels, *part.ranges, *(key for key, text in settings.items() if "{" in text)}
    fixed = {key: text for key, text in settings.items() if key not in varied}
    levels = ({**fixed, name: text_of(level)} for name, values in part.levels.items() for level in values)
    refused = (_refusal(scenario, config, each) for each in (fixed, *levels))
    return next((text for text in refused if text is not None), None)


def _refusal(scenario: Scenario, config: VesselConfig, settings: Mapping[str, str]) -> str | None:
    try:
        return refusal(scenario, config, settings)
    except ConfigError as error:
        return error.problems[0]
