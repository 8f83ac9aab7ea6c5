"""A sweep whose processes are killed: the sweep itself, a worker of a Dask cluster, its scheduler. No run is lost, none
stands there twice, and the file is that of one process."""

from __future__ import annotations

import functools
import json
import os
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from pyarrow import parquet

from companion.cli.common import end
from companion.cli.main import argument_parser
from companion.cli.sweep import sweep
from sitl.sweep.rows import PARQUET, Row, SweepError, read_parquet
from sitl.sweep.sailing import Sail
from tests.unit.sitl.sweep.fake_sails import SCHEDULER, TALE, scheduler_killing_sail, told_sail
from tests.waiting import wait_until

ROOT = Path(__file__).parents[2]
DESIGN = """
name = "night"
seeds = 10
[[part]]
scenarios = ["hold", "route"]
levels = { wind = ["1", "2"] }
"""
RUNS = 40


def design(folder: Path) -> Path:
    path = folder / "night.toml"
    path.write_text(DESIGN, encoding="utf-8")
    return path


def words(folder: Path, *options: str) -> list[str]:
    return ["sweep", str(design(folder)), "--out", str(folder / "out"), *options]


def sail_with(folder: Path, sail: Sail, *options: str) -> int:
    return sweep(argument_parser().parse_args(words(folder, *options)), sail, lambda: False)


def found(folder: Path) -> list[Row]:
    return [replace(row, duration_s=0.0, cpu_s=0.0) for row in read_parquet(folder / "out" / PARQUET)]


def table(folder: Path) -> Any:
    """The Parquet file as it is, without the two columns that no two runs share."""
    return parquet.read_table(folder / "out" / PARQUET).drop_columns(["duration_s", "cpu_s"])


def sailed(folder: Path) -> Counter[str]:
    return Counter((folder / TALE).read_text(encoding="utf-8").splitlines())


def is_gone(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] == "Z"


@pytest.fixture(scope="module")
def one_process(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sweep in one process."""
    folder = tmp_path_factory.mktemp("one")
    sail_with(folder, functools.partial(told_sail, folder), "--jobs", "1")
    return folder


@pytest.fixture(scope="module")
def expected(one_process: Path) -> list[Row]:
    """What one process gives."""
    return found(one_process)


@pytest.mark.process
def test_a_sweep_that_is_killed_leaves_no_worker_and_goes_on(tmp_path: Path, expected: list[Row]) -> None:
    command = [sys.executable, "-m", "tests.protocol.fake_sweep", str(tmp_path), "7", *words(tmp_path, "--jobs", "1")]
    assert subprocess.run(command, cwd=ROOT, check=False, capture_output=True).returncode == -signal.SIGKILL
    wait_until(lambda: is_gone(int((tmp_path / "worker.pid").read_text(encoding="utf-8"))), "the worker's end")
    before = sailed(tmp_path)
    assert 0 < len(before) < RUNS
    sail_with(tmp_path, functools.partial(told_sail, tmp_path), "--jobs", "1")
    assert found(tmp_path) == expected
    assert len(sailed(tmp_path)) == RUNS and sailed(tmp_path).total() == RUNS


@contextmanager
def cluster(folder: Path) -> Iterator[str]:
    """A scheduler, whose address this gives, and four workers, each a process of its own."""
    file, local = folder / "scheduler.json", folder / "dask"
    file.unlink(missing_ok=True)
    local.mkdir(exist_ok=True)
    dask = [sys.executable, "-m", "dask.__main__"]
    outputs = {"cwd": ROOT, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    started: list[subprocess.Popen[bytes]] = []
    at = ["--host", "127.0.0.1", "--no-dashboard"]
    try:
        head = [*dask, "scheduler", *at, "--port", "0", "--scheduler-file", str(file)]
        started.append(subprocess.Popen(head, **outputs))  # type: ignore[call-overload]
        wait_until(lambda: file.exists() and file.stat().st_size > 0, "a scheduler")
        (folder / SCHEDULER).write_text(str(started[0].pid), encoding="utf-8")
        crew = ["--nworkers", "4", "--nthreads", "1", "--local-directory", str(local), "--scheduler-file", str(file)]
        started.append(subprocess.Popen([*dask, "worker", *at, *crew], **outputs))  # type: ignore[call-overload]
        yield str(json.loads(file.read_text(encoding="utf-8"))["address"])
    finally:
        for process in reversed(started):
            end(process)


@pytest.mark.sweep
@pytest.mark.process
@pytest.mark.filterwarnings("ignore")  # of Dask, at the death of its scheduler
def test_a_cluster_that_loses_a_worker_and_its_scheduler_loses_no_run(
    tmp_path: Path, one_process: Path, expected: list[Row]
) -> None:
    deadly = functools.partial(scheduler_killing_sail, tmp_path, (3,), 8)
    with cluster(tmp_path) as address, pytest.raises(SweepError, match="the same command goes on from here"):
        sail_with(tmp_path, deadly, "--scheduler", address)
    before, sailed_before = found(tmp_path), sailed(tmp_path)
    assert (tmp_path / "killed-3").exists() and 0 < len(before) < RUNS
    with cluster(tmp_path) as address:
        sail_with(tmp_path, deadly, "--scheduler", address)
    ours = found(tmp_path)
    assert ours == expected and table(tmp_path).equals(table(one_process))
    assert len(sailed(tmp_path)) == RUNS
    finished = [row.run.command for row in before if row.error is None]
    assert all(sailed(tmp_path)[command] == sailed_before[command] for command in finished), "no row is sailed again"
    # what a worker had finished and not handed over is sailed again when it dies
    assert max(sailed(tmp_path).values()) <= 2


@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(SweepError, match=r"tcp://127\.0\.0\.1:9: no scheduler answers there"):
        sail_with(tmp_path, told_sail, "--scheduler", "tcp://127.0.0.1:9")  # type: ignore[arg-type]
