"""`companion scenario list | run | table`: named scenarios, run in lockstep and checked."""

from __future__ import annotations

import argparse
import shutil
import textwrap
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from companion.cli.common import UsageError, new_folder
from companion.cli.progress import Sailing, bar
from companion.cli.report import leave_page, leave_table
from companion.core.nearest import did_you_mean

if TYPE_CHECKING:
    from sitl.scenarios.rig import Composer, Conditions
    from sitl.scenarios.scenario import Scenario, ScenarioResult

_NARROWEST = 60  # columns of the list, however narrow the terminal is


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    scenario = commands.add_parser("scenario", help="run a named scenario in lockstep and check it")
    verbs = scenario.add_subparsers(required=True, metavar="list | run | table")
    list_ = verbs.add_parser("list", help="the scenarios by subject, or the settings of one")
    list_.add_argument("name", metavar="NAME", nargs="?", help="show this one's settings")
    list_.set_defaults(command=_list)
    run = verbs.add_parser("run", help="sail one in lockstep and check it")
    run.add_argument("name", metavar="NAME")
    run.add_argument("--vessel", metavar="V")
    run.add_argument("--seed", type=int, default=0)
    run.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="changes")
    run.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="NAME@T_S[+DURATION_S]",
        dest="faults",
        help="a fault besides; then safety margins judge the run, and its checks are only shown",
    )
    run.add_argument("--out", type=Path, metavar="DIR", help="folder of the log and result.json")
    run.set_defaults(command=_run)
    table = verbs.add_parser("table", help="compare the thesis's law with the companion's on the same seeds; slow")
    table.add_argument("name", metavar="NAME", choices=["four_corner", "route"])
    table.add_argument("--seeds", type=int, default=8, metavar="N")
    table.add_argument("--out", type=Path, metavar="DIR", help="keep the runs there, with a page of all of them")
    table.set_defaults(command=_table)


def _list(arguments: argparse.Namespace) -> int:
    from sitl.scenarios import BY_SUBJECT

    if arguments.name is not None:
        print(_described(_known(arguments.name)))
        return 0
    for subject, scenarios in BY_SUBJECT.items():
        print(subject)
        for scenario in scenarios:
            print(_filled(f"  {scenario.name:18}{scenario.vessel:14}", scenario.text))
        print()
    print("companion scenario list NAME shows its settings, companion scenario run NAME sails it.")
    return 0


def _described(scenario: Scenario) -> str:
    """What a scenario does, and a line for each of its settings."""
    lines = [scenario.text, f"boat: {scenario.vessel}", "", "settings (--set KEY=VALUE), and their defaults:"]
    lines += [f"  {key:18}{value or '-'}" for key, value in scenario.defaults.items()]
    for vessel, own in scenario.by_vessel.items():
        lines.append(f"  with {vessel}: {' '.join(f'{key}={value}' for key, value in own.items())}")
    return "\n".join(lines)


def _filled(head: str, text: str) -> str:
    """`text` beside `head`, in lines as long as the terminal is wide."""
    width = max(_NARROWEST, shutil.get_terminal_size().columns)
    return textwrap.fill(text, width, initial_indent=head, subsequent_indent=" " * len(head))


def _table(arguments: argparse.Namespace) -> int:
    from sitl.scenarios import SCENARIOS, route_table, table

    if arguments.seeds < 1:
        raise UsageError(f"--seeds {arguments.seeds}: must be at least 1")
    of = route_table if arguments.name == "route" else table
    scenario, count = SCENARIOS[arguments.name], of.count(arguments.seeds)
    with bar(scenario.name) as told:
        sailing = Sailing(told, scenario.name, scenario.lasts_s, count)
        for line in of.lines(scenario, _watched(sailing), arguments.seeds, keep=arguments.out):
            print(line, flush=True)
    if arguments.out is not None:
        leave_table(arguments.out)
    return 0


def _watched(sailing: Sailing) -> Composer:
    """Builds rigs whose ticks `sailing` counts."""
    from companion.cli.rig import LockstepRig

    def compose(conditions: Conditions, folder: Path) -> LockstepRig:
        sailing.begin()
        return LockstepRig(conditions, folder, watch=sailing.step)

    return compose


def _known(name: str) -> Scenario:
    """The scenario of that name. Raises UsageError."""
    from sitl.scenarios import SCENARIOS

    if name not in SCENARIOS:
        raise UsageError(f"no scenario '{name}'; there is {', '.join(SCENARIOS)}{did_you_mean(name, SCENARIOS)}")
    return SCENARIOS[name]


def _run(arguments: argparse.Namespace) -> int:
    """Exit code 0 where all checks hold, else 1."""
    from sitl.scenarios.scenario import ScenarioError, run

    scenario = _known(arguments.name)
    changes = _changes(arguments.changes)
    folder = arguments.out or new_folder(Path("out"), f"{arguments.name}-seed{arguments.seed}")
    started_s = time.perf_counter()
    try:
        with bar(scenario.name) as told:
            compose = _watched(Sailing(told, scenario.name, scenario.lasts_s))
            result = run(
                scenario, compose, folder, arguments.seed, arguments.vessel, changes, draw=True, faults=arguments.faults
            )
    except (ScenarioError, ValueError) as error:
        raise UsageError(str(error)) from error
    print_result(result)
    if not result.ok:
        _note_weather(scenario, arguments.vessel or scenario.vessel, changes)
    leave_page(folder)
    print(f"{folder}: {time.perf_counter() - started_s:.1f} s")
    return 0 if result.ok else 1


def _note_weather(scenario: Scenario, vessel: str, changes: dict[str, str]) -> None:
    """Say which weather of a run that failed is more than the boat holds."""
    from companion.cli.held_weather import more_than_it_holds
    from companion.config.vessel import find, load
    from sitl.scenarios.scenario import settings_for

    config = load(find(vessel))
    note = more_than_it_holds(config, settings_for(scenario, vessel, config, changes))
    if note:
        print(note)


def _changes(texts: Sequence[str]) -> dict[str, str]:
    """`KEY=VALUE` texts by key. Raises UsageError."""
    changes: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals:
            raise UsageError(f"--set {text}: write KEY=VALUE")
        changes[key] = value
    return changes


def print_result(result: ScenarioResult) -> None:
    """Print the figures of a run, its checks and its margins."""
    print(result.boat)
    for name, value in result.metrics.items():
        print(f"{name:24} {value:10.3f}")
    for check in result.checks:
        verdict, relation = "ok  " if check.ok else "FAIL", "at least" if check.at_least else "at most"
        print(f"{verdict} {check.name}: {check.value:.3f} {check.unit}, {relation} {check.limit:g}")
    if not result.checks and result.error is None:
        print("no check: this scenario asks nothing of such a run, which is measured alone")
    for margin in result.margins:
        word = "ok  " if margin.value > 0.0 else "UNSAFE"
        print(f"{word} safety, {margin.name}: {margin.value:.3f} {margin.unit} left, at {margin.at_s:.0f} s")
    if result.error:
        print(f"FAIL {result.error}")
    if result.hint:
        print(result.hint)
