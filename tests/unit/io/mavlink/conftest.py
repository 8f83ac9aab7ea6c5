"""A desk to try one service at: a vessel of plain parts, a hub that keeps what is sent, and peers of each persona.

Every message goes through its bytes and back, both ways, as on a link.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from companion.core.decision import ACCEPTED, Home, MissionProgress, MissionState, Outcome, Result, TextKind
from companion.core.events import EventLog
from companion.core.work import AtOnce
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.framer import Framer, Packed, frame, pack
from companion.io.mavlink.wire.hub import Peer
from companion.io.mavlink.wire.personas import ARDUPILOT, PX4
from companion.loop import NoStorage
from companion.mission.plan import PlanKind, Plans
from companion.params.store import Parameters


def over_the_wire(packed: Packed) -> Any:
    (message,) = Framer().feed(frame(packed, 0, 1, 1))
    return message


class DeskSupervisor:
    def __init__(self, plans: Plans) -> None:
        self._plans = plans
        self.seq = 0
        self.armed = False
        self.home: Home | None = Home(63.44, 10.4, 2.5)
        self.mission_edits = SimpleNamespace(under_way=False, due=lambda: None)
        self.guided = self
        self.gone_to: list[tuple[float, float]] = []
        self.in_guided = True

    def go(self, lat_deg: float, lon_deg: float, now_s: float) -> Outcome:
        """As `Guided.go`."""
        if not self.in_guided:
            return Outcome(Result.TEMPORARILY_REJECTED, "choose Guided first")
        self.gone_to.append((lat_deg, lon_deg))
        return ACCEPTED

    def status(self, now_s: float) -> Any:
        count = len(self._plans.items(PlanKind.MISSION))
        progress = MissionProgress(MissionState.NOT_STARTED, self.seq, count)
        return SimpleNamespace(home=self.home, mission=progress, armed=self.armed)

    def set_current(self, seq: int, reset: bool, now_s: float) -> Outcome:
        if seq >= len(self._plans.items(PlanKind.MISSION)):
            return Outcome(Result.DENIED, f"there is no item {seq}")
        self.seq = seq
        return ACCEPTED


class DeskHub:
    """What services need of the hub; keeps (peer or endpoint, message)."""

    def __init__(self) -> None:
        self.endpoints: list[Endpoint] = []
        self.sent: list[tuple[Any, Any]] = []
        self.announced: list[int] = []
        self.patience = 1.0

    @property
    def outlets(self) -> list[Endpoint]:
        return self.endpoints

    listeners = outlets

    def send(self, peer: Peer, message: Any) -> None:
        self.sent.append((peer, over_the_wire(pack(message))))

    def send_packed(self, outlet: Endpoint, packed: Packed) -> None:
        self.sent.append((outlet, over_the_wire(packed)))

    def say(self, peer: Peer, kind: TextKind, text: str) -> None:
        self.send(peer, mavlink.MAVLink_statustext_message(kind.severity, text.encode()[:50]))

    def announce(self, now_s: float, *numbers: int) -> None:
        self.announced.extend(numbers)


class Desk:
    """`tell` a service something as a peer, see what was `heard` since."""

    def __init__(self) -> None:
        self.messages = mavlink
        self.hub: Any = DeskHub()
        self.plans, self.events, self.parameters = Plans(), EventLog(), Parameters()
        self.supervisor = DeskSupervisor(self.plans)
        self.limits = SimpleNamespace(sway_n=20.0)
        config = SimpleNamespace(limits=self.limits, servos=(), relays=(), length_m=3.0, thrusters=())
        self.vessel: Any = SimpleNamespace(
            plans=self.plans,
            events=self.events,
            parameters=self.parameters,
            supervisor=self.supervisor,
            config=config,
            storage=NoStorage(),
            worker=AtOnce(),
            last_tick=None,
        )
        self.now_s = 0.0
        self._service: Any = None
        self._peers: dict[str, Peer] = {}
        for name, system, persona in (("qgc", 255, PX4), ("other", 254, PX4), ("rover", 255, ARDUPILOT)):
            endpoint = Endpoint(name, persona, lambda data, now_s: len(data))
            self.hub.endpoints.append(endpoint)
            self._peers[name] = Peer(endpoint, system, 190)

    def peer(self, name: str) -> Peer:
        return self._peers[name]

    def add_peer(self, name: str, peer: Peer) -> None:
        self._peers[name] = peer

    def serve(self, service: Any) -> Any:
        self._service = service
        return service

    def tell(self, message: Any, peer: Peer | None = None) -> None:
        self._service.handles[type(message).id](over_the_wire(pack(message)), peer or self.peer("qgc"), self.now_s)

    def answer(self) -> None:
        """Let the service answer what is done beside it."""
        self._service.answer(self.now_s)

    def wait(self, duration_s: float) -> None:
        for _ in range(round(duration_s * 10)):
            self.now_s += 0.1
            self._service.update(self.now_s)

    def heard(self) -> list[tuple[Any, Any]]:
        sent, self.hub.sent = self.hub.sent, []
        return sent

    def replies(self) -> list[Any]:
        return [message for _, message in self.heard()]

    def texts(self) -> list[str]:
        return [event.text for event in self.events.drain()]


@pytest.fixture
def desk() -> Desk:
    return Desk()
