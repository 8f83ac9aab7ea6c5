"""How far a long piece of work has come, as whoever does it tells whoever shows it."""

from __future__ import annotations

from collections.abc import Callable

Told = Callable[[str, float], None]
"""Is told what is being done, in words, and which share of the whole is done, 0 to 1."""

_LATE = 0.9  # share of the usual work from which this may be one of the long ones


def tell_nobody(_text: str, _share: float) -> None:
    """A `Told` that nobody looks at."""


def part(told: Told, begin: float, end: float) -> Told:
    """`told` for a part of the whole, from the share `begin` to `end`."""
    return lambda text, share: told(text, begin + (end - begin) * share)


def usual_share(done: float, usual: float) -> float:
    """The share of a work of which only the `usual` length is known. What takes longer creeps on towards 1."""
    share = done / usual
    return share if share < _LATE else 1.0 - (1.0 - _LATE) * _LATE / share


class Work:
    """Counts what is done of a work that `usual`ly takes so much, and tells it under `text`."""

    def __init__(self, told: Told, text: str, usual: float) -> None:
        self._told = told
        self._text = text
        self._usual = usual
        self._done = 0.0

    def step(self, amount: float = 1.0) -> None:
        """So much more is done."""
        self._done += amount
        self._told(self._text, usual_share(self._done, self._usual))
