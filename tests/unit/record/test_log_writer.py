"""A log on a medium that fails: it stops, says why, and begins anew as a folder of its own."""

from __future__ import annotations

import csv
import errno
import json
import os
import shutil
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from companion.core.decision import TextKind
from companion.core.tick import DeviceHealth
from companion.params.table import TABLE
from companion.record import log_writer
from companion.record.log_writer import CHECK_S, MOST_RETRY_S, RETRY_S, DirectLog, LogOutput, LogSet, ThreadLog
from companion.record.readings import read_ticks
from companion.record.recorder import LogFolder, Medium
from companion.record.storage import REMIND_S, LogWatch, log_health
from tests.faulty_disk import FaultyDisk
from tests.unit.record.ticks import tick
from tests.waiting import wait_until


class CountingDisk(FaultyDisk):
    """Counts the writes."""

    def __init__(self) -> None:
        super().__init__()
        self.appended = 0

    def append(self, descriptor: int, data: bytes) -> None:
        self.appended += 1
        super().append(descriptor, data)


class Content:
    """Two files; the number of folders furnished."""

    def __init__(self) -> None:
        self.furnished: list[Path] = []

    def headers(self) -> Mapping[str, bytes]:
        return {"a.csv": b"a\n", "b.csv": b""}

    def furnish(self, folder: Path) -> None:
        self.furnished.append(folder)
        (folder / "manifest.json").write_text("{}", encoding="utf-8")


class Log:
    """A log without threads on a faulty disk."""

    def __init__(self, folder: Path) -> None:
        self.disk, self.content = FaultyDisk(), Content()
        self.files = LogSet(folder / "run", self.content, self.disk)
        self.out = DirectLog(self.files)

    def put(self, row: str, now_s: float) -> None:
        self.out.put("a.csv", f"{row}\n".encode(), now_s)

    def rows(self, folder: str = "run") -> list[str]:
        return (self.files.folder.with_name(folder) / "a.csv").read_text(encoding="utf-8").splitlines()


@pytest.fixture
def log(tmp_path: Path) -> Log:
    return Log(tmp_path)


def test_a_full_medium_stops_the_log_and_a_new_folder_begins_when_there_is_space(log: Log) -> None:
    log.put("1", 0.0)
    log.disk.fail_with(errno.ENOSPC)
    log.put("2", 1.0)
    assert log.out.stopped == "No space left on device" and log.out.lost_bytes == 2
    log.disk.fail_with(None)
    log.put("3", 1.5)
    assert log.out.stopped is not None and log.out.lost_bytes == 4, "the medium is left alone for a while"
    log.put("4", 1.0 + 2.0 * RETRY_S)
    assert log.out.stopped is None and log.out.number == 2 and log.out.folder.name == "run-2"
    assert log.rows() == ["a", "1"] and log.rows("run-2") == ["a", "4"]
    assert [folder.name for folder in log.content.furnished] == ["run", "run-2"]
    log.out.close()


def test_attempts_come_ever_less_often_and_use_one_folder(log: Log, tmp_path: Path) -> None:
    log.disk.fail_with(errno.EROFS)
    began = [n for n in range(1000) if _attempts(log, float(n))]
    gaps = [b - a for a, b in pairwise(began)]
    assert gaps == sorted(gaps) and gaps[0] < gaps[-1] <= MOST_RETRY_S + 1.0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run", "run-2"]


def _attempts(log: Log, now_s: float) -> bool:
    before = len(log.content.furnished)
    log.put("x", now_s)
    return len(log.content.furnished) > before


def test_a_folder_that_was_deleted_is_noticed(log: Log) -> None:
    log.put("1", 0.0)
    shutil.rmtree(log.out.folder)
    log.put("2", CHECK_S + 1.0)
    assert log.out.number == 2 and log.rows("run-2") == ["a", "2"] and log.out.stopped is None
    log.out.close()


def test_one_deleted_file_counts_as_deleted(log: Log) -> None:
    log.put("1", 0.0)
    (log.out.folder / "b.csv").unlink()
    log.put("2", CHECK_S + 1.0)
    assert log.rows() == ["a", "1"] and log.rows("run-2") == ["a", "2"]
    log.out.close()


def test_a_medium_that_cannot_sync_stops_the_log_too(log: Log) -> None:
    log.put("1", 0.0)
    log.disk.fail_with(errno.EIO)
    log.files.sync()
    log.disk.fail_with(None)
    log.put("2", 0.1)
    assert log.out.stopped == "Input/output error"
    log.out.close()


@pytest.mark.parametrize("number", [errno.EINVAL, errno.EBADF])
def test_a_file_system_without_sync_is_no_fault(log: Log, number: int) -> None:
    log.put("1", 0.0)
    log.disk.fail_with(number)
    log.files.sync()
    log.disk.fail_with(None)
    log.put("2", 0.1)
    assert log.out.stopped is None and log.rows() == ["a", "1", "2"]
    log.out.close()


def test_a_stalled_medium_holds_nobody_up_and_too_much_is_lost_as_whole_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log_writer, "MOST_BYTES", 1000)
    disk = FaultyDisk()
    out = ThreadLog(LogSet(tmp_path / "run", Content(), disk))
    disk.stall()
    out.put("a.csv", b"00000\n", 0.0)
    disk.wait_for_stall()  # from here on its thread takes nothing more
    for n in range(1, 300):
        out.put("a.csv", f"{n:05d}\n".encode(), 0.0)
    assert out.lost_bytes > 0
    disk.go_on()
    wait_until(lambda: len((tmp_path / "run" / "a.csv").read_bytes()) > 900, "the rows that waited")
    out.put("a.csv", b"last\n", 0.0)
    out.close()
    rows = (tmp_path / "run" / "a.csv").read_text(encoding="utf-8").splitlines()
    kept = [int(row) for row in rows[1:-1]]
    assert rows[-1] == "last" and kept == list(range(len(kept))) and len(kept) * 6 + out.lost_bytes == 300 * 6


def test_a_burst_is_one_write_and_closing_does_not_wait_for_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The thread that writes was woken by each row, and took the interpreter from the tick or the upload in hand."""
    monkeypatch.setattr(log_writer, "_GATHER_S", 1e6)
    disk = CountingDisk()
    out = ThreadLog(LogSet(tmp_path / "run", Content(), disk))
    headers = disk.appended
    for n in range(100):
        out.put("a.csv", f"{n}\n".encode(), 0.0)
    out.close()
    assert disk.appended == headers + 1
    assert (tmp_path / "run" / "a.csv").read_text(encoding="utf-8").splitlines()[1:] == [str(n) for n in range(100)]


def test_closing_gives_up_on_a_medium_that_never_answers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_writer, "_CLOSING_S", 0.0)
    disk = FaultyDisk()
    out = ThreadLog(LogSet(tmp_path / "run", Content(), disk))
    disk.stall()
    out.put("a.csv", b"row\n", 0.0)
    disk.wait_for_stall()
    out.close()
    disk.go_on()


def test_the_new_folder_is_a_whole_log_with_the_parameters_of_now(tmp_path: Path) -> None:
    disk, states = FaultyDisk(), list[Path]()
    manifest = {"vessel": "test", "parameters": {"WP_SPEED": 0.5, "NAV_ACC_RAD": 2.0}}
    medium = Medium(durable=True, disk=disk)
    log = LogFolder(tmp_path / "run", ["port", "starboard"], ["gnss"], manifest, TABLE, medium, states.append)
    health = (DeviceHealth("gnss", False, None, "no fix"),)
    log.record(replace(tick(0.0), health=health))
    disk.fail_with()
    log.parameter("WP_SPEED", 0.75)
    log.record(replace(tick(1.0), health=health))
    disk.fail_with(None)
    for n in (50, 51):
        log.record(replace(tick(float(n)), health=health))
    log.close()
    folder = tmp_path / "run-2"
    assert json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["parameters"] == {
        "WP_SPEED": 0.75,
        "NAV_ACC_RAD": 2.0,
    }
    rows = list(csv.DictReader((folder / "ticks.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(row["t_s"]) for row in rows] == [50.0, 51.0]
    ticks = list(read_ticks(folder / "log.mcap", []))
    assert [t.t_s for t in ticks] == [50.0, 51.0]
    assert [h.text for t in ticks for h in t.health] == ["no fix"], "what the devices report is there again"
    assert (folder / "ticks.ulg").stat().st_size > 1000 and states == [tmp_path / "run", folder]


class Output:
    """A log as `LogWatch` sees it."""

    def __init__(self) -> None:
        self.folder, self.number, self.stopped, self.lost_bytes = Path("run"), 1, None, 0
        self.stopped: str | None

    def put(self, name: str, data: bytes, now_s: float) -> None: ...

    def close(self) -> None: ...


def test_people_are_told_when_it_stops_every_five_minutes_and_when_it_goes_on() -> None:
    output, said = Output(), list[tuple[float, TextKind, str]]()
    log: LogOutput = output
    watch = LogWatch(log, lambda t_s, kind, name, text: said.append((t_s, kind, text)))
    for n in range(2000):
        now_s = float(n)
        if n == 10:
            output.stopped = "No space left on device"
            assert not log_health(log).ok
        if n == 800:
            output.stopped, output.number, output.folder = None, 2, Path("run-2")
        if n == 900:
            output.lost_bytes = 5000
        watch.update(now_s)
        assert bool(watch.fault) == (10 <= n < 800)
    stopped = "Log stopped: No space left on device"
    assert said == [
        (10.0, TextKind.ATTENTION, stopped),
        (10.0 + REMIND_S, TextKind.ATTENTION, stopped),
        (10.0 + 2.0 * REMIND_S, TextKind.ATTENTION, stopped),
        (800.0, TextKind.ROUTINE, "Log goes on in run-2"),
        (800.0 + REMIND_S, TextKind.ATTENTION, "Log has gaps: the medium is too slow"),
    ]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EIO])
def test_a_medium_that_is_full_at_the_start_begins_the_log_later(number: int, tmp_path: Path) -> None:
    disk, run = FaultyDisk(), tmp_path / "run"
    disk.fail_with(number)
    with pytest.raises(OSError, match=os.strerror(number)):
        LogSet(run, Content(), disk)
    files = LogSet(run, Content(), disk, patient=True)
    assert files.stopped == os.strerror(number) and files.number == 0
    files.put({"a.csv": b"1\n"}, 1.0)
    disk.fail_with(None)
    files.put({"a.csv": b"2\n"}, 100.0)
    assert files.stopped is None and files.lost_bytes == 2 and files.folder == run
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run"]
    assert (run / "a.csv").read_text(encoding="utf-8").splitlines() == ["a", "2"]
    files.close()


def test_a_mistake_at_the_start_is_not_waited_for(tmp_path: Path) -> None:
    disk = FaultyDisk()
    disk.fail_with(errno.EACCES)
    with pytest.raises(PermissionError):
        LogSet(tmp_path / "run", Content(), disk, patient=True)


def test_a_log_that_begins_anew_leaves_other_runs_of_the_same_second_alone(log: Log, tmp_path: Path) -> None:
    """A computer without a clock begins its runs at the same second; retention may have deleted the first of them."""
    for name in ("run-2", "run-3"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.csv").write_text("theirs\n", encoding="utf-8")
    log.put("1", 0.0)
    log.disk.fail_with(errno.ENOSPC)
    for n in range(60):
        log.put("2", 1.0 + n)
    log.disk.fail_with(None)
    log.put("3", 1.0 + 2.0 * MOST_RETRY_S)
    assert log.out.folder.name == "run-4" and log.rows("run-4") == ["a", "3"]
    assert log.rows("run-2") == log.rows("run-3") == ["theirs"]
    log.out.close()
