"""What the computer lacks: memory, descriptors. And whether its clock was stepped."""

from __future__ import annotations

import resource
from collections.abc import Callable, Sequence
from pathlib import Path

from companion.core.decision import TextKind
from companion.core.events import Announce
from companion.core.tick import Tick

_PERIOD_S = 2.0
_LEAST_MEMORY, _ENOUGH_MEMORY = 0.04, 0.08  # of all; the second ends the fault
_LEAST_DESCRIPTORS, _ENOUGH_DESCRIPTORS = 8, 16
_STEP_NS = 1_000_000_000
MEMORY, DESCRIPTORS = "little memory left", "few file descriptors left"


class HostWatch:
    """`faults(now_s)`: what the computer lacks, looked at every 2 s. As a recorder it announces steps of the wall
    clock; the boat keeps time by another one, so that they change nothing but the times of day in the log."""

    def __init__(
        self,
        say: Announce,
        memory_share: Callable[[], float | None] | None = None,
        descriptors_left: Callable[[], int | None] | None = None,
    ) -> None:
        """The two functions look at the machine, unless a test says what to see."""
        self._say = say
        self._memory_share = memory_share or memory_share_left
        self._descriptors_left = descriptors_left or count_descriptors_left
        self._due_s = 0.0
        self._faults: tuple[str, ...] = ()
        self._offset_ns: int | None = None

    def faults(self, now_s: float) -> Sequence[str]:
        """A few words for each fault."""
        if now_s < self._due_s:
            return self._faults
        self._due_s = now_s + _PERIOD_S
        found = []
        share, left = self._memory_share(), self._descriptors_left()
        if share is not None and share < (_ENOUGH_MEMORY if MEMORY in self._faults else _LEAST_MEMORY):
            found.append(MEMORY)
        if left is not None and left < (_ENOUGH_DESCRIPTORS if DESCRIPTORS in self._faults else _LEAST_DESCRIPTORS):
            found.append(DESCRIPTORS)
        self._faults = tuple(found)
        return self._faults

    def record(self, tick: Tick) -> None:
        """See `Recorder`. Slow drift of the clock, as NTP makes it, is none of its business."""
        offset_ns = tick.time_unix_ns - round(tick.t_s * 1e9)
        before_ns, self._offset_ns = self._offset_ns, offset_ns
        if before_ns is not None and abs(offset_ns - before_ns) >= _STEP_NS:
            text = f"Computer's clock stepped by {(offset_ns - before_ns) * 1e-9:+.0f} s"
            self._say(tick.t_s, TextKind.ATTENTION, "clock_step", text)

    def close(self) -> None:
        """See `Recorder`."""


def memory_share_left() -> float | None:
    """Share of the memory that can still be had; None where the system does not say."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        sizes = {name: int(rest.split()[0]) for name, _, rest in (line.partition(":") for line in lines)}
        return sizes["MemAvailable"] / sizes["MemTotal"]
    except (OSError, ValueError, KeyError, IndexError, ZeroDivisionError):
        return None


def count_descriptors_left() -> int | None:
    """How many files this process may still open; 0 where not even its own list of them can be opened."""
    limit = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if limit == resource.RLIM_INFINITY:
        return None
    try:
        return limit - sum(1 for _ in Path("/proc/self/fd").iterdir())
    except OSError:
        return 0 if Path("/proc").is_dir() else None
