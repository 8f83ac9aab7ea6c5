"""Replace a whole file: a power cut leaves the old content or the new, never a mixture."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path


def replace_file(
    directory: Path, name: str, data: bytes, mode: int = 0o644, owner: tuple[int, int] | None = None
) -> None:
    """Write a temporary file, fsync, rename, fsync the directory. `owner`: (user, group) of the new file.

    Raises OSError, and then leaves nothing behind.
    """
    temporary = directory / f"{name}.tmp"
    try:
        temporary.unlink(missing_ok=True)  # one left by a power cut would keep its own mode
        fd = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, mode)
        try:
            if owner is not None:
                os.fchown(fd, *owner)
            write_all(fd, data)
            os.fsync(fd)
        finally:
            os.close(fd)
        temporary.replace(directory / name)
        _sync_directory(directory)
    except OSError:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise


def write_all(fd: int, data: bytes) -> None:
    """Write all of `data`, in as many calls as it takes. Raises OSError."""
    view = memoryview(data)
    while view:
        written = os.write(fd, view)
        view = view[written:]


def _sync_directory(directory: Path) -> None:
    fd = os.open(directory, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        os.fsync(fd)
    finally:
        os.close(fd)
