"""`companion evaluate ardurover`: this autopilot and ArduRover on the same tasks, weather and plant."""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from companion.app import program_version
from companion.cli.common import UsageError, chosen, seeds

if TYPE_CHECKING:
    from sitl.evaluate.beside import Row, Rows
    from sitl.evaluate.tasks import Sailed, Task


def add_to(tasks: Any) -> None:
    """Add the command to `tasks`, the subparsers of `evaluate`."""
    beside = tasks.add_parser(
        "ardurover",
        help="sail the same tasks with ArduRover and with the companion, and compare them",
        description="BINARY is an ArduRover for SITL that you have built or downloaded; nothing is fetched here. Runs "
        "that stand in DIR/rows.json are not sailed again.",
    )
    beside.add_argument("binary", type=Path, metavar="BINARY")
    beside.add_argument("--task", action="append", default=[], metavar="NAME", help="left out: all; `list` shows them")
    beside.add_argument("--seeds", type=seeds, default=range(8), metavar="A-B", help="as 0-7, or 3")
    beside.add_argument("--out", type=Path, default=Path("out/ardurover"), metavar="DIR")
    beside.set_defaults(command=_beside)


def _beside(arguments: argparse.Namespace) -> int:
    from sitl.evaluate.beside import Rows
    from sitl.evaluate.tasks import TASKS

    names = chosen("task", arguments.task, TASKS)
    if not names:
        return 0
    if not arguments.binary.is_file():
        raise UsageError(f"{arguments.binary}: no such file")
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = Rows(arguments.out / "rows.json")
    for seed in arguments.seeds:
        _sail_missing(rows, {name: TASKS[name] for name in names}, seed, arguments)
    for line in rows.table():
        print(line)
    return 0


def _sail_missing(rows: Rows, tasks: Mapping[str, Task], seed: int, arguments: argparse.Namespace) -> None:
    """Sail what does not stand in `rows`, with both."""
    from sitl.evaluate.beside import OWN, ROVER

    autopilots = {ROVER: _by_rover(arguments.binary), OWN: _by_own()}
    for name, task in tasks.items():
        for autopilot, sail in autopilots.items():
            if not rows.has(name, seed, autopilot):
                rows.add(_row(name, task, seed, autopilot, sail, arguments.out / autopilot))


_Sail = Callable[["Task", int, Path], "Sailed"]


def _by_rover(binary: Path) -> _Sail:
    from sitl.evaluate.rover_setup import setups
    from sitl.evaluate.tasks import sail_rover

    known = setups()
    return lambda task, seed, folder: sail_rover(task, seed, binary, known[task.vessel], folder)


def _by_own() -> _Sail:
    from companion.cli.rig import LockstepRig
    from sitl.evaluate.tasks import sail_own

    return lambda task, seed, folder: sail_own(task, seed, LockstepRig, folder)


def _row(name: str, task: Task, seed: int, autopilot: str, sail: _Sail, folder: Path) -> Row:
    """Sail and judge one run; its log stays until the next one."""
    from sitl.evaluate.ardurover import RoverError
    from sitl.evaluate.beside import Row
    from sitl.evaluate.tasks import judge
    from sitl.scenarios.ground_station import GroundStationTimeout

    shutil.rmtree(folder, ignore_errors=True)
    figures: Mapping[str, float] = {}
    error, version = "", ""
    try:
        sailed = sail(task, seed, folder)
        version = sailed.version or program_version()
        figures = {figure.name: round(figure.value, 5) for figure in judge(task, sailed)}
    except (RoverError, GroundStationTimeout, ValueError) as problem:
        error = str(problem)
    print(f"{name}, seed {seed}, {autopilot}: {error or 'sailed'}", flush=True)
    return Row(name, task.vessel, seed, autopilot, version, datetime.now(UTC).date().isoformat(), figures, error)
