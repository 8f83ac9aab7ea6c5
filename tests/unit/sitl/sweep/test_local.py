"""Processes of this machine as workers: what they sail is what this process sails, also where one is killed."""

from __future__ import annotations

import functools
from dataclasses import replace
from pathlib import Path

import pytest

from sitl.sweep.local import LocalWorkers, cores
from sitl.sweep.rows import Row, in_order
from sitl.sweep.sailing import Refused, Sail, sail_all
from tests.unit.sitl.sweep.fake_sails import TALE, always_deadly_sail, deadly_sail, refusing_sail
from tests.unit.sitl.sweep.made import rows, runs


def sail_with(count: int, sail: Sail, folder: Path, of: int = 6) -> list[Row]:
    taken: list[Row] = []
    workers = LocalWorkers(count, sail, folder)
    try:
        sail_all(runs(of), workers, taken.append, lambda what: False)
    finally:
        workers.close()
    return in_order(taken)


def timeless(found: list[Row]) -> list[Row]:
    return [replace(row, duration_s=0.0, cpu_s=0.0) for row in found]


def test_two_processes_give_what_one_gives_though_one_is_killed_in_mid_run(tmp_path: Path) -> None:
    found = sail_with(2, functools.partial(deadly_sail, tmp_path, (2,)), tmp_path / "a")
    assert timeless(found) == timeless(in_order(rows(6, tmp_path / "b")))
    tale = (tmp_path / TALE).read_text(encoding="utf-8").splitlines()
    assert sorted(tale) == sorted(run.command for _, run in runs(6))


def test_a_run_that_kills_every_worker_fails_and_the_others_are_sailed(tmp_path: Path) -> None:
    found = sail_with(1, always_deadly_sail, tmp_path, of=3)
    assert [row.ok for row in found] == [True, False, True]
    assert "several workers died of it" in str(found[1].error)


def test_a_refusal_comes_through(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="law=tesis"):
        sail_with(1, refusing_sail, tmp_path, of=1)


def test_there_is_a_core() -> None:
    assert cores() >= 1
