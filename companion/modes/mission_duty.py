"""What a mission asks of the vessel beside the sailing: speed, home and outputs, what comes after its end, and after a restart."""

from __future__ import annotations

from collections.abc import Callable

from companion.core.types import Home, MissionState, ModeId, NavState, Severity
from companion.mission.executor import MissionExecutor, Replaced
from companion.mission.tasks import FollowLeader, SetHome, SetSpeed, SetStation
from companion.modes.auxiliary import AuxiliaryOutputs
from companion.modes.events import EventLog
from companion.modes.failsafes import Action
from companion.modes.follow_duty import FollowDuty
from companion.modes.helm import Helm
from companion.modes.homing import HomeKeeper
from companion.modes.mission import MissionMode
from companion.params import Parameters


class MissionDuty:
    """`update(now_s)` once a tick, `after(nav, now_s)` when the mission has steered. Remembers what was said of the last new plan, and
    whether the first tick is over. `set_speed` takes the speed that the mission sets, None for the usual one."""

    def __init__(
        self,
        parameters: Parameters,
        executor: MissionExecutor,
        mission: MissionMode,
        helm: Helm,
        home: HomeKeeper,
        auxiliary: AuxiliaryOutputs,
        following: FollowDuty,
        events: EventLog,
        set_speed: Callable[[float | None], None],
    ) -> None:
        self._parameters = parameters
        self._executor = executor
        self._mission = mission
        self._helm = helm
        self._home = home
        self._auxiliary = auxiliary
        self._following = following
        self._events = events
        self._set_speed = set_speed
        self._replaced: Replaced | None = None
        self._restored = False

    def restore(self, now_s: float) -> None:
        """On the first tick: a mission that a restart interrupted waits, and goes on when armed if MIS_ON_START says so."""
        if self._restored:
            return
        self._restored = True
        if self._executor.progress.state is not MissionState.ACTIVE:
            return
        self._executor.pause()
        goes_on = bool(self._parameters["MIS_ON_START"])
        self._helm.choose_disarmed(ModeId.MISSION if goes_on else ModeId.HOLD)
        remedy = "goes on when armed" if goes_on else "choose Mission to go on"
        text = f"Mission was interrupted at item {self._executor.progress.seq}: {remedy}"
        self._events.say(now_s, Severity.NOTICE, "mission_interrupted", text)

    def tell_of_new_plan(self, now_s: float) -> None:
        """Whether the mission goes on in it or begins anew."""
        replaced = self._executor.replaced
        if replaced is not None and replaced is not self._replaced:
            seq = self._executor.progress.seq
            text = f"New mission goes on at item {seq}" if replaced is Replaced.CONTINUED else "New mission begins at its first item"
            self._events.say(now_s, Severity.NOTICE, "mission_replaced", text)
        self._replaced = replaced

    def after(self, nav: NavState, now_s: float) -> None:
        """Perform what the mission asks of the vessel, and what comes after its end."""
        for action in self._mission.take_actions():
            if isinstance(action, SetSpeed):
                self._set_speed(action.speed_mps)
            elif isinstance(action, SetHome):
                self._set_home(action, nav, now_s)
            elif isinstance(action, SetStation):
                self._following.set_station(action.bearing_rad, action.distance_m, now_s)
            elif isinstance(action, FollowLeader):
                self._follow(action, nav, now_s)
            else:
                self._auxiliary.request(action, now_s)
        ended = self._mission.ended
        if ended is not None and self._helm.mode is self._mission:
            self._end(ended, nav, now_s)

    def _follow(self, action: FollowLeader, nav: NavState, now_s: float) -> None:
        """What comes after the item waits until the mission is resumed. Without a leader the boat holds, or ends its mission where nothing comes after."""
        complete = self._mission.ended is MissionState.COMPLETE
        if action.system_id is None or self._following.choose_leader(action.system_id, now_s).accepted:
            reason = self._helm.switch(ModeId.FOLLOW, nav, now_s)
            if reason is None:
                then = "Mission complete" if complete else f"choose Mission to go on at item {self._executor.progress.seq}"
                self._events.say(now_s, Severity.NOTICE, "mission_follows", f"Item {action.seq}: following; {then}")
                return
            self._events.say(now_s, Severity.WARNING, "refused", f"Item {action.seq}: Follow refused: {reason}")
        if not complete and self._helm.switch(ModeId.HOLD, nav, now_s, intended=False) is not None:
            self._helm.stop()

    def _end(self, ended: MissionState, nav: NavState, now_s: float) -> None:
        text = "Mission complete" if ended is MissionState.COMPLETE else "Mission cleared"
        self._events.say(now_s, Severity.NOTICE, "mission_ended", text)
        switch = self._helm.switch
        if ended is MissionState.COMPLETE and self._mission.docked and switch(ModeId.DOCK, nav, now_s) is None:
            return
        then = Action(int(self._parameters["MIS_DONE_ACT"])) if ended is MissionState.COMPLETE else Action.HOLD
        if then is Action.RTL and switch(ModeId.RTL, nav, now_s) is None:
            return
        if then is Action.NEUTRAL or switch(ModeId.HOLD, nav, now_s) is not None:
            self._helm.stop()

    def _set_home(self, action: SetHome, nav: NavState, now_s: float) -> None:
        if action.lat_deg is None or action.lon_deg is None:
            self._home.set_here(nav, now_s)
        else:
            self._home.set(Home(action.lat_deg, action.lon_deg, nav.altitude_m), now_s)
