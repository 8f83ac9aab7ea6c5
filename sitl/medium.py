"""The medium of a log that is full or read-only while a fault says so."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Protocol

from sitl.faults import Faults

_FAULTS = {"disk_full": errno.ENOSPC, "disk_read_only": errno.EROFS}


class Medium(Protocol):
    """The calls of `companion.record.disk.Disk`, each of which raises OSError where the medium fails."""

    def replace(self, directory: Path, name: str, data: bytes, mode: int, owner: tuple[int, int] | None) -> None:
        """Replace a file as a whole."""
        ...

    def begin(self, path: Path) -> int:
        """Make an empty file; returns its descriptor."""
        ...

    def append(self, descriptor: int, data: bytes) -> None:
        """Write all of `data`."""
        ...

    def sync(self, descriptor: int) -> None:
        """Sync what was appended."""
        ...


class FaultyMedium:
    """Another medium, with the faults of a run."""

    def __init__(self, medium: Medium, faults: Faults) -> None:
        self._medium, self._faults = medium, faults

    def replace(self, directory: Path, name: str, data: bytes, mode: int, owner: tuple[int, int] | None) -> None:
        """Replace a file as a whole. Raises OSError under a fault."""
        self._check()
        self._medium.replace(directory, name, data, mode, owner)

    def begin(self, path: Path) -> int:
        """Make an empty file; returns its descriptor. Raises OSError under a fault."""
        self._check()
        return self._medium.begin(path)

    def append(self, descriptor: int, data: bytes) -> None:
        """Write all of `data`. Raises OSError under a fault."""
        self._check()
        self._medium.append(descriptor, data)

    def sync(self, descriptor: int) -> None:
        """Sync what was appended. Raises OSError under a fault."""
        self._check()
        self._medium.sync(descriptor)

    def _check(self) -> None:
        for name, number in _FAULTS.items():
            if name in self._faults.active:
                raise OSError(number, os.strerror(number))
