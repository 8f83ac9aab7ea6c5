"""Operator control, handed from one ground station to another. What others may do meanwhile is decided in
`companion/supervisor/authority.py`."""

from __future__ import annotations

from collections.abc import Mapping

from companion.core.decision import ACCEPTED, Outcome, Result, TextKind
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.actions import REQUEST_OPERATOR_CONTROL
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.loop import Vessel
from companion.supervisor.authority import AuthorityRequest, RequestedAction

_TAKE, _RELEASE = 1, 0


class OperatorService:
    """MAV_CMD_REQUEST_OPERATOR_CONTROL (32100): param1 1 takes control for the sender, 0 releases it; param2 1: others
    may take it over.

    In: the command, by way of `CommandService`. Out: CONTROL_STATUS to all when control changes; a refused request is
    passed on to the system in control, which may then allow it. Remembers where that system was heard last.
    """

    handles: Mapping[int, Handler] = {}

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self._in_control: Peer | None = None

    def update(self, now_s: float) -> None:
        """Control is released when the system in control is silent for COM_DL_LOSS_T."""
        ground_stations = self._vessel.supervisor.ground_stations
        silent = ground_stations.lapse_control(now_s, self._vessel.parameters["COM_DL_LOSS_T"])
        if silent:
            self._in_control = None
            self._hub.control_changed()
            self._changed(now_s, f"system {silent}, in control, is silent: any may command", TextKind.ATTENTION)

    def carry_out(self, request: CommandRequest) -> Outcome | Answer:
        """Control of the boat for one ground station, or its release.

        param1: 1 takes control, 0 releases it.
        param2: 1 lets others take it over.
        """
        action, takeover = request.whole(1), request.whole_or(2, 0)
        if action not in (_TAKE, _RELEASE) or takeover not in (0, 1):
            return denied("params 1 and 2 of command 32100 should be 0 or 1")
        supervisor, system = self._vessel.supervisor, request.peer.system
        asked = RequestedAction.TAKE_CONTROL if action == _TAKE else RequestedAction.RELEASE_CONTROL
        reason = supervisor.refusal(AuthorityRequest(asked, system=system), request.now_s)
        if reason is not None:
            if action == _TAKE and self._in_control is not None:
                self._pass_on(self._in_control, request)
            return Answer(Outcome(Result.FAILED if action == _TAKE else Result.DENIED, reason))
        stations = supervisor.ground_stations
        before = stations.in_control, stations.takeover
        if action == _TAKE:
            stations.take_control(system, bool(takeover), request.now_s)
        else:
            stations.release_control()
        self._in_control = request.peer if action == _TAKE else None
        self._hub.control_changed()
        if (stations.in_control, stations.takeover) != before:
            taken = "lets control be taken over" if takeover else "has control"
            what = "released control" if action == _RELEASE else taken
            self._changed(request.now_s, f"system {system} {what}", TextKind.ROUTINE)
        return ACCEPTED

    def _pass_on(self, in_control: Peer, request: CommandRequest) -> None:
        params = (_TAKE, request.params[1], request.params[2], request.peer.system, 0.0, 0.0, 0.0)
        self._hub.send(
            in_control,
            mavlink.MAVLink_command_long_message(
                in_control.system, in_control.component, REQUEST_OPERATOR_CONTROL, 0, *map(float, params)
            ),
        )
        self._hub.say(in_control, TextKind.ATTENTION, f"system {request.peer.system} asks for control")

    def _changed(self, now_s: float, text: str, kind: TextKind) -> None:
        self._vessel.events.say(now_s, kind, "operator_control", text)
        self._hub.announce(now_s, mavlink.MAVLINK_MSG_ID_CONTROL_STATUS)
