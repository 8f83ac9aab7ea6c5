"""Sail the rows of tables.toml, and the runs of theses.toml, over their seeds and write the figures beside them:
`python -m docs.results.measure`.

Each run is a process of its own, `companion scenario run …`. Finished runs stand in out/results and are not sailed
again while the commit is the same, so that a measurement that was cut off goes on where it was.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from docs.results.consistency import NAME as CONSISTENCY
from docs.results.consistency import measured_consistency

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
TABLES = HERE / "tables.toml"
THESES = HERE / "theses.toml"


class Failed(Exception):
    """A run without a result: its command and what it wrote."""


@dataclass(frozen=True, slots=True)
class Run:
    """One scenario on one seed."""

    scenario: str
    vessel: str
    seed: int
    settings: tuple[tuple[str, str], ...]

    @property
    def words(self) -> list[str]:
        """The command, without the program that runs it and without its folder."""
        changes = [word for key, value in self.settings for word in ("--set", f"{key}={value}")]
        vessel = ["--vessel", self.vessel] if self.vessel else []
        return ["scenario", "run", self.scenario, *vessel, "--seed", str(self.seed), *changes]

    @property
    def folder(self) -> str:
        """Its place among the finished runs."""
        settings = "-".join(f"{key}={value}" for key, value in self.settings) or "usual"
        return f"{self.scenario}/{self.vessel or 'usual'}/{settings}/{self.seed}"


def tables() -> list[dict[str, Any]]:
    """The tables as the file has them, and the runs of the theses' findings as one more."""
    found: list[dict[str, Any]] = tomllib.loads(TABLES.read_text(encoding="utf-8"))["table"]
    return [*found, theses_table(theses())]


def theses() -> dict[str, Any]:
    """The findings as theses.toml has them."""
    return tomllib.loads(THESES.read_text(encoding="utf-8"))


def theses_table(theses: Mapping[str, Any]) -> dict[str, Any]:
    """The runs of all findings as one table. A row's label is `run_name` of its finding and number."""
    findings = theses["finding"]
    metrics = {metric: None for finding in findings for metric in _metrics_of(finding)}
    return {
        "name": THESES.stem,
        "title": "What the theses found",
        "text": theses["served"],
        "seeds": theses["seeds"],
        "first_seed": theses["first_seed"],
        "columns": [{"metric": metric, "title": metric, "of": "mean"} for metric in metrics],
        "rows": [
            {**run, "label": run_name(finding, number)}
            for finding in findings
            for number, run in enumerate(finding.get("run", ()))
        ],
    }


def run_name(finding: Mapping[str, Any], number: int) -> str:
    """The label of a finding's run among the measured rows."""
    return f"{finding['name']} {number}"


def _metrics_of(finding: Mapping[str, Any]) -> Iterator[str]:
    yield from (metric for run in finding.get("run", ()) for metric, _ in run["show"])
    for expected in finding.get("expect", ()):
        yield expected["metric"]
        yield expected.get("of", expected["metric"])


def runs_of(table: Mapping[str, Any], row: Mapping[str, Any], most_seeds: int | None = None) -> list[Run]:
    """The runs of one row. `most_seeds`: not more than these."""
    count, first = int(row.get("seeds", table["seeds"])), int(table.get("first_seed", 0))
    seeds = range(first, first + (count if most_seeds is None else min(count, most_seeds)))
    return [_run(table, row, seed) for seed in seeds]


def _run(table: Mapping[str, Any], row: Mapping[str, Any], seed: int) -> Run:
    settings = dict(row.get("set", {}))
    if "spread" in row:
        settings["model_error"] = f"{row['spread'] if seed % 2 else -row['spread']:g}"
    return Run(
        row.get("scenario", table.get("scenario", "")),
        row.get("vessel", table.get("vessel", "")),
        seed,
        tuple(sorted(settings.items())),
    )


# --- sailing -------------------------------------------------------------------------------------------------------


def sailed(run: Run, kept: Path, commit: str) -> dict[str, Any]:
    """The result of a run, from out/results where it is of this commit already. Raises Failed."""
    finished = kept / run.folder / "finished.json"
    if finished.is_file():
        before: dict[str, Any] = json.loads(finished.read_text(encoding="utf-8"))
        if before["commit"] == commit:
            return before
    folder = finished.parent / "log"
    shutil.rmtree(folder, ignore_errors=True)
    command = [sys.executable, "-m", "companion", *run.words, "--out", str(folder)]
    done = subprocess.run(
        command, cwd=ROOT, env={**os.environ, "OMP_NUM_THREADS": "1"}, capture_output=True, text=True, check=False
    )
    result = folder / "result.json"
    if not result.is_file():
        raise Failed(f"companion {shlex.join(run.words)}: {(done.stderr or done.stdout).strip()}")
    found = json.loads(result.read_text(encoding="utf-8"))
    kept_result = {
        "commit": commit,
        "seed": run.seed,
        "ok": found["ok"],
        "error": found["error"],
        "metrics": found["metrics"],
    }
    finished.write_text(json.dumps(kept_result) + "\n", encoding="utf-8")
    shutil.rmtree(folder)
    return kept_result


def commit_of(root: Path) -> str:
    """The short name of the commit, with a + where files differ from it."""
    name = _git(root, "rev-parse", "--short", "HEAD")
    changed = _git(root, "status", "--porcelain", "--untracked-files=no", "--", ".", ":!docs")
    return f"{name}+" if changed else name


def _git(root: Path, *words: str) -> str:
    return subprocess.run(["git", *words], cwd=root, capture_output=True, text=True, check=True).stdout.strip()


# --- writing -------------------------------------------------------------------------------------------------------


def measured(
    table: Mapping[str, Any],
    rows: Sequence[tuple[Mapping[str, Any], list[Run]]],
    results: Mapping[Run, Mapping[str, Any]],
    commit: str,
) -> dict[str, Any]:
    """What the file of a table holds."""
    wanted = {column["metric"] for column in table["columns"]}
    return {
        "title": table["title"],
        "text": table["text"],
        "columns": table["columns"],
        "command": f"make results ARGS='--table {table['name']}'",
        "date": datetime.now(UTC).date().isoformat(),
        "commit": commit,
        "version": version("usv-companion") if _is_installed() else "",
        "rows": [_row(row, runs, results, wanted) for row, runs in rows],
    }


def _is_installed() -> bool:
    try:
        return bool(version("usv-companion"))
    except ModuleNotFoundError:
        return False


def _row(
    row: Mapping[str, Any], runs: Sequence[Run], results: Mapping[Run, Mapping[str, Any]], wanted: set[str]
) -> dict[str, Any]:
    found = [results[run] for run in runs]
    return {
        "label": row["label"],
        "law": row.get("set", {}).get("law", ""),
        "command": f"companion {shlex.join(runs[0].words)}",
        "runs": [
            {
                "seed": one["seed"],
                "ok": one["ok"],
                "metrics": {name: one["metrics"][name] for name in sorted(wanted & one["metrics"].keys())},
            }
            for one in found
        ],
    }


def _wanted(arguments: argparse.Namespace) -> Iterator[dict[str, Any]]:
    names = [*(table["name"] for table in tables()), CONSISTENCY]
    for name in arguments.table:
        if name not in names:
            sys.exit(f"no table {name}; there is {', '.join(names)}")
    return (table for table in tables() if not arguments.table or table["name"] in arguments.table)


def main(argv: Sequence[str] | None = None) -> int:
    """Exit code 0 when every run has a result."""
    parser = argparse.ArgumentParser(
        prog="python -m docs.results.measure", description="Measure the tables of the documentation."
    )
    parser.add_argument(
        "--table", action="append", default=[], metavar="NAME", help="only this one; can be given several times"
    )
    parser.add_argument("--seeds", type=int, metavar="N", help="at most so many seeds a row")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="runs at a time (%(default)d)")
    parser.add_argument(
        "--kept", type=Path, default=ROOT / "out" / "results", metavar="DIR", help="where finished runs are kept"
    )
    parser.add_argument("--out", type=Path, default=HERE, metavar="DIR", help="where the JSON files go")
    arguments = parser.parse_args(argv)
    commit = commit_of(ROOT)
    for table in _wanted(arguments):
        rows = [(row, runs_of(table, row, arguments.seeds)) for row in table["rows"]]
        runs = list(dict.fromkeys(run for _, of_row in rows for run in of_row))
        with ThreadPoolExecutor(arguments.jobs) as pool:
            done = dict(zip(runs, pool.map(lambda run: sailed(run, arguments.kept, commit), runs), strict=True))
        _write(arguments.out, table["name"], measured(table, rows, done, commit), f"{len(runs)} runs")
    if not arguments.table or CONSISTENCY in arguments.table:
        _write(arguments.out, CONSISTENCY, measured_consistency(arguments.kept, arguments.jobs, arguments.seeds), "")
    return 0


def _write(folder: Path, name: str, content: Mapping[str, Any], runs: str) -> None:
    target = folder / f"{name}.json"
    target.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    sys.stdout.write(f"{target}: {len(content['rows'])} rows{', ' if runs else ''}{runs}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failed as failure:
        sys.exit(str(failure))
