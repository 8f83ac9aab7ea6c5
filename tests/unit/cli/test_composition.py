"""What a simulation in real time does that one in lockstep does not."""

from __future__ import annotations

import errno
from typing import cast

import pytest

from companion.cli.composition import WhileThereIsSpace
from companion.core.tick import Tick


class Medium:
    """A recorder on a medium that takes `space` ticks, and refuses to be closed once it is full."""

    def __init__(self, space: int) -> None:
        self.space, self.taken = space, 0

    def record(self, tick: Tick) -> None:
        self.write()

    def write(self) -> None:
        self._use()
        self.taken += 1

    def close(self) -> None:
        self._use()

    def _use(self) -> None:
        if self.taken >= self.space:
            raise OSError(errno.ENOSPC, "No space left on device")


def test_a_full_medium_ends_the_truth_but_not_the_boat(capsys: pytest.CaptureFixture[str]) -> None:
    """It ended the boat, which had said that it goes on without its log: `companion: the system: No space left`."""
    medium, tick = Medium(3), cast("Tick", None)
    recorder = WhileThereIsSpace(medium, "truth.csv")
    for _ in range(5):
        recorder.record(tick)
    recorder.close()
    assert medium.taken == 3
    assert capsys.readouterr().err == "companion: truth.csv ends here: No space left on device; the boat sails on\n"


def test_a_full_medium_ends_the_truth_of_a_plant_alone_too(capsys: pytest.CaptureFixture[str]) -> None:
    medium = Medium(2)
    recorder = WhileThereIsSpace(medium, "truth.csv")
    for _ in range(4):
        recorder.write()
    recorder.close()
    assert medium.taken == 2 and "truth.csv ends here" in capsys.readouterr().err
