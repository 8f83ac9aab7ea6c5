"""What a mission asks of the vessel without leaving its mode: speed, home, fence, follow position, outputs, payload."""

from __future__ import annotations

from companion.core.decision import Home
from companion.core.estimate import NavState
from companion.fence.guard import FenceGuard
from companion.mission.tasks import (
    AuxiliaryAction,
    PayloadAction,
    SetFollowPosition,
    SetHome,
    SetSpeed,
    Setting,
    SwitchFence,
)
from companion.supervisor.cruise import Cruise
from companion.supervisor.follow_duty import FollowDuty
from companion.supervisor.homing import HomeKeeper
from companion.supervisor.outputs import AuxiliaryOutputs
from companion.supervisor.payload import Payload


class MissionActions:
    """`perform(action, nav, now_s)`. Remembers nothing."""

    def __init__(
        self,
        cruise: Cruise,
        home: HomeKeeper,
        fence: FenceGuard,
        auxiliary: AuxiliaryOutputs,
        following: FollowDuty,
        payload: Payload,
    ) -> None:
        self._cruise = cruise
        self._home = home
        self._fence = fence
        self._auxiliary = auxiliary
        self._following = following
        self._payload = payload

    def perform(
        self,
        action: Setting | AuxiliaryAction | PayloadAction,
        nav: NavState,
        now_s: float,
    ) -> None:
        """Carry out one action. What is refused is announced by the part that refuses."""
        if isinstance(action, SetSpeed):
            self._cruise.ask(action.speed_mps)
        elif isinstance(action, SetHome):
            self._set_home(action, nav, now_s)
        elif isinstance(action, SwitchFence):
            self._fence.switch(action.on, now_s)
        elif isinstance(action, SetFollowPosition):
            self._following.set_follow_position(action.bearing_rad, action.distance_m, now_s)
        elif isinstance(action, AuxiliaryAction):
            self._auxiliary.request(action, now_s)
        else:
            self._payload.request(action, now_s, by_mission=True)

    def ended(self, now_s: float) -> None:
        """The mission has ended."""
        self._payload.mission_ended(now_s)

    def _set_home(self, action: SetHome, nav: NavState, now_s: float) -> None:
        if action.lat_deg is None or action.lon_deg is None:
            self._home.set_here(nav, now_s)
        else:
            self._home.set(Home(action.lat_deg, action.lon_deg, nav.altitude_m), now_s)
