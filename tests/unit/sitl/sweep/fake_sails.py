"""Sails that cost nothing, for workers in other processes: their figures follow from the run alone."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
from pathlib import Path

from sitl.sweep.plan import Run
from sitl.sweep.sailing import Refused

TALE = "sailed.txt"
SCHEDULER = "scheduler.pid"


def sail(run: Run, folder: Path) -> None:
    """Seed 3 fails, seed 4 raises."""
    if run.seed == 4:
        raise ValueError("no such wind")
    value = 0.1 * run.seed + sum(run.factors.values())
    check = {"name": "position RMS", "value": value, "limit": 10.0, "unit": "m", "at_least": False}
    (folder / "ticks.csv").write_text("t_s\n0.0\n", encoding="utf-8")
    result = {
        "ok": run.seed != 3,
        "error": None,
        "metrics": {"position_rms_m": value, "seed_parity": float(run.seed % 2)},
        "checks": [
            check,
            {**check, "name": "contacts", "value": float(run.seed == 3), "limit": 0.0, "ok": run.seed != 3},
        ],
    }
    result["checks"][0]["ok"] = True
    (folder / "result.json").write_text(json.dumps(result), encoding="utf-8")


def told_sail(marks: Path, run: Run, folder: Path) -> None:
    """As `sail`, told in `marks`."""
    with (marks / TALE).open("a", encoding="utf-8") as tale:
        tale.write(f"{run.command}\n")
    sail(run, folder)


def deadly_sail(marks: Path, deadly: tuple[int, ...], run: Run, folder: Path) -> None:
    """As `told_sail`, but the first run of each deadly seed kills its process."""
    mark = marks / f"killed-{run.seed}"
    if run.seed in deadly and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    told_sail(marks, run, folder)


def always_deadly_sail(run: Run, folder: Path) -> None:
    """Seed 1 always kills its process."""
    if run.seed == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    sail(run, folder)


def scheduler_killing_sail(marks: Path, deadly: tuple[int, ...], fatal: int, run: Run, folder: Path) -> None:
    """As `deadly_sail`, but the first run of the fatal seed kills the scheduler and never ends."""
    mark = marks / "scheduler-killed"
    if run.seed == fatal and not mark.exists():
        mark.touch()
        os.kill(int((marks / SCHEDULER).read_text(encoding="utf-8")), signal.SIGKILL)
        signal.pause()
    deadly_sail(marks, deadly, run, folder)


def refusing_sail(run: Run, folder: Path) -> None:
    """No scenario takes these settings."""
    raise Refused(f"{run.command}: law=tesis: one of companion, thesis")


def sweep_killing_sail(marks: Path, fatal: int, run: Run, folder: Path) -> None:
    """As `told_sail`, but the first run of the fatal seed kills the sweep and never ends; its process number stays."""
    mark = marks / "worker.pid"
    if run.seed == fatal and not mark.exists():
        mark.write_text(str(os.getpid()), encoding="utf-8")
        sweep = multiprocessing.parent_process()
        assert sweep is not None and sweep.pid is not None
        os.kill(sweep.pid, signal.SIGKILL)
        signal.pause()
    told_sail(marks, run, folder)
