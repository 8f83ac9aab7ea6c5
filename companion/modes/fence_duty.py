"""What a new fence or a new plan means for what the boat is about: the mode under way gives way to the fence, a mission at rest is warned of."""

from __future__ import annotations

from companion.core.types import ModeId, Severity
from companion.mission.plan import PlanKind, Plans
from companion.modes.events import EventLog
from companion.modes.fence_guard import FenceGuard
from companion.modes.helm import Helm
from companion.modes.hold import HoldMode
from companion.modes.mission import MissionMode
from companion.modes.mode import ModeInputs

_SETTLED_S = 3.0  # ground stations send mission, fence and rally points one after the other


class FenceDuty:
    """`update(inputs)` once a tick. Remembers the fence and the plans seen last, and when they changed."""

    def __init__(self, fence: FenceGuard, plans: Plans, helm: Helm, hold: HoldMode, mission: MissionMode, events: EventLog) -> None:
        self._fence = fence
        self._plans = plans
        self._helm = helm
        self._hold = hold
        self._mission = mission
        self._events = events
        self._seen_fence: object = None
        self._seen_plans: object = None
        self._changed_s: float | None = None

    def update(self, inputs: ModeInputs) -> None:
        """Call after the newest estimate is in."""
        key = self._fence.key
        if key != self._seen_fence:
            self._seen_fence = key
            if key and self._helm.armed:
                self._mind_new_fence(inputs)
        if self._helm.armed and self._helm.mode is self._mission and self._mission.blocked is not None:
            self._interrupt(f"Mission stopped: {self._mission.blocked}", inputs)
        self._warn_of_plan(inputs)

    def _mind_new_fence(self, inputs: ModeInputs) -> None:
        """A fence that comes in force under way is obeyed at once: refused, it could not keep the boat off what it was drawn for."""
        helm, nav = self._helm, inputs.nav
        if helm.mode is self._mission and (reason := self._mission.fence_refusal(inputs)) is not None:
            self._interrupt(f"Stopped by the new fence: {reason}", inputs)
        elif helm.mode is self._hold and self._hold.going and (reason := self._fence.go_refusal(nav, *self._hold.target)) is not None:
            self._hold.hold_here(nav)
            self._events.say(inputs.now_s, Severity.WARNING, "fence_stops", f"Go-to stopped by the new fence: {reason}")
        elif helm.mode.id is ModeId.RTL and helm.enter_again(inputs.now_s) is not None:
            self._interrupt("RTL stopped by the new fence: no way home inside it", inputs)
        elif helm.mode.id is ModeId.DOCK and (reason := helm.mode.check(inputs)) is not None:
            self._interrupt(f"Docking stopped by the new fence: {reason}", inputs)

    def _interrupt(self, text: str, inputs: ModeInputs) -> None:
        self._events.say(inputs.now_s, Severity.WARNING, "fence_stops", f"{text}; holding here")
        if self._helm.switch(ModeId.HOLD, inputs.nav, inputs.now_s, intended=False) is not None:
            self._helm.stop()

    def _warn_of_plan(self, inputs: ModeInputs) -> None:
        """Once mission and fence are both there: what would be refused at the start is said now."""
        plans = self._fence.key, self._plans.plan_id(PlanKind.MISSION)
        if plans != self._seen_plans:
            self._seen_plans = plans
            self._changed_s = inputs.now_s
        if self._changed_s is None or inputs.now_s - self._changed_s < _SETTLED_S or not inputs.nav.position_valid:
            return
        self._changed_s = None
        under_way = self._helm.armed and self._helm.mode is self._mission
        if plans[0] and plans[1] and not under_way and (reason := self._mission.fence_refusal(inputs)) is not None:
            self._events.say(inputs.now_s, Severity.WARNING, "mission_crosses_fence", f"Check the mission: {reason}")
