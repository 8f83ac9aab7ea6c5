"""Control of the vessel, handed from one ground station to another. What others may do meanwhile stands in `operators.py`."""

from __future__ import annotations

from collections.abc import Mapping

from companion.core.types import Outcome, Severity
from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.command_request import Answer, Request, denied
from companion.io.mavlink.hub import Handler, Hub, Peer
from companion.io.mavlink.operators import REQUEST_OPERATOR_CONTROL
from companion.io.mavlink.vessel import VesselFace

_TAKE, _RELEASE = 1, 0


class OperatorService:
    """MAV_CMD_REQUEST_OPERATOR_CONTROL (32100): param1 1 asks for control, 0 gives it back; param2 1: others may take it over. Always in the sender's own name.

    In: the command, by way of `CommandService`. Out: CONTROL_STATUS to all when it changes; the request itself to who has control, who may then allow
    it. Remembers where who has control was heard last.
    """

    handles: Mapping[int, Handler] = {}

    def __init__(self, hub: Hub, vessel: VesselFace) -> None:
        self._hub = hub
        self._vessel = vessel
        self._holder: Peer | None = None

    def update(self, now_s: float) -> None:
        """Control goes back to all when who has it is silent for as long as a lost ground station."""
        silent = self._hub.operators.lapsed(now_s, self._vessel.parameters["COM_DL_LOSS_T"])
        if silent:
            self._holder = None
            self._changed(now_s, f"system {silent}, in control, is silent: any may command", Severity.WARNING)

    def carry_out(self, request: Request) -> Outcome | Answer:
        action, takeover = request.whole(1), request.whole_or(2, 0)
        if action not in (_TAKE, _RELEASE) or takeover not in (0, 1):
            return denied("param 1 of command 32100 should be 0 or 1, param 2 too")
        operators, peer = self._hub.operators, request.peer
        before = operators.in_control, operators.takeover
        outcome = operators.request(peer.system, bool(takeover), request.now_s) if action == _TAKE else operators.release(peer.system)
        if not outcome.accepted:
            if action == _TAKE and self._holder is not None:
                self._ask(self._holder, request)
            return Answer(outcome)
        self._holder = peer if action == _TAKE else None
        if (operators.in_control, operators.takeover) != before:
            what = "released control" if action == _RELEASE else "lets control be taken over" if takeover else "has control"
            self._changed(request.now_s, f"system {peer.system} {what}", Severity.NOTICE)
        return outcome

    def _ask(self, holder: Peer, request: Request) -> None:
        params = (_TAKE, request.params[1], request.params[2], request.peer.system, 0.0, 0.0, 0.0)
        self._hub.send(
            holder, mavlink.MAVLink_command_long_message(holder.system, holder.component, REQUEST_OPERATOR_CONTROL, 0, *map(float, params))
        )
        self._hub.say(holder, Severity.NOTICE, f"system {request.peer.system} asks for control")

    def _changed(self, now_s: float, text: str, severity: Severity) -> None:
        self._vessel.events.say(now_s, severity, "operator_control", text)
        self._hub.announce(now_s, mavlink.MAVLINK_MSG_ID_CONTROL_STATUS)
