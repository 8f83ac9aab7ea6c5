"""The command protocol: every command gets exactly one acknowledgement, at once, sent to who asked.

What a command does stands in `command_vessel.py` (arming, modes, go-to, mission, home, …) and `command_messages.py`
(requests for messages and their rates). Source: MAVLink guide, "Command Protocol".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from companion.core.decision import Outcome, TextKind
from companion.io.mavlink.commands.messages import MessageCommands
from companion.io.mavlink.commands.request import UNSUPPORTED, Answer, CommandHandler, CommandRequest
from companion.io.mavlink.commands.vessel import ONCE, VesselCommands
from companion.io.mavlink.transfer.component_metadata import Descriptions
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.loop import Vessel

REPEAT_S = 2.0  # MAVSDK sends a command up to 4 times, 0.5 s apart, with nothing to tell them apart
_MOST_PEERS = 64


@dataclass(slots=True)
class _Last:
    """The command that a peer sent last, and the supervisor's version after it."""

    key: bytes
    outcome: Outcome
    at_s: float
    version: int


class CommandService:
    """In: COMMAND_LONG, COMMAND_INT, SET_MODE. Out: COMMAND_ACK and what was asked for.

    Remembers each peer's last command: a repetition of one that must not be done twice is only acknowledged again.
    """

    def __init__(
        self, hub: Hub, vessel: Vessel, described: Descriptions, more: Mapping[int, CommandHandler] | None = None
    ) -> None:
        """`described`: the files that say what parameters and events are; `more`: commands of other services."""
        self._hub = hub
        self._supervisor = vessel.supervisor
        self._vessel = VesselCommands(hub, vessel)
        self._commands: Mapping[int, CommandHandler] = {
            **self._vessel.commands,
            **MessageCommands(hub, vessel, described).commands,
            **(more or {}),
        }
        self._last: dict[Peer, _Last] = {}
        self._batch = -1
        self._answered: set[tuple[Peer, bytes]] = set()  # in this batch
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_COMMAND_LONG: self._on_long,
            mavlink.MAVLINK_MSG_ID_COMMAND_INT: self._on_int,
            mavlink.MAVLINK_MSG_ID_SET_MODE: self._on_set_mode,
        }

    def update(self, now_s: float) -> None:
        """Nothing here takes time."""

    def _on_long(self, message: Any, peer: Peer, now_s: float) -> None:
        m = message
        params = (m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7)
        self._carry_out(
            CommandRequest(m.command, params, None, peer, now_s, m.confirmation), broadcast=m.target_system == 0
        )

    def _on_int(self, message: Any, peer: Peer, now_s: float) -> None:
        m = message
        params = (m.param1, m.param2, m.param3, m.param4, float(m.x), float(m.y), m.z)
        self._carry_out(CommandRequest(m.command, params, m.frame, peer, now_s), broadcast=m.target_system == 0)

    def _is_repeat(self, request: CommandRequest) -> bool:
        """Whether the same command of the same sender came just before it, in the same batch.

        A sender that has waited too long repeats its command, and the boat then finds both. It gets one answer: MAVSDK
        would take the second for the answer to its next command, or log "Received ack for not-existing command".
        """
        if self._batch != self._hub.batch:
            self._batch = self._hub.batch
            self._answered.clear()
        key = (request.peer, request.key)
        known = key in self._answered
        self._answered.add(key)
        return known

    def _carry_out(self, request: CommandRequest, broadcast: bool) -> None:
        if self._is_repeat(request):
            return
        handler = self._commands.get(request.command)
        if handler is None:
            if not broadcast:  # who speaks to everybody does not want to hear it from everybody
                self._acknowledge(request, UNSUPPORTED.outcome)
            return
        repeated = self._repeated(request)
        if repeated is not None:
            self._acknowledge(request, repeated)
            return
        result = handler(request)
        if isinstance(result, Answer) and result.later:
            return
        outcome = result.outcome if isinstance(result, Answer) else result
        self._remember(request, outcome)
        self._acknowledge(request, outcome)
        if isinstance(result, Answer):
            self._tell(result, request.peer)

    def _tell(self, answer: Answer, peer: Peer) -> None:
        for message in answer.messages:
            self._hub.send(peer, message)
        if answer.outcome.reason:
            self._hub.say(peer, answer.kind, answer.outcome.reason)

    def _acknowledge(self, request: CommandRequest, outcome: Outcome) -> None:
        peer = request.peer
        self._hub.send(
            peer,
            mavlink.MAVLink_command_ack_message(
                request.command, outcome.result.value, target_system=peer.system, target_component=peer.component
            ),
        )

    def _repeated(self, request: CommandRequest) -> Outcome | None:
        """What became of this command a moment ago, where doing it again would do something else."""
        last = self._last.get(request.peer)
        if request.command not in ONCE or last is None or last.key != request.key:
            return None
        overtaken = request.now_s - last.at_s > REPEAT_S or last.version != self._supervisor.version
        return None if overtaken or not last.outcome.accepted else last.outcome

    def _remember(self, request: CommandRequest, outcome: Outcome) -> None:
        if len(self._last) >= _MOST_PEERS and request.peer not in self._last:
            self._last.pop(next(iter(self._last)))
        self._last[request.peer] = _Last(request.key, outcome, request.now_s, self._supervisor.version)

    def _on_set_mode(self, message: Any, peer: Peer, now_s: float) -> None:
        """SET_MODE (#11): no acknowledgement exists, so a refusal is said. Its armed bit means nothing."""
        if not message.base_mode & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
            self._hub.say(peer, TextKind.REFUSAL, "mode not changed: it has no number")
            return
        result = self._vessel.set_mode(message.custom_mode, peer, now_s)
        if isinstance(result, Answer):
            self._tell(result, peer)
