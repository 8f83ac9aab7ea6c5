"""A real scenario in a sweep: its row is what its command gives."""

from __future__ import annotations

import json
from pathlib import Path

from companion.cli.main import main
from companion.cli.sweep import sail
from sitl.sweep.local import LocalWorkers
from sitl.sweep.plan import Run, key_of
from sitl.sweep.rows import Row
from sitl.sweep.sailing import sail_all


def test_the_command_of_a_row_gives_the_figures_of_the_row(tmp_path: Path) -> None:
    taken: list[Row] = []
    run = Run("hold", "revolt", 5, (("time", "15"), ("wind", "3")), faults=("imu_lost@20+2",))
    workers = LocalWorkers(1, sail, tmp_path)
    try:
        sail_all([(key_of(run), run)], workers, taken.append, lambda what: False)
    finally:
        workers.close()
    (row,) = taken
    assert row.error is None and row.metrics
    assert main([*run.words, "--out", str(tmp_path / "again")]) == (0 if row.ok else 1)
    again = json.loads((tmp_path / "again" / "result.json").read_text(encoding="utf-8"))
    assert again["metrics"] == dict(row.metrics) and again["ok"] == row.ok
    assert {one["name"]: one["value"] for one in again["margins"]} == dict(row.safety)
    assert row.safety["circling"] > 0.0 and again["faults"] == ["imu_lost@20+2"]
