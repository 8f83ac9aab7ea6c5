"""All ground stations on all links: receives, routes to services, sends what they answer.

A service is an object with `handles` (message id → handler) and `update(now_s)`. A handler `(message, peer, now_s)` is called only for
messages addressed to us or to everybody, and answers before it returns:

    hub.send(peer, message)             to who asked, on the endpoint where it asked
    hub.broadcast(message)              to everybody
    hub.announce(now_s, id, …)          telemetry messages to everybody now, as each endpoint's dialect has them, without waiting for their turn
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from companion.core.types import DeviceHealth, Severity, Status, Tick
from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.dialects import DEFAULT_DIALECT, Dialect
from companion.io.mavlink.endpoint import Endpoint
from companion.io.mavlink.framer import Packed, UnknownMessage, pack
from companion.io.mavlink.guard import RADIO_STATUS
from companion.io.mavlink.link_options import HIGH_LATENCY
from companion.io.mavlink.links import PEER_TIMEOUT_S, Link
from companion.io.mavlink.operators import Operators, denials
from companion.io.mavlink.router import Router
from companion.io.mavlink.signing import Signing, is_signed, unsigned
from companion.io.mavlink.statustext import statustexts, unasked_prearm_texts
from companion.io.mavlink.vessel import VesselFace

COMPONENT = 1  # MAV_COMP_ID_AUTOPILOT1: ground stations make a vehicle of no other


@dataclass(frozen=True, slots=True)
class Peer:
    """Who asked: a system and component behind an endpoint."""

    endpoint: Endpoint
    system: int
    component: int


Handler = Callable[[Any, Peer, float], None]


class Service(Protocol):
    """A part of the protocol: the messages that it handles, and what it does by itself as time passes."""

    @property
    def handles(self) -> Mapping[int, Handler]: ...

    def update(self, now_s: float) -> None: ...


@runtime_checkable
class ClosingService(Protocol):
    """A service that holds what must be given back."""

    def close(self) -> None: ...


Tap = Callable[[Sequence[bytes]], None]
Ear = Callable[[str, str, float, bytes], None]


class TelemetryFace(Protocol):
    """What is sent unasked, and at which rates."""

    def publish(self, tick: Tick) -> None: ...

    def announce(self, status: Status, now_s: float, numbers: Iterable[int]) -> None: ...

    def tell_changes(self, status: Status, now_s: float) -> None: ...

    def message(self, number: int, dialect: Dialect, now_s: float) -> Any: ...

    def interval_s(self, endpoint: Endpoint, number: int, now_s: float) -> float | None: ...

    def set_interval(self, endpoint: Endpoint, number: int, interval_s: float | None, now_s: float) -> bool: ...

    def set_high_latency(self, on: bool) -> None: ...

    def set_data_stream(self, endpoint: Endpoint, group: int, rate_hz: float, start: bool, now_s: float) -> None: ...


class _LogOutlet(Endpoint):
    """An endpoint that never answers: the log. What was sent and received is handed over packet by packet, at each flush."""

    def __init__(self, tap: Tap) -> None:
        super().__init__("log", DEFAULT_DIALECT, lambda data, now_s: len(data))
        self._tap = tap
        self._packets: list[bytes] = []

    def send_bytes(self, data: bytes) -> None:
        self._packets.append(data)

    def flush(self, now_s: float) -> None:
        if self._packets:
            packets, self._packets = self._packets, []
            self._tap(packets)


class Hub:
    """Implements `core.ports.Stations`. Remembers which systems are ground stations, and when each endpoint last heard one."""

    def __init__(
        self,
        vessel: VesselFace,
        links: Sequence[Link],
        version: str,
        *,
        telemetry: Callable[[Hub, VesselFace], TelemetryFace],
        services: Callable[[Hub], Sequence[Service]],
        tap: Tap | None = None,
        ear: Ear | None = None,
        patience: float = 1.0,
        signing: Signing | None = None,
    ) -> None:
        """`version`: of the program. `telemetry`, `services`: made on the hub (`services.connect`).

        `tap`: is given every packet, in and out, a few at a time, without signatures. `ear`: each known one that came in, before it is handled, as (dialect, endpoint,
        now_s, packet). `patience`: by what time-outs of peers, who live in wall time, are
        stretched where vessel time runs faster. `signing`: has the key, for those links that ask for signatures.
        """
        self.vessel = vessel
        self.version = version
        self.patience = patience
        self.system = int(vessel.parameters["MAV_SYS_ID"])
        self.operators = Operators(vessel.config.operators)
        self._links = tuple(links)
        self._signing = signing
        for number, link in enumerate(self._links):
            link.guard.signing, link.guard.number = signing, number
        self._router = Router((self.system, COMPONENT), patience)
        self._log = None if tap is None else _LogOutlet(tap)
        self._ear = ear
        self._stations: set[int] = set()
        self._greeted_s: weakref.WeakKeyDictionary[Endpoint, float] = weakref.WeakKeyDictionary()
        self._statustext_id = 0
        self._supervisor_version = vessel.supervisor.version
        self.telemetry = telemetry(self, vessel)
        self._services = tuple(services(self))
        self._handlers: dict[int, tuple[Handler, ...]] = {}
        for service in self._services:
            for number, handler in service.handles.items():
                self._handlers[number] = (*self._handlers.get(number, ()), handler)

    # --- Stations --------------------------------------------------------------------------------------------------

    def serve(self, now_s: float) -> None:
        """Read what came in, answer it at once."""
        for link in self._links:
            for endpoint, message in link.receive(now_s):
                self._take(endpoint, message, now_s)
            for text in link.news():
                self.vessel.events.say(now_s, Severity.WARNING, "link", text)
        self._tell_changes(now_s)
        self._flush(now_s)

    def publish(self, tick: Tick) -> None:
        """Telemetry of a tick, as far as it is due on each endpoint, and what the services do by themselves."""
        self._supervisor_version = self.vessel.supervisor.version
        self.telemetry.publish(tick)
        for service in self._services:
            service.update(tick.t_s)
        self._tell_changes(tick.t_s)
        self._flush(tick.t_s)

    def health(self, now_s: float) -> Sequence[DeviceHealth]:
        return [link.health(now_s) for link in self._links]

    def filenos(self) -> Sequence[int]:
        return [number for link in self._links for number in link.filenos()]

    def close(self) -> None:
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
        """Every remote that can be written to now."""
        for link in self._links:
            yield from link.endpoints

    @property
    def outlets(self) -> Iterator[Endpoint]:
        """The endpoints, and the log."""
        yield from self.endpoints
        if self._log is not None:
            yield self._log

    @property
    def listeners(self) -> Iterator[Endpoint]:
        """The outlets that are told what everybody should know: not those of a link that costs by the byte."""
        return (outlet for outlet in self.outlets if outlet.telemetry != HIGH_LATENCY)

    def send(self, peer: Peer, message: Any) -> None:
        """One message to who asked."""
        packed = pack(message)
        self.send_packed(peer.endpoint, packed)
        if self._log is not None:
            self.send_packed(self._log, packed)

    def broadcast(self, message: Any) -> None:
        """One message to everybody."""
        packed = pack(message)
        for outlet in self.listeners:
            self.send_packed(outlet, packed)

    def send_packed(self, outlet: Endpoint, packed: Packed) -> None:
        outlet.send(packed, self.system, COMPONENT)

    def announce(self, now_s: float, *numbers: int) -> None:
        """Telemetry messages of these ids to everybody now."""
        self.telemetry.announce(self.vessel.supervisor.status(now_s), now_s, numbers)

    def say(self, peer: Peer, severity: Severity, text: str) -> None:
        """A text for who asked; what everybody should know goes to `vessel.events`."""
        for message in self.texts(severity, text):
            self.send(peer, message)

    def texts(self, severity: Severity, text: str) -> Sequence[Any]:
        """STATUSTEXT messages of one text."""
        self._statustext_id = self._statustext_id % 0xFFFF + 1
        return statustexts(severity, text, self._statustext_id)

    # --- receiving -------------------------------------------------------------------------------------------------

    def _take(self, endpoint: Endpoint, message: Any, now_s: float) -> None:
        system, component = message.get_srcSystem(), message.get_srcComponent()
        number = message.get_msgId()  # `.id` is a field of its own in some messages
        not_for_us = isinstance(message, UnknownMessage) or (system == self.system and component == COMPONENT)
        self._write_down(endpoint, message, now_s, aloud=not not_for_us)
        self._router.take(message, endpoint, self.endpoints, now_s)
        if not_for_us or number == RADIO_STATUS:
            return
        peer = Peer(endpoint, system, component)
        if number == mavlink.MAVLINK_MSG_ID_HEARTBEAT and message.type == mavlink.MAV_TYPE_GCS:
            self._stations.add(system)
        if system in self._stations:
            self._station_heard(peer, now_s)
        self.operators.heard(system, now_s)
        handlers = self._handlers.get(number)
        if handlers is None or not self._is_ours(message) or self._denied(message, peer):
            return
        for handler in handlers:
            try:
                handler(message, peer, now_s)
            except Exception as error:  # noqa: BLE001  the boat does not stop for what a peer sent
                self.vessel.events.say(
                    now_s, Severity.ERROR, "mavlink_handler_failed", f"{message.get_type()} not handled: {type(error).__name__}: {error}"
                )

    def _write_down(self, endpoint: Endpoint, message: Any, now_s: float, aloud: bool) -> None:
        """For the log, and where `aloud` for the ear: no key, and no signature, which would let a weak passphrase be guessed."""
        if message.get_msgId() == mavlink.MAVLINK_MSG_ID_SETUP_SIGNING:
            return
        data = unsigned(bytes(message.get_msgbuf()), None if isinstance(message, UnknownMessage) else message.crc_extra)
        if is_signed(data):
            return
        if self._log is not None:
            self._log.send_bytes(data)
        if self._ear is not None and aloud:
            self._ear(endpoint.dialect.name, endpoint.name, now_s, data)

    def _is_ours(self, message: Any) -> bool:
        system = getattr(message, "target_system", getattr(message, "target", 0))  # the short name in MANUAL_CONTROL
        return system in (0, self.system) and getattr(message, "target_component", 0) in (0, COMPONENT)

    def _denied(self, message: Any, peer: Peer) -> bool:
        """A message from who may not command is answered with a refusal, and the reason."""
        remote = self.vessel.supervisor.following.remote_system == peer.system
        reason = self.operators.refusal(message, peer.system, remote)
        if reason is None:
            return False
        for answer in denials(message, peer.system, peer.component):
            self.send(peer, answer)
        if self.operators.tells(message, peer.system, reason):
            self.say(peer, Severity.WARNING, f"Not obeyed: {reason}")
        return True

    def _station_heard(self, peer: Peer, now_s: float) -> None:
        self.vessel.supervisor.station_heard(peer.system, now_s)
        if peer.endpoint.telemetry == HIGH_LATENCY:
            return
        before_s = self._greeted_s.get(peer.endpoint)
        self._greeted_s[peer.endpoint] = now_s
        if before_s is None or now_s - before_s > PEER_TIMEOUT_S * self.patience:
            self.say(peer, Severity.INFO, f"USV companion {self.version}")
            for text in unasked_prearm_texts(self.vessel.supervisor.status(now_s)):
                self.say(peer, Severity.WARNING, text)

    def _tell_changes(self, now_s: float) -> None:
        """A change of mode or arming is known to everybody before anything else happens."""
        version = self.vessel.supervisor.version
        if version != self._supervisor_version:
            self._supervisor_version = version
            self.telemetry.tell_changes(self.vessel.supervisor.status(now_s), now_s)

    def _flush(self, now_s: float) -> None:
        for outlet in self.outlets:
            outlet.flush(now_s)
