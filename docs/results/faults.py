"""Run the fault matrix and write what was seen beside it: `python -m docs.results.faults`.

One file a vessel and mode, in `docs/results/matrix`. The page judges them by `sitl/fault_matrix/expected.toml`.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from companion.cli.rig import LockstepRig
from docs.results.measure import ROOT, commit_of
from sitl.fault_matrix.cell import Observed, judge, run_stage
from sitl.fault_matrix.table import load

FOLDER = ROOT / "docs" / "results" / "matrix"
_MODULE = "docs.results.faults"


def write(seen: Sequence[Observed], vessel: str, mode: str, commit: str, folder: Path = FOLDER) -> Path:
    """The file of one vessel and mode."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{vessel}-{mode}.json"
    head = {"date": datetime.now(UTC).date().isoformat(), "commit": commit}
    rows = ",\n".join(json.dumps(one.row(), ensure_ascii=False) for one in seen)
    path.write_text(f'{json.dumps(head)[:-1]}, "cells": [\n{rows}\n]}}\n', encoding="utf-8")
    return path


def sail(vessel: str, mode: str, commit: str, folder: Path) -> None:
    """One stage, in this process."""
    table = load()
    with tempfile.TemporaryDirectory() as place:
        seen = run_stage(table, vessel, mode, LockstepRig, Path(place) / "runs")
    write(seen, vessel, mode, commit, folder)
    red = {one.fault: problems for one in seen if (problems := judge(table, one))}
    sys.stdout.write(f"{vessel} {mode}: {len(seen)} cells, {len(red)} not as expected\n")
    for fault, problems in red.items():
        sys.stdout.write(f"    {fault}: {'; '.join(problems)}\n")
    sys.stdout.flush()


def _beside(commit: str, folder: Path, stage: tuple[str, str]) -> int:
    vessel, mode = stage
    command = [sys.executable, "-m", _MODULE, "--one", vessel, mode, "--commit", commit, "--out", str(folder)]
    return subprocess.run(command, cwd=ROOT, check=False).returncode


def main(argv: Sequence[str] | None = None) -> int:
    """Exit code 0 when every stage could be run; red cells are told, and stand in the page."""
    parser = argparse.ArgumentParser(prog=f"python -m {_MODULE}", description="Run the fault matrix.")
    parser.add_argument("--vessel", action="append", help="only this one; can be given several times")
    parser.add_argument("--mode", action="append", help="only this one; can be given several times")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="stages at a time (%(default)d)")
    parser.add_argument("--out", type=Path, default=FOLDER, metavar="DIR", help="where the files go")
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--commit", help=argparse.SUPPRESS)
    arguments = parser.parse_args(argv)
    commit = arguments.commit or commit_of(ROOT)
    if arguments.one:
        vessel, mode = arguments.one
        sail(vessel, mode, commit, arguments.out)
        return 0
    stages = [
        stage
        for stage in load().stages()
        if (not arguments.vessel or stage[0] in arguments.vessel) and (not arguments.mode or stage[1] in arguments.mode)
    ]
    with ThreadPoolExecutor(arguments.jobs) as pool:
        return max(pool.map(partial(_beside, commit, arguments.out), stages), default=0)


if __name__ == "__main__":
    sys.exit(main())
