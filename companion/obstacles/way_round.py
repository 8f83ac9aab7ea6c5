"""How a mode leads the rest of its way round obstacles: what is looked for beside the control thread, and how it is
laid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from companion.core.decision import ModeInputs
from companion.obstacles.open_water import Water

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class WayRound(Generic[T]):
    """`find(water)` takes long and uses nothing that may change meanwhile. `lay(found, inputs)` takes its result in a
    tick, and returns why no way leads round, or None; it leaves a result alone that no longer fits."""

    find: Callable[[Water], T]
    lay: Callable[[T, ModeInputs], str | None]
