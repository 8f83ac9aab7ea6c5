"""Many futures of one past: each cell of the matrix goes on from the same settled boat, in a process of its own."""

from __future__ import annotations

import os
import shutil
import sys
import traceback
from collections.abc import Callable
from pathlib import Path


def branch(folder: Path, into: Path, future: Callable[[], None]) -> bool:
    """Carry out `future` in a copy of this process, whose open files below `folder` are copies below `into`. Waits for
    it; returns whether it ended well. Only for a process without threads, on a system with /dev/fd."""
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    status = 1
    try:
        _move(folder.resolve(), into)
        future()
        status = 0
    except BaseException:  # noqa: BLE001  a copy of the process must not go on with what its parent does
        traceback.print_exc()
        sys.stderr.flush()
    os._exit(status)


def _move(folder: Path, into: Path) -> None:
    """Let every descriptor of a file below `folder` be one of its copy."""
    shutil.copytree(folder, into)
    for entry in Path("/dev/fd").iterdir():
        try:
            path = entry.readlink()
        except OSError:
            continue  # the descriptor of the listing itself
        if path.is_relative_to(folder):
            descriptor = os.open(into / path.relative_to(folder), os.O_WRONLY | os.O_APPEND)
            os.dup2(descriptor, int(entry.name))
            os.close(descriptor)
