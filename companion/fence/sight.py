"""Whether the boat's place is known well enough to keep it inside the fence.

While a person steers without a position, the estimate carries the last one on, by inertial sensors and the hull's
model. The fence is enforced on it, with twice its accuracy to spare, until that is worse than COM_POS_FS_EPH or the
last measured position is a minute old.
"""

from __future__ import annotations

from companion.core.decision import TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.params.store import Parameters

_RECKONED_S = 60.0
_TEXTS = {
    "fence_reckoned": "Position lost: fence kept by dead reckoning",
    "fence_blind": "Position lost: the fence is not enforced",
}


class Sight:
    """`update` once a tick, `sees` between.

    Remembers whether there has been a position, whether what was carried on since has become too uncertain (until the
    position is measured again), and what was announced last.
    """

    def __init__(self, parameters: Parameters, events: EventLog) -> None:
        self._parameters = parameters
        self._events = events
        self._placed = self._lost = False
        self._told: str | None = None

    def forget(self) -> None:
        """There is no fence: nothing is to be announced."""
        self._told = None

    def sees(self, nav: NavState, needs_position: bool) -> bool:
        """Whether the fence is enforced now. `needs_position`: the mode ends when the position is lost, so that none is
        carried on for it."""
        if nav.position_valid:
            return True
        good = nav.position_age_s <= _RECKONED_S and nav.position_accuracy_m <= self._parameters["COM_POS_FS_EPH"]
        return self._placed and not self._lost and not needs_position and good

    def update(self, nav: NavState, armed: bool, needs_position: bool, now_s: float) -> bool:
        """As `sees`. Announces what changes while the boat is armed, in a mode that goes on without a position."""
        seen = self.sees(nav, needs_position)
        if nav.position_valid:
            self._placed, self._lost = True, False
            if self._told is not None:
                self._told, text = None, "Position is back: the fence is enforced again"
                self._events.say(now_s, TextKind.ROUTINE, "fence_seen", text)
        elif not needs_position:
            self._lost = not seen
            name = "fence_reckoned" if seen else "fence_blind"
            if armed and name != self._told:
                self._told = name
                self._events.say(now_s, TextKind.ATTENTION, name, _TEXTS[name])
        return seen
