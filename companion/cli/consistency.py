"""`companion evaluate consistency`: whether the estimator's covariance is that of its errors, over many seeds."""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from companion.app import load_vessel, program_version
from companion.cli.common import UsageError, chosen, seeds

if TYPE_CHECKING:
    from sitl.evaluate.consistency import Believed, Run
    from sitl.scenarios.rig import Rig

_STATES = (0, 1, 3, 4, 8)  # of the filter's errors: position and velocity in north and east, heading
_WIND = "2"


def add_to(tasks: Any) -> None:
    """Add the command to `tasks`, the subparsers of `evaluate`."""
    command = tasks.add_parser(
        "consistency",
        help="compare the errors of the estimate with its covariance: NEES, NVS, bias and NIS",
        description="Sails each case with each seed in processes of its own. Every figure is a mean over the seeds, 1 "
        "where the covariance is that of the errors (0 for the bias), at several instants, and is inside where no more "
        "instants lie outside of the two-sided 95 % band than chance explains. Runs of this commit that stand in DIR "
        "are not sailed again.",
    )
    command.add_argument("vessel", metavar="VESSEL", help="a bundled name or a TOML file")
    command.add_argument("--case", action="append", default=[], metavar="NAME", help="left out: all; `list` shows them")
    command.add_argument("--seeds", type=seeds, default=range(20), metavar="A-B", help="as 0-19")
    command.add_argument("--gnss", default="rtk", help="grade of the receiver (%(default)s)")
    command.add_argument(
        "--file", action="store_true", help="with the vessel's file as it is; else it tells the sensors' true figures"
    )
    command.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), metavar="N", help="runs at a time")
    command.add_argument("--out", type=Path, default=Path("out/consistency"), metavar="DIR")
    command.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, too")
    command.set_defaults(command=_consistency)


@dataclass(frozen=True, slots=True)
class _Work:
    """One run to sail."""

    vessel: str
    case: str
    gnss: str
    told: bool
    seed: int

    def file(self, out: Path) -> Path:
        kind = "told" if self.told else "file"
        return out / Path(self.vessel).stem / self.gnss / kind / self.case / f"{self.seed}.json"


def _consistency(arguments: argparse.Namespace) -> int:
    from sitl.evaluate.consistency import CASES
    from sitl.sensors import grade

    names = chosen("case", arguments.case, CASES)
    if not names:
        return 0
    if len(arguments.seeds) < 2:
        raise UsageError("--seeds: two or more")
    if arguments.jobs < 1:
        raise UsageError(f"--jobs {arguments.jobs}: must be at least 1")
    grade(arguments.gnss)
    load_vessel(arguments.vessel)
    runs = {name: _sailed(_works(arguments, name), arguments.out, arguments.jobs) for name in names}
    from sitl.evaluate.consistency_table import figures, lines

    shown = {name: figures(CASES[name], of_case) for name, of_case in runs.items()}
    for line in lines(shown):
        print(line)
    if arguments.json is not None:
        _write(arguments, shown)
    return 0


def _works(arguments: argparse.Namespace, case: str) -> list[_Work]:
    return [_Work(arguments.vessel, case, arguments.gnss, not arguments.file, seed) for seed in arguments.seeds]


def _sailed(works: Sequence[_Work], out: Path, jobs: int) -> list[Run]:
    """The runs, from their files where these are of this commit and vessel."""
    if jobs == 1:
        return [_run(work, out) for work in works]
    from sitl.sweep.interrupts import held_back

    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        try:
            with held_back():
                runs = pool.map(_run, works, (out for _ in works))
            return list(runs)
        except KeyboardInterrupt:
            for worker in multiprocessing.active_children():
                worker.kill()
            raise


def _run(work: _Work, out: Path) -> Run:
    """A run from its file, sailed and written where there is none."""
    from sitl.evaluate.consistency import Run, Sample
    from sitl.sweep.plan import contents_of
    from sitl.sweep.provenance import commit

    file = work.file(out)
    made_by = {"commit": commit(), "contents": contents_of(work.vessel)}
    if file.is_file():
        kept = json.loads(file.read_text(encoding="utf-8"))
        if {"commit": kept["commit"], "contents": kept.get("contents", "")} == made_by:
            return Run(tuple(Sample(**sample) for sample in kept["samples"]), kept["innovations"])
    run = _sail(work)
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(".part")
    part.write_text(json.dumps({**made_by, **asdict(run)}) + "\n", encoding="utf-8")
    part.replace(file)
    return run


def _sail(work: _Work) -> Run:
    from companion.cli.rig import LockstepRig
    from sitl.evaluate.consistency import CASES, sail
    from sitl.evaluate.told_sensors import told
    from sitl.scenarios.rig import Conditions

    case = CASES[work.case]
    conditions = Conditions(work.vessel, seed=work.seed, wind=_WIND, gnss=work.gnss, faults=case.faults)
    if work.told:
        conditions = replace(conditions, known=told(load_vessel(work.vessel), work.gnss))
    with tempfile.TemporaryDirectory() as folder:
        return sail(case, conditions, LockstepRig, _believed, Path(folder))


def _believed(rig: Rig) -> Believed | None:
    """What the boat believes, by the inertial filter's own covariance and its doubts, brought from the sensor's place
    to the boat's origin."""
    from companion.cli.rig import LockstepRig
    from sitl.evaluate.consistency import Believed

    assert isinstance(rig, LockstepRig)
    inertial, tick = rig.vessel.inertial, rig.vessel.last_tick
    if inertial is None or not inertial.running or tick is None:
        return None
    nav = tick.nav
    arm = inertial.offset(inertial.lever_m)
    moved = np.eye(len(_STATES))
    moved[:4, 4] = arm.east_m, -arm.north_m, arm.east_mps, -arm.north_mps
    covariance = moved @ np.asarray(inertial.filter.covariance)[np.ix_(_STATES, _STATES)] @ moved.T
    doubt_m, doubt_mps, doubt_rad = inertial.doubts
    covariance += np.diag(np.square([doubt_m, doubt_m, doubt_mps, doubt_mps, doubt_rad]))
    return Believed(
        (nav.north_m, nav.east_m, nav.north_mps, nav.east_mps, nav.yaw_rad),
        tuple(map(tuple, covariance.tolist())),
        {judged.sense: (judged.t_s, judged.square) for judged in nav.judged},
    )


def _write(arguments: argparse.Namespace, shown: Mapping[str, Any]) -> None:
    from sitl.sweep.provenance import commit

    first, last = arguments.seeds[0], arguments.seeds[-1]
    content = {
        "vessel": load_vessel(arguments.vessel).name,
        "gnss": arguments.gnss,
        "told": not arguments.file,
        "seeds": [first, last],
        "date": datetime.now(UTC).date().isoformat(),
        "commit": commit(),
        "version": program_version(),
        "cases": shown,
    }
    arguments.json.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
