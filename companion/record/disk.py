"""The medium, as the writers see it. Tests have one that is slow, full or gone."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Protocol

from companion.record.replacing import replace_file, write_all

Owner = tuple[int, int]  # user, group


class Disk(Protocol):
    """Calls that may take seconds. Each raises OSError where the medium fails."""

    def replace(self, directory: Path, name: str, data: bytes, mode: int, owner: Owner | None) -> None:
        """Replace a file as a whole and sync it: a power cut leaves the old content or the new."""
        ...

    def begin(self, path: Path) -> int:
        """Make an empty file; returns its descriptor, for appending."""
        ...

    def append(self, descriptor: int, data: bytes) -> None:
        """Write all of `data`."""
        ...

    def sync(self, descriptor: int) -> None:
        """Sync what was appended to the medium."""
        ...


class RealDisk:
    """The `Disk` of a boat."""

    def replace(self, directory: Path, name: str, data: bytes, mode: int, owner: Owner | None) -> None:
        """As `Disk.replace`."""
        replace_file(directory, name, data, mode, owner)

    def begin(self, path: Path) -> int:
        """As `Disk.begin`."""
        return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND | os.O_CLOEXEC, 0o644)

    def append(self, descriptor: int, data: bytes) -> None:
        """As `Disk.append`."""
        write_all(descriptor, data)

    def sync(self, descriptor: int) -> None:
        """As `Disk.sync`."""
        os.fdatasync(descriptor)


REAL_DISK = RealDisk()
