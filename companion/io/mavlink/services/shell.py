"""The boat's shell over MAVLink: SERIAL_CONTROL with the device SHELL, as consoles of ground stations use it.

QGroundControl's MAVLink Console and MAVSDK send whole lines; MAVProxy's `nsh` sends lines and asks for more output many
times a second. They show what comes back as it is: the line again, the answer, the prompt. What the commands say stands
in `companion/supervisor/shell.py`. A line that sets a parameter is answered when the value is on the medium; the lines
behind it wait for that.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from companion.core.decision import Event, TextKind
from companion.core.storing import Ticket
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.loop import Vessel
from companion.supervisor.authority import AuthorityRequest, RequestedAction
from companion.supervisor.shell import Reply, answer
from companion.supervisor.snapshot import BoatSnapshot

PROMPT = "usv> "
DATA = 70  # bytes of one message
_SHELL = 10  # SERIAL_CONTROL_DEV
_REPLY, _RESPOND = 1, 2  # SERIAL_CONTROL_FLAG
_MOST_CLIENTS = 8
_LONGEST_LINE = 200
_MOST_WAITING = 16_000  # bytes; about two of the longest answers
_MOST_UNREAD = 4_000  # bytes, while a parameter is being stored
_IDLE_S = 600.0
_SHARE = 0.25  # of the line
_FRAME_BYTES = 81 + 14
_SAVED_S = 0.1
_EVENTS = 50
_BACK = (8, 127)


@dataclass(slots=True)
class _Session:
    """One client: the line that it writes, and the output that waits for room on its link. `listens`: whether it wants
    any. `held`: an answer that waits until what it tells is stored; meanwhile the input stays in `unread`."""

    used_s: float
    allowed_s: float
    listens: bool
    line: bytearray = field(default_factory=bytearray)
    waiting: bytearray = field(default_factory=bytearray)
    unread: bytearray = field(default_factory=bytearray)
    held: tuple[Ticket, Sequence[str]] | None = None
    allowance: float = 0.0

    def put(self, text: str) -> None:
        """Add output; what exceeds the bound is left out."""
        if not self.listens:
            return
        self.waiting += text.encode("ascii", "replace")[: max(0, _MOST_WAITING - len(self.waiting))]

    def say(self, lines: Sequence[str]) -> None:
        """Put the lines of an answer, and the prompt."""
        self.put("".join(f"{text}\n" for text in lines) + PROMPT)


class ShellService:
    """In and out: SERIAL_CONTROL. A line that sets a parameter is obeyed from who may set one.

    Remembers each client's session, and the newest events.
    """

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self._sessions: dict[Peer, _Session] = {}
        self._events: deque[Event] = deque(maxlen=_EVENTS)
        self.handles: Mapping[int, Handler] = {mavlink.MAVLINK_MSG_ID_SERIAL_CONTROL: self._on_serial_control}

    def update(self, now_s: float) -> None:
        """Note the tick's events, and send output that waits."""
        if self._vessel.last_tick is not None:
            self._events.extend(self._vessel.last_tick.events)
        for peer, session in list(self._sessions.items()):
            if peer.endpoint.gone or now_s - session.used_s > _IDLE_S * self._hub.patience:
                del self._sessions[peer]
            else:
                self._send(peer, session, now_s)

    def answer(self, now_s: float) -> None:
        """Answer lines whose parameter is stored, and go on with those behind them."""
        for peer, session in self._sessions.items():
            if session.held is not None and not session.held[0].pending:
                self._read(session, peer, now_s)
                self._send(peer, session, now_s)

    def _on_serial_control(self, message: Any, peer: Peer, now_s: float) -> None:
        """Take what a client writes. Without data and the wish for an answer, it closes its session."""
        if message.flags & _REPLY:
            return
        if message.device != _SHELL:
            self._hub.say(peer, TextKind.REFUSAL, "No such serial port: the shell alone (10)")
            return
        data = bytes(message.data[: min(message.count, DATA)])
        listens = bool(message.flags & _RESPOND)
        if not data and not listens:
            self._sessions.pop(peer, None)
            return
        session = self._session(peer, listens, now_s)
        if session is not None:
            session.unread += data[: max(0, _MOST_UNREAD - len(session.unread))]
            self._read(session, peer, now_s)
            self._send(peer, session, now_s)

    def _session(self, peer: Peer, listens: bool, now_s: float) -> _Session | None:
        """The client's session, begun where it is new; None where there are too many."""
        session = self._sessions.get(peer)
        if session is None:
            if len(self._sessions) >= _MOST_CLIENTS:
                self._hub.say(peer, TextKind.REFUSAL, "Shell refused: too many clients use it")
                return None
            session = self._sessions[peer] = _Session(now_s, now_s, listens, allowance=_burst(peer))
            session.put(f"USV companion {self._hub.version}; help lists the commands\n{PROMPT}")
        session.used_s, session.listens = now_s, listens
        return session

    # --- input -----------------------------------------------------------------------------------------------------

    def _read(self, session: _Session, peer: Peer, now_s: float) -> None:
        """Take bytes as a terminal does: a line feed ends the line, backspace deletes, other control bytes are
        ignored."""
        boat: BoatSnapshot | None = None  # one for all lines: it takes a while
        while self._may_go_on(session) and session.unread:
            byte = session.unread.pop(0)
            if byte == ord("\n"):
                boat = boat or snapshot_of(self._vessel, tuple(self._events), now_s)
                self._obey(session, boat, peer, now_s)
            elif byte in _BACK:
                del session.line[-1:]
            elif byte >= ord(" ") and len(session.line) <= _LONGEST_LINE:
                session.line.append(byte)

    def _obey(self, session: _Session, boat: BoatSnapshot, peer: Peer, now_s: float) -> None:
        """Echo a line and answer it."""
        line = session.line.decode("ascii", "replace")
        session.line.clear()
        session.put(f"{line}\n")
        if len(line) > _LONGEST_LINE:
            lines: Sequence[str] = (f"Line longer than {_LONGEST_LINE} characters",)
        elif len(session.waiting) > _MOST_WAITING // 2:
            lines = ("Too much at once: wait for the answers",)
        else:
            lines = self._carry_out(session, answer(line, boat), peer, now_s)
        if session.held is None:
            session.say(lines)

    @staticmethod
    def _may_go_on(session: _Session) -> bool:
        """Whether no answer is held any more. Says it where its ticket is settled."""
        if session.held is None:
            return True
        ticket, lines = session.held
        if ticket.pending:
            return False
        session.held = None
        session.say(lines if ticket.durable else (f"In force but not stored: {ticket.reason}",))
        return True

    def _carry_out(self, session: _Session, reply: Reply, peer: Peer, now_s: float) -> Sequence[str]:
        """Set what the reply asks to be set, and hold its answer; returns what to say of any other."""
        if reply.setting is None:
            return reply.lines
        request = AuthorityRequest(RequestedAction.PARAMETER, system=peer.system, granted=peer.endpoint.guard.granted)
        reason = self._vessel.supervisor.refusal(request, now_s)
        if reason is not None:
            return (f"Not obeyed: {reason}",)
        self._vessel.parameters.set(reply.setting.name, reply.setting.value)
        session.held = self._vessel.storage.parameters(), reply.lines
        return reply.lines

    # --- output ----------------------------------------------------------------------------------------------------

    def _send(self, peer: Peer, session: _Session, now_s: float) -> None:
        """Send as much as the link has room for."""
        elapsed_s = max(0.0, now_s - session.allowed_s)
        session.allowed_s = now_s
        session.allowance = min(_burst(peer), session.allowance + elapsed_s * _SHARE * peer.endpoint.bytes_per_s)
        while session.waiting and session.allowance >= _FRAME_BYTES and not peer.endpoint.busy:
            data = bytes(session.waiting[:DATA])
            del session.waiting[:DATA]
            session.allowance -= _FRAME_BYTES
            padded = list(data.ljust(DATA, b"\0"))
            self._hub.send(
                peer,
                mavlink.MAVLink_serial_control_message(
                    _SHELL, _REPLY, 0, 0, len(data), padded, peer.system, peer.component
                ),
            )


def _burst(peer: Peer) -> float:
    """Bytes that may be sent at once after a pause."""
    return max(2.0 * _FRAME_BYTES, _SAVED_S * _SHARE * peer.endpoint.bytes_per_s)


def snapshot_of(vessel: Vessel, events: Sequence[Event], now_s: float) -> BoatSnapshot:
    """The boat as it is now. It asks every mode, so not in every tick."""
    supervisor = vessel.supervisor
    return BoatSnapshot(
        config=vessel.config,
        parameters=vessel.parameters,
        status=supervisor.status(now_s),
        report=supervisor.arming_report(now_s),
        tick=vessel.last_tick,
        cause=supervisor.mode_cause,
        modes=supervisor.modes,
        refusals=supervisor.mode_refusals(now_s),
        sources=vessel.sources,
        events=events,
        in_control=supervisor.ground_stations.in_control,
    )
