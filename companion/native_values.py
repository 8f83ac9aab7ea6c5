"""Methods of compiled dataclasses, in place of those that `dataclass` would make of text at import: a sixth of the time
of a start.

`sitl/native/source.py` puts a call of `give` after each class. Which fields count is asked at the first call.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import Field, fields
from operator import attrgetter
from reprlib import recursive_repr
from typing import Any

Values = Callable[[Any], tuple[Any, ...]]


def give(kind: type[Any], *methods: str) -> None:
    """Give a dataclass methods as `dataclass` makes them: `repr`, `eq`, `hash`, or `no hash`."""
    for method in methods:
        _MAKERS[method](kind)


def _describe(kind: type[Any]) -> None:
    @recursive_repr()
    def __repr__(self: Any) -> str:
        shown = ", ".join(f"{item.name}={getattr(self, item.name)!r}" for item in fields(kind) if item.repr)
        return f"{self.__class__.__qualname__}({shown})"

    setattr(kind, "__repr__", __repr__)  # noqa: B010  # mypy lets nobody assign a method


def _compare(kind: type[Any]) -> None:
    values: Values | None = None

    def __eq__(self: Any, other: Any) -> bool:
        nonlocal values
        if other.__class__ is not self.__class__:
            return NotImplemented
        if values is None:
            values = _values(kind, lambda item: item.compare)
        return values(self) == values(other)

    setattr(kind, "__eq__", __eq__)  # noqa: B010


def _number(kind: type[Any]) -> None:
    values: Values | None = None

    def __hash__(self: Any) -> int:
        nonlocal values
        if values is None:
            values = _values(kind, lambda item: item.compare if item.hash is None else item.hash)
        return hash(values(self))

    setattr(kind, "__hash__", __hash__)  # noqa: B010


def _refuse_number(kind: type[Any]) -> None:
    setattr(kind, "__hash__", None)  # noqa: B010


def _values(kind: type[Any], wanted: Callable[[Field[Any]], bool]) -> Values:
    """Reads those fields as a tuple."""
    names = [item.name for item in fields(kind) if wanted(item)]
    if len(names) > 1:
        return attrgetter(*names)
    return lambda value: tuple(getattr(value, name) for name in names)


_MAKERS = {"repr": _describe, "eq": _compare, "hash": _number, "no hash": _refuse_number}
