"""Where `companion identify LOGDIR` of a Trial writes, and whether what it says to type next can be typed."""

from __future__ import annotations

import shlex
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from companion.analysis import trial_identify, trial_log
from companion.cli import identify
from companion.cli.main import main
from companion.config.overlay import in_force
from companion.config.vessel import find
from tests.unit.config.test_overlay import OVERLAY


@pytest.fixture
def vessel_file(tmp_path: Path) -> Path:
    path = tmp_path / "boat.toml"
    shutil.copyfile(find("revolt"), path)
    return path


@pytest.fixture
def log_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The log of a Trial whose finding is OVERLAY."""
    folder = tmp_path / "log"
    folder.mkdir()
    log = SimpleNamespace(folder=folder, config=SimpleNamespace(name="revolt"))
    model = SimpleNamespace(simulate=lambda values: values)
    found = SimpleNamespace(overlay=OVERLAY, log=log, model=model, fit=None, values=(), warnings=(), text="")
    monkeypatch.setattr(identify, "open_log", lambda _: log)
    monkeypatch.setattr(trial_log, "manoeuvres", lambda _: ("drift",))
    monkeypatch.setattr(trial_identify, "identify_trial", lambda *_: found)
    monkeypatch.setattr(trial_identify, "replace", lambda fit, **_: fit)
    monkeypatch.setattr(trial_identify, "plot", lambda _model, _fit, picture: picture.write_bytes(b""))
    return folder


@pytest.mark.parametrize("elsewhere", [False, True])
def test_the_command_that_accepts_the_overlay_can_be_typed_as_it_is_told(
    elsewhere: bool, vessel_file: Path, log_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[Any]
) -> None:
    out = tmp_path / "out"
    place = ["--out", str(out)] if elsewhere else []
    assert main(["identify", str(log_folder), "--vessel", str(vessel_file), *place]) == 0
    told = capsys.readouterr().out.splitlines()[-1]
    assert main(shlex.split(told.partition(": companion ")[2])) == 0
    assert in_force(vessel_file) is not None


@pytest.mark.parametrize("elsewhere", [False, True])
def test_the_picture_goes_where_it_is_asked_for(
    elsewhere: bool, vessel_file: Path, log_folder: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    place = ["--out", str(out)] if elsewhere else []
    assert main(["identify", str(log_folder), "--vessel", str(vessel_file), *place]) == 0
    assert (out / "identified.png").is_file() is elsewhere
    assert (log_folder / "identified.png").is_file() is not elsewhere
