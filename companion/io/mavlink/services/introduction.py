"""Who the boat is, to clients of the ArduPilot family: the banner and the version that Mission Planner asks for when it
connects, and where the command `mode` of MAVProxy works."""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from typing import Any

from companion.core.decision import TextKind
from companion.io.mavlink.commands.messages import autopilot_version
from companion.io.mavlink.commands.request import DONE, Answer, CommandRequest
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.io.mavlink.wire.personas import ARDUPILOT, PX4
from companion.io.transport import urls
from companion.loop import Vessel

_MAVPROXY = 230  # the component by which it speaks


class IntroductionService:
    """In: AUTOPILOT_VERSION_REQUEST, HEARTBEAT, DO_SEND_BANNER. Remembers the endpoints on which MAVProxy was told
    where its command works."""

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self._told: weakref.WeakSet[Endpoint] = weakref.WeakSet()
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_HEARTBEAT: self._on_heartbeat,
            mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION_REQUEST: self._on_version_request,
        }

    def update(self, now_s: float) -> None:
        """Nothing here takes time."""

    def banner(self, request: CommandRequest) -> Answer:
        """Send the program's version and the vessel's name as texts."""
        persona = request.peer.endpoint.persona
        manner = ", modes as Rover" if persona is ARDUPILOT else ""
        texts = [f"USV companion {self._hub.version}{manner}", f"Frame: boat, {self._vessel.config.title}"]
        return Answer(DONE.outcome, [message for text in texts for message in self._hub.texts(TextKind.ROUTINE, text)])

    def _on_version_request(self, message: Any, peer: Peer, now_s: float) -> None:
        """The request from before REQUEST_MESSAGE; it has no acknowledgement."""
        version, name = self._hub.version, self._vessel.config.name
        self._hub.send(peer, autopilot_version(version, name, peer.endpoint.persona))

    def _on_heartbeat(self, message: Any, peer: Peer, now_s: float) -> None:
        """MAVProxy's command `mode` fails with every vehicle of PX4 ("required argument is not a float", 1.8.75)."""
        if peer.component != _MAVPROXY or peer.endpoint.persona is not PX4 or peer.endpoint in self._told:
            return
        self._told.add(peer.endpoint)
        place = place_to_connect(self._hub.link_names)
        remedy = "needs ?dialect=ardupilot" if place is None else f"works on {place}"
        self._hub.say(peer, TextKind.ATTENTION, f"MAVProxy's mode command {remedy}")


def place_to_connect(link_names: Sequence[str]) -> str | None:
    """Where a client finds the ardupilot persona, as "TCP port 5762"; None where no link with it waits for clients."""
    for name in link_names:
        try:
            link = urls.parse_url(name)
        except urls.TransportError:
            continue
        if link.options.get("dialect") == ARDUPILOT.name and link.scheme in ("tcpin", "udpin"):
            return f"{link.scheme[:3].upper()} port {link.port}"
    return None
