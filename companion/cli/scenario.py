"""`companion scenario list | run | table`: named scenarios, run in lockstep and checked."""

from __future__ import annotations

import argparse
import time
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from companion.cli.common import UsageError, new_folder
from companion.cli.report import leave_page, leave_table
from companion.core.nearest import did_you_mean

if TYPE_CHECKING:
    from sitl.scenarios.scenario import ScenarioResult


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    scenario = commands.add_parser("scenario", help="run a named scenario in lockstep and check it")
    verbs = scenario.add_subparsers(required=True, metavar="list | run | table")
    verbs.add_parser("list", help="the scenarios and their settings").set_defaults(command=_list)
    run = verbs.add_parser("run", help="run one")
    run.add_argument("name", metavar="NAME")
    run.add_argument("--vessel", metavar="V")
    run.add_argument("--seed", type=int, default=0)
    run.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="changes")
    run.add_argument("--out", type=Path, metavar="DIR", help="folder of the log and result.json")
    run.set_defaults(command=_run)
    table = verbs.add_parser("table", help="compare the thesis's law with the companion's on the same seeds; slow")
    table.add_argument("name", metavar="NAME", choices=["four_corner", "route"])
    table.add_argument("--seeds", type=int, default=8, metavar="N")
    table.add_argument("--out", type=Path, metavar="DIR", help="keep the runs there, with a page of all of them")
    table.set_defaults(command=_table)


def _list(arguments: argparse.Namespace) -> int:
    from sitl.scenarios import SCENARIOS

    for scenario in SCENARIOS.values():
        settings = " ".join(f"{key}={value}" for key, value in scenario.defaults.items())
        print(f"{scenario.name:20} {scenario.text} ({scenario.vessel}); {settings}")
    return 0


def _table(arguments: argparse.Namespace) -> int:
    from companion.cli.rig import LockstepRig
    from sitl.scenarios import SCENARIOS, route_table, table

    if arguments.seeds < 1:
        raise UsageError(f"--seeds {arguments.seeds}: must be at least 1")
    lines = route_table.lines if arguments.name == "route" else table.lines
    for line in lines(SCENARIOS[arguments.name], LockstepRig, arguments.seeds, keep=arguments.out):
        print(line, flush=True)
    if arguments.out is not None:
        leave_table(arguments.out)
    return 0


def _no_scenario(name: str, known: Collection[str]) -> str:
    return f"no scenario '{name}'; there is {', '.join(known)}{did_you_mean(name, known)}"


def _run(arguments: argparse.Namespace) -> int:
    """Exit code 0 where all checks hold, else 1."""
    from companion.cli.rig import LockstepRig
    from sitl.scenarios import SCENARIOS
    from sitl.scenarios.scenario import ScenarioError, run

    if arguments.name not in SCENARIOS:
        raise UsageError(_no_scenario(arguments.name, SCENARIOS))
    changes = _changes(arguments.changes)
    folder = arguments.out or new_folder(Path("out"), f"{arguments.name}-seed{arguments.seed}")
    started_s = time.perf_counter()
    try:
        result = run(
            SCENARIOS[arguments.name], LockstepRig, folder, arguments.seed, arguments.vessel, changes, draw=True
        )
    except (ScenarioError, ValueError) as error:
        raise UsageError(str(error)) from error
    _print_result(result)
    leave_page(folder)
    print(f"{folder}: {time.perf_counter() - started_s:.1f} s")
    return 0 if result.ok else 1


def _changes(texts: Sequence[str]) -> dict[str, str]:
    """`KEY=VALUE` texts by key. Raises UsageError."""
    changes: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals:
            raise UsageError(f"--set {text}: write KEY=VALUE")
        changes[key] = value
    return changes


def _print_result(result: ScenarioResult) -> None:
    print(result.boat)
    for name, value in result.metrics.items():
        print(f"{name:24} {value:10.3f}")
    for check in result.checks:
        verdict, relation = "ok  " if check.ok else "FAIL", "at least" if check.at_least else "at most"
        print(f"{verdict} {check.name}: {check.value:.3f} {check.unit}, {relation} {check.limit:g}")
    if result.error:
        print(f"FAIL {result.error}")
    if result.hint:
        print(result.hint)
