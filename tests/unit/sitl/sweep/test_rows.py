"""Rows in the journal and in the Parquet file."""

import math
from dataclasses import replace
from pathlib import Path

import pandas
import pytest

from sitl.sweep.rows import (
    JOURNAL,
    Journal,
    SweepError,
    in_order,
    pending,
    read_journal,
    read_parquet,
    read_rows,
    write_parquet,
)
from tests.unit.sitl.sweep.made import rows, runs


def test_rows_come_back_from_the_journal(tmp_path: Path) -> None:
    made = rows(5, tmp_path)
    with Journal(tmp_path) as journal:
        for row in made:
            journal.add(row)
    assert read_journal(tmp_path) == made
    assert read_rows(tmp_path) == in_order(made)


@pytest.mark.parametrize("kept", range(0, 400, 57))
def test_a_journal_cut_off_anywhere_keeps_the_whole_rows_and_goes_on(tmp_path: Path, kept: int) -> None:
    first, second, third = rows(3, tmp_path)
    with Journal(tmp_path) as journal:
        journal.add(first)
        journal.add(second)
    path = tmp_path / JOURNAL
    length = len(path.read_bytes().splitlines(keepends=True)[0])
    path.write_bytes(path.read_bytes()[: length + kept])
    with Journal(tmp_path) as journal:
        assert list(journal.rows.values()) == [first]
        journal.add(third)
    assert read_journal(tmp_path) == [first, third]


def test_a_second_sweep_may_not_write_there(tmp_path: Path) -> None:
    with Journal(tmp_path), pytest.raises(SweepError, match="another sweep writes there"):
        Journal(tmp_path)
    Journal(tmp_path).close()


def test_finished_runs_of_this_commit_are_not_pending(tmp_path: Path) -> None:
    planned, made = runs(4), rows(2, tmp_path)
    known = {row.key: row for row in made}
    assert pending(planned, known, made[0].commit) == planned[2:]
    assert pending(planned, known, "another") == planned


def test_the_parquet_file_has_a_column_for_each_figure(tmp_path: Path) -> None:
    made = rows(5, tmp_path)
    write_parquet(reversed(made), tmp_path / "a.parquet")
    table = pandas.read_parquet(tmp_path / "a.parquet")
    assert list(table["seed"]) == [0, 1, 2, 3, 4]
    assert list(table["ok"]) == [True, True, True, False, False]
    assert table["metric.position_rms_m"][2] == pytest.approx(0.7) and math.isnan(table["metric.position_rms_m"][4])
    assert table["error"][4] == "ValueError: no such wind" and table["failed_checks"][3].tolist() == ["contacts"]
    assert table["log"][3] == f"logs/{made[3].key}" and pandas.isna(table["log"][0])
    assert {"setting.wind", "factor.push", "version.numpy", "commit", "duration_s", "host", "margin"} <= set(
        table.columns
    )
    assert read_parquet(tmp_path / "a.parquet") == made


def test_whoever_sails_first_the_file_is_the_same(tmp_path: Path) -> None:
    made = rows(5, tmp_path)
    write_parquet(made, tmp_path / "a.parquet")
    write_parquet([made[3], made[0], made[4], made[2], made[1]], tmp_path / "b.parquet")
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()


def test_figures_that_are_no_numbers_survive(tmp_path: Path) -> None:
    (row,) = rows(1, tmp_path)
    row = replace(row, metrics={"a": math.inf, "b": -math.inf})
    with Journal(tmp_path) as journal:
        journal.add(row)
    write_parquet([row], tmp_path / "a.parquet")
    assert read_journal(tmp_path) == [row] == read_parquet(tmp_path / "a.parquet")


def test_a_folder_without_runs_is_named(tmp_path: Path) -> None:
    with pytest.raises(SweepError, match="no runs of a sweep there"):
        read_rows(tmp_path)
    pandas.DataFrame({"other": [1]}).to_parquet(tmp_path / "runs.parquet")
    with pytest.raises(SweepError, match="not the rows of a sweep"):
        read_rows(tmp_path)
