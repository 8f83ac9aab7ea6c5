"""What several commands need."""

from __future__ import annotations

import signal


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
