"""Following beside the steering: what the lead boat's crew asks for, whether the data are good, the follow position.

Whether the crew is obeyed is decided in `authority.py`, when the leader is lost in `following/watch.py`, and what then
happens by the row leader_lost of `failsafes.py`."""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.config.vessel import VesselConfig
from companion.core.decision import ACCEPTED, ModeId, ModeInputs, Outcome, Result, TextKind
from companion.core.estimate import NavState, RelativeBy
from companion.core.events import EventLog
from companion.core.readings import LeaderState, Wish
from companion.following.follow_position import FollowPosition
from companion.following.watch import LeaderWatch
from companion.params.store import Parameters
from companion.supervisor.authority import WISHES, AuthorityRequest, Facts, RequestedAction, Right, refusal
from companion.supervisor.helm import Helm
from companion.supervisor.mode_changes import Cause
from companion.supervisor.situation import Source, estimate_refusal
from companion.supervisor.sticks import Sticks

_LATE_S = 1.0  # a message that was overtaken by a newer one comes within this
_HEARD_S = 4.0  # since its last message, of a system that may be chosen as the leader
_MOST_SYSTEMS = 32
_LASTED_S = 6.0  # of another way to place the leader, before it is announced
_BETTER = 0.7  # of the uncertainty: it still gets better
_WAYS = tuple(RelativeBy)
_PRESSES = 255  # the counter goes from 255 to 1


class FollowDuty:
    """`heard(state)` each message of the leader, `update(inputs)` once a tick, before the failsafes.

    A change of the module's wish, or a press that repeats it, is a decision like one of a ground station (`choose`).
    The wish of a module that is heard for the first time, or after its restart, is none. Remembers the last message of
    the module, which leader was followed, and the follow position.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        helm: Helm,
        sticks: Sticks,
        events: EventLog,
        choose: Callable[[ModeId, float, Cause], Outcome],
        refusal_now: Callable[[AuthorityRequest, float], str | None],
    ) -> None:
        """`choose(mode, now_s, cause)`: a person's choice of a mode. `refusal_now(request, now_s)`: by the table of
        authority."""
        self._parameters = parameters
        self._helm = helm
        self._sticks = sticks
        self._events = events
        self._choose = choose
        self._refusal = refusal_now
        helm.waits = self._waits
        self._watch = LeaderWatch(parameters, self._leads)
        self._position = FollowPosition(config, parameters, events)
        self._newest_s: dict[int, float] = {}  # last message of every system that sends a leader's position
        self._module: LeaderState | None = None  # its last message that came in order
        self._followed: int | None = None
        self._following = False
        self._armed = False
        self._awaits = False  # in Follow, which could not be entered yet
        self._since_s = 0.0
        self._heading_lies = False  # as last told
        self._by: RelativeBy | None = None  # what the leader's place rests on, as last told
        self._by_since: tuple[RelativeBy, float, float] = (RelativeBy.POSITIONS, math.inf, 0.0)  # way, sigma, since

    # --- what others ask -------------------------------------------------------------------------------------------

    @property
    def follow_position(self) -> tuple[float, float]:
        """(distance_m, bearing_rad) in force; the bearing in the leader's frame, π astern."""
        return self._position.now

    def fault(self, nav: NavState, now_s: float) -> str | None:
        """Why the leader cannot be followed now, or None."""
        return self._watch.fault(nav, now_s)

    def sight(self, nav: NavState, facts: Facts, now_s: float) -> Source:
        """For the failsafes. `facts`: those of now."""
        fault = (
            None
            if self._waiting(now_s)
            else self._watch.fault(nav, now_s) or ("follow cannot begin" if self._awaits else None)
        )
        stays = refusal(AuthorityRequest(RequestedAction.RETURN_TO_FOLLOW, Right.BOAT), facts)
        if stays is None and self._watch.jump_m is not None:
            stays = f"leader jumped {self._watch.jump_m:.0f} m"
        return Source(fault, self._watch.good_s(now_s), stays)

    @property
    def module(self) -> int | None:
        """The system of the leader module; None before one was heard."""
        return None if self._module is None else self._module.system_id

    @property
    def wish(self) -> Wish | None:
        """What the leader module asks for; None where the leader has no module."""
        return self._watch.wish

    @property
    def followed(self) -> int | None:
        """The system that the boat followed last."""
        return self._followed

    @property
    def awaits(self) -> bool:
        """Whether the boat stands by in Follow until the leader is heard."""
        return self._awaits and self._helm.stopped and self._helm.mode.id is ModeId.FOLLOW

    # --- requests --------------------------------------------------------------------------------------------------

    def set_follow_position(self, bearing_rad: float | None, distance_m: float | None, now_s: float) -> Outcome:
        """Another follow position, until the next command, a change of the parameters, or disarming. None keeps the
        present value."""
        return self._position.command(bearing_rad, distance_m, now_s)

    def choose_leader(self, system_id: int, now_s: float) -> Outcome:
        """Set FOLL_SYSID to a system that is heard. Accepted once its messages count: a new leader is refused at
        first."""
        if now_s - self._newest_s.get(system_id, -math.inf) > _HEARD_S:
            return self._refuse(Result.TEMPORARILY_REJECTED, f"Follow refused: leader {system_id} not heard yet", now_s)
        if (
            int(self._parameters["FOLL_SYSID"]) != system_id
            and (refusal := self._parameters.set("FOLL_SYSID", system_id)) is not None
        ):
            return self._refuse(
                Result.DENIED, f"Follow refused: system id {system_id}: {refusal.name.lower().replace('_', ' ')}", now_s
            )
        if self._watch.system_id != system_id:
            return self._refuse(Result.TEMPORARILY_REJECTED, f"Follow refused: leader {system_id} not heard yet", now_s)
        return ACCEPTED

    def follow(self, system_id: int | None, now_s: float) -> Outcome:
        """Follow mode; `system_id` None: the leader of FOLL_SYSID."""
        if system_id is not None and (outcome := self.choose_leader(system_id, now_s)) != ACCEPTED:
            return outcome
        return self._choose(ModeId.FOLLOW, now_s, Cause.OPERATOR)

    def taken_over(self, now_s: float) -> None:
        """A person has decided something else: remote control ends."""
        if self._sticks.remote_system is not None:
            self._sticks.hand_over(now_s, None)

    # --- what comes in ---------------------------------------------------------------------------------------------

    def heard(self, state: LeaderState, counts: bool) -> None:
        """A message of a lead boat; `counts`: that boat leads."""
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
        text = f"Lead boat asks for {WISHES[wish]}"
        if (rule := self._wish_refusal(now_s)) is not None:
            self._events.say(now_s, TextKind.REFUSAL, "refused", f"Lead boat: {WISHES[wish]} refused: {rule}")
            return
        self._events.say(now_s, TextKind.ROUTINE, "leader_wish", text)
        mode = ModeId.FOLLOW if wish is Wish.AUTONOMOUS else ModeId.MANUAL
        accepted = self._choose(mode, now_s, Cause.LEAD_BOAT).accepted
        if accepted and wish is Wish.REMOTE:
            self._sticks.hand_over(now_s, state.system_id)

    def _wish_refusal(self, now_s: float) -> str | None:
        return self._refusal(AuthorityRequest(RequestedAction.LEADER_WISH, Right.LEAD_BOAT), now_s)

    def _leads(self, system_id: int) -> bool:
        """Whether the system that led last still may. Asked many times a tick, so with the facts that matter only."""
        facts = Facts(chosen_leader=int(self._parameters["FOLL_SYSID"]), leader=system_id)
        return refusal(AuthorityRequest(RequestedAction.LEADER_POSITION, Right.LEAD_BOAT, system_id), facts) is None

    # --- once a tick -----------------------------------------------------------------------------------------------

    def update(self, inputs: ModeInputs) -> None:
        """Watch the data; announce how Follow begins."""
        self._watch.update(inputs.nav, inputs.now_s)
        if self._armed and not self._helm.armed:
            self._position.drop()
        self._armed = self._helm.armed
        if self._sticks.remote_system is not None and self._wish_refusal(inputs.now_s) is not None:
            self.taken_over(inputs.now_s)
        following = self._armed and self._helm.mode.id is ModeId.FOLLOW
        self._awaits = self._awaits and following and self._helm.stopped
        if following and not self._following:
            self._since_s, self._awaits = inputs.now_s, self._helm.stopped
            self._watch.forget_jump()
            self._begin(inputs)
        elif self._awaits and inputs.leader_fault is None:
            self._helm.resume(inputs.now_s)
            if not self._helm.stopped:
                self._begin(inputs)
        elif not self._waiting(inputs.now_s):
            self._awaits = False
        self._following = following
        self._position.update(following, inputs.now_s)
        if following and inputs.leader_fault is None:
            self._followed = self._watch.system_id
        self._tell_way(inputs, following)
        self._tell_heading(inputs, following)

    def _tell_heading(self, inputs: ModeInputs, following: bool) -> None:
        """Announce in Follow that the leader's heading is not used, and that it is again."""
        leader, lied = inputs.leader, self._heading_lies
        if leader is None or not following:
            return
        self._heading_lies = leader.heading_lies
        if leader.heading_lies and not lied:
            text = "Leader's heading ignored: it is off its course"
            self._events.say(inputs.now_s, TextKind.ATTENTION, "leader_heading", text)
        elif lied and not leader.heading_lies:
            self._events.say(inputs.now_s, TextKind.ROUTINE, "leader_heading", "Leader's heading is used again")

    def _tell_way(self, inputs: ModeInputs, following: bool) -> None:
        """Announce in Follow what the leader's place rests on, once that has lasted and gets no better. That positions
        are all there is, is no news at the beginning."""
        leader, now_s = inputs.leader, inputs.now_s
        if not following:
            self._by = None
        if leader is None or not following:
            return
        by, sigma_m, since_s = self._by_since
        if leader.relative_by is not by or leader.relative_m < _BETTER * sigma_m:
            self._by_since = leader.relative_by, leader.relative_m, now_s
            return
        if by is self._by or now_s - since_s < _LASTED_S:
            return
        before, self._by = self._by, by
        if before is None and by is RelativeBy.POSITIONS:
            return
        worse = before is not None and _WAYS.index(by) < _WAYS.index(before)
        text = f"Leader's place by {by.value}, ±{leader.relative_m:.1f} m"
        self._events.say(now_s, TextKind.ATTENTION if worse else TextKind.ROUTINE, "leader_place", text)

    def _begin(self, inputs: ModeInputs) -> None:
        leader, nav, least_m = inputs.leader, inputs.nav, self._parameters["FOLL_MIN_DIST"]
        if self._helm.stopped:
            self._events.say(
                inputs.now_s,
                TextKind.ATTENTION,
                "leader_awaited",
                f"Follow waits for the leader: {inputs.leader_fault}",
            )
            return
        text = f"Following system {self._watch.system_id}: {self._position.text}"
        self._events.say(inputs.now_s, TextKind.ROUTINE, "station", text)
        if leader is None:
            return
        away_m = math.hypot(leader.north_m - nav.north_m, leader.east_m - nav.east_m)
        if away_m < least_m:
            near = f"Leader {away_m:.0f} m away, below FOLL_MIN_DIST ({least_m:g} m)"
            self._events.say(inputs.now_s, TextKind.ATTENTION, "leader_near", near)

    def _waits(self, mode: ModeId, nav: NavState, now_s: float) -> bool:
        """Whether Follow waits for a leader that sends only once the boat is in Follow. A module always sends: the boat
        does not wait for it."""
        if mode is not ModeId.FOLLOW or not self._parameters["FOLL_WAIT_T"] or self._watch.wish is not None:
            return False
        return estimate_refusal(self._helm.modes[mode], nav) is None and self._watch.fault(nav, now_s) is not None

    def _waiting(self, now_s: float) -> bool:
        return self._awaits and now_s - self._since_s <= self._parameters["FOLL_WAIT_T"]

    def _refuse(self, result: Result, text: str, now_s: float) -> Outcome:
        self._events.say(now_s, TextKind.REFUSAL, "refused", text)
        return Outcome(result, text)


def _pressed(before: int, now: int) -> int:
    """Presses from one count to the other; negative for an older message. After 255 comes 1: 0 means none since the
    module started."""
    if before == 0 or now == 0:
        return now - before
    return (now - before + _PRESSES // 2) % _PRESSES - _PRESSES // 2
