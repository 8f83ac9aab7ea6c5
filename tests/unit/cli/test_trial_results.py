"""The overlays of a vessel's file as the boat sees them, and what the process beside it says."""

from __future__ import annotations

import os
import resource
import shutil
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

from companion.analysis.trial_identify import write
from companion.cli.main import main
from companion.cli.trial_results import FileTrials, IdentifyProcess, finding_of, line_of
from companion.config.overlay import free_place, in_force, overlays
from companion.config.vessel import find, load
from companion.core.storing import Stored
from companion.core.trial_results import TrialFinding, TrialResultError
from companion.core.work import AtOnce
from tests.threadless import no_threads
from tests.unit.config.test_overlay import OVERLAY


@pytest.fixture
def vessel_file(tmp_path: Path) -> Path:
    path = tmp_path / "boat.toml"
    shutil.copyfile(find("revolt"), path)
    return path


def found(vessel_file: Path, text: str = OVERLAY) -> TrialFinding:
    """What `finding` does, without the fit."""
    free_place(vessel_file.parent, "boat", "2026-11-22").write_text(text, encoding="utf-8")
    return TrialFinding(True, 0.4)


def trials_of(vessel_file: Path, text: str = OVERLAY) -> FileTrials:
    return FileTrials(vessel_file, lambda: found(vessel_file, text), AtOnce())


def test_a_finding_is_proposed_accepted_and_undone(vessel_file: Path) -> None:
    trials, before = trials_of(vessel_file), load(vessel_file)
    assert (trials.proposal, trials.in_force) == (None, None)
    assert trials.identify().result(20.0) == TrialFinding(True, 0.4)
    assert (trials.proposal, trials.in_force) == ("boat.trial-2026-11-22.toml", None)
    assert load(vessel_file) == before
    assert trials.accept().state is Stored.DURABLE
    assert (trials.proposal, trials.in_force) == (None, "boat.trial-2026-11-22.toml")
    assert load(vessel_file).hull.m11_kg == 300.0 and trials.parameters == {"DP_BW_SURGE": 0.4}
    trials.identify().result(20.0)
    assert trials.proposal == "boat.trial-2026-11-22b.toml"  # nothing in force is overwritten
    assert trials.accept().durable and trials.undo().durable
    assert trials.in_force == "boat.trial-2026-11-22.toml"
    assert trials.undo().durable and load(vessel_file) == before and trials.parameters == {}
    assert trials.undo().reason.endswith("nothing to undo")
    trials.close()


def test_without_threads_a_trial_is_not_identified(vessel_file: Path) -> None:
    trials = trials_of(vessel_file)
    with no_threads(), pytest.raises(TrialResultError, match="no threads left"):
        trials.identify().result(0.0)


def test_an_overlay_for_which_there_is_no_room_is_none(vessel_file: Path) -> None:
    """Half of one could be accepted: what is cut off after a line is a valid file."""
    whole = SimpleNamespace(overlay=OVERLAY)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(OVERLAY) // 2, limits[1]))
    try:
        with pytest.raises(OSError):
            write(whole, vessel_file.parent, "boat", "2026-11-22")  # type: ignore[arg-type]
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert (
        overlays(vessel_file) == () and FileTrials(vessel_file, lambda: found(vessel_file), AtOnce()).proposal is None
    )


def test_a_report_that_cannot_be_written_is_said_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    assert main(["trial", "report", str(tmp_path), "--out", str(tmp_path / "file" / "trial.html")]) == 2
    assert "nothing can be written in" in capsys.readouterr().err


def test_a_model_that_the_file_does_not_take_is_not_accepted(vessel_file: Path) -> None:
    trials = trials_of(vessel_file, OVERLAY.replace("300.0", "-1.0"))
    trials.identify().result(20.0)
    ticket = trials.accept()
    assert ticket.state is Stored.FAILED and "m11_kg" in ticket.reason
    assert in_force(vessel_file) is None and trials.proposal is not None


def test_the_newest_is_accepted_by_the_name_of_the_vessel(
    vessel_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["trial", "accept", str(vessel_file)]) == 2
    assert "no overlay waits to be accepted" in capsys.readouterr().err
    found(vessel_file)
    assert main(["trial", "accept", str(vessel_file)]) == 0
    assert in_force(vessel_file) is not None


def test_the_line_of_the_process_is_read_as_it_was_meant() -> None:
    assert finding_of("words\n" + line_of(lambda: TrialFinding(False, 1.2)), "") == TrialFinding(False, 1.2)

    def fails() -> TrialFinding:
        raise TrialResultError("too short")

    with pytest.raises(TrialResultError, match="too short"):
        finding_of(line_of(fails), "")
    with pytest.raises(TrialResultError, match="MemoryError"):
        finding_of("", "Traceback\nMemoryError\n")
    with pytest.raises(TrialResultError, match="said nothing"):
        finding_of("", "")


@pytest.mark.process
def test_a_process_that_is_ended_is_no_finding(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    process = IdentifyProcess(tmp_path / "boat.toml", tmp_path)
    monkeypatch.setattr("companion.cli.trial_results._SETTLED_S", 0.0)
    assert "identify" in process.command and process.command[0] == sys.executable
    with pytest.raises(TrialResultError, match="no such file"):
        process()
    process.close()
    assert not process.unfinished
    with pytest.raises(TrialResultError, match="the program ends"):
        process()


@pytest.mark.process
def test_one_that_is_ended_before_it_has_told_is_unfinished(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """So that the end of the run can say it: Ctrl-C ended it without a word."""
    process = IdentifyProcess(tmp_path / "boat.toml", tmp_path)
    monkeypatch.setattr("companion.cli.trial_results._SETTLED_S", 0.0)
    begun = tmp_path / "begun"
    code = f"import pathlib, time; pathlib.Path({str(begun)!r}).touch(); time.sleep(60.0)"
    process.command = [sys.executable, "-c", code]
    ended: list[str] = []

    def run() -> None:
        with pytest.raises(TrialResultError) as error:
            process()
        ended.append(str(error.value))

    thread = threading.Thread(target=run)
    thread.start()
    while not begun.exists():
        thread.join(0.01)
    process.close()
    thread.join(20.0)
    assert process.unfinished and ended == ["the program ends"]


@pytest.mark.process
def test_ctrl_c_for_the_boat_leaves_the_report_in_the_making(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C goes to all processes of a terminal's session. `trial.html` was never written then."""
    process = IdentifyProcess(tmp_path / "boat.toml", tmp_path)
    monkeypatch.setattr("companion.cli.trial_results._SETTLED_S", 0.0)
    session = tmp_path / "session"
    code = f"import os, pathlib; pathlib.Path({str(session)!r}).write_text(str(os.getsid(0)))"
    process.command = [sys.executable, "-c", code]
    with pytest.raises(TrialResultError, match="said nothing"):
        process()
    process.close()
    assert int(session.read_text(encoding="utf-8")) != os.getsid(0)
