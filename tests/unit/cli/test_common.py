"""What several commands share."""

from __future__ import annotations

import argparse
import contextlib
import errno
import io
import os
import signal
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

import pytest

from companion.cli import common
from companion.cli.common import Interrupt, UsageError, judge_log_folder
from companion.cli.main import main
from tests.unit.console.recorded import write_log

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@pytest.fixture(autouse=True)
def _handlers() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in SIGNALS}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", SIGNALS)
def test_each_signal_is_remembered(number: signal.Signals) -> None:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    interrupt = Interrupt()
    assert not interrupt.received
    signal.raise_signal(number)
    assert interrupt.received


def test_what_nohup_started_outlives_its_terminal() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    interrupt = Interrupt()
    signal.raise_signal(signal.SIGHUP)
    assert not interrupt.received


def test_a_terminal_that_is_gone_stops_nothing_that_prints(monkeypatch: pytest.MonkeyPatch) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w", buffering=1, encoding="utf-8") as gone:
        monkeypatch.setattr(sys, "stdout", gone)
        monkeypatch.setattr(sys, "stderr", io.StringIO())
        common.outlive_outputs()
        print("nobody reads this", flush=True)
        sys.stderr.write("kept")
        assert sys.stderr.getvalue() == "kept"
        with contextlib.suppress(OSError):
            gone.close()


def test_a_log_folder_is_made_and_left_empty(tmp_path: Path) -> None:
    judge_log_folder(tmp_path / "logs" / "boat")
    assert list((tmp_path / "logs" / "boat").iterdir()) == []


def test_a_file_is_no_log_folder(tmp_path: Path) -> None:
    (tmp_path / "log").touch()
    for folder in (tmp_path / "log", tmp_path / "log" / "below"):
        with pytest.raises(UsageError, match=f"no log can be written in {folder}: .* choose another folder by --log"):
            judge_log_folder(folder)


@pytest.mark.parametrize("command", ["identify", "calibrate", "report"])
def test_results_of_long_work_are_refused_before_it_where_they_cannot_be_written(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They failed after it."""
    log, out = write_log(tmp_path / "log", 1), tmp_path / "file" / "out"
    (tmp_path / "file").touch()
    words = [command, str(log), "--out", str(out / "report.html" if command == "report" else out)]
    assert main(words) == 2
    said = (
        f"companion: nothing can be written in {out}: part of it is a file, not a folder; choose another one by --out"
    )
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("number", "remedy"),
    [(errno.EACCES, "sudo chown"), (errno.EROFS, "mount it for writing"), (errno.ENOSPC, "delete old logs")],
)
def test_a_medium_that_refuses_has_a_remedy(
    number: int, remedy: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(**_: object) -> NoReturn:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(tempfile, "TemporaryFile", refused)
    with pytest.raises(UsageError, match=f"{tmp_path}: .*{remedy}"):
        judge_log_folder(tmp_path)


def test_a_user_without_a_home_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """As in a container that runs as a number: it was a traceback, even with both folders given."""

    def none() -> NoReturn:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", none)
    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    with pytest.raises(UsageError, match="set HOME, or --log and --state"):
        common.boat_folder("revolt")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    assert common.boat_folder("revolt") == tmp_path / "usv-companion" / "revolt"


def test_a_full_medium_that_takes_an_empty_file_is_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Full(io.BytesIO):
        def write(self, data: object) -> NoReturn:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(tempfile, "TemporaryFile", lambda **_: Full())
    with pytest.raises(UsageError, match="the medium is full"):
        judge_log_folder(tmp_path)


def test_seeds_from_one_to_another() -> None:
    assert common.seeds("0-7") == range(8) and common.seeds("3") == range(3, 4)
    for text in ("5-3", "x", "", "1-2-3"):
        with pytest.raises(argparse.ArgumentTypeError, match="write A-B, as 0-7, or one seed"):
            common.seeds(text)
