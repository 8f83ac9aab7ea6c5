"""The rows of consistency.toml, measured by `companion evaluate consistency`."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

NAME = "consistency"
_HERE = Path(__file__).parent


def consistency_rows() -> Mapping[str, Any]:
    """As consistency.toml has them."""
    return tomllib.loads((_HERE / f"{NAME}.toml").read_text(encoding="utf-8"))


def words_of(row: Mapping[str, Any], seeds: str) -> list[str]:
    """The command of a row, without the program that runs it and without where it keeps its runs."""
    return ["evaluate", "consistency", *row["words"], "--seeds", seeds]


def measured_consistency(kept: Path, jobs: int, most_seeds: int | None) -> dict[str, Any]:
    """What consistency.json holds. Raises CalledProcessError where a command fails."""
    content = consistency_rows()
    seeds = _first(content["seeds"], most_seeds)
    rows = []
    for row in content["rows"]:
        words = words_of(row, seeds)
        with tempfile.TemporaryDirectory() as folder:
            found = Path(folder) / "found.json"
            more = ["--jobs", str(jobs), "--out", str(kept / NAME), "--json", str(found)]
            subprocess.run(
                [sys.executable, "-m", "companion", *words, *more],
                cwd=_HERE.parents[1],
                env={**os.environ, "OMP_NUM_THREADS": "1"},
                stdout=subprocess.DEVNULL,
                check=True,
            )
            measured = json.loads(found.read_text(encoding="utf-8"))
        rows.append({"label": row["label"], "command": f"companion {shlex.join(words)}", **measured})
    return {"command": f"make results ARGS='--table {NAME}'", "rows": rows}


def _first(seeds: str, most: int | None) -> str:
    first, last = map(int, seeds.split("-"))
    return f"{first}-{last if most is None else min(last, first + most - 1)}"
