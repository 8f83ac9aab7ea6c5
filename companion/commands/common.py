"""What several commands need."""

from __future__ import annotations

import signal
from pathlib import Path


class UsageError(Exception):
    """A command line that cannot be carried out; one line that says what to do."""


class Interrupt:
    """Whether the process was asked to end: Ctrl-C, SIGTERM."""

    def __init__(self) -> None:
        self.asked = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._ask)

    def _ask(self, number: int, frame: object) -> None:
        self.asked = True


def fresh_folder(directory: Path, name: str) -> Path:
    """A folder that is not there yet."""
    folder, n = directory / name, 2
    while folder.exists():
        folder, n = directory / f"{name}-{n}", n + 1
    return folder
