"""A new fence ends a mode whose way it cuts off. A new mission that crosses the fence is announced."""

from __future__ import annotations

from companion.core.decision import ModeId, ModeInputs, TextKind
from companion.core.events import EventLog
from companion.fence.guard import FenceGuard
from companion.mission.plan import PlanKind, Plans
from companion.modes.mission import MissionMode
from companion.supervisor.helm import Helm
from companion.supervisor.mode_changes import Cause

_SETTLED_S = 3.0  # ground stations send mission, fence and rally points one after the other


class FenceDuty:
    """`update(inputs)` once a tick. Remembers the fence and the plans seen last, and when they changed."""

    def __init__(self, fence: FenceGuard, plans: Plans, helm: Helm, mission: MissionMode, events: EventLog) -> None:
        self._fence = fence
        self._plans = plans
        self._helm = helm
        self._mission = mission
        self._events = events
        self._seen_fence: object = None
        self._seen_plans: object = None
        self._told_of: object = None
        self._changed_s: float | None = None

    def update(self, inputs: ModeInputs) -> None:
        """Call after the newest estimate is in."""
        key = self._fence.key
        if key != self._seen_fence:
            self._seen_fence = key
            if key and self._helm.armed:
                self._mind_new_fence(inputs)
            if key:
                self._helm.refusal(ModeId.RTL, inputs.nav, inputs.now_s)  # its answer is known when RTL is asked for
            self._tell_of_no_circles(inputs.now_s)
        mode = self._helm.mode
        if self._helm.armed and mode.blocked is not None:
            self._interrupt(f"{mode.id.value} stopped: {mode.blocked}", inputs)
        self._warn_of_plan(inputs)

    def _mind_new_fence(self, inputs: ModeInputs) -> None:
        """A fence that comes into force under way is obeyed at once: it may guard something that lies ahead."""
        mode = self._helm.mode
        reason = self._helm.guarded(mode, lambda: mode.mind_fence(inputs), inputs.now_s)
        if reason is not None:
            self._interrupt(f"{mode.id.value} stopped: {reason}", inputs)

    def _tell_of_no_circles(self, now_s: float) -> None:
        """Announce the circles of a new fence that are none."""
        fence_id, none = self._plans.plan_id(PlanKind.FENCE), self._fence.no_circle
        if none is not None and fence_id != self._told_of:
            text = f"Fence item {none}: circle of radius 0 ignored"
            self._events.say(now_s, TextKind.ATTENTION, "fence_no_circle", text)
        self._told_of = fence_id

    def _interrupt(self, text: str, inputs: ModeInputs) -> None:
        self._events.say(inputs.now_s, TextKind.ATTENTION, "fence_stops", text)
        if self._helm.switch(ModeId.HOLD, inputs.nav, inputs.now_s, Cause.FENCE) is not None:
            self._helm.stop(Cause.FENCE)

    def _warn_of_plan(self, inputs: ModeInputs) -> None:
        """Check a new mission against the fence, a step each tick. Announce, once both are there, what would be refused
        at the start."""
        plans = self._fence.key, self._plans.plan_id(PlanKind.MISSION)
        if plans != self._seen_plans:
            self._seen_plans = plans
            self._changed_s = inputs.now_s
        if self._changed_s is None or not inputs.nav.position_valid:
            return
        under_way = self._helm.armed and self._helm.mode is self._mission
        reason = self._refusal(inputs) if plans[0] and plans[1] and not under_way else None
        unfinished = reason is None and not under_way and not self._mission.fence_checked
        if unfinished or inputs.now_s - self._changed_s < _SETTLED_S:
            return
        self._changed_s = None
        if reason is not None:
            self._events.say(inputs.now_s, TextKind.ATTENTION, "mission_crosses_fence", f"Check the mission: {reason}")

    def _refusal(self, inputs: ModeInputs) -> str | None:
        return self._helm.guarded(self._mission, lambda: self._mission.fence_refusal(inputs), inputs.now_s)
