"""Deletes the oldest log folders while all together are larger than a limit."""

from __future__ import annotations

import contextlib
import shutil
import threading
from collections.abc import Callable
from pathlib import Path

from companion.core.log_names import is_of_run

_MARK = "manifest.json"  # only folders with this file are ever deleted
_PERIOD_S = 300.0


def size_bytes(folder: Path) -> int:
    """Size of all files in a folder; files that vanish meanwhile are ignored."""
    total = 0
    for path in folder.rglob("*"):
        try:
            total += path.stat().st_size if path.is_file() else 0
        except OSError:
            continue
    return total


def trim(directory: Path, limit_bytes: int, current: Path) -> tuple[list[Path], int]:
    """Delete the oldest log folders in `directory` until all together hold at most `limit_bytes`. `current` is never
    deleted, nor are the folders in which its log went on.

    The oldest is the one written last the longest ago: a computer that keeps no time while it is off may begin a log
    years too early, and learns the time under way.

    Returns the deleted folders and the bytes left. A folder that cannot be deleted stays, without an error. Raises
    OSError for a directory that cannot be read.
    """
    logs = [path for path in directory.iterdir() if _is_log(path)] if directory.is_dir() else []
    sizes = {path: size_bytes(path) for path in logs}
    total = sum(sizes.values())
    deleted: list[Path] = []
    for path in sorted((path for path in logs if not is_of_run(path.name, current.name)), key=_ended_s):
        if total <= limit_bytes:
            break
        shutil.rmtree(path, ignore_errors=True)
        if not path.exists():
            deleted.append(path)
            total -= sizes[path]
    return deleted, total


def _is_log(path: Path) -> bool:
    try:
        return (path / _MARK).is_file()
    except OSError:  # not ours to read, as lost+found at the top of a medium
        return False


def _ended_s(folder: Path) -> float:
    """When a file in it was written last, by the computer's clock; 0 for a folder that vanishes meanwhile."""
    newest_s = 0.0
    for path in folder.rglob("*"):
        try:
            newest_s = max(newest_s, path.stat().st_mtime)
        except OSError:
            continue
    return newest_s


class Retention:
    """Trims in a thread of its own: at once, and every five minutes. Warns once when the present run alone is over the
    limit."""

    def __init__(self, directory: Path, limit_bytes: int, current: Path, warn: Callable[[str], None]) -> None:
        self._arguments = (directory, limit_bytes, current)
        self._warn = warn
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="log-retention", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the thread."""
        self._stop.set()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        warned = False
        while True:
            left = 0
            with contextlib.suppress(OSError):  # a medium that fails may be well again later
                _, left = trim(*self._arguments)
            if left > self._arguments[1] and not warned:
                warned = True
                limit_mb = self._arguments[1] / 1e6
                self._warn(
                    f"logs hold {left / 1e6:.0f} MB, more than their limit of {limit_mb:.0f} MB: "
                    "nothing older is left to delete"
                )
            if self._stop.wait(_PERIOD_S):
                return


def keep_logs(directory: Path, limit_mb: int | None, current: Path, warn: Callable[[str], None]) -> Retention | None:
    """The Retention of `--log-limit`; None without a limit."""
    return None if limit_mb is None else Retention(directory, limit_mb * 1_000_000, current, warn)
