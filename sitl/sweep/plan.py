"""A design as the runs that it asks for, in the order in which they are sailed."""

from __future__ import annotations

import hashlib
import itertools
import json
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

from scipy.stats import qmc

from companion.config.overlay import that_count
from companion.config.vessel import ConfigError, bundled, find
from sitl.scenarios.scenario import Scenario
from sitl.sweep.design import DesignConfig, PartConfig, Value, fields_in, text_of


@dataclass(frozen=True, slots=True)
class Run:
    """One scenario on one seed. `settings`: what differs from the scenario's own, in order of their names. `point`: the
    design point in words, without what is sampled. `factors`: what was sampled, by name. `faults`: besides the
    scenario's own."""

    scenario: str
    vessel: str
    seed: int
    settings: tuple[tuple[str, str], ...] = ()
    point: str = ""
    factors: Mapping[str, float] = field(default_factory=dict, compare=False)
    faults: tuple[str, ...] = ()

    @property
    def words(self) -> list[str]:
        """The command that repeats it, without the program's name."""
        changes = [word for key, value in self.settings for word in ("--set", f"{key}={value}")]
        faults = [word for fault in self.faults for word in ("--fault", fault)]
        return ["scenario", "run", self.scenario, "--vessel", self.vessel, "--seed", str(self.seed), *changes, *faults]

    @property
    def command(self) -> str:
        """The command that repeats it, as a person types it."""
        return f"companion {shlex.join(self.words)}"


def key_of(run: Run) -> str:
    """What tells a run from all others: 16 hexadecimal digits. A vessel that is a file counts with its contents."""
    text = json.dumps([run.scenario, run.vessel, contents_of(run.vessel), run.seed, run.settings, run.faults])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def vessel_changed(key: str, run: Run) -> bool:
    """Whether `run`, sailed under that key, had a vessel whose file says something else now, or is gone."""
    try:
        return key_of(run) != key
    except (ConfigError, OSError):
        return True


@cache
def contents_of(vessel: str) -> str:
    """A digest of a vessel's own file, and of the trials' overlays that count; empty for a bundled one without an
    overlay, which the commit names."""
    file = find(vessel)
    own = b"" if vessel in bundled() else file.read_bytes()
    data = own + b"".join(overlay.read_bytes() for overlay in that_count(file))
    return hashlib.sha256(data).hexdigest() if data else ""


def runs_of(design: DesignConfig, scenarios: Mapping[str, Scenario]) -> list[Run]:
    """All runs, each once. The first seed of every point comes before the second of any, and a sample with all levels
    before the next sample, so that a sweep that is cut off has equally many of each, and pairs."""
    by_part = [(list(_points(part, scenarios)), _seeds(design, part)) for part in design.parts]
    most = max(len(seeds) for _, seeds in by_part)
    ordered = (
        Run(point.scenario, point.vessel, seeds[number], point.settings, point.point, point.factors)
        for number in range(most)
        for points, seeds in by_part
        if number < len(seeds)
        for point in points
    )
    found: dict[tuple[object, ...], Run] = {}
    for run in ordered:
        found.setdefault((run.scenario, run.vessel, run.seed, run.settings), run)
    return list(found.values())


def sampled(part: PartConfig) -> list[dict[str, float]]:
    """The values of the factors with a range, a row a sample; one empty row where there are none. The same file gives
    the same samples. Source: scipy.stats.qmc; a Sobol sequence is scrambled after Owen (1998)."""
    if not part.ranges or part.samples is None:
        return [{}]
    kind = qmc.Sobol if part.sampling == "sobol" else qmc.LatinHypercube
    unit = kind(len(part.ranges), rng=part.sampling_seed).random(part.samples)
    limits = list(part.ranges.values())
    scaled = qmc.scale(unit, [one.low for one in limits], [one.high for one in limits])
    return [
        {name: round(float(value), one.digits) for (name, one), value in zip(part.ranges.items(), row, strict=True)}
        for row in scaled
    ]


def _seeds(design: DesignConfig, part: PartConfig) -> range:
    first = design.first_seed if part.first_seed is None else part.first_seed
    return range(first, first + (design.seeds if part.seeds is None else part.seeds))


def _points(part: PartConfig, scenarios: Mapping[str, Scenario]) -> Iterator[Run]:
    for sample in sampled(part):
        for name in part.scenarios:
            for vessel in part.vessels or (scenarios[name].vessel,):
                for levels in _crossed(part.levels):
                    settings = _settings(part, levels, sample)
                    yield Run(name, vessel, 0, settings, _words(part, name, vessel, levels), sample)


def _crossed(levels: Mapping[str, Sequence[Value]]) -> Iterator[dict[str, Value]]:
    for values in itertools.product(*levels.values()):
        yield dict(zip(levels, values, strict=True))


def _settings(
    part: PartConfig, levels: Mapping[str, Value], sample: Mapping[str, float]
) -> tuple[tuple[str, str], ...]:
    factors = {name: text_of(value) for name, value in {**levels, **sample}.items()}
    texts = {key: text_of(value) for key, value in part.settings.items()}
    used = {name for text in texts.values() for name in fields_in(text)}
    own = {name: text for name, text in factors.items() if name not in used}
    return tuple(sorted({**own, **{key: text.format_map(factors) for key, text in texts.items()}}.items()))


def _words(part: PartConfig, scenario: str, vessel: str, levels: Mapping[str, Value]) -> str:
    """A point in words: fixed settings that hold no sampled factor, then the levels."""
    fixed = {
        key: text_of(value)
        for key, value in part.settings.items()
        if not set(fields_in(text_of(value))) & (part.ranges.keys() | part.levels.keys())
    }
    varied = {name: text_of(value) for name, value in levels.items()}
    return " ".join((scenario, vessel, *(f"{key}={value}" for key, value in {**fixed, **varied}.items())))
