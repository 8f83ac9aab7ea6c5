"""Enumerations whose members are keys of dictionaries and sets that the tick looks up."""

from __future__ import annotations

from enum import Enum


class Named(Enum):
    """An enumeration of texts whose members are hashed by identity, as they are compared. Enum's own `__hash__` is a
    function in Python: it takes most of the time of a look-up. `word`: the value, without Enum's way to it, which takes
    two functions."""

    __hash__ = object.__hash__

    def __init__(self, word: str) -> None:
        self.word = word
