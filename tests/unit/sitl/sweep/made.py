"""Runs and rows of tests."""

from __future__ import annotations

from pathlib import Path

from sitl.sweep.plan import Run, key_of
from sitl.sweep.rows import Row
from sitl.sweep.sailing import sailed
from tests.unit.sitl.sweep.fake_sails import sail


def runs(count: int) -> list[tuple[str, Run]]:
    """Runs of `hold` with their keys."""
    made = [Run("hold", "revolt", seed, (("wind", "2"),), "hold revolt wind=2", {"push": 0.5}) for seed in range(count)]
    return [(key_of(run), run) for run in made]


def rows(count: int, folder: Path) -> list[Row]:
    """Their rows, sailed in this process."""
    return [sailed(key, run, sail, folder) for key, run in runs(count)]
