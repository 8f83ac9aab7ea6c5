"""Trials of a vessel's file: a process beside the boat identifies its model, and the overlays say which one counts.

`companion identify --beside` is that process: it comes after all other programs, and tells what it found in one line of
JSON. The control thread waits neither for it nor for the medium.
"""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from companion.cli.common import end
from companion.config.overlay import in_force, parameters_that_count, proposed, set_accepted
from companion.config.vessel import ConfigError, load
from companion.core.ports import Worker
from companion.core.storing import Stored, Ticket
from companion.core.tick import Tick
from companion.core.trial_results import TrialFinding, TrialResultError
from companion.core.work import settle
from companion.io.transport.threads import begun

if TYPE_CHECKING:
    from companion.analysis.trial_identify import TrialIdentification

_LONGEST_S = 1800.0  # on a small board that sails meanwhile
_SETTLED_S = 2.0  # in which the log's last rows come to the disk
REPORT = "trial.html"  # in the log folder

Identify = Callable[[], TrialFinding]


class FileTrials:
    """Implements `core.trial_results.TrialResults` with the overlays beside a vessel's file; as a recorder it only ends
    what runs. Remembers which overlay waits and which counts, as they were when something last changed."""

    def __init__(self, vessel_file: Path, identify: Identify, worker: Worker, close: Callable[[], None] = lambda: None):
        """`identify` runs in a thread of its own; `worker` changes the files. `close`: ends what `identify` waits
        for."""
        self._file, self._identify, self._worker, self._close = vessel_file, identify, worker, close
        self._proposal: str | None = None
        self._in_force: str | None = None
        self._parameters: Mapping[str, float] = {}
        self._look()

    @property
    def proposal(self) -> str | None:
        """As `TrialResults.proposal`."""
        return self._proposal

    @property
    def in_force(self) -> str | None:
        """As `TrialResults.in_force`."""
        return self._in_force

    @property
    def parameters(self) -> Mapping[str, float]:
        """As `TrialResults.parameters`."""
        return self._parameters

    def identify(self) -> Future[TrialFinding]:
        """As `TrialResults.identify`."""
        future: Future[TrialFinding] = Future()
        if begun(partial(settle, future, self._identified), "trial") is None:
            future.set_exception(TrialResultError("no threads left"))
        return future

    def _identified(self) -> TrialFinding:
        found = self._identify()
        self._look()
        return found

    def accept(self) -> Ticket:
        """As `TrialResults.accept`. A model that the vessel's file does not take is not accepted."""
        return self._change(lambda: accept(self._file))

    def undo(self) -> Ticket:
        """As `TrialResults.undo`."""
        return self._change(lambda: undo(self._file))

    def _change(self, change: Callable[[], object]) -> Ticket:
        ticket = Ticket()

        def work() -> None:
            try:
                change()
                self._look()
            except (OSError, ValueError, ConfigError) as error:
                reason = error.strerror or str(error) if isinstance(error, OSError) else str(error).splitlines()[0]
                ticket.reason, ticket.state = reason, Stored.FAILED
            else:
                ticket.state = Stored.DURABLE

        self._worker.submit(work)
        return ticket

    def _look(self) -> None:
        with contextlib.suppress(OSError, ValueError):
            waits, counts = proposed(self._file), in_force(self._file)
            self._proposal = None if waits is None else waits.name
            self._in_force = None if counts is None else counts.name
            self._parameters = parameters_that_count(self._file)

    def record(self, tick: Tick) -> None:
        """Nothing to record."""

    def close(self) -> None:
        """End an identification that runs."""
        self._close()


class IdentifyProcess:
    """`identify` for `FileTrials`: one process at a time, in a session of its own. It tells what it found and then
    writes the report, even if the boat is rebooted or ended by Ctrl-C meanwhile; `close` ends one that has not told
    yet, and leaves it `unfinished`."""

    def __init__(self, vessel_file: Path, log_folder: Path) -> None:
        command = ["identify", str(log_folder), "--vessel", str(vessel_file), "--beside"]
        self.command = [sys.executable, "-m", "companion", *command]
        self._process: subprocess.Popen[str] | None = None
        self._told = False
        self._runs = False
        self._ended = threading.Event()
        self.unfinished = False

    def __call__(self) -> TrialFinding:
        """Run it until it has told what it found. Raises TrialResultError."""
        self._runs = True
        try:
            return self._found()
        finally:
            self._runs = False

    def _found(self) -> TrialFinding:
        if self._process is not None:
            self._process.wait()  # it may still write the report of the trial before
        self._told = False
        self._ended.wait(_SETTLED_S)
        if self._ended.is_set():
            raise TrialResultError("the program ends")
        with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as complaints:
            self._process = process = subprocess.Popen(
                self.command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=complaints,
                text=True,
                start_new_session=True,
            )
            limit = threading.Timer(_LONGEST_S, process.kill)
            limit.daemon = True
            limit.start()
            assert process.stdout is not None
            with process.stdout as said:
                out = said.readline()  # it goes on with the report
            limit.cancel()
            if self._ended.is_set():
                raise TrialResultError("the program ends")
            self._told = bool(out)
            complaints.seek(0)
            return finding_of(out, complaints.read())

    def close(self) -> None:
        """End it, unless it has told already."""
        self.unfinished |= self._runs and not self._told
        self._ended.set()
        process = self._process
        if process is None or self._told:
            return
        end(process)


def accept(vessel_file: Path) -> Path:
    """Let the newest proposal of a vessel's file count; returns it. Raises ValueError without one, OSError, ConfigError
    where the file does not take it: then it does not count."""
    overlay = proposed(vessel_file)
    if overlay is None:
        raise ValueError(f"{vessel_file}: no overlay waits to be accepted")
    accept_overlay(vessel_file, overlay)
    return overlay


def accept_overlay(vessel_file: Path, overlay: Path) -> None:
    """Let `overlay` count. Raises ValueError for a file that is none, OSError, ConfigError where the vessel's file does
    not take it: then it does not count."""
    set_accepted(overlay, True)
    try:
        load(vessel_file)
    except ConfigError:
        set_accepted(overlay, False)
        raise


def undo(vessel_file: Path) -> Path:
    """The overlay in force counts no longer; returns it. Raises ValueError without one, OSError."""
    overlay = in_force(vessel_file)
    if overlay is None:
        raise ValueError(f"{vessel_file}: no overlay counts, so there is nothing to undo")
    set_accepted(overlay, False)
    return overlay


def identified(log_folder: Path, vessel_file: Path) -> TrialIdentification:
    """Identify from the log. The overlay goes beside the vessel's file, or into the log folder where that is not
    possible; the picture into the log folder. Raises TrialResultError, LogError, OSError."""
    from companion.analysis.log_reader import open_log
    from companion.analysis.trial_identify import identify_trial, write

    found = identify_trial(open_log(log_folder))
    date = datetime.now(UTC).date().isoformat()
    try:
        write(found, vessel_file.parent, vessel_file.stem, date)
    except OSError as error:
        overlay, _ = write(found, log_folder, vessel_file.stem, date)
        raise TrialResultError(f"{vessel_file.parent}: {error.strerror}; the model is in {overlay}") from error
    return found


def finding(found: TrialIdentification) -> TrialFinding:
    """In short."""
    return TrialFinding(found.better, None if found.prediction is None else found.prediction.ratio)


def report(found: TrialIdentification, log_folder: Path) -> None:
    """Write the report of the trial into the log folder. Raises LogError, OSError."""
    from companion.analysis.trial_report import write_report
    from companion.cli.keeping import keepings

    write_report(found, log_folder / REPORT, keepings(found))


def line_of(work: Identify) -> str:
    """What `work` found, or why it could not, as `finding_of` reads it."""
    from companion.analysis.log_reader import LogError

    try:
        found = work()
    except (LogError, TrialResultError, OSError) as error:
        return json.dumps({"error": str(error)})
    return json.dumps({"better": found.better, "error_share": found.error_share})


def finding_of(out: str, err: str) -> TrialFinding:
    """What the process printed. Raises TrialResultError with its reason, or the last line of its complaints."""
    try:
        said = json.loads(out.strip().splitlines()[-1])
        if "error" in said:
            raise TrialResultError(str(said["error"]))
        return TrialFinding(bool(said["better"]), said["error_share"])
    except (IndexError, ValueError, KeyError, TypeError) as error:
        lines = err.strip().splitlines()
        raise TrialResultError(lines[-1] if lines else "the process said nothing") from error
