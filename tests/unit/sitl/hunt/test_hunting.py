"""A hunt finds the least margins of a sea whose margins are known, and what it finds is small."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import pytest

from sitl.hunt.hunting import Finding, Sailor, hunt
from sitl.hunt.search import BROKE_OFF, Known, Search, counts, nearest, violations
from sitl.sweep.plan import Run, key_of
from sitl.sweep.rows import Row
from sitl.sweep.sailing import row_of
from tests.unit.sitl.hunt.made import box, margin_m


def row(run: Run) -> Row:
    margins = [{"name": "fence", "value": margin_m(run)}, {"name": "disarmed", "value": 0.02}]
    return row_of(key_of(run), run, {"ok": True, "margins": margins, "metrics": {}, "checks": []}, None, 0.0)


def hunted(runs: int, faults: bool = True, seed: int = 0, places: int = 1) -> tuple[list[Finding], Sequence[Row]]:
    made = box(faults=faults)
    sailor = Sailor(lambda some: [row(run) for run in some], runs)
    return hunt(Search(made, seed), sailor, made.defaults, places, lambda found: None), sailor.rows


def test_the_violation_is_found_and_shrunk_to_its_cause() -> None:
    findings, rows = hunted(160)
    assert [found.prop for found in findings] == ["fence"]
    (found,) = findings
    assert [fault.partition("@")[0] for fault in found.run.faults] == ["gnss_lost"]
    assert [key for key, _ in found.run.settings] == ["wind"] and found.margin <= 0.0
    assert len(rows) == 160
    assert "gnss_lost" in found.found.command


def test_without_faults_there_is_nothing_but_a_least_margin() -> None:
    findings, rows = hunted(120, faults=False)
    assert not findings
    near = nearest(rows)["fence"]
    assert near.safety["fence"] < 1.6, "the most wind of the box leaves 1 m"
    assert counts(rows)["fence"] == (0, 120)


def test_the_search_learns() -> None:
    _, rows = hunted(120, faults=False, seed=3)
    margins = [one.safety["fence"] for one in rows]
    assert sum(margins[60:]) / 60 < sum(margins[:24]) / 24 - 0.5


def test_the_same_seed_asks_the_same_questions() -> None:
    first, second = (hunted(80, seed=5, places=2)[1] for _ in range(2))
    assert [one.run for one in first] == [one.run for one in second]
    assert [one.run for one in first] != [one.run for one in hunted(80, seed=6, places=2)[1]]


def test_a_run_that_an_error_ends_violates_that() -> None:
    _, run = Search(box(), 0).ask()
    broken = row_of(key_of(run), run, {}, "ZeroDivisionError: division by zero", 0.0)
    assert violations(broken) == [BROKE_OFF]
    timeout = row_of(key_of(run), run, {"ok": False, "error": "docked: not within 400 s", "margins": []}, None, 0.0)
    assert violations(timeout) == [BROKE_OFF]


def test_a_margin_that_is_no_number_is_a_violation() -> None:
    """The boat was nowhere, and the hunt took that for good."""
    _, run = Search(box(), 0).ask()
    margins = [{"name": "fence", "value": math.nan}, {"name": "disarmed", "value": -0.1}]
    lost = row_of(key_of(run), run, {"ok": False, "margins": margins, "metrics": {}, "checks": []}, None, 0.0)
    assert violations(lost) == ["fence", "disarmed"]
    assert nearest([row(run), lost])["fence"] is lost and counts([row(run), lost])["fence"] == (1, 2)


def test_a_known_violation_is_known_with_more_faults_too() -> None:
    known = Known("fence", frozenset({"gnss_lost"}))
    run = Run("hold", "revolt", 0, (), "", {}, ("gnss_lost@5+3", "imu_lost@9+3"))
    assert known.covers("fence", run) and not known.covers("leader", run)
    assert not Known("fence", frozenset({"leak"})).covers("fence", run)


@pytest.mark.parametrize("runs", range(1, 8))
def test_what_the_last_runs_violate_is_a_find_too(runs: int) -> None:
    """The number of runs is no multiple of what is asked for together, which is 8 here: nobody looked at the last ones."""
    made = box(faults=False)
    sailor = Sailor(lambda some: [replace(row(run), safety={"fence": -1.0}) for run in some], runs)
    (found,) = hunt(Search(made, 0), sailor, made.defaults, 4, lambda found: None)
    assert len(sailor.rows) == runs and found.prop == "fence"
