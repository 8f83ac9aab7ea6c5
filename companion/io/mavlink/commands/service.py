"""The command protocol: every command gets an acknowledgement, sent to who asked.

It comes at once, except for a command that changes what is stored: that one is acknowledged when it is on the medium.
Meanwhile a client that asks again, or that has waited for a while, is told that the command is in progress.

What a command does stands in `command_vessel.py` (arming, modes, go-to, mission, home, …) and `command_messages.py`
(requests for messages and their rates). Source: MAVLink guide, "Command Protocol".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from companion.core.decision import Outcome, Result, TextKind
from companion.core.storing import Ticket
from companion.io.mavlink.commands.messages import MessageCommands
from companion.io.mavlink.commands.request import UNSUPPORTED, Answer, CommandHandler, CommandRequest
from companion.io.mavlink.commands.vessel import ONCE, VesselCommands
from companion.io.mavlink.transfer.component_metadata import Descriptions
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.actions import READING
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.loop import Vessel

PATIENCE_S = 0.3  # after which, and then again and again, a client is told that its command is in progress
REPEAT_S = 2.0  # MAVSDK sends a command up to 4 times, 0.5 s apart, with nothing to tell them apart
_MOST_PEERS = 64
_MOST_ANSWERED = 1_000
_MOST_UNSTORED = 64
_IN_PROGRESS = Outcome(Result.IN_PROGRESS)
_NOT_STORED_YET = Answer(Outcome(Result.FAILED, "In force but not stored yet: the medium is too slow"))


@dataclass(slots=True)
class _Last:
    """The command that a peer sent last, other than to read, when it was answered, and the version then."""

    key: bytes
    outcome: Outcome
    at_s: float
    version: int


@dataclass(slots=True)
class _Unstored:
    """A command that is done but not stored yet, its answer, and when its peer is told so next."""

    request: CommandRequest
    answer: Answer
    ticket: Ticket
    tell_s: float


class CommandService:
    """In: COMMAND_LONG, COMMAND_INT, SET_MODE. Out: COMMAND_ACK and what was asked for.

    Remembers each peer's last command, but for those that only read: a repetition of one that must not be done twice is
    only acknowledged again.
    Remembers too the commands that are to be acknowledged when they are stored.
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
        self._unstored: list[_Unstored] = []
        self._answered: dict[tuple[Peer, bytes], int] = {}  # the batch in which that command came last
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_COMMAND_LONG: self._on_long,
            mavlink.MAVLINK_MSG_ID_COMMAND_INT: self._on_int,
            mavlink.MAVLINK_MSG_ID_SET_MODE: self._on_set_mode,
        }

    def update(self, now_s: float) -> None:
        """Acknowledge what is stored; tell clients that wait long."""
        self.answer(now_s)
        for one in self._unstored:
            if now_s >= one.tell_s:
                one.tell_s = now_s + PATIENCE_S * self._hub.patience
                self._acknowledge(one.request, _IN_PROGRESS)

    def answer(self, now_s: float) -> None:
        """Acknowledge commands that are stored, or refuse those that could not be."""
        for one in [one for one in self._unstored if not one.ticket.pending]:
            self._unstored.remove(one)
            self._settle(one, now_s)

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
        key, batch = (request.peer, request.key), self._hub.batch
        known = self._answered.pop(key, None) == batch
        self._answered[key] = batch
        if len(self._answered) > _MOST_ANSWERED:
            del self._answered[next(iter(self._answered))]
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
        if isinstance(result, Outcome):
            self._conclude(request, Answer(result), request.now_s, tell=False)
        elif result.outcome.accepted and (ticket := self._ticket_of(result)) is not None:
            self._wait(_Unstored(request, result, ticket, request.now_s + PATIENCE_S * self._hub.patience))
        elif not result.later:
            self._conclude(request, result, request.now_s)

    def _ticket_of(self, answer: Answer) -> Ticket | None:
        return self._hub.vessel.storage.parameters() if answer.sets_parameters else answer.stored

    def _conclude(self, request: CommandRequest, answer: Answer, now_s: float, tell: bool = True) -> None:
        self._remember(request, answer.outcome, now_s)
        self._acknowledge(request, answer.outcome)
        if tell:
            self._tell(answer, request.peer)

    def _wait(self, one: _Unstored) -> None:
        """Answer when it is stored: now, or in one of the next updates. Of too many, the oldest are answered now."""
        now_s = one.request.now_s
        if not one.ticket.pending:
            self._settle(one, now_s)
            return
        self._unstored.append(one)
        if len(self._unstored) > _MOST_UNSTORED:
            self._conclude(self._unstored.pop(0).request, _NOT_STORED_YET, now_s)

    def _settle(self, one: _Unstored, now_s: float) -> None:
        """The ticket of a command is settled: answer it."""
        failed = Answer(Outcome(Result.FAILED, f"{one.answer.unstored}: {one.ticket.reason}"))
        self._conclude(one.request, one.answer if one.ticket.durable else failed, now_s)

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
        """What became of this command a moment ago, where doing it again would do something else; in progress while it
        is being stored."""
        if any(one.request.peer == request.peer and one.request.key == request.key for one in self._unstored):
            return _IN_PROGRESS
        last = self._last.get(request.peer)
        if request.command not in ONCE or last is None or last.key != request.key:
            return None
        overtaken = request.now_s - last.at_s > REPEAT_S or last.version != self._supervisor.version
        return None if overtaken or not last.outcome.accepted else last.outcome

    def _remember(self, request: CommandRequest, outcome: Outcome, now_s: float) -> None:
        if request.command in READING:
            return
        if len(self._last) >= _MOST_PEERS and request.peer not in self._last:
            self._last.pop(next(iter(self._last)))
        self._last[request.peer] = _Last(request.key, outcome, now_s, self._supervisor.version)

    def _on_set_mode(self, message: Any, peer: Peer, now_s: float) -> None:
        """SET_MODE (#11): no acknowledgement exists, so a refusal is said. Its armed bit means nothing."""
        if not message.base_mode & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
            self._hub.say(peer, TextKind.REFUSAL, "mode not changed: it has no number")
            return
        result = self._vessel.set_mode(message.custom_mode, peer, now_s)
        if isinstance(result, Answer):
            self._tell(result, peer)
