"""What the transmitter does beside steering and choosing modes: one act for each function of a switch, and arming by
its yaw stick."""

from __future__ import annotations

from companion.core.decision import Outcome, TextKind
from companion.mission.plan import Plans
from companion.mission.tasks import SetRelay, TakePicture
from companion.params.sailing import BY_MOTOR_ALONE, WITHOUT_WIND
from companion.params.transmitter import RELAYS, AuxFunction
from companion.supervisor.authority import RequestedAction
from companion.supervisor.cruise_learning import CruiseLearning
from companion.supervisor.mission_edits import MissionEdits
from companion.supervisor.parts import SupervisorParts
from companion.supervisor.requests import Requests
from companion.supervisor.rudder_arming import RudderArming

_MISSION_FUNCTIONS = frozenset({AuxFunction.SAVE_WAYPOINT, AuxFunction.CLEAR_MISSION, AuxFunction.MISSION_RESET})


class AuxFunctions:
    """`switched(function, on, now_s)` when a switch has moved, `update(now_s)` once a tick → what the yaw stick asks
    for. Remembers its own parts; a refusal is announced by the part that refuses."""

    def __init__(self, parts: SupervisorParts, requests: Requests, plans: Plans) -> None:
        self._parts = parts
        self._requests = requests
        self.mission_edits = MissionEdits(plans, parts.helm, parts.events)
        self._learning = CruiseLearning(parts.config, parts.parameters, parts.helm, parts.events)
        self._rudder = RudderArming(parts.parameters, parts.helm)

    def update(self, now_s: float) -> RequestedAction | None:
        """ARM, DISARM, or None."""
        parts = self._parts
        self._learning.update(parts.nav, parts.achieved, now_s)
        return self._rudder.update(parts.sticks.transmitter(now_s), parts.nav, now_s)

    def switched(self, function: AuxFunction, on: bool, now_s: float) -> None:
        """Carry out a function; most act only when the switch is moved on."""
        parts = self._parts
        if function is AuxFunction.FENCE:
            self._requests.switch_fence(on, now_s)
        elif function is AuxFunction.LEARN_CRUISE:
            self._learning.switched(on, parts.nav, now_s)
        elif function is AuxFunction.SAILBOAT_MOTOR:
            self._motor(on, now_s)
        elif function in RELAYS:
            parts.auxiliary.request(SetRelay(RELAYS[function], on), now_s)
        elif on:
            self._act_once(function, now_s)

    def _act_once(self, function: AuxFunction, now_s: float) -> None:
        """What a switch does when it is moved on."""
        parts = self._parts
        if function is AuxFunction.CAMERA:
            outcome = parts.payload.request(TakePicture(), now_s)
            if not outcome.accepted:
                parts.events.say(now_s, TextKind.REFUSAL, "payload_refused", outcome.reason)
        elif function is AuxFunction.SAILBOAT_TACK:
            self._tack(now_s)
        elif function in _MISSION_FUNCTIONS:
            self._mission(function, now_s)

    def _tack(self, now_s: float) -> None:
        sailor = self._parts.sailor
        if sailor is None or not sailor.ask_tack():
            self._parts.events.say(now_s, TextKind.REFUSAL, "tack_refused", "No tack: the boat does not beat")

    def _motor(self, on: bool, now_s: float) -> None:
        """The motor alone while the switch is on, else where there is no wind."""
        parts = self._parts
        if parts.sailor is None or not parts.sailor.has_motor:
            parts.events.say(now_s, TextKind.REFUSAL, "motor_refused", "No motor beside the sail")
        elif (refused := parts.parameters.set("SAIL_MOTOR", BY_MOTOR_ALONE if on else WITHOUT_WIND)) is not None:
            parts.events.say(now_s, TextKind.REFUSAL, "motor_refused", f"SAIL_MOTOR: {refused.name}")

    def _mission(self, function: AuxFunction, now_s: float) -> Outcome:
        parts = self._parts
        if function is AuxFunction.SAVE_WAYPOINT:
            return self.mission_edits.save_waypoint(parts.nav, now_s)
        if function is AuxFunction.CLEAR_MISSION:
            return self.mission_edits.clear(now_s)
        return self._requests.reset_mission(now_s)
