"""Tells at the upload of a mission, and at its start, of a long way to its first place and of a battery too small."""

from __future__ import annotations

from companion.core.decision import TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.geodesy import rough_distance_and_bearing
from companion.core.readings import Battery
from companion.mission.executor import MissionExecutor
from companion.mission.outlook import (
    battery_lasts_s,
    battery_warning,
    first_leg_warning,
    full_battery_s,
    length_text,
)
from companion.mission.plan import PlanKind, Plans
from companion.mission.summary import Reckoning, first_leg
from companion.modes.mission import MissionMode
from companion.params.store import Parameters
from companion.supervisor.cruise import Cruise
from companion.supervisor.helm import Helm
from companion.supervisor.homing import HomeKeeper

_LEGS_A_TICK = 20  # a long mission is not computed in one tick
_LEAST_USED = 0.03  # share of the battery from which its use can be told: boards report whole percents


class OutlookDuty:
    """`update(nav, battery, now_s)` once a tick. Remembers the plan seen last, the reckoning under way, and what the
    battery has given so far."""

    def __init__(
        self,
        parameters: Parameters,
        plans: Plans,
        executor: MissionExecutor,
        mission: MissionMode,
        helm: Helm,
        cruise: Cruise,
        home: HomeKeeper,
        events: EventLog,
    ) -> None:
        self._parameters, self._plans, self._executor = parameters, plans, executor
        self._mission, self._helm, self._cruise, self._home = mission, helm, cruise, home
        self._events = events
        self._use = BatteryUse()
        self._plan: int | None = None  # of the mission seen last; None before the first tick
        self._sailing = False
        self._due = self._uploaded = False
        self._reckoning: Reckoning | None = None
        self._first_told = False

    def update(self, nav: NavState, battery: Battery | None, now_s: float) -> None:
        """Reckon what is new, and tell."""
        self._use.update(battery, self._helm.armed and not self._helm.mode.by_stick, now_s)
        self._look(now_s)
        if self._due and nav.position_valid:
            self._due, self._first_told = False, False
            home = self._home.home
            self._reckoning = Reckoning(
                self._executor.way_ahead(),
                self._cruise.speed_mps,
                (nav.lat_deg, nav.lon_deg),
                None if home is None else (home.lat_deg, home.lon_deg),
                rough_distance_and_bearing,
                self._parameters["MPC_XY_VEL_MAX"],
                self._mission.most_astern_mps,
            )
        if self._reckoning is not None:
            self._reckon(self._reckoning, battery, now_s)

    def _look(self, now_s: float) -> None:
        """Whether a mission was uploaded or begins. A mission from before a restart is told when it begins."""
        plan, before = self._plans.plan_id(PlanKind.MISSION), self._plan
        sailing = self._helm.armed and self._helm.mode is self._mission
        uploaded = before is not None and plan != before
        if plan != before:
            self._reckoning, self._due = None, False
        if plan and (uploaded or (sailing and not self._sailing)):
            self._due, self._uploaded = True, uploaded
        self._plan, self._sailing = plan, sailing

    def _reckon(self, reckoning: Reckoning, battery: Battery | None, now_s: float) -> None:
        over = reckoning.advance(_LEGS_A_TICK)
        leg = first_leg(reckoning.legs)
        if (over or leg is not None) and not self._first_told:
            self._first_told = True
            self._warn("first_leg", first_leg_warning(leg, self._parameters["MIS_DIST_1WP"]), now_s)
        if over:
            self._reckoning = None
            self._tell_length(reckoning.length_m, reckoning.time_s, battery, now_s)

    def _tell_length(self, length_m: float, time_s: float, battery: Battery | None, now_s: float) -> None:
        full_s = full_battery_s(self._parameters["BAT_ENDURANCE"], self._use.full_s)
        remaining = None if battery is None else battery.remaining
        lasts_s = battery_lasts_s(full_s, remaining, self._parameters["BAT_CRIT_THR"])
        warning = battery_warning(length_m, time_s, lasts_s)
        if warning is not None:
            self._warn("mission_outlasts", warning, now_s)
        elif self._uploaded:
            self._events.say(now_s, TextKind.ROUTINE, "mission_length", length_text(length_m, time_s))

    def _warn(self, name: str, text: str | None, now_s: float) -> None:
        if text is not None:
            self._events.say(now_s, TextKind.ATTENTION, name, text)


class BatteryUse:
    """`update(battery, under_way, now_s)` once a tick. Remembers the share used and the time taken while the boat was
    under way by itself, and the last reading."""

    def __init__(self) -> None:
        self._used = 0.0
        self._time_s = 0.0
        self._last: tuple[float, float] | None = None  # share and time, under way

    def update(self, battery: Battery | None, under_way: bool, now_s: float) -> None:
        """Count. A battery that is charged meanwhile counts anew from there."""
        remaining = None if battery is None else battery.remaining
        if remaining is None or not under_way:
            self._last = None
            return
        if self._last is not None and remaining <= self._last[0]:
            self._used += self._last[0] - remaining
            self._time_s += now_s - self._last[1]
        self._last = remaining, now_s

    @property
    def full_s(self) -> float | None:
        """How long a full battery would last so, s; None until enough of it is used to tell."""
        return self._time_s / self._used if self._used >= _LEAST_USED else None
