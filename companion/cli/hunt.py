"""`companion hunt SCENARIO`: the run that comes nearest to a violated safety property, and its smallest case."""

from __future__ import annotations

import argparse
import json
import math
import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from companion.analysis.capability import capability
from companion.cli.common import UsageError
from companion.cli.crew import Ending, add_crew_to, refuse_other_code, sail_to_the_end, workers_of
from companion.cli.progress import bar
from companion.cli.sweep import sail
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import ConfigError, VesselConfig, find, load
from companion.core.nearest import did_you_mean
from companion.core.progress import Told

if TYPE_CHECKING:
    from sitl.hunt.box import Box
    from sitl.hunt.hunting import Finding
    from sitl.hunt.search import Search
    from sitl.scenarios.scenario import Scenario
    from sitl.sweep.plan import Run
    from sitl.sweep.rows import Journal, Row
    from sitl.sweep.sailing import Sail, Workers

_HUNTS = Path("out") / "hunts"
_MINUTES = 10.0
_SEEDS = 2**31  # numpy's generator takes twice as many; a search counts its own up from it
_HELD_MPS = 8.0  # wind for a boat that has no capability: jets and rudders keep a circle, not a point
_DIRECTIONS, _STEP_MPS = 12, 0.02
FINDINGS = "findings.json"


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    hunt = commands.add_parser(
        "hunt", help="search weather, faults and errors of the model for a run that violates a safety property"
    )
    hunt.add_argument("name", metavar="SCENARIO")
    hunt.add_argument("--vessel", metavar="V", help="default: the one that the scenario is made for")
    hunt.add_argument("--property", metavar="NAME", dest="prop", help="search for this one alone")
    hunt.add_argument("--no-faults", action="store_true", help="weather and errors of the model alone")
    hunt.add_argument("--seed", type=int, default=0, help="seed of the search")
    hunt.add_argument("--first-seed", type=int, default=0, metavar="N", help="first of the ten seeds that it sails")
    hunt.add_argument("--minutes", type=float, metavar="M", help=f"begin no run after this time (usually {_MINUTES:g})")
    hunt.add_argument("--runs", type=int, metavar="N", help="sail so many runs, however long that takes")
    hunt.add_argument("--out", type=Path, metavar="DIR", help="folder of the hunt; default: out/hunts/NAME/COMMIT")
    add_crew_to(hunt)
    hunt.set_defaults(command=_hunt)


class BoatStrength:
    """What `companion capability` says of a boat; a `sitl.hunt.box.Strength`. A boat without sideways thrust lies with
    its bow in the wind, so that direction counts."""

    def __init__(self, config: VesselConfig, interrupted: Callable[[], bool] = lambda: False) -> None:
        """`interrupted`: whether to end now, since this may take long: then KeyboardInterrupt is raised."""
        self._config = config
        self._interrupted = interrupted
        self._winds: dict[tuple[float, frozenset[str]], float] = {}

    @property
    def top_speed_mps(self) -> float:
        """Through calm water."""
        return top_speed_mps(self._config)

    def wind_mps(self, current_mps: float, lost: frozenset[str]) -> float:
        """See `Strength`. The current comes from where the wind comes from, in steps of 0.02 m/s."""
        key = math.ceil(round(current_mps / _STEP_MPS, 6)) * _STEP_MPS, lost
        if key not in self._winds:
            self._winds[key] = self._held_mps(*key)
        return self._winds[key]

    def current_mps(self, most_mps: float, lost: frozenset[str]) -> float:
        """See `Strength`."""
        low, high = 0, int(most_mps / _STEP_MPS)
        while low < high:
            middle = (low + high + 1) // 2
            low, high = (middle, high) if self.wind_mps(middle * _STEP_MPS, lost) > 0.0 else (low, middle - 1)
        return low * _STEP_MPS

    def _held_mps(self, current_mps: float, lost: frozenset[str]) -> float:
        if self._interrupted():
            raise KeyboardInterrupt
        try:
            found = capability(self._config, sorted(lost), current_mps, _DIRECTIONS)
        except ConfigError:
            return 0.0 if lost else _HELD_MPS
        if self._config.limits.sway_n > 0.0:
            return found.least_mps
        return 0.0 if lost else found.wind_mps[0]


def _hunt(arguments: argparse.Namespace) -> int:
    """Exit code 0 where no property is violated, else 1."""
    if arguments.runs is not None and arguments.runs < 1:
        raise UsageError(f"--runs {arguments.runs}: must be at least 1")
    if not 0 <= arguments.seed < _SEEDS:
        raise UsageError(f"--seed {arguments.seed}: 0 to {_SEEDS - 1}")
    minutes = arguments.minutes
    arguments.minutes = _MINUTES if minutes is None and arguments.runs is None else minutes
    return sail_to_the_end(arguments, lambda interrupted: hunt(arguments, sail, interrupted))


def hunt(arguments: argparse.Namespace, sail: Sail, interrupted: Callable[[], bool]) -> int:
    """`companion hunt` with its arguments. `sail`: how a run is sailed; `interrupted`: whether to end now. Raises
    ConfigError, SweepError, UsageError, OSError."""
    from sitl.hunt.search import Search
    from sitl.sweep.provenance import commit
    from sitl.sweep.rows import PARQUET, Journal, arrow, write_parquet

    arrow()
    scenario = _known(arguments.name)
    vessel = arguments.vessel or scenario.vessel
    box = _box(arguments, scenario, vessel, interrupted)
    search = Search(box, arguments.seed, arguments.prop)
    name = scenario.name if vessel == scenario.vessel else f"{scenario.name}-{Path(vessel).stem}"
    folder = arguments.out or _HUNTS / name / commit()
    with Journal(folder) as journal:
        refuse_other_code(journal, folder, commit())
        print(f"hunt {scenario.name} with {vessel}: {folder}", flush=True)
        try:
            findings, rows = _hunted(arguments, sail, Ending(arguments.minutes, interrupted), journal, search, box)
        finally:
            write_parquet(journal.rows.values(), folder / PARQUET)
    (folder / FINDINGS).write_text(
        json.dumps([finding.row() for finding in findings], indent=1) + "\n", encoding="utf-8"
    )
    _tell(rows, findings, "; interrupted: the same command goes on from here" if interrupted() else "")
    print(f"written: {folder / PARQUET}, {folder / FINDINGS}")
    return 1 if findings else 0


def _known(name: str) -> Scenario:
    from sitl.scenarios import SCENARIOS

    if name not in SCENARIOS:
        raise UsageError(f"no scenario '{name}'; there is {', '.join(SCENARIOS)}{did_you_mean(name, SCENARIOS)}")
    return SCENARIOS[name]


def _box(arguments: argparse.Namespace, scenario: Scenario, vessel: str, interrupted: Callable[[], bool]) -> Box:
    """The box. Raises ConfigError for a vessel file with errors, UsageError for a boat that cannot do the scenario."""
    from sitl.hunt.box import Box
    from sitl.hunt.search import BROKE_OFF
    from sitl.scenarios.safety import PROPERTIES
    from sitl.scenarios.scenario import refusal, settings_for

    if arguments.prop is not None and arguments.prop not in (names := (*PROPERTIES, BROKE_OFF)):
        raise UsageError(f"--property {arguments.prop}: one of {', '.join(names)}")
    config = load(find(vessel))
    refused = refusal(scenario, config, settings_for(scenario, vessel, config, {}))
    if refused is not None:
        raise UsageError(f"{scenario.name} is not for {config.name}: {refused}")
    strength = BoatStrength(config, interrupted)
    return Box(scenario, vessel, config, strength, faults=not arguments.no_faults, first_seed=arguments.first_seed)


def _hunted(
    arguments: argparse.Namespace, sail: Sail, ending: Ending, journal: Journal, search: Search, box: Box
) -> tuple[list[Finding], Sequence[Row]]:
    """What was found, and all rows."""
    from sitl.hunt.hunting import Sailor, hunt
    from sitl.sweep.local import cores

    jobs = arguments.jobs or cores()
    with workers_of(arguments, sail, journal.folder, jobs) as workers, bar("hunt", time_left=False) as told:
        progress = HuntProgress(told, arguments.minutes, arguments.runs, time.monotonic(), arguments.keep)

        def sail_some(runs: Sequence[Run]) -> Sequence[Row]:
            return _sailed(runs, workers, journal, ending, progress)

        sailor = Sailor(sail_some, arguments.runs)
        findings = hunt(search, sailor, box.defaults, workers.places, progress.find)
    return findings, sailor.rows


def _sailed(
    runs: Sequence[Run], workers: Workers, journal: Journal, ending: Ending, progress: HuntProgress
) -> Sequence[Row]:
    """The rows of runs: of those that were sailed before at once; without the last ones where the time is over. Logs go
    with their runs' commands, which make them anew, unless they are asked for."""
    from sitl.sweep.plan import key_of
    from sitl.sweep.sailing import sail_all

    keys = [(key_of(run), run) for run in runs]

    def take(row: Row) -> None:
        journal.add(row if progress.keep else without_log(row, journal.folder))

    left = [(key, run) for key, run in keys if key not in journal.rows]
    if left:
        sail_all(left, workers, take, ending.stopped)
    rows = [journal.rows[key] for key, _ in keys if key in journal.rows]
    for row in rows:
        progress.take(row, time.monotonic())
    return rows


def without_log(row: Row, folder: Path) -> Row:
    """The row, whose log below `folder` is deleted."""
    if row.log is not None:
        shutil.rmtree(folder / row.log, ignore_errors=True)
    return replace(row, log=None)


class HuntProgress:
    """Is told each row and each finding; prints the runs that came nearer than all before. `minutes`, `most`: when the
    hunt ends; `now_s`: of any clock, the same in `take`; `keep`: whether the logs stay."""

    def __init__(self, told: Told, minutes: float | None, most: int | None, now_s: float, keep: bool = False) -> None:
        self._told, self._minutes, self._most, self._begun_s = told, minutes, most, now_s
        self._nearest: dict[str, float] = {}
        self._done = 0
        self._found = 0
        self.keep = keep

    def take(self, row: Row, now_s: float) -> None:
        """A run has ended."""
        from sitl.hunt.search import margins_of

        self._done += 1
        for prop, margin in margins_of(row).items():
            if margin < self._nearest.get(prop, math.inf):
                self._nearest[prop] = margin
                print(f"{self._done:5} {prop} {margin:.3f}: {row.run.command}", flush=True)
        spent = (now_s - self._begun_s) / (60.0 * self._minutes) if self._minutes is not None else 0.0
        share = max(spent, 0.0 if self._most is None else self._done / self._most)
        self._told(f"{self._done} runs, {self._found} found", share)

    def find(self, finding: Finding) -> None:
        """A violation has been found, and shrunk."""
        self._found += 1
        print(f"FOUND {finding.prop} {finding.margin:.3f}: {finding.run.command}", flush=True)


def _tell(rows: Sequence[Row], findings: Sequence[Finding], over: str) -> None:
    """What the hunt found, property by property. `over`: why it ended early."""
    from sitl.hunt.search import counts, margins_of, nearest

    near = nearest(rows)
    print(f"{len(rows)} runs{over}")
    for prop, (bad, having) in counts(rows).items():
        print(f"{prop}: {bad} of {having} runs violate it; nearest {margins_of(near[prop])[prop]:.3f}")
        print(f"  {near[prop].run.command}")
    for finding in findings:
        print(f"smallest case, {finding.prop} {finding.margin:.3f}:\n  {finding.run.command}")
