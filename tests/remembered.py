"""How much an object keeps, whatever its attributes are called: for tests that nothing which comes in from outside
fills the memory."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any


def remembered(thing: object, room: str = "companion") -> int:
    """Bytes of buffers and texts, and elements of containers, that `thing` holds: in its attributes, in those
    containers, and in objects of classes of that `room`. What several hold is counted once."""
    return _size(thing, room, set())


def _size(thing: Any, room: str, seen: set[int]) -> int:
    if id(thing) in seen:
        return 0
    seen.add(id(thing))
    if isinstance(thing, bytes | bytearray | str):
        return len(thing)
    if isinstance(thing, Mapping):
        return sum(1 + _size(key, room, seen) + _size(value, room, seen) for key, value in thing.items())
    if isinstance(thing, list | tuple | set | frozenset | deque):
        return sum(1 + _size(part, room, seen) for part in thing)
    if type(thing).__module__.startswith(room):
        return sum(_size(value, room, seen) for value in _attributes(thing))
    return 0


def _attributes(thing: Any) -> list[Any]:
    slots = [name for cls in type(thing).__mro__ for name in getattr(cls, "__slots__", ())]
    return (
        [*vars(thing).values()]
        if hasattr(thing, "__dict__")
        else [getattr(thing, n) for n in slots if hasattr(thing, n)]
    )
