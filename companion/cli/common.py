"""What several commands share: errors of use, the folders of a boat, the end of a run."""

from __future__ import annotations

import argparse
import contextlib
import errno
import math
import os
import shlex
import signal
import subprocess
import sys
import tempfile
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from companion.clock import DrivenClock
from companion.core.nearest import did_you_mean
from companion.core.ports import Clock
from companion.record.log_writer import medium_fails

_BLOCK = 4096
_ENDING_S = 5.0  # in which a process may end by itself


class UsageError(Exception):
    """A command that cannot be carried out: one line that says why and what to do."""


def seeds(text: str) -> range:
    """The seeds `0-7`, or `3` alone. Raises ArgumentTypeError."""
    first, _, last = text.partition("-")
    with contextlib.suppress(ValueError):
        if found := range(int(first), int(last or first) + 1):
            return found
    raise argparse.ArgumentTypeError(f"'{text}': write A-B, as 0-7, or one seed")


def judge_time(speed: float, duration_s: float | None) -> None:
    """Raises UsageError for a speed or a duration that makes no sense."""
    if not 0.0 < speed < math.inf:
        raise UsageError(f"--speed {speed:g}: a number above 0")
    if duration_s is not None and not duration_s > 0.0:
        raise UsageError(f"--duration {duration_s:g}: must be above 0")


def chosen(option: str, asked: Sequence[str], known: Collection[str]) -> list[str]:
    """What `--option` names of what there is: all where it is left out, and nothing for `list`, which prints them.
    Raises UsageError for a name that is not known."""
    if list(asked) == ["list"]:
        print("\n".join(known))
        return []
    for name in asked:
        if name not in known:
            raise UsageError(f"no {option} '{name}'{did_you_mean(name, known)}; --{option} list shows them")
    return list(asked or known)


def typed(*words: object) -> str:
    """A command of this program as a person types it in a shell."""
    return f"companion {shlex.join(map(str, words))}"


def add_clock_to(parser: argparse.ArgumentParser) -> None:
    """Add `--clock HOST:PORT`: the time comes from another program (`companion.clock.DrivenClock`). It is for tests and
    co-simulation; the help leaves it out."""
    parser.add_argument("--clock", metavar="HOST:PORT", help=argparse.SUPPRESS)


def driven_clock(text: str, epoch_unix_ns: int) -> DrivenClock:
    """The clock of `--clock text`. Raises UsageError for what is no address, OSError where nothing listens there."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal():
        raise UsageError(f"--clock {text}: write HOST:PORT")
    return DrivenClock((host, int(port)), epoch_unix_ns)


class Interrupt:
    """Takes over the signals that end a process, and remembers in `received` whether one of them has come: Ctrl-C,
    SIGTERM, and SIGHUP of a terminal that closes.

    A process started with `nohup` outlives its terminal. SIGPIPE ends nothing: a client that hangs up, or a pipe that
    nobody reads any more, is told by an error where it is written to.
    """

    def __init__(self) -> None:
        self.received = False
        signal.signal(signal.SIGINT, self._note)
        signal.signal(signal.SIGTERM, self._note)
        if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
            signal.signal(signal.SIGHUP, self._note)
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)

    def _note(self, number: int, frame: object) -> None:
        self.received = True


class _Outliving:
    """A text stream of which nobody may read any more: what cannot be written is lost, and raises nothing."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write, or lose, `text`."""
        with contextlib.suppress(OSError, ValueError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Write, or lose, what waits."""
        with contextlib.suppress(OSError, ValueError):
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def outlive_outputs() -> None:
    """From now on a terminal or a pipe that is gone stops nothing that prints."""
    sys.stdout, sys.stderr = _Outliving(sys.stdout), _Outliving(sys.stderr)


def is_over(clock: Clock, duration_s: float | None) -> bool:
    """Whether `clock` has reached `duration_s`; False where that is None."""
    return duration_s is not None and clock.now_s() >= duration_s


def boat_folder(name: str, simulated: bool = False) -> Path:
    """The folder of a boat's logs and state in the user's home. A simulated boat has its own. Raises UsageError for a
    user without a home."""
    try:
        base = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state")
    except RuntimeError as error:
        raise UsageError("this user has no home to keep logs and state in: set HOME, or --log and --state") from error
    return base / "usv-companion" / (f"{name}-sitl" if simulated else name)


def new_folder(directory: Path, name: str) -> Path:
    """The path `directory/name`, numbered if that already exists. Creates nothing."""
    folder, n = directory / name, 2
    while folder.exists():
        folder, n = directory / f"{name}-{n}", n + 1
    return folder


_REMEDIES: Mapping[int, str] = {
    errno.EACCES: "permission denied; `sudo chown $USER` gives it to you, or",
    errno.EROFS: "the medium is read-only; mount it for writing, or",
    errno.ENOSPC: "the medium is full; delete old logs (--log-limit does), or",
    errno.ENOTDIR: "part of it is a file, not a folder;",
    errno.EEXIST: "it is a file, not a folder;",
}


def judge_log_folder(folder: Path) -> None:
    """Make `folder`, where log folders will be made. Raises UsageError where nothing can be written there."""
    try:
        _try(folder)
    except OSError as error:
        raise no_log(folder, error) from error


def judge_log_limit(limit_mb: int | None) -> None:
    """Raises UsageError for a `--log-limit` under 1 MB."""
    if limit_mb is not None and limit_mb < 1:
        raise UsageError(f"--log-limit {limit_mb}: must be at least 1 MB")


def judge_logs(logs: Path, sitl: bool) -> None:
    """Make the folder of the logs. A medium that is full or fails is said, and keeps no boat ashore, nor one adrift
    whose computer has just restarted. Raises UsageError as `judge_log_folder` for all else, and in simulation."""
    try:
        judge_log_folder(logs)
    except UsageError as error:
        cause = error.__cause__
        if sitl or not isinstance(cause, OSError) or not medium_fails(cause):
            raise
        complain(f"{error}; until then it runs without a log")


def judge_out_folder(folder: Path) -> None:
    """Make `folder`, in which results of long work will be written. Raises UsageError as `judge_log_folder`."""
    try:
        _try(folder)
    except OSError as error:
        raise UsageError(f"nothing can be written in {folder}: {_remedy(error)} choose another one by --out") from error


def no_log(folder: Path, error: OSError) -> UsageError:
    """What to say where no log can be written in `folder`."""
    return UsageError(f"no log can be written in {folder}: {_remedy(error)} choose another folder by --log")


def no_ports(folder: Path, error: OSError) -> UsageError:
    """What to say where no ports of simulated devices can be made in `folder`."""
    return UsageError(f"no ports can be made in {folder}: {_remedy(error)} choose another folder by --dir")


def _try(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder, buffering=0) as file:
        file.write(bytes(_BLOCK))  # a full medium often still takes an empty file


def _remedy(error: OSError) -> str:
    return _REMEDIES.get(error.errno or 0, f"{error.strerror or error};")


def complain(text: str) -> None:
    """One line on standard error, in the program's name."""
    print(f"companion: {text}", file=sys.stderr)


def tell_fault(trace: str) -> None:
    """Write the whole trace of a fault that does not end the program to stderr."""
    complain(f"a fault of the program, which goes on; please report it:\n{trace}")


def print_warnings(warnings: Iterable[str]) -> None:
    """Each warning on its own line of standard error."""
    for warning in warnings:
        print(f"warning: {warning}", file=sys.stderr)


def add_time_span(parser: argparse.ArgumentParser) -> None:
    """The options `--from` and `--to`, as `from_s` and `to_s`: the part of a log that a command uses."""
    parser.add_argument(
        "--from",
        type=float,
        default=0.0,
        metavar="S",
        dest="from_s",
        help="leave out what was before, in the boat's time",
    )
    parser.add_argument("--to", type=float, default=float("inf"), metavar="S", dest="to_s")


def end(process: subprocess.Popen[Any]) -> None:
    """Ask a process to end, and kill it where it does not."""
    process.terminate()
    try:
        process.wait(_ENDING_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
