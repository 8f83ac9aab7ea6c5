"""MAVLink's events interface: numbered events that reach every ground station, because each asks again for what it
missed.

Every event goes to all links whose clients may know the interface, since all count the same numbers. Source: MAVLink
guide, "Events Interface"; libevents, `receive.h`, for what a client does with them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from typing import Any

from companion.io.mavlink.telemetry.arming_events import EventContent
from companion.io.mavlink.telemetry.following import streamed
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.framer import pack
from companion.io.mavlink.wire.hub import Handler, Hub, Peer

KEPT = 200  # events that can be asked for again
MOST_AT_ONCE = 32  # in answer to one request; a client asks again for the rest
_NO_SUCH_EVENT = 0  # MAV_EVENT_ERROR_REASON_UNAVAILABLE
_NUMBERS = 0x10000


class EventBuffer:
    """The newest events with their numbers, which count modulo 65536. `latest`: number of the newest; the first event
    has the one after it."""

    def __init__(self, latest: int = 0) -> None:
        self.latest = latest
        self._events: deque[Any] = deque(maxlen=KEPT)

    def add(self, content: EventContent, now_s: float) -> Any:
        """The EVENT message of a new event."""
        self.latest = (self.latest + 1) % _NUMBERS
        boot_ms = int(now_s * 1000.0) & 0xFFFFFFFF
        message = mavlink.MAVLink_event_message(
            0, 0, content.id, boot_ms, self.latest, content.log_levels, list(content.arguments)
        )
        self._events.append(message)
        return message

    @property
    def oldest(self) -> int:
        """Number of the oldest event that is kept; of the next one where none is."""
        return (self.latest - len(self._events) + 1) % _NUMBERS

    def get(self, sequence: int) -> Any | None:
        """The EVENT message of that number; None where it is not kept."""
        place = (sequence - self.oldest) % _NUMBERS
        return self._events[place] if place < len(self._events) else None


class EventService:
    """`send(contents, now_s)` to all. In: REQUEST_EVENT. Out: EVENT, RESPONSE_EVENT_ERROR; the telemetry streams
    CURRENT_EVENT_SEQUENCE with the numbers from here."""

    def __init__(self, hub: Hub, buffer: EventBuffer) -> None:
        self._hub = hub
        self._buffer = buffer
        self.handles: Mapping[int, Handler] = {mavlink.MAVLINK_MSG_ID_REQUEST_EVENT: self._on_request}

    def update(self, now_s: float) -> None:
        """Nothing here takes time."""

    def send(self, contents: Iterable[EventContent], now_s: float) -> None:
        """New events. A line that is busy gets them when its client asks for them again."""
        outlets = [outlet for outlet in self._hub.outlets if takes_events(outlet)]
        for content in contents:
            packed = pack(self._buffer.add(content, now_s))
            for outlet in outlets:
                if not outlet.busy:
                    self._hub.send_packed(outlet, packed)
        self._hub.telemetry.set_event_sequence(self._buffer.latest)
        self._hub.announce(now_s, mavlink.MAVLINK_MSG_ID_CURRENT_EVENT_SEQUENCE)

    def _on_request(self, message: Any, peer: Peer, now_s: float) -> None:
        """REQUEST_EVENT: the events again, or from which one on they are kept."""
        first = message.first_sequence
        count = (message.last_sequence - first) % _NUMBERS + 1
        for sequence in ((first + i) % _NUMBERS for i in range(min(count, MOST_AT_ONCE))):
            event = self._buffer.get(sequence)
            if event is None:
                self._hub.send(
                    peer,
                    mavlink.MAVLink_response_event_error_message(
                        peer.system, peer.component, sequence, self._buffer.oldest, _NO_SUCH_EVENT
                    ),
                )
                return
            if not peer.endpoint.busy:
                self._hub.send(peer, event)


def takes_events(endpoint: Endpoint) -> bool:
    """Whether events go to that endpoint."""
    return endpoint.persona.has_events and streamed(endpoint, mavlink.MAVLINK_MSG_ID_EVENT)
