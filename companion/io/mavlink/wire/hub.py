"""Serves all ground stations on all links: receives messages, gives them to services, sends the answers.

A service is an object with `handles` (message id → handler) and `update(now_s)`. A handler `(message, peer, now_s)` is
called only for messages addressed to the boat or to all. It answers before it returns, unless the answer needs the
medium or long work; then the service has an `answer(now_s)` that is called whenever such work may be done.

    hub.send(peer, message)             to the sender of the request, on its endpoint
    hub.broadcast(message)              to all
    hub.announce(now_s, id, …)          telemetry messages to all at once, in each endpoint's persona
"""

from __future__ import annotations

import sys
import weakref
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from companion.core.decision import Status, TextKind
from companion.core.tick import DeviceHealth, Tick
from companion.io.mavlink.telemetry.statustext import statustexts
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.actions import CONTROLLING, STREAMS, action_of, denials
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.exposure import exposed
from companion.io.mavlink.wire.framer import Packed, UnknownMessage, pack
from companion.io.mavlink.wire.guard import RADIO_STATUS
from companion.io.mavlink.wire.link_options import HIGH_LATENCY
from companion.io.mavlink.wire.links import PEER_TIMEOUT_S, Link
from companion.io.mavlink.wire.log_outlet import LogOutlet, Tap
from companion.io.mavlink.wire.personas import Persona
from companion.io.mavlink.wire.proof import Proof
from companion.io.mavlink.wire.repeats import AGAIN_S, Repeats
from companion.io.mavlink.wire.router import Router
from companion.io.mavlink.wire.service_kinds import AnsweringService, ClosingService
from companion.io.mavlink.wire.signing import Signing, is_signed, unsigned
from companion.io.mavlink.wire.twin import Twin
from companion.loop import Vessel
from companion.supervisor.authority import AuthorityRequest

_MOST_MESSAGES, _LEAST_SHARE = 40, 8  # handled in one call: of all links together, and of each at least
COMPONENT = 1  # MAV_COMP_ID_AUTOPILOT1: ground stations show a vehicle only for this component


@dataclass(frozen=True, slots=True)
class Peer:
    """The sender of a message: a system and component behind an endpoint."""

    endpoint: Endpoint
    system: int
    component: int


Handler = Callable[[Any, Peer, float], None]


class Service(Protocol):
    """A part of the protocol: it handles messages of some ids, and acts on its own as time passes."""

    @property
    def handles(self) -> Mapping[int, Handler]:
        """The handler of each message id that the service handles."""
        ...

    def update(self, now_s: float) -> None:
        """Do what is due by time. The hub calls it after each tick's telemetry."""
        ...


Ear = Callable[[str, str, float, bytes], None]


@dataclass(frozen=True, slots=True)
class Copies:
    """The functions that get copies of packets, for the logs. `tap` gets every packet, in and out, a few at a time,
    without signatures. `ear` gets each known incoming packet before it is handled, as (persona, endpoint, now_s,
    packet)."""

    tap: Tap | None = None
    ear: Ear | None = None


NO_COPIES = Copies()


class TelemetryFace(Protocol):
    """Sends telemetry, and keeps the rate of each message on each endpoint."""

    def publish(self, tick: Tick) -> None:
        """Send the tick's telemetry where it is due."""
        ...

    def announce(self, status: Status, now_s: float, numbers: Iterable[int]) -> None:
        """Send the messages of these ids to all endpoints now."""
        ...

    def tell_changes(self, status: Status, now_s: float) -> None:
        """Send what has changed and cannot wait for its interval."""
        ...

    def message(self, number: int, persona: Persona, now_s: float) -> Any:
        """A streamed message as it would be sent now; None if it has no content."""
        ...

    def interval_s(self, endpoint: Endpoint, number: int, now_s: float) -> float | None:
        """Interval of a message, s; NEVER if it is not streamed, None if it cannot be streamed."""
        ...

    def set_interval(self, endpoint: Endpoint, number: int, interval_s: float | None, now_s: float) -> bool:
        """Set the interval of a message; None: default. Returns False if the message cannot be streamed."""
        ...

    def set_high_latency(self, on: bool) -> None:
        """Turn the telemetry of high-latency links on or off."""
        ...

    def set_event_sequence(self, latest: int) -> None:
        """Note the number of the newest event."""
        ...

    def set_data_stream(self, endpoint: Endpoint, group: int, rate_hz: float, start: bool, now_s: float) -> None:
        """Set the rate of a MAVLink 1 data stream group, or stop it."""
        ...


class Hub:
    """Implements `core.ports.GroundStationPort`. Remembers which systems are ground stations, and when each endpoint
    last heard one."""

    def __init__(
        self,
        vessel: Vessel,
        links: Sequence[Link],
        version: str,
        *,
        telemetry: Callable[[Hub, Vessel], TelemetryFace],
        services: Callable[[Hub], Sequence[Service]],
        copies: Copies = NO_COPIES,
        patience: float = 1.0,
        signing: Signing | None = None,
    ) -> None:
        """`version` is the program's version. `telemetry` and `services` make those parts for this hub
        (`assembly.connect`). `patience` multiplies the time-outs of peers: peers live in wall time, and vessel time may
        run faster. `signing` has the key for links that require signatures."""
        self.vessel = vessel
        self.version = version
        self.patience = patience
        self.system = int(vessel.parameters["MAV_SYS_ID"])
        self._told: set[tuple[int, str]] = set()  # systems whose streams are refused, and why
        self._links = tuple(links)
        self._signing = signing
        for number, link in enumerate(self._links):
            link.guard.signing, link.guard.number = signing, number
            link.guard.operators = vessel.supervisor.ground_stations.operators
            link.guard.exposed = exposed(link.name)
            link.guard.proves = link.guard.options.proof
        self._received: tuple[deque[tuple[int, Endpoint, Any]], ...] = tuple(deque() for _ in self._links)
        share = max(_LEAST_SHARE, _MOST_MESSAGES // max(1, len(self._links)))
        self._share = sys.maxsize if vessel.waker is None else share
        self._router = Router((self.system, COMPONENT), patience)
        self._twin = Twin(patience)
        self._log = None if copies.tap is None else LogOutlet(copies.tap)
        self._ear = copies.ear
        self._stations: set[int] = set()
        self._greeted_s: weakref.WeakKeyDictionary[Endpoint, float] = weakref.WeakKeyDictionary()
        self._statustext_id = 0
        self._repeats = Repeats(AGAIN_S * patience)
        self._now_s = 0.0  # of the packet or the tick that is handled
        self._readings = 0
        self.batch = 0  # number of the reading of a link with which the message came that is handled now
        self._supervisor_version = vessel.supervisor.version
        self.modes_asked: dict[Persona, int] = {}  # the number of the mode that clients of a persona chose last
        self.telemetry = telemetry(self, vessel)
        self._services = tuple(services(self))
        self._answering = [service for service in self._services if isinstance(service, AnsweringService)]
        self._handlers: dict[int, tuple[Handler, ...]] = {}
        for service in self._services:
            for number, handler in service.handles.items():
                self._handlers[number] = (*self._handlers.get(number, ()), handler)

    # --- core.ports.GroundStationPort ---------------------------------------------------------------------------------

    def serve(self, now_s: float) -> None:
        """Read the messages that have arrived and answer them at once, as many as a tick has time for. The rest waits
        for the next call, which comes before anything else but a tick."""
        self._now_s = now_s
        for link, received in zip(self._links, self._received, strict=True):
            if not received:
                self._readings += 1
                received.extend((self._readings, endpoint, message) for endpoint, message in link.receive(now_s))
            for _ in range(min(len(received), self._share)):
                self.batch, endpoint, message = received.popleft()
                self._take(endpoint, message, now_s)
            for text in link.news():
                self.vessel.events.say(now_s, TextKind.ATTENTION, "link", text)
        if self.vessel.waker is not None and any(self._received):
            self.vessel.waker.ring()
        for service in self._answering:
            self._let(service, service.answer, now_s)
        self._tell_changes(now_s)
        self._flush(now_s)

    def publish(self, tick: Tick) -> None:
        """Send the telemetry that is due on each endpoint, then update the services."""
        self._now_s = tick.t_s
        self._supervisor_version = self.vessel.supervisor.version
        self.telemetry.publish(tick)
        for service in self._services:
            self._let(service, service.update, tick.t_s)
        self._tell_changes(tick.t_s)
        self._flush(tick.t_s)

    def _let(self, service: object, work: Callable[[float], None], now_s: float) -> None:
        """Let a service do its work. Where it fails, that is an event: what clients ask for may not stop the boat."""
        try:
            work(now_s)
        except Exception as error:  # noqa: BLE001  as of a handler
            text = f"{type(service).__name__} not served: {type(error).__name__}: {error}"
            self.vessel.events.say(now_s, TextKind.FAULT, "mavlink_service_failed", text)

    def health(self, now_s: float) -> Sequence[DeviceHealth]:
        """The health of each link."""
        return [link.health(now_s) for link in self._links]

    def filenos(self) -> Sequence[int]:
        """The descriptors of all links, to wait on."""
        return [number for link in self._links for number in link.filenos()]

    def close(self) -> None:
        """Close the services, the links and the signing store."""
        for service in self._services:
            if isinstance(service, ClosingService):
                service.close()
        for link in self._links:
            link.close()
        if self._signing is not None:
            self._signing.close()

    # --- for services ----------------------------------------------------------------------------------------------

    @property
    def endpoints(self) -> Iterator[Endpoint]:
        """Every endpoint that accepts messages now."""
        for link in self._links:
            yield from link.endpoints

    @property
    def link_names(self) -> Sequence[str]:
        """The URLs of the links."""
        return [link.name for link in self._links]

    @property
    def outlets(self) -> Iterator[Endpoint]:
        """The endpoints, and the log."""
        yield from self.endpoints
        if self._log is not None:
            yield self._log

    @property
    def listeners(self) -> Iterator[Endpoint]:
        """The outlets that get messages for all: every outlet except those of high-latency links."""
        return (outlet for outlet in self.outlets if outlet.telemetry != HIGH_LATENCY)

    def send(self, peer: Peer, message: Any) -> None:
        """Send a message to one peer, and to the log."""
        packed = pack(message)
        self.send_packed(peer.endpoint, packed)
        if self._log is not None:
            self.send_packed(self._log, packed)

    def broadcast(self, message: Any) -> None:
        """Send a message to all listeners."""
        packed = pack(message)
        for outlet in self.listeners:
            self.send_packed(outlet, packed)

    def send_packed(self, outlet: Endpoint, packed: Packed) -> None:
        """Send a packed message from the autopilot to one outlet."""
        outlet.send(packed, self.system, COMPONENT)

    def announce(self, now_s: float, *numbers: int) -> None:
        """Send the telemetry messages of these ids to all listeners now."""
        self.telemetry.announce(self.vessel.supervisor.status(now_s), now_s, numbers)

    def say(self, peer: Peer, kind: TextKind, text: str) -> None:
        """Send a STATUSTEXT to one peer, but no refusal that it has heard within 30 s. An event of the vessel sends a
        text to all."""
        if self._repeats.says(peer.endpoint, kind, text, self._now_s):
            for message in self.texts(kind, text):
                self.send(peer, message)

    def say_to_all(self, kind: TextKind, text: str) -> None:
        """Send a STATUSTEXT to all listeners, but no refusal to one that has heard it within 30 s."""
        packed = [pack(message) for message in self.texts(kind, text)]
        for outlet in self.listeners:
            if self._repeats.says(outlet, kind, text, self._now_s):
                for one in packed:
                    self.send_packed(outlet, one)

    def texts(self, kind: TextKind, text: str) -> Sequence[Any]:
        """The STATUSTEXT messages that carry a text."""
        self._statustext_id = self._statustext_id % 0xFFFF + 1
        return statustexts(kind, text, self._statustext_id)

    def control_changed(self) -> None:
        """Operator control has changed: announce once more why streams are refused."""
        self._told.clear()

    # --- receiving -------------------------------------------------------------------------------------------------

    def _take(self, endpoint: Endpoint, message: Any, now_s: float) -> None:
        system, component = message.get_srcSystem(), message.get_srcComponent()
        number = message.get_msgId()  # `.id` is a field of its own in some messages
        if endpoint.proof is not None and not endpoint.proof.proven:
            self._prove(Peer(endpoint, system, component), endpoint.proof, message, now_s)
        not_for_us = isinstance(message, UnknownMessage) or self._has_our_address(message, now_s)
        self._write_down(endpoint, message, now_s, aloud=not not_for_us)
        self._router.take(message, endpoint, self.endpoints, now_s)
        if not_for_us or number == RADIO_STATUS:
            return
        peer = Peer(endpoint, system, component)
        if number == mavlink.MAVLINK_MSG_ID_HEARTBEAT and message.type == mavlink.MAV_TYPE_GCS:
            self._stations.add(system)
        if system in self._stations:
            self._ground_station_heard(peer, now_s)
        self.vessel.supervisor.ground_stations.packet(system, now_s)
        handlers = self._handlers.get(number)
        if handlers is None or not self._is_ours(message) or self._denied(message, peer, now_s):
            return
        for handler in handlers:
            try:
                handler(message, peer, now_s)
            except Exception as error:  # noqa: BLE001  no message from a peer may stop the boat
                self.vessel.events.say(
                    now_s,
                    TextKind.FAULT,
                    "mavlink_handler_failed",
                    f"{message.get_type()} not handled: {type(error).__name__}: {error}",
                )

    def _has_our_address(self, message: Any, now_s: float) -> bool:
        """Whether the sender is this boat by its address. If it is another vehicle or a client, that is announced."""
        if (message.get_srcSystem(), message.get_srcComponent()) != (self.system, COMPONENT):
            return False
        if self._twin.take(message, now_s):
            text = f"Another vehicle has system id {self.system}: set MAV_SYS_ID"
            self.vessel.events.say(now_s, TextKind.ATTENTION, "same_system_id", text)
        elif self._is_ours(message) and self._twin.take_client(message, now_s):
            text = f"Client with our ids {self.system}/1 ignored: give it others"
            self.vessel.events.say(now_s, TextKind.ATTENTION, "same_address", text)
        return True

    def _prove(self, peer: Peer, proof: Proof, message: Any, now_s: float) -> None:
        """Limit what is sent to an address until it has shown that it receives it. The question comes first: it must
        not find the allowance used up."""
        proof.proven = peer.endpoint.trusted
        proof.take(message)
        for question in proof.questions(now_s):
            self.send(peer, question)

    def _write_down(self, endpoint: Endpoint, message: Any, now_s: float, aloud: bool) -> None:
        """Copy a packet to the log, and to the ear if `aloud`. Keys and signatures are left out, because a signature
        helps to guess a weak passphrase."""
        if message.get_msgId() == mavlink.MAVLINK_MSG_ID_SETUP_SIGNING:
            return
        data = unsigned(bytes(message.get_msgbuf()), None if isinstance(message, UnknownMessage) else message.crc_extra)
        if is_signed(data):
            return
        if self._log is not None:
            self._log.send_bytes(data)
        if self._ear is not None and aloud:
            self._ear(endpoint.persona.name, endpoint.name, now_s, data)

    def _is_ours(self, message: Any) -> bool:
        system = getattr(message, "target_system", getattr(message, "target", 0))  # the short name in MANUAL_CONTROL
        return system in (0, self.system) and getattr(message, "target_component", 0) in (0, COMPONENT)

    def _denied(self, message: Any, peer: Peer, now_s: float) -> bool:
        """Whether the sender has no authority for a message. The sender then gets a refusal."""
        if message.get_msgId() not in CONTROLLING:
            return False
        action = action_of(message)
        request = AuthorityRequest(action, system=peer.system, granted=peer.endpoint.guard.granted)
        reason = self.vessel.supervisor.refusal(request, now_s)
        if reason is None:
            return False
        for answer in denials(message, peer.system, peer.component):
            self.send(peer, answer)
        told = (peer.system, reason)
        if action not in STREAMS or told not in self._told:
            self.say(peer, TextKind.REFUSAL, f"Not obeyed: {reason}")
        if action in STREAMS:
            self._told.add(told)
        return True

    def _ground_station_heard(self, peer: Peer, now_s: float) -> None:
        self.vessel.supervisor.ground_station_heard(now_s)
        proof = peer.endpoint.proof
        if peer.endpoint.telemetry == HIGH_LATENCY or (proof is not None and not proof.proven):
            return
        before_s = self._greeted_s.get(peer.endpoint)
        self._greeted_s[peer.endpoint] = now_s
        if before_s is None or now_s - before_s > PEER_TIMEOUT_S * self.patience:
            self.say(peer, TextKind.ROUTINE, f"USV companion {self.version}")
            for text in self.vessel.storage.lost():
                self.say(peer, TextKind.ATTENTION, text)

    def _tell_changes(self, now_s: float) -> None:
        """Announce a change of mode or arming to all before anything else happens."""
        version = self.vessel.supervisor.version
        if version != self._supervisor_version:
            self._supervisor_version = version
            self.telemetry.tell_changes(self.vessel.supervisor.status(now_s), now_s)

    def _flush(self, now_s: float) -> None:
        for outlet in self.outlets:
            outlet.flush(now_s)
