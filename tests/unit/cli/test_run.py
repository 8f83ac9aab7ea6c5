"""What keeps a run from starting, and what does not."""

from __future__ import annotations

import errno
import os
import tempfile
from pathlib import Path
from typing import NoReturn

import pytest

from companion.cli import run
from companion.cli.common import UsageError


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EIO])
def test_a_boat_starts_on_a_medium_that_takes_no_log(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A computer that restarted adrift with a full card left the boat without an autopilot."""

    def refused(**_: object) -> NoReturn:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(tempfile, "TemporaryFile", refused)
    run.judge_logs(tmp_path, sitl=False)
    assert capsys.readouterr().err.startswith(f"companion: no log can be written in {tmp_path}: ")
    with pytest.raises(UsageError, match="no log can be written"):
        run.judge_logs(tmp_path, sitl=True)


def test_a_mistake_of_the_log_folder_ends_the_run(tmp_path: Path) -> None:
    (tmp_path / "log").touch()
    with pytest.raises(UsageError, match="it is a file, not a folder"):
        run.judge_logs(tmp_path / "log", sitl=False)
