"""Frozen records that are made a thousand times a second."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Any, TypeVar

T = TypeVar("T")


def quick(cls: type[T]) -> type[T]:
    """Decorator over `@dataclass(frozen=True, slots=True)`: the same class, its instances made in a third of the time.

    The `__init__` of a frozen dataclass goes through `object.__setattr__` at 0.2 µs a field. This one fills the fields while the instance
    is of an open class with the same slots, and makes it one of the frozen class when it is whole. Raises TypeError for what is more than
    plain fields with plain defaults.
    """
    parts = fields(cls)  # type: ignore[arg-type]
    plain = all(part.init and not part.kw_only and part.default_factory is MISSING for part in parts)
    if not plain or "__slots__" not in vars(cls) or hasattr(cls, "__post_init__"):
        raise TypeError(f"{cls.__name__}: only for slotted classes of plain fields")
    names = [part.name for part in parts]
    opened = type(cls.__name__, (), {"__slots__": tuple(names)})
    scope: dict[str, Any] = {"closed": cls, "opened": opened, "become": object.__setattr__}
    scope |= {f"default_{part.name}": part.default for part in parts}
    arguments = [part.name if part.default is MISSING else f"{part.name}=default_{part.name}" for part in parts]
    lines = [
        f"def __init__(self, {', '.join(arguments)}):",
        "become(self, '__class__', opened)",
        *(f"self.{name} = {name}" for name in names),
        "self.__class__ = closed",
    ]
    exec("\n    ".join(lines), scope)
    scope["__init__"].__qualname__ = f"{cls.__qualname__}.__init__"
    cls.__init__ = scope["__init__"]  # type: ignore[method-assign]
    return cls
