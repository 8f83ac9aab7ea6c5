"""Old logs go, the newest and whatever is no log stay."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import pytest

from companion.record import retention
from companion.record.retention import Retention, size_bytes, trim
from tests.forbidden import forbid
from tests.waiting import wait_until


def log(directory: Path, name: str, begun_s: float, size: int = 1000, ended_s: float | None = None) -> Path:
    folder = directory / name
    folder.mkdir()
    for file, content, written_s in (("ticks.csv", b"x" * size, ended_s or begun_s), ("manifest.json", b"{}", begun_s)):
        (folder / file).write_bytes(content)
        os.utime(folder / file, (written_s, written_s))
    return folder


def test_the_oldest_go_first_and_no_more_than_needed(tmp_path: Path) -> None:
    logs = [log(tmp_path, f"revolt-{n}", 100.0 * n) for n in range(5)]
    deleted, left = trim(tmp_path, 3100, logs[4])
    assert deleted == logs[:2]
    assert left == sum(map(size_bytes, logs[2:])) <= 3100


def test_a_log_begun_before_the_computer_knew_the_time_is_as_old_as_its_last_row(tmp_path: Path) -> None:
    """Without a battery for its clock the computer begins in 1970; the network tells it the time under way."""
    last_year, yesterday = log(tmp_path, "b", 1.75e9), log(tmp_path, "a", 100.0, ended_s=1.78e9)
    assert trim(tmp_path, 1500, tmp_path / "present")[0] == [last_year]
    assert yesterday.is_dir()


def test_the_present_run_stays_whatever_its_size_and_age(tmp_path: Path) -> None:
    present = log(tmp_path, "present", 0.0, 5000)
    other = log(tmp_path, "other", 100.0)
    deleted, left = trim(tmp_path, 100, present)
    assert deleted == [other]
    assert present.is_dir() and left == size_bytes(present)


def test_the_folders_in_which_its_log_went_on_stay_too(tmp_path: Path) -> None:
    present, more, other = log(tmp_path, "run", 10.0), log(tmp_path, "run-2", 20.0), log(tmp_path, "run-twice", 30.0)
    trim(tmp_path, 0, present)
    assert present.exists() and more.exists() and not other.exists()


def test_what_is_no_log_is_never_deleted(tmp_path: Path) -> None:
    precious = tmp_path / "photographs"
    precious.mkdir()
    (precious / "grandmother.jpg").write_bytes(b"x" * 10_000)
    (tmp_path / "notes.txt").write_bytes(b"x" * 10_000)
    assert trim(tmp_path, 10, tmp_path / "none") == ([], 0)
    assert (precious / "grandmother.jpg").is_file() and (tmp_path / "notes.txt").is_file()


def test_no_directory_no_work(tmp_path: Path) -> None:
    assert trim(tmp_path / "none", 10, tmp_path) == ([], 0)


def test_a_folder_that_cannot_be_read_is_no_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old, present = log(tmp_path, "old", 100.0), log(tmp_path, "present", 200.0)
    (tmp_path / "lost+found").mkdir()
    forbid(tmp_path / "lost+found", monkeypatch)
    assert trim(tmp_path, 10, present)[0] == [old]


def test_it_outlives_a_medium_that_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old, present = log(tmp_path, "old", 50.0), log(tmp_path, "present", 100.0)
    faults = [OSError(errno.EIO, os.strerror(errno.EIO))]

    def trim_later(*arguments: Any) -> Any:
        if faults:
            raise faults.pop()
        return trim(*arguments)

    monkeypatch.setattr(retention, "trim", trim_later)
    monkeypatch.setattr(retention, "_PERIOD_S", 0.01)
    kept = Retention(tmp_path, 10, present, lambda text: None)
    wait_until(lambda: not old.exists(), "the medium is well again")
    kept.close()


def test_a_run_that_alone_is_too_large_is_told_once(tmp_path: Path) -> None:
    present = log(tmp_path, "present", 0.0, 5000)
    warnings: list[str] = []
    kept = Retention(tmp_path, 100, present, warnings.append)
    kept.close()
    assert len(warnings) == 1 and "more than their limit" in warnings[0]
