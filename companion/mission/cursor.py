"""A place in a plan, and how it moves on through "do" items and jumps."""

from __future__ import annotations

from collections.abc import Sequence

from companion.mission.commands import TASKS, Command
from companion.mission.plan import PlanItem
from companion.mission.tasks import Action, SetHome, SetSpeed

ENDLESS = -1
_STARTS = (Command.IMAGE_START_CAPTURE, Command.VIDEO_START_CAPTURE)
_STOPS = (Command.IMAGE_STOP_CAPTURE, Command.VIDEO_STOP_CAPTURE)
_MOST_STEPS = 20_000  # between two tasks; twice the longest plan


class Cursor:
    """Where a mission stands: `seq`, the times each jump was taken, the speed that the mission has set (None: none), and whether it is
    `surveying`: the camera was set to shoot on the way, which is how ground stations mark the transects of a survey.

    `seq` equal to the number of items means the end. `copy` looks ahead without moving the original. With `follow_endless` False
    endless jumps are passed by.
    """

    __slots__ = ("_follow_endless", "_items", "jumps", "seq", "speed_mps", "surveying")

    def __init__(
        self,
        items: Sequence[PlanItem],
        seq: int = 0,
        jumps: dict[int, int] | None = None,
        speed_mps: float | None = None,
        follow_endless: bool = True,
    ) -> None:
        self._items = items
        self._follow_endless = follow_endless
        self.seq = seq
        self.jumps: dict[int, int] = jumps if jumps is not None else {}
        self.speed_mps = speed_mps
        self.surveying = False
        self.stand_at(seq)

    def copy(self) -> Cursor:
        other = Cursor(self._items, 0, dict(self.jumps), self.speed_mps, self._follow_endless)
        other.seq, other.surveying = self.seq, self.surveying
        return other

    def stand_at(self, seq: int) -> None:
        """Another place, as if the items before it had been sailed in order."""
        self.seq = seq
        shooting = (_shooting(item) for item in reversed(self._items[:seq]))
        self.surveying = next((on for on in shooting if on is not None), False)

    @property
    def item(self) -> PlanItem | None:
        """The item at this place; None at the end."""
        return self._items[self.seq] if self.seq < len(self._items) else None

    def advance(self) -> list[Action]:
        """Leave the present item for the next task, or the end."""
        self.seq += 1
        return self.settle()

    def settle(self) -> list[Action]:
        """Run "do" items from here to the next task or the end; returns what they change, in order.

        A loop of jumps with no task in it is left after a bounded number of steps, past its jumps.
        """
        actions: list[Action] = []
        items, count, steps = self._items, len(self._items), 0
        while self.seq < count:
            item = items[self.seq]
            if item.command in TASKS:
                break
            steps += 1
            if item.command == Command.DO_JUMP and steps <= _MOST_STEPS and self._takes(item):
                self.seq = int(item.param1)
                continue
            self.seq += 1
            if (shooting := _shooting(item)) is not None:
                self.surveying = shooting
            if (action := self._action(item)) is not None and steps <= _MOST_STEPS:
                actions.append(action)
        return actions

    def _takes(self, jump: PlanItem) -> bool:
        """Whether this jump is taken now; counts it. Counters run per item and are not set back by leaving the loop."""
        if not 0 <= jump.param1 < len(self._items):
            return False
        if jump.param2 == ENDLESS:
            return self._follow_endless
        taken = self.jumps.get(self.seq, 0)
        if not taken < jump.param2:
            return False
        self.jumps[self.seq] = taken + 1
        return True

    def _action(self, item: PlanItem) -> Action | None:
        if item.command == Command.DO_CHANGE_SPEED and item.param2 != -1.0:
            self.speed_mps = item.param2 if item.param2 > 0.0 else None
            return SetSpeed(self.speed_mps)
        if item.command == Command.DO_SET_HOME:
            return SetHome(None, None) if item.param1 == 1.0 else SetHome(item.lat_deg, item.lon_deg)
        return None


def _shooting(item: PlanItem) -> bool | None:
    """Whether this item has the camera shoot from here on, or stops it; None where it does neither."""
    if item.command == Command.DO_SET_CAM_TRIGG_DIST:
        return item.param1 > 0.0
    if item.command in _STARTS:
        return True
    return False if item.command in _STOPS else None
