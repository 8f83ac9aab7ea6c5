"""The computer under the boat: whether ticks come in time, and what else it lacks.

Who hogs the processor, or memory that is swapped out, makes ticks late. The control laws then steer by old readings, so
late ticks are a failsafe of their own. They are told from the times of the ticks alone: a replay judges as the boat
did.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from companion.core.decision import TextKind
from companion.core.events import Announce
from companion.core.tick import COMPUTER, DeviceHealth
from companion.params.store import Parameters

WINDOW_S = 3.0
MANY = 5  # late ticks in the window; one long stop is over when it is seen


class ComputerWatch:
    """`update` once a tick. Remembers the late ticks of the last WINDOW_S, and what was announced."""

    def __init__(self, period_s: float, parameters: Parameters, say: Announce) -> None:
        self._period_s = period_s
        self._parameters = parameters
        self._say = say
        self._last_s: float | None = None
        self._late: deque[tuple[float, float]] = deque(maxlen=256)  # when, how late, s
        self._faults: tuple[str, ...] = ()
        self.ticks_late = False

    @property
    def worst_s(self) -> float:
        """The latest of the late ticks; 0 without one."""
        return max((late_s for _, late_s in self._late), default=0.0)

    def update(self, now_s: float, faults: Sequence[str] = ()) -> None:
        """A tick begins. `faults`: what else the computer lacks, a few words each."""
        limit_s = self._parameters["FS_TICK_LATE"]
        late_s = 0.0 if self._last_s is None else now_s - self._last_s - self._period_s
        self._last_s = now_s
        if 0.0 < limit_s < late_s:
            self._late.append((now_s, late_s))
        while self._late and (now_s - self._late[0][0] > WINDOW_S or not limit_s):
            self._late.popleft()
        self.ticks_late = bool(self._late) if self.ticks_late else len(self._late) >= MANY
        self._tell(now_s, tuple(faults))

    @property
    def health(self) -> DeviceHealth:
        """The computer as a device."""
        late = (f"ticks up to {self.worst_s:.2g} s late",) if self.ticks_late else ()
        text = "; ".join((*late, *self._faults))
        return DeviceHealth(COMPUTER, not text, None, text)

    def _tell(self, now_s: float, faults: tuple[str, ...]) -> None:
        """Announce each fault when it begins, and when all are over."""
        for fault in faults:
            if fault not in self._faults:
                self._say(now_s, TextKind.ATTENTION, "computer", f"Computer: {fault}")
        if self._faults and not faults:
            self._say(now_s, TextKind.ROUTINE, "computer", "Computer: well again")
        self._faults = faults
