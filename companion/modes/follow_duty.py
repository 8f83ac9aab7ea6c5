"""What following asks of the vessel beside the steering: whose word counts, whether the data are good, where the station is."""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.core.types import ACCEPTED, LeaderState, ModeId, NavState, Outcome, Result, Severity, Wish
from companion.modes.events import EventLog
from companion.modes.follow_station import FollowStation
from companion.modes.helm import Helm
from companion.modes.leader_watch import LeaderWatch
from companion.modes.mode import ModeInputs
from companion.modes.situation import LeaderSight, estimate_refusal
from companion.modes.sticks import Sticks, is_centred
from companion.params import Parameters

_ASKS_FOR = {Wish.MANUAL: "Manual", Wish.REMOTE: "remote control", Wish.AUTONOMOUS: "Follow"}
_LATE_S = 1.0  # a message that was overtaken by a newer one comes within this
_HEARD_S = 4.0  # since its last message, of a system that may be chosen as the leader
_MOST_SYSTEMS = 32
_PRESSES = 255  # the counter goes from 255 to 1


class FollowDuty:
    """`heard(state)` each message of the leader, `update(inputs)` once a tick, before the failsafes.

    A change of the module's wish, or its repetition by a press, is a decision like one made at a ground station, and goes the same way
    (`request_mode`); what a module wishes when it is first heard, or anew after a restart, is none. Remembers the last wish heard and of whom,
    which system steers by remote, which leader was followed, and the station.
    """

    def __init__(
        self, parameters: Parameters, helm: Helm, sticks: Sticks, events: EventLog, request_mode: Callable[[ModeId, float], Outcome]
    ) -> None:
        self._parameters = parameters
        self._helm = helm
        self._sticks = sticks
        self._events = events
        self._request_mode = request_mode
        helm.waits = self._waits
        self._watch = LeaderWatch(parameters)
        self._station = FollowStation(parameters, events)
        self._newest_s: dict[int, float] = {}  # of every system that tells of a lead boat
        self._module: LeaderState | None = None  # its last message that was not overtaken
        self._followed: int | None = None
        self._following = False
        self._armed = False
        self._awaits = False  # in Follow, which could not be entered yet
        self._since_s = 0.0
        self.remote_system: int | None = None
        """The system whose sticks alone steer, since its crew asked for it; None: as usual."""

    # --- what others ask -------------------------------------------------------------------------------------------

    @property
    def station(self) -> tuple[float, float]:
        """(distance_m, bearing_rad) in force."""
        return self._station.now

    def fault(self, nav: NavState, now_s: float) -> str | None:
        """Why the leader cannot be followed now, or None."""
        return self._watch.fault(nav, now_s)

    def sight(self, nav: NavState, now_s: float) -> LeaderSight:
        """For the failsafes."""
        fault = None if self._waiting(now_s) else self._watch.fault(nav, now_s) or ("follow cannot begin" if self._awaits else None)
        return LeaderSight(fault, self._watch.good_s(now_s), self._stays(now_s))

    def stands_for_station(self, state: LeaderState) -> bool:
        """Whether this message of the leader is as good as one of a ground station: in Follow, and while the lead boat steers by remote."""
        return self._helm.intended.id is ModeId.FOLLOW or self.remote_system == state.system_id

    def stick_refusal(self, system_id: int) -> str | None:
        """Why the sticks of this system do not steer, or None."""
        if self.remote_system is not None and self.remote_system != system_id:
            return f"the lead boat (system {self.remote_system}) steers by remote. Choose a mode to take over"
        by_choice = system_id in (self.remote_system, int(self._parameters["MAN_GCS_SYSID"]))
        if not by_choice and self._module is not None and self._module.system_id == system_id:
            return "a lead boat steers once its crew asks for remote control"
        return None

    # --- requests --------------------------------------------------------------------------------------------------

    def set_station(self, bearing_rad: float | None, distance_m: float | None, now_s: float) -> Outcome:
        """Another station, until the next command, the parameters change or the boat is disarmed; None keeps what is."""
        return self._station.command(bearing_rad, distance_m, now_s)

    def choose_leader(self, system_id: int, now_s: float) -> Outcome:
        """That system leads from now on, as by FOLL_SYSID. One that is not heard changes nothing; where another was followed, accepted once the new one's
        messages count."""
        if now_s - self._newest_s.get(system_id, -math.inf) > _HEARD_S:
            return self._refuse(Result.TEMPORARILY_REJECTED, f"Follow refused: leader {system_id} not heard yet", now_s)
        if int(self._parameters["FOLL_SYSID"]) != system_id and (refusal := self._parameters.set("FOLL_SYSID", system_id)) is not None:
            return self._refuse(Result.DENIED, f"Follow refused: system id {system_id}: {refusal.name.lower().replace('_', ' ')}", now_s)
        if self._watch.system_id != system_id:
            return self._refuse(Result.TEMPORARILY_REJECTED, f"Follow refused: leader {system_id} not heard yet", now_s)
        return ACCEPTED

    def follow(self, system_id: int | None, now_s: float) -> Outcome:
        """Follow mode; `system_id` None: the leader as FOLL_SYSID has it."""
        if system_id is not None and (outcome := self.choose_leader(system_id, now_s)) != ACCEPTED:
            return outcome
        return self._request_mode(ModeId.FOLLOW, now_s)

    def taken_over(self, now_s: float) -> None:
        """A decision was made, wherever: remote control of an earlier one ends."""
        if self.remote_system is not None:
            self.remote_system = None
            self._sticks.hand_over(now_s, reserved=False)

    # --- what comes in ---------------------------------------------------------------------------------------------

    def heard(self, state: LeaderState, counts: bool) -> None:
        """A message of a lead boat; `counts`: of the one that leads."""
        if len(self._newest_s) >= _MOST_SYSTEMS and state.system_id not in self._newest_s:
            del self._newest_s[min(self._newest_s, key=lambda system: self._newest_s[system])]
        self._newest_s[state.system_id] = state.heard_s
        if not counts:
            return
        self._watch.heard(state)
        if state.wish is None:
            return
        before = self._module
        if before is not None and before.system_id == state.system_id:
            newer = _pressed(before.presses, state.presses)
            restarted = state.presses == 0 and before.presses != 0
            if (newer < 0 or restarted) and state.heard_s - before.heard_s < _LATE_S:
                return
            if not restarted and (newer != 0 or (state.wish is not before.wish and state.t_s >= before.t_s)):
                self._module = state
                self._decide(state)
                return
            if state.t_s < before.t_s:
                return
        self._module = state

    def _decide(self, state: LeaderState) -> None:
        wish, now_s = state.wish, state.heard_s
        if wish is None or wish is Wish.NONE:
            return
        text = f"Lead boat asks for {_ASKS_FOR[wish]}"
        if not self._parameters["FOLL_AUTH"]:
            self._events.say(now_s, Severity.WARNING, "refused", f"{text}: not obeyed, FOLL_AUTH is 0")
            return
        self._events.say(now_s, Severity.NOTICE, "leader_wish", text)
        accepted = self._request_mode(ModeId.FOLLOW if wish is Wish.AUTONOMOUS else ModeId.MANUAL, now_s).accepted
        if accepted and wish is Wish.REMOTE:
            self.remote_system = state.system_id
            self._sticks.hand_over(now_s, reserved=True)

    # --- once a tick -----------------------------------------------------------------------------------------------

    def update(self, inputs: ModeInputs) -> None:
        """Watch the data, and say what it begins with."""
        self._watch.update(inputs.nav, inputs.now_s)
        if self._armed and not self._helm.armed:
            self._station.drop()
        self._armed = self._helm.armed
        if not self._parameters["FOLL_AUTH"]:
            self.taken_over(inputs.now_s)
        following = self._armed and self._helm.mode.id is ModeId.FOLLOW
        self._awaits = self._awaits and following and self._helm.stopped
        if following and not self._following:
            self._since_s, self._awaits = inputs.now_s, self._helm.stopped
            self._begin(inputs)
        elif self._awaits and inputs.leader_fault is None:
            self._helm.resume(inputs.now_s)
            if not self._helm.stopped:
                self._begin(inputs)
        elif not self._waiting(inputs.now_s):
            self._awaits = False
        self._following = following
        self._station.update(following, inputs.now_s)
        if following and inputs.leader_fault is None:
            self._followed = self._watch.system_id

    def _begin(self, inputs: ModeInputs) -> None:
        leader, nav, least_m = inputs.leader, inputs.nav, self._parameters["FOLL_MIN_DIST"]
        if self._helm.stopped:
            self._events.say(inputs.now_s, Severity.NOTICE, "leader_awaited", f"Follow waits for the leader: {inputs.leader_fault}")
            return
        text = f"Following system {self._watch.system_id}, station {self._station.text}"
        self._events.say(inputs.now_s, Severity.INFO, "station", text)
        if leader is None:
            return
        away_m = math.hypot(leader.north_m - nav.north_m, leader.east_m - nav.east_m)
        if away_m < least_m:
            text = f"Leader is {away_m:.0f} m away, nearer than FOLL_MIN_DIST, {least_m:g} m"
            self._events.say(inputs.now_s, Severity.WARNING, "leader_near", text)

    def _waits(self, mode: ModeId, nav: NavState, now_s: float) -> bool:
        """For a leader that sends only once the boat is in Follow. A module sends always: it is not waited for."""
        if mode is not ModeId.FOLLOW or not self._parameters["FOLL_WAIT_T"] or self._watch.wish is not None:
            return False
        return estimate_refusal(self._helm.modes[mode], nav) is None and self._watch.fault(nav, now_s) is not None

    def _waiting(self, now_s: float) -> bool:
        return self._awaits and now_s - self._since_s <= self._parameters["FOLL_WAIT_T"]

    def _stays(self, now_s: float) -> str | None:
        """Why the boat does not go back to Follow by itself once the data are good."""
        watch = self._watch
        if self._followed is not None and watch.system_id != self._followed and not self._parameters["FOLL_SYSID"]:
            return "it is another leader"
        if self._parameters["FOLL_AUTH"] and watch.wish in (Wish.MANUAL, Wish.REMOTE):
            return f"the lead boat asks for {_ASKS_FOR[watch.wish]}"
        sticks = self._sticks.live(now_s) if self._helm.mode.by_stick else None
        return "somebody steers" if sticks is not None and not is_centred(sticks) else None

    def _refuse(self, result: Result, text: str, now_s: float) -> Outcome:
        self._events.say(now_s, Severity.WARNING, "refused", text)
        return Outcome(result, text)


def _pressed(before: int, now: int) -> int:
    """Presses from one count to the other, negative where the message is an older one. After 255 comes 1: 0 is for none since the module started."""
    if before == 0 or now == 0:
        return now - before
    return (now - before + _PRESSES // 2) % _PRESSES - _PRESSES // 2
