"""The state machine of a mission: the present task of the boat and the tasks after it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import Enum
from typing import Any

from companion.core.decision import MissionProgress, MissionState
from companion.mission.commands import DESTINATIONS, Command, must_stay
from companion.mission.cursor import Cursor
from companion.mission.itinerary import task_at
from companion.mission.plan import Adopt, PlanItem, PlanKind, Plans, item_number, shared_items
from companion.mission.snapshot import SnapshotError, read_snapshot, write_snapshot
from companion.mission.tasks import Action, Complete, DoCondition, Sail, SetSpeed, Stay, Task

_COMPLETE = Complete()


class Replaced(Enum):
    """Effect of a new plan on a mission that was under way."""

    CONTINUED = "continued"  # at the same item: the plan is the same up to it
    RESTARTED = "restarted"  # from the first item


class MissionExecutor:
    """Advances through the mission of `plans` as items are completed (`complete`).

    It has no clock: the tasks hold durations, and the mode that carries them out measures time. Navigation follows
    MAVLink's mission protocol; an item counts as reached when it is done, one with a hold on arrival. Remembers the
    state (MISSION_STATE), the place in the plan, the count of each jump, the speed that the mission has set, whether
    the boat sails stern first, and whether it has arrived at a destination where it stays.
    """

    def __init__(self, plans: Plans) -> None:
        self._plans = plans
        self._items: tuple[PlanItem, ...] = plans.items(PlanKind.MISSION)
        self._cursor = Cursor(self._items)
        self._state = MissionState.NOT_STARTED if self._items else MissionState.NO_MISSION
        self._arrived = False
        self._reached = 0
        self._reached_seq: int | None = None
        self._task: Task | None = None  # made on the first reading of `task`
        self._passed = 0  # number of points of the present route passed
        self._just_passed: int | None = None  # the item passed last, while sailing on
        self._actions: list[Action] = []
        self.replaced: Replaced | None = None
        """Effect of the last change of plan on the mission under way; None once the mission has moved on."""
        self._shared: tuple[Sequence[PlanItem], Sequence[PlanItem], int] = ((), (), 0)
        plans.prepare_by(PlanKind.MISSION, self.prepare)
        plans.on_change(self._on_change)

    @property
    def progress(self) -> MissionProgress:
        """State, current item and items reached."""
        count = len(self._items)
        return MissionProgress(
            self._state, max(0, min(self._cursor.seq, count - 1)), count, self._reached_seq, self._reached
        )

    @property
    def task(self) -> Task | None:
        """The present task: the same object until something changes. None while the mission is not ACTIVE; `Complete`
        after the last item."""
        if self._state is MissionState.COMPLETE:
            return _COMPLETE
        if self._state is not MissionState.ACTIVE:
            return None
        if self._task is None:
            self._task = task_at(self._cursor, self._arrived)
            self._passed = 0
        return self._task

    @property
    def next_place(self) -> tuple[int, float, float] | None:
        """(seq, lat_deg, lon_deg) of the first destination from the current item on; None if there is none."""
        for item in self._items[0 if self._state is MissionState.COMPLETE else max(0, self._cursor.seq) :]:
            if item.command in DESTINATIONS or item.command == Command.NAV_LOITER_TURNS:
                return item.seq, item.lat_deg, item.lon_deg
        return None

    @property
    def gate(self) -> DoCondition | None:
        """The condition that delays "do" items on the present leg, or None."""
        return self._cursor.gate if self._state is MissionState.ACTIVE else None

    def open_gate(self) -> tuple[Action, ...]:
        """The condition is met: returns the actions that it delayed. Actions still delayed at the end of the leg run
        then."""
        return tuple(self._cursor.open_gate())

    @property
    def following(self) -> Task | None:
        """The task after the present route, where the boat sails on without a stop; None else."""
        task = self.task
        if not isinstance(task, Sail) or not task.beyond:
            return None
        cursor = self._cursor.copy()
        for _ in task.route[self._passed :]:
            cursor.advance()
        return task_at(cursor, False)

    def ahead(self) -> Iterator[Task]:
        """The tasks from here to the end, in order; endless for a mission with an endless loop. Changes nothing, and
        what changes later does not change them."""
        done = self._state is MissionState.COMPLETE
        return _tasks(Cursor(self._items) if done else self._cursor.copy(), self._arrived and not done)

    def way_ahead(self) -> Cursor:
        """From here to the end, for `Reckoning`: a copy that takes no endless jumps. Changes nothing."""
        if self._state is MissionState.COMPLETE:
            return Cursor(self._items, follow_endless=False)
        return self._cursor.copy(follow_endless=False)

    def take_actions(self) -> tuple[Action, ...]:
        """Actions of "do" items that ran when the mission began, changed its current item or was replaced; each is
        returned once."""
        actions, self._actions = tuple(self._actions), []
        return actions

    def begin(self, first: int | None = None) -> str | None:
        """Start or resume; returns the reason if that is refused, else None.

        A paused or interrupted mission continues at its current item, a complete one starts over. With `first` it
        starts afresh at that item.
        """
        if not self._items:
            return "no mission: upload one first"
        if first is not None and (refusal := self._outside(first)) is not None:
            return refusal
        afresh = first is not None or self._state is MissionState.COMPLETE
        ahead = Cursor(self._items, first or 0) if afresh else self._cursor.copy()
        seq = ahead.seq
        ahead.settle()
        if ahead.item is None:
            return f"nothing to sail to from item {item_number(seq)} on"
        if afresh:
            self._rewind(seq)
        self._state = MissionState.ACTIVE
        self._task = None  # that of an active mission still has the points that the boat has passed
        self.replaced = None
        self._settle()
        return None

    def pause(self) -> None:
        """Pause an active mission; `begin` resumes it, bow first."""
        if self._state is MissionState.ACTIVE:
            self._state = MissionState.PAUSED
            self._task = None
            self._cursor.astern = False

    def sail_astern(self, astern: bool) -> None:
        """Sail stern first from here on, or bow first, until an item or a pause changes it."""
        if self._cursor.astern is not astern:
            self._cursor.astern = astern
            self._task = None

    def set_current(self, seq: int | None, reset: bool = False) -> str | None:
        """Make `seq` the current item; returns the reason if that is refused, else None. `reset` clears the counters of
        the jumps. `seq` None: the present item, which goes on as it is.

        The state stays, but a complete mission becomes NOT_STARTED at `seq`.
        """
        if not self._items:
            return "no mission: upload one first"
        if seq is None:
            if self._state is not MissionState.COMPLETE:
                self._forget_jumps(reset)
                return None
            seq = self.progress.seq
        if (refusal := self._outside(seq)) is not None:
            return refusal
        self._cursor.stand_at(seq)
        self._actions += self._cursor.trigger_before()
        if reset:
            self._cursor.jumps.clear()
        self._arrived = False
        self._just_passed = None
        self._task = None
        self.replaced = None
        if self._state is MissionState.ACTIVE:
            self._settle()
        elif self._state is MissionState.COMPLETE:
            self._state = MissionState.NOT_STARTED
        return None

    def complete(self, seq: int) -> tuple[Action, ...]:
        """The boat has passed or finished item `seq` of the present task; returns the actions that follow, in order.

        Points of a route before `seq` count as passed too. A `seq` that is not ahead in the present task is ignored,
        and so is a repetition of the point passed last.
        """
        task = self.task
        actions: list[Action] = []
        if task is None or isinstance(task, Complete):
            return ()
        if isinstance(task, Sail):
            for _ in range(self._points_up_to(task, seq)):
                actions += self._pass_point(task)
        elif task.seq == seq:
            item = self._cursor.item
            if not self._arrived or (item is not None and item.command == Command.NAV_LOITER_TIME):
                self._count(seq)
            actions += self._advance()
            self._just_passed = None
            self._task = None
        return (*self.take_actions(), *actions)

    def snapshot(self) -> dict[str, Any]:
        """The mission's place and state, as JSON values."""
        return write_snapshot(
            self._plans.plan_id(PlanKind.MISSION),
            self._state,
            self._cursor,
            self._arrived,
            (self._reached, self._reached_seq),
        )

    def restore(self, snapshot: Mapping[str, Any]) -> str | None:
        """Restore the place and state of `snapshot`; returns the reason if that is refused, else None. An ACTIVE
        mission is ACTIVE again: `begin` or `pause` it."""
        if snapshot.get("plan_id") != self._plans.plan_id(PlanKind.MISSION):
            return "it belongs to another mission"
        try:
            kept = read_snapshot(snapshot, len(self._items))
        except SnapshotError as error:
            return str(error)
        self._cursor = Cursor(self._items, kept.seq, kept.jumps, kept.speed_mps, held=kept.held)
        self._actions += self._cursor.trigger_before()
        self._state = kept.state
        item = self._cursor.item
        self._arrived = kept.arrived and item is not None and must_stay(item)
        self._reached, self._reached_seq = kept.reached, kept.reached_seq
        self._just_passed = None
        self._task = None
        if self._state is MissionState.ACTIVE:
            self._settle()
        return None

    # --- moving on -------------------------------------------------------------------------------------------------

    def _points_up_to(self, sail: Sail, seq: int) -> int:
        """Number of points ahead up to and including `seq`; 0 if it is not ahead."""
        if sail.route[self._passed].seq != seq == self._just_passed:
            return 0
        for number, point in enumerate(sail.route[self._passed :], start=1):
            if point.seq == seq:
                return number
        return 0

    def _pass_point(self, sail: Sail) -> list[Action]:
        seq = sail.route[self._passed].seq
        last = self._passed == len(sail.route) - 1
        self._passed += 1
        self._just_passed = seq
        if last:
            self._task = None
        item = self._items[seq]
        if last and must_stay(item):
            self._arrived = True
            if item.command != Command.NAV_LOITER_TIME:
                self._count(seq)
            return []
        self._count(seq)
        return self._advance()

    def _count(self, seq: int) -> None:
        self._reached += 1
        self._reached_seq = seq

    def _advance(self) -> list[Action]:
        self.replaced = None
        self._arrived = False
        actions = self._cursor.advance()
        if self._cursor.item is None:
            self._state = MissionState.COMPLETE
        return actions

    def _settle(self) -> None:
        self._actions += self._cursor.settle()
        if self._cursor.item is None:
            self._state = MissionState.COMPLETE

    def _rewind(self, seq: int) -> None:
        """Forget jumps and speed, and move to `seq`."""
        if self._cursor.speed_mps is not None:
            self._actions.append(SetSpeed(None))
        self._cursor = Cursor(self._items, seq)
        self._actions += self._cursor.trigger_before()
        self._arrived = False
        self._just_passed = None
        self._task = None

    def _forget_jumps(self, reset: bool) -> None:
        """If `reset`; a route under way then leads elsewhere."""
        if reset:
            self._cursor.jumps.clear()
            self._task = None if isinstance(self._task, Sail) else self._task

    def _outside(self, seq: int) -> str | None:
        if 0 <= seq < len(self._items):
            return None
        return f"the mission has items 1 to {item_number(len(self._items) - 1)}"

    # --- a new plan ------------------------------------------------------------------------------------------------

    def prepare(self, items: Sequence[PlanItem]) -> Callable[[], Adopt]:
        """The work that a new mission needs (`Plans.prepare_by`): how many items it shares with the present one."""
        before = self._items

        def work() -> Adopt:
            shared = shared_items(before, items)

            def adopt() -> None:
                self._shared = before, items, shared

            return adopt

        return work

    def _shared_with(self, before: Sequence[PlanItem]) -> int:
        """How many items the mission in force shares with the one before."""
        if self._shared[0] is before and self._shared[1] is self._items:
            return self._shared[2]
        return shared_items(before, self._items)

    def _on_change(self, kind: PlanKind) -> None:
        if kind is not PlanKind.MISSION:
            return
        before, self._items = self._items, self._plans.items(PlanKind.MISSION)
        underway = self._state in (MissionState.ACTIVE, MissionState.PAUSED)
        upto = self._cursor.seq + 1
        self._task = None
        self.replaced = None
        shared = self._shared_with(before) if underway else 0
        self._shared = (), (), 0
        if underway and shared >= upto:
            jumps = {seq: taken for seq, taken in self._cursor.jumps.items() if seq < shared}
            before_it = self._cursor
            self._cursor = Cursor(self._items, before_it.seq, jumps, before_it.speed_mps, held=before_it.held)
            self._cursor.astern, self._cursor.leg_speed_mps = before_it.astern, before_it.leg_speed_mps
            self.replaced = Replaced.CONTINUED
            return
        self._rewind(0)
        if not self._items:
            self._state = MissionState.NO_MISSION
        elif self._state is MissionState.ACTIVE:
            self.replaced = Replaced.RESTARTED
            self._settle()
        else:
            self.replaced = Replaced.RESTARTED if underway else None
            self._state = MissionState.NOT_STARTED


def _tasks(cursor: Cursor, arrived: bool) -> Iterator[Task]:
    """The tasks from a place of a mission on, which the cursor passes. `arrived`: the boat is at the first one."""
    cursor.settle()
    while cursor.item is not None:
        task = task_at(cursor, arrived)
        yield task
        arrived = False
        if isinstance(task, Sail):
            for _ in task.route[1:]:
                cursor.advance()
            arrived = must_stay(cursor.item) if cursor.item is not None else False
        if isinstance(task, Stay) and task.duration_s is None:
            return
        if not arrived:
            cursor.advance()
