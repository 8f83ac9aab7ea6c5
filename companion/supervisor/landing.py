"""Take-off and Land, which programs written for aircraft ask for, and what follows at the end of a voyage."""

from __future__ import annotations

from companion.core.decision import ACCEPTED, ModeId, Outcome, Result, TextKind
from companion.supervisor.requests import Requests

_DOCK = 1  # COM_LAND_ACT


class Landing:
    """`update(now_s)` once a tick. Remembers since when the voyage is over (COM_DISARM_LAND)."""

    def __init__(self, requests: Requests) -> None:
        self._requests = requests
        self._parts = requests.parts
        self._over_since_s: float | None = None

    @property
    def landed(self) -> bool:
        """Whether an armed boat counts as landed: the voyage is over. In RTL it does not: at home QGroundControl would
        offer no go-to then."""
        return self._over and self._parts.helm.mode.id is not ModeId.RTL

    def take_off(self, now_s: float) -> Outcome:
        """A boat is afloat: nothing to do, but a boat that sticks steer holds from now on, as an aircraft hovers. With
        COM_TAKEOFF_OK 0 it is refused."""
        if not self._parts.parameters["COM_TAKEOFF_OK"]:
            text = "Take-off refused: this is a boat (COM_TAKEOFF_OK)"
            self._parts.events.say(now_s, TextKind.REFUSAL, "refused", text)
            return Outcome(Result.DENIED, text)
        self._parts.events.say(now_s, TextKind.ROUTINE, "afloat", "Take-off: afloat already, nothing to do")
        if self._parts.helm.armed and self._parts.helm.mode.by_stick:
            return self._requests.hold_here(now_s)
        return ACCEPTED

    def land(self, place: tuple[float, float] | None, now_s: float) -> Outcome:
        """Dock or hold, by COM_LAND_ACT. `place` (lat_deg, lon_deg): where to hold; None: here."""
        helm, hold = self._parts.helm, self._parts.hold
        if not helm.armed:
            return ACCEPTED
        if self._parts.parameters["COM_LAND_ACT"] == _DOCK:
            reason = helm.choice_refusal(ModeId.DOCK, self._parts.nav, now_s)
            if reason is None:
                return self._requests.request_mode(ModeId.DOCK, now_s)
            self._parts.events.say(now_s, TextKind.ATTENTION, "land_holds", f"Land holds, no docking: {reason}")
        if place is None:
            outcome = self._requests.hold_here(now_s)
        else:
            outcome = self._requests.go_to(*place, None, None, now_s)
        if outcome.accepted:
            hold.land()
        return outcome

    def update(self, now_s: float) -> None:
        """Disarm a boat whose voyage has been over for COM_DISARM_LAND."""
        wait_s = self._parts.parameters["COM_DISARM_LAND"]
        if not self._over or wait_s < 0.0:
            self._over_since_s = None
            return
        if self._over_since_s is None:
            self._over_since_s = now_s
        if now_s - self._over_since_s >= wait_s:
            self._over_since_s = None
            self._parts.events.say(now_s, TextKind.ROUTINE, "landed", "Voyage is over: disarming (COM_DISARM_LAND)")
            self._requests.disarm(now_s)

    @property
    def _over(self) -> bool:
        helm = self._parts.helm
        return helm.armed and not helm.stopped and helm.mode.voyage_over
