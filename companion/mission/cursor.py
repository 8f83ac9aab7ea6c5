"""A place in a plan, and how it advances through "do" items and jumps."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.mission.auxiliary import auxiliary_of
from companion.mission.commands import GATES, RULES, TASKS, Command, Role
from companion.mission.jumps import ENDLESS, JUMPS, target_of
from companion.mission.payload import PICTURES, payload_of
from companion.mission.plan import PlanItem
from companion.mission.tasks import (
    Action,
    ByDistance,
    ByTime,
    DoCondition,
    FollowLeader,
    SetFollowPosition,
    SetHome,
    SetSpeed,
    StopPictures,
    SwitchFence,
    TriggerAsBefore,
)

_STARTS = (Command.IMAGE_START_CAPTURE, Command.VIDEO_START_CAPTURE)
_STOPS = (Command.IMAGE_STOP_CAPTURE, Command.VIDEO_STOP_CAPTURE)
_MOST_STEPS = 20_000  # between two tasks; twice the longest plan


class Cursor:
    """Place of a mission: `seq`, how often each jump was taken, the speed that the mission has set (None: none),
    whether the boat sails stern first (`astern`), and whether it is `surveying`: the camera shoots on the way, which is
    how ground stations mark the transects of a survey.

    `seq` equal to the number of items means the end. `copy` looks ahead without moving the original. `follow_endless`
    False: endless jumps are not taken. `held`: numbers of the condition (first) and the "do" items that wait for it on
    the present leg; they run when it is met (`open_gate`), or at the end of the leg. `leg_speed_mps`: top speed on the
    present leg.
    """

    __slots__ = (
        "_follow_endless",
        "_gate_serial",
        "_items",
        "astern",
        "held",
        "jumps",
        "leg_speed_mps",
        "seq",
        "speed_mps",
        "surveying",
    )

    def __init__(
        self,
        items: Sequence[PlanItem],
        seq: int = 0,
        jumps: dict[int, int] | None = None,
        speed_mps: float | None = None,
        follow_endless: bool = True,
        held: Sequence[int] = (),
    ) -> None:
        self._items = items
        self._follow_endless = follow_endless
        self.seq = seq
        self.jumps: dict[int, int] = jumps if jumps is not None else {}
        self.speed_mps = self.leg_speed_mps = speed_mps
        self.held: list[int] = list(held)
        self._gate_serial = 0
        self.astern = self.surveying = False
        self._look_back()

    def copy(self, follow_endless: bool = True) -> Cursor:
        """A copy to look ahead with; without the held items, which do not matter then."""
        ahead = Cursor(self._items, 0, dict(self.jumps), self.speed_mps, self._follow_endless and follow_endless)
        ahead.seq, ahead.surveying, ahead.leg_speed_mps = self.seq, self.surveying, self.leg_speed_mps
        ahead.astern = self.astern
        return ahead

    def stand_at(self, seq: int) -> None:
        """Move to another place, as if the items before it had been sailed in order; held items are discarded."""
        self.seq = seq
        self.leg_speed_mps = self.speed_mps
        self.held.clear()
        self._look_back()

    def _look_back(self) -> None:
        shooting = (_shooting(item) for item in reversed(self._items[: self.seq]))
        self.surveying = next((on for on in shooting if on is not None), False)

    @property
    def gate(self) -> DoCondition | None:
        """The condition that delays items now, or None."""
        if not self.held:
            return None
        item = self._items[self.held[0]]
        is_delay = item.command == Command.CONDITION_DELAY
        return DoCondition(
            item.seq, self._gate_serial, item.param1 if is_delay else None, None if is_delay else item.param1
        )

    def open_gate(self) -> list[Action]:
        """The present condition is met: run the items that it held, up to the next condition. Returns their actions."""
        actions: list[Action] = []
        if self.held:
            self.held.pop(0)
            self._gate_serial += 1
        while self.held and self._items[self.held[0]].command not in GATES:
            if (action := self._action(self._items[self.held.pop(0)])) is not None:
                actions.append(action)
        return actions

    def _open_all(self) -> list[Action]:
        actions: list[Action] = []
        while self.held:
            actions += self.open_gate()
        return actions

    @property
    def item(self) -> PlanItem | None:
        """The item at `seq`; None at the end."""
        return self._items[self.seq] if self.seq < len(self._items) else None

    def advance(self) -> list[Action]:
        """Advance from the present item to the next task or the end; held items run first. Returns the actions, in
        order."""
        actions = self._open_all()
        self.leg_speed_mps = self.speed_mps
        self.seq += 1
        return actions + self.settle()

    def settle(self) -> list[Action]:
        """Run "do" items up to the next task or the end, or hold them; returns their actions, in order.

        A loop of jumps without a task ends after a bounded number of steps, by ignoring its jumps.
        """
        actions: list[Action] = []
        items, count, steps = self._items, len(self._items), 0
        while self.seq < count:
            item = items[self.seq]
            if item.command in TASKS:
                break
            steps += 1
            if item.command in JUMPS and steps <= _MOST_STEPS and (target := self._takes(item)) is not None:
                self.seq = target
                continue
            self.seq += 1
            if (shooting := _shooting(item)) is not None:
                self.surveying = shooting
            if item.command == Command.DO_SET_REVERSE:
                self.astern = item.param1 == 1.0
            if steps <= _MOST_STEPS:
                self._run(item, actions)
        if self.seq >= count:
            actions += self._open_all()
        return actions

    def _run(self, item: PlanItem, actions: list[Action]) -> None:
        """Run a "do" item or a condition: append its action to `actions`, or hold it."""
        action = self._action(item)
        holds = bool(self.held) or item.command in GATES
        if isinstance(action, SetSpeed):
            self.speed_mps = action.speed_mps
            either = (self.leg_speed_mps, action.speed_mps)
            fastest = None if None in either else max(speed for speed in either if speed is not None)
            self.leg_speed_mps = fastest if holds else action.speed_mps
        if holds and (action is not None or item.command in GATES):
            if not self.held:
                self._gate_serial += 1
            self.held.append(item.seq)
        elif action is not None:
            actions.append(action)

    def _takes(self, jump: PlanItem) -> int | None:
        """Where this jump leads, if it is taken now; counts it. Each item has its counter, which leaving the loop does
        not reset."""
        target = target_of(self._items, jump)
        if target is None or jump.param2 == ENDLESS:
            return target if self._follow_endless else None
        taken = self.jumps.get(self.seq, 0)
        if not taken < jump.param2:
            return None
        self.jumps[self.seq] = taken + 1
        return target

    @staticmethod
    def _action(item: PlanItem) -> Action | None:
        if item.command == Command.DO_CHANGE_SPEED and item.param2 != -1.0:
            return SetSpeed(item.param2 if item.param2 > 0.0 else None)
        if item.command == Command.DO_SET_HOME:
            return SetHome(None, None) if item.param1 == 1.0 else SetHome(item.lat_deg, item.lon_deg)
        if item.command == Command.DO_FENCE_ENABLE:
            return SwitchFence(item.param1 == 1.0) if item.param1 <= 1.0 else None
        if item.command == Command.DO_FOLLOW:
            return FollowLeader(item.seq, int(item.param1) if item.param1 > 0.0 else None)
        if item.command == Command.USER_3:
            bearing_rad, distance_m = math.radians(item.param1), item.param2
            return SetFollowPosition(
                None if math.isnan(bearing_rad) else bearing_rad, None if math.isnan(distance_m) else distance_m
            )
        if item.command in RULES and RULES[item.command].role is Role.PAYLOAD:
            return payload_of(item)
        return auxiliary_of(item)

    def trigger_before(self) -> list[Action]:
        """What the items before this place have the camera do on the way; empty for a plan without pictures."""
        if not any(item.command in PICTURES for item in self._items):
            return []
        for action in map(payload_of, reversed(self._items[: self.seq])):
            match action:
                case ByDistance(camera=camera, spacing_m=spacing_m):
                    return [TriggerAsBefore(ByDistance(camera, spacing_m) if spacing_m > 0.0 else None)]
                case ByTime(count=count):
                    return [TriggerAsBefore(action if count is None else None)]
                case StopPictures():
                    break
        return [TriggerAsBefore(None)]


def _shooting(item: PlanItem) -> bool | None:
    """True if this item starts the camera, False if it stops it, None if neither."""
    if item.command == Command.DO_SET_CAM_TRIGG_DIST:
        return item.param1 > 0.0
    if item.command in _STARTS:
        return True
    return False if item.command in _STOPS else None
