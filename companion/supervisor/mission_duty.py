"""What a mission does to the vessel's mode: handing over to Follow and Trial, what comes after its end."""

from __future__ import annotations

from companion.core.decision import MissionState, ModeId, ModeInputs, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.mission.executor import MissionExecutor, Replaced
from companion.mission.plan import item_number
from companion.mission.tasks import BeginTrial, FollowLeader
from companion.modes.hold import HoldMode
from companion.modes.mission import MissionMode
from companion.modes.trial.mode import COMPLETE, TrialOrder
from companion.params.store import Parameters
from companion.supervisor.failsafes import FailsafeAction
from companion.supervisor.follow_duty import FollowDuty
from companion.supervisor.helm import Helm
from companion.supervisor.mission_actions import MissionActions
from companion.supervisor.mode_changes import Cause


class MissionDuty:
    """`restore` and `tell_of_new_plan` once a tick, `after(nav, now_s)` when the mission has steered. Remembers the
    last new plan, whether the first tick is over, and whether the boat was to rest after its mission."""

    def __init__(
        self,
        parameters: Parameters,
        executor: MissionExecutor,
        mission: MissionMode,
        hold: HoldMode,
        helm: Helm,
        following: FollowDuty,
        actions: MissionActions,
        events: EventLog,
    ) -> None:
        self._parameters = parameters
        self._executor = executor
        self._mission = mission
        self._hold = hold
        self._helm = helm
        self._following = following
        self._actions = actions
        self._events = events
        self._replaced: Replaced | None = None
        self._restored = False
        self._rests = False

    @property
    def rests(self) -> bool:
        """Whether the boat has no thrust because its mission has ended and MIS_DONE_ACT is Neutral."""
        return self._rests and self._helm.stopped and self._helm.cause is Cause.MISSION_END

    @property
    def _item(self) -> int:
        """Number of the current item."""
        return item_number(self._executor.progress.seq)

    def restore(self, now_s: float) -> None:
        """On the first tick: pause a mission that a restart interrupted. With MIS_ON_START it goes on when armed."""
        if self._restored:
            return
        self._restored = True
        if self._executor.progress.state is not MissionState.ACTIVE:
            return
        self._executor.pause()
        goes_on = bool(self._parameters["MIS_ON_START"])
        self._helm.choose_disarmed(ModeId.MISSION if goes_on else ModeId.HOLD, Cause.RESTART)
        remedy = "goes on when armed" if goes_on else "choose Mission to go on"
        text = f"Interrupted at item {self._item}: {remedy}"
        self._events.say(now_s, TextKind.ATTENTION, "mission_interrupted", text)

    def tell_of_new_plan(self, now_s: float) -> None:
        """Announce whether the mission goes on in a new plan or begins anew."""
        replaced = self._executor.replaced
        if replaced is not None and replaced is not self._replaced:
            text = (
                f"New mission goes on at item {self._item}"
                if replaced is Replaced.CONTINUED
                else "New mission begins at its first item"
            )
            self._events.say(now_s, TextKind.ROUTINE, "mission_replaced", text)
        self._replaced = replaced

    def after(self, nav: NavState, now_s: float) -> None:
        """Perform the actions of the mission, and what comes after its end."""
        for action in self._mission.take_actions():
            if isinstance(action, FollowLeader):
                self._follow(action, nav, now_s)
            elif isinstance(action, BeginTrial):
                self._begin_trial(action, nav, now_s)
            else:
                self._actions.perform(action, nav, now_s)
        ended = self._mission.ended
        if ended is not None and self._helm.mode is self._mission:
            self._end(ended, nav, now_s)

    def _follow(self, action: FollowLeader, nav: NavState, now_s: float) -> None:
        """Follow; the next items wait until the mission is resumed. Without a leader the boat holds; the mission ends
        if no item is left."""
        complete = self._mission.ended is MissionState.COMPLETE
        if action.system_id is None or self._following.choose_leader(action.system_id, now_s).accepted:
            reason = self._helm.switch(ModeId.FOLLOW, nav, now_s, Cause.MISSION_ITEM)
            if reason is None:
                then = "Mission complete" if complete else f"choose Mission for item {self._item}"
                self._events.say(
                    now_s, TextKind.ROUTINE, "mission_follows", f"Item {item_number(action.seq)}: following; {then}"
                )
                return
            self._events.say(
                now_s, TextKind.REFUSAL, "refused", f"Item {item_number(action.seq)}: Follow refused: {reason}"
            )
        refused = Cause.MISSION_ITEM_REFUSED
        if not complete and self._helm.switch(ModeId.HOLD, nav, now_s, refused) is not None:
            self._helm.stop(refused)

    def _begin_trial(self, action: BeginTrial, nav: NavState, now_s: float) -> None:
        """Sail a trial; without one the boat holds, and the mission stays at its item."""
        reason = self._helm.switch_for(TrialOrder(action.radius_m), nav, now_s, Cause.MISSION_ITEM)
        if reason is None:
            return
        text = f"Item {item_number(action.seq)}: Trial refused: {reason}"
        self._events.say(now_s, TextKind.REFUSAL, "refused", text)
        if self._helm.switch(ModeId.HOLD, nav, now_s, Cause.MISSION_ITEM_REFUSED) is not None:
            self._helm.stop(Cause.MISSION_ITEM_REFUSED)

    def trial_ended(self, how: str, inputs: ModeInputs) -> None:
        """After a trial the boat holds; a mission that began it goes on if it is complete."""
        helm, nav, now_s, cause = self._helm, inputs.nav, inputs.now_s, Cause.TRIAL_END
        by_mission = helm.cause is Cause.MISSION_ITEM
        if how == COMPLETE and by_mission and helm.switch(ModeId.MISSION, nav, now_s, cause) is None:
            self._mission.finish_trial(inputs)
            return
        if helm.switch(ModeId.HOLD, nav, now_s, cause) is not None:
            helm.stop(cause)

    def _end(self, ended: MissionState, nav: NavState, now_s: float) -> None:
        text = "Mission complete" if ended is MissionState.COMPLETE else "Mission cleared"
        self._events.say(now_s, TextKind.ROUTINE, "mission_ended", text)
        self._actions.ended(now_s)
        helm, complete, cause = self._helm, ended is MissionState.COMPLETE, Cause.MISSION_END
        landed = self._mission.voyage_over
        if complete and self._mission.docked and helm.switch(ModeId.DOCK, nav, now_s, cause) is None:
            return
        then = FailsafeAction(int(self._parameters["MIS_DONE_ACT"])) if complete else FailsafeAction.HOLD
        self._rests = then is FailsafeAction.NEUTRAL
        if then is FailsafeAction.RTL and helm.switch(ModeId.RTL, nav, now_s, cause) is None:
            return
        if then is FailsafeAction.NEUTRAL or helm.switch(ModeId.HOLD, nav, now_s, cause) is not None:
            helm.stop(cause)
        elif landed:
            self._hold.land()
