"""What the theses found, sailed anew on one seed of each finding: it comes out as measured."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from companion.cli.rig import LockstepRig
from docs.generate.theses import MEASURED, holds, kept_on
from docs.results.measure import Run, runs_of, tables, theses
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run

FINDINGS = [one for one in theses()["finding"] if "expect" in one]
_sailed: dict[Run, Mapping[str, float]] = {}


@pytest.fixture(scope="module")
def measured() -> dict[str, Any]:
    return {row["label"]: row for row in json.loads(MEASURED.read_text(encoding="utf-8"))["rows"]}


def sail(one: Run, folder: Path) -> Mapping[str, float]:
    """The metrics of a run; those that several findings share are sailed once."""
    if one not in _sailed:
        outcome = run(
            SCENARIOS[one.scenario], LockstepRig, folder, seed=one.seed, vessel=one.vessel, changes=dict(one.settings)
        )
        assert outcome.error is None, outcome.error
        _sailed[one] = outcome.metrics
    return _sailed[one]


@pytest.mark.sweep
@pytest.mark.parametrize("finding", FINDINGS, ids=lambda one: one["name"])
def test_one_seed_of_a_finding(finding: Mapping[str, Any], tmp_path: Path, measured: dict[str, Any]) -> None:
    (table,) = (table for table in tables() if table["name"] == "theses")
    runs = [runs_of(table, row)[0] for row in finding["run"]]
    metrics = [sail(one, tmp_path / str(i)) for i, one in enumerate(runs)]
    assert holds(finding, metrics) == kept_on(finding, measured)[runs[0].seed]
