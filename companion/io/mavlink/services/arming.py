"""Why the boat cannot be armed, told to each ground station in the form that it knows.

One that uses the events interface gets the arming checks as a list with remedies. All others get texts, "PreArm: …",
every 30 s. A ground station shows that it uses events by asking for the metadata of the component and then, once it has
loaded that of the events, for the checks (MAV_CMD_RUN_PREARM_CHECKS): so do QGroundControl and MAVSDK, also when they
know the files from an earlier connection. QGroundControl hides the texts by itself from then on.
"""

from __future__ import annotations

import weakref
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from companion.core.decision import Outcome, TextKind
from companion.io.mavlink.commands.request import DONE, Answer, CommandRequest, not_now
from companion.io.mavlink.services.events import EventService, takes_events
from companion.io.mavlink.telemetry.arming_events import ArmingEvents, EventContent
from companion.io.mavlink.telemetry.statustext import SETTLING_S, prearm_texts, unasked_prearm_texts
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.framer import pack
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.io.mavlink.wire.links import PEER_TIMEOUT_S
from companion.io.mavlink.wire.personas import PX4
from companion.loop import Vessel

PREARM_PERIOD_S = 30.0  # QGroundControl shows each text for 35 s
FIRST_TEXT_S = 5.0  # for a ground station to ask for metadata before it gets texts
_LOOK_S = 0.5
_REPORT_S = 1.0  # at least, between two reports


@dataclass(slots=True)
class _Client:
    """One ground station on one endpoint."""

    heard_s: float
    asked_metadata: bool = False
    uses_events: bool = False


@dataclass(slots=True)
class _Listener:
    """One endpoint: when texts are due on it, and who is behind it."""

    due_s: float
    clients: dict[tuple[int, int], _Client] = field(default_factory=dict)


class ArmingService:
    """In: HEARTBEAT of ground stations, their requests for metadata and checks. Out: reports of the arming checks by
    events, and STATUSTEXT.

    Remembers the last report, and who on each endpoint uses events.
    """

    def __init__(self, hub: Hub, vessel: Vessel, events: EventService, described: ArmingEvents) -> None:
        """`described`: with the names that the metadata has."""
        self._hub = hub
        self._vessel = vessel
        self._events = events
        self._described = described
        self._listeners: weakref.WeakKeyDictionary[Endpoint, _Listener] = weakref.WeakKeyDictionary()
        self._sent: tuple[EventContent, ...] = ()
        self._sent_s: float | None = None
        self._looked_s: float | None = None
        self._asked = False
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_HEARTBEAT: self._on_heartbeat,
            mavlink.MAVLINK_MSG_ID_COMMAND_LONG: self._on_command,
            mavlink.MAVLINK_MSG_ID_COMMAND_INT: self._on_command,
        }

    def update(self, now_s: float) -> None:
        """Send what is due."""
        self._report(now_s)
        self._tell_refusal(now_s)
        self._send_texts(now_s)

    def run_checks(self, request: CommandRequest) -> Outcome | Answer:
        """Send every reason for which the boat would refuse to arm: as events to a ground station that uses them, else
        as `PreArm: …` texts."""
        client = self._listener(request.peer.endpoint, request.now_s).clients.get(_key(request.peer))
        if client is not None and client.asked_metadata and takes_events(request.peer.endpoint):
            client.uses_events = self._asked = True
            return DONE
        status = self._vessel.supervisor.status(request.now_s)
        if status.armed:
            return not_now("armed already")
        texts = [self._hub.texts(TextKind.ATTENTION, text) for text in prearm_texts(status)]
        return Answer(DONE.outcome, [message for messages in texts for message in messages])

    # --- events ----------------------------------------------------------------------------------------------------

    def _report(self, now_s: float) -> None:
        """Send the report if it was asked for or has changed, at most once a second."""
        looked = self._looked_s is not None and now_s - self._looked_s < _LOOK_S
        if (not self._asked and (looked or now_s < SETTLING_S)) or self._too_soon(now_s):
            return
        self._looked_s = now_s
        contents = self._described.report(self._vessel.supervisor.arming_report(now_s))
        if self._asked or contents != self._sent:
            self._asked = False
            self._sent, self._sent_s = contents, now_s
            self._events.send(contents, now_s)

    def _too_soon(self, now_s: float) -> bool:
        return self._sent_s is not None and now_s - self._sent_s < _REPORT_S

    def _tell_refusal(self, now_s: float) -> None:
        """Arming was refused in this tick: QGroundControl, which hides the texts, shows this event with the list."""
        tick = self._vessel.last_tick
        if tick is not None and any(event.name == "arming_refused" for event in tick.events):
            self._events.send([self._described.not_armed(PX4.custom_mode(tick.status.mode))], now_s)

    # --- texts -----------------------------------------------------------------------------------------------------

    def _send_texts(self, now_s: float) -> None:
        """Texts to each endpoint where they are due, unless all who are there use events."""
        due: list[tuple[Endpoint, _Listener]] = []
        for outlet in self._hub.listeners:
            listener = self._listener(outlet, now_s)
            silent = [key for key, client in listener.clients.items() if now_s - client.heard_s > self._forget_s]
            for key in silent:
                del listener.clients[key]
            if now_s >= listener.due_s and not _all_use_events(listener):
                due.append((outlet, listener))
        supervisor = self._vessel.supervisor
        texts = unasked_prearm_texts(supervisor.status(now_s)) if due and not supervisor.armed else ()
        if texts:
            for outlet, listener in due:
                listener.due_s = now_s + PREARM_PERIOD_S
                for text in texts:
                    for message in self._hub.texts(TextKind.ATTENTION, text):
                        self._hub.send_packed(outlet, pack(message))

    # --- who is there ----------------------------------------------------------------------------------------------

    @property
    def _forget_s(self) -> float:
        return PEER_TIMEOUT_S * self._hub.patience

    def _listener(self, endpoint: Endpoint, now_s: float) -> _Listener:
        listener = self._listeners.get(endpoint)
        if listener is None:
            listener = self._listeners[endpoint] = _Listener(self._first_text_s(endpoint, now_s))
        return listener

    def _first_text_s(self, endpoint: Endpoint, now_s: float) -> float:
        """When somebody new there gets texts."""
        return now_s + (FIRST_TEXT_S * self._hub.patience if takes_events(endpoint) else 0.0)

    def _on_heartbeat(self, message: Any, peer: Peer, now_s: float) -> None:
        listener = self._listener(peer.endpoint, now_s)
        client = listener.clients.get(_key(peer))
        if client is not None and now_s - client.heard_s <= self._forget_s:
            client.heard_s = now_s
        elif message.type == mavlink.MAV_TYPE_GCS:
            listener.clients[_key(peer)] = _Client(now_s)
            listener.due_s = self._first_text_s(peer.endpoint, now_s)

    def _on_command(self, message: Any, peer: Peer, now_s: float) -> None:
        """A request for the metadata: texts wait until it has had time to load them."""
        asks = message.command == mavlink.MAV_CMD_REQUEST_MESSAGE
        if asks and message.param1 == mavlink.MAVLINK_MSG_ID_COMPONENT_METADATA:
            listener = self._listener(peer.endpoint, now_s)
            client = listener.clients.setdefault(_key(peer), _Client(now_s))
            client.asked_metadata = True
            listener.due_s = max(listener.due_s, now_s + PREARM_PERIOD_S * self._hub.patience)


def _key(peer: Peer) -> tuple[int, int]:
    return peer.system, peer.component


def _all_use_events(listener: _Listener) -> bool:
    return bool(listener.clients) and all(client.uses_events for client in listener.clients.values())
