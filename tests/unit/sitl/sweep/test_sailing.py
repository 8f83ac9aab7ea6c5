"""Runs are handed out and rows taken, by workers that do what a test tells them."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.sweep.plan import Run
from sitl.sweep.rows import Row, SweepError
from sitl.sweep.sailing import Died, Refused, row_of, sail_all, sailed
from tests.unit.sitl.sweep.fake_sails import refusing_sail, sail
from tests.unit.sitl.sweep.made import runs


class Crew:
    """`places` workers; each run in hand ends when the test's dice say so, or dies, `deaths` times in all."""

    def __init__(self, places: int, deaths: int, dice: random.Random, risk: float = 0.5) -> None:
        self.places = places
        self.sailed: list[str] = []
        self._deaths, self._dice, self._risk = deaths, dice, risk
        self._hands: list[tuple[str, Run]] = []

    def begin(self, key: str, run: Run) -> None:
        assert len(self._hands) < self.places
        self._hands.append((key, run))

    def finished(self, timeout_s: float) -> Sequence[Row | Died]:
        key, run = self._hands.pop(self._dice.randrange(len(self._hands)))
        if self._deaths and self._dice.random() < self._risk:
            self._deaths -= 1
            return [Died(key, "killed")]
        self.sailed.append(key)
        return [row_of(key, run, {"ok": True}, None, 1.0)]

    def close(self) -> None:
        pass


def never(what: str) -> bool:
    return False


@given(st.integers(0, 12), st.integers(1, 5), st.integers(0, 2), st.integers(0, 99))
def test_each_run_has_one_row_whoever_dies(count: int, places: int, deaths: int, seed: int) -> None:
    taken: list[Row] = []
    sail_all(runs(count), Crew(places, deaths, random.Random(seed)), taken.append, never)
    assert sorted(row.seed for row in taken) == list(range(count))
    assert all(row.ok for row in taken)


def test_a_run_of_which_three_workers_die_fails() -> None:
    taken: list[Row] = []
    crew = Crew(1, 100, random.Random(1), risk=1.0)
    sail_all(runs(1), crew, taken.append, never)
    (row,) = taken
    assert not row.ok and row.error == "several workers died of it: killed" and not crew.sailed


def test_nothing_is_begun_after_the_time_is_over_and_what_is_begun_ends() -> None:
    taken: list[Row] = []
    sail_all(runs(9), Crew(3, 0, random.Random(1)), taken.append, lambda what: what == "begin" and len(taken) >= 2)
    assert 4 <= len(taken) <= 5


def test_an_interrupt_ends_it_at_once() -> None:
    taken: list[Row] = []
    sail_all(runs(9), Crew(3, 0, random.Random(1)), taken.append, lambda what: len(taken) >= 2)
    assert len(taken) == 2


def test_a_worker_with_other_code_is_named() -> None:
    class Other(Crew):
        def finished(self, timeout_s: float) -> Sequence[Row | Died]:
            return [
                replace(row, commit="old", host="far") for row in super().finished(timeout_s) if isinstance(row, Row)
            ]

    with pytest.raises(SweepError, match="worker on far runs old"):
        sail_all(runs(2), Other(1, 0, random.Random(1)), print, never)


def test_the_log_of_a_good_run_goes_and_that_of_a_failed_one_stays(tmp_path: Path) -> None:
    made = [sailed(key, run, sail, tmp_path) for key, run in runs(5)]
    assert sorted(path.name for path in (tmp_path / "logs").iterdir()) == sorted([made[3].key, made[4].key])
    assert "no such wind" in (tmp_path / str(made[4].log) / "error.txt").read_text(encoding="utf-8")
    kept = sailed(*runs(1)[0], sail, tmp_path, keep=True)
    assert kept.ok and (tmp_path / str(kept.log) / "result.json").is_file()


def test_what_a_design_must_not_ask_for_is_no_row(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="law=tesis"):
        sailed(*runs(1)[0], refusing_sail, tmp_path)


def check(value: float, limit: float, ok: bool, at_least: bool = False, name: str = "c") -> dict[str, object]:
    return {"name": name, "value": value, "limit": limit, "at_least": at_least, "unit": "m", "ok": ok}


@pytest.mark.parametrize(
    ("checks", "margin", "tightest"),
    [
        ([], None, None),
        ([check(1.0, 4.0, True, name="a"), check(3.0, 4.0, True, name="b")], 0.25, "b"),
        ([check(3.0, 2.0, True, at_least=True)], 0.5, "c"),
        ([check(5.0, 4.0, False)], -0.25, "c"),
        ([check(0.0, 0.0, True)], None, None),
        ([check(2.0, 0.0, False)], -2.0, "c"),
        ([check(math.nan, 1.0, False)], -math.inf, "c"),
    ],
)
def test_the_margin_is_that_of_the_check_nearest_to_failing(
    checks: list[dict[str, object]], margin: float | None, tightest: str | None
) -> None:
    key, run = runs(1)[0]
    row = row_of(key, run, {"ok": True, "checks": checks}, None, 1.0)
    assert (row.margin, row.tightest) == (margin, tightest)
