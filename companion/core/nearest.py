"""The name that a person may have meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

_ALIKE = 0.6  # difflib's ratio: one letter wrong, missing or swapped in a short name


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`; did you mean 'hold'?` for a name close to a known one, to end a refusal with; else empty."""
    found = nearest(name, known)
    return "" if found is None else f"; did you mean '{found}'?"


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The known name that is close to this one; None where none is."""
    by_lower = {each.lower(): each for each in known}
    close = get_close_matches(name.lower(), list(by_lower), n=1, cutoff=_ALIKE)
    return by_lower[close[0]] if close else None
