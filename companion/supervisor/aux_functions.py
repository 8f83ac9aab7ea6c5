"""What the transmitter's switches do beside choosing modes and arming: one act for each function."""

from __future__ import annotations

from companion.core.decision import Outcome, TextKind
from companion.mission.tasks import SetRelay, TakePicture
from companion.params.transmitter import RELAYS, AuxFunction
from companion.supervisor.parts import SupervisorParts
from companion.supervisor.requests import Requests

_MISSION_FUNCTIONS = frozenset({AuxFunction.SAVE_WAYPOINT, AuxFunction.CLEAR_MISSION, AuxFunction.MISSION_RESET})


class AuxFunctions:
    """`switched(function, on, now_s)` when a switch has moved. Remembers nothing; a refusal is announced by the part
    that refuses."""

    def __init__(self, parts: SupervisorParts, requests: Requests) -> None:
        self._parts = parts
        self._requests = requests

    def switched(self, function: AuxFunction, on: bool, now_s: float) -> None:
        """Carry out a function; most act only when the switch is moved on."""
        parts = self._parts
        if function is AuxFunction.FENCE:
            self._requests.switch_fence(on, now_s)
        elif function is AuxFunction.LEARN_CRUISE:
            parts.cruise_learning.switched(on, parts.nav, now_s)
        elif function in RELAYS:
            parts.auxiliary.request(SetRelay(RELAYS[function], on), now_s)
        elif on and function is AuxFunction.CAMERA:
            outcome = parts.payload.request(TakePicture(), now_s)
            if not outcome.accepted:
                parts.events.say(now_s, TextKind.REFUSAL, "payload_refused", outcome.reason)
        elif on and function in _MISSION_FUNCTIONS:
            self._mission(function, now_s)

    def _mission(self, function: AuxFunction, now_s: float) -> Outcome:
        parts = self._parts
        if function is AuxFunction.SAVE_WAYPOINT:
            return parts.mission_edits.save_waypoint(parts.nav, now_s)
        if function is AuxFunction.CLEAR_MISSION:
            return parts.mission_edits.clear(now_s)
        return self._requests.reset_mission(now_s)
