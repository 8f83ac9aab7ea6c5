"""Plans on a medium that stalls and fails: what is acknowledged is in force and stored, and what is stored in the end
is what is in force."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from companion.core.events import EventLog
from companion.core.storing import Stored, Ticket
from companion.io.mavlink.transfer.mission_service import MissionService
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.hub import Peer
from companion.io.mavlink.wire.personas import PX4
from companion.mission.plan import PlanItem, PlanKind, PlanResult, Plans
from companion.params.store import Parameters
from tests.unit.io.mavlink.slow_storage import SlowWorker

ACCEPTED = int(PlanResult.ACCEPTED)


class Medium:
    """A storage with one file for each kind of plan. As with the true writer, only the newest content waits, and one
    that failed is tried again."""

    def __init__(self) -> None:
        self.disk: dict[int, tuple[PlanItem, ...]] = dict.fromkeys(map(int, PlanKind), ())
        self._waiting: dict[int, tuple[tuple[PlanItem, ...], Ticket]] = {}

    def plan(self, kind: int, items: Sequence[PlanItem]) -> Ticket:
        waiting = self._waiting.get(kind)
        ticket = waiting[1] if waiting is not None and waiting[1].pending else Ticket()
        self._waiting[kind] = tuple(items), ticket
        return ticket

    def write(self) -> None:
        for kind, (items, ticket) in self._waiting.items():
            self.disk[kind], ticket.state = items, Stored.DURABLE
        self._waiting.clear()

    def fail(self, reached: bool) -> None:
        """`reached`: the content is there all the same, and only its sync failed."""
        for kind, (items, ticket) in self._waiting.items():
            if reached:
                self.disk[kind] = items
            ticket.reason, ticket.state = "Input/output error", Stored.FAILED


class Sea:
    """A vessel with the mission service and two ground stations that answer every request."""

    def __init__(self) -> None:
        self.plans, self.medium, self.worker, self.now_s = Plans(), Medium(), SlowWorker(), 0.0
        config = SimpleNamespace(limits=SimpleNamespace(sway_n=20.0), length_m=3.0, servos=(), relays=(), thrusters=())
        vessel: Any = SimpleNamespace(
            plans=self.plans,
            events=EventLog(),
            parameters=Parameters(),
            config=config,
            storage=self.medium,
            worker=self.worker,
            supervisor=SimpleNamespace(
                status=lambda now_s: SimpleNamespace(home=None),
                mission_edits=SimpleNamespace(under_way=False, due=lambda: None),
            ),
        )
        hub: Any = SimpleNamespace(patience=1.0, send=self._hear, announce=lambda now_s, *numbers: None)
        self.service = MissionService(hub, vessel)
        self.peers = [Peer(Endpoint(str(n), PX4, lambda data, now_s: len(data)), n, 190) for n in (254, 255)]
        self.sending: dict[Peer, list[PlanItem]] = {}
        self.answered: list[tuple[Peer, int]] = []

    def _hear(self, peer: Peer, message: Any) -> None:
        if message.get_type() == "MISSION_ACK":
            self.answered.append((peer, message.type))
            if message.type == ACCEPTED:
                assert self.plans.items(PlanKind.MISSION) == tuple(self.sending[peer]), "it is in force"
                assert self.medium.disk[0] == tuple(self.sending[peer]), "it is stored"

    def tell(self, message: Any, peer: Peer) -> None:
        self.service.handles[type(message).id](message, peer, self.now_s)

    def upload(self, peer: Peer, items: list[PlanItem]) -> None:
        """All of it at once; items that the service does not want yet are ignored."""
        self.sending[peer] = items
        self.tell(mavlink.MAVLink_mission_count_message(1, 1, len(items), 0), peer)
        for i in items:
            self.tell(
                mavlink.MAVLink_mission_item_int_message(1, 1, i.seq, 3, 16, 0, 1, 0, 0, 0, 0, i.x, i.y, 0, 0), peer
            )

    def step(self, what: str, peer: Peer, count: int, salt: int) -> None:
        match what:
            case "upload":
                self.upload(peer, [PlanItem(k, 16, 3, 0, 0, 0, 0, 1000 * salt + k, 5, 0) for k in range(count)])
            case "begin":
                self.sending[peer] = []
                self.tell(mavlink.MAVLink_mission_count_message(1, 1, count, 0), peer)
            case "cancel":
                self.tell(mavlink.MAVLink_mission_ack_message(1, 1, PlanResult.OPERATION_CANCELLED, 0), peer)
            case "clear":
                self.sending[peer] = []
                self.tell(mavlink.MAVLink_mission_clear_all_message(1, 1, 0), peer)
            case "work":
                self.worker.work()
            case "write":
                self.medium.write()
            case "fail" | "fail late":
                self.medium.fail(what == "fail late")
        self.now_s += 0.1
        self.service.update(self.now_s)


STEPS = st.tuples(
    st.sampled_from(["upload"] * 3 + ["work"] * 3 + ["write"] * 2 + ["fail", "fail late", "clear", "begin", "cancel"]),
    st.integers(0, 1),
    st.integers(1, 3),
)


@given(script=st.lists(STEPS, max_size=60))
@settings(deadline=None, derandomize=True, max_examples=300)
def test_what_is_acknowledged_is_stored_and_what_is_stored_is_in_force(script: list[tuple[str, int, int]]) -> None:
    sea = Sea()
    for salt, (what, number, count) in enumerate(script, start=1):
        sea.step(what, sea.peers[number], count, salt)
    for _ in range(4):
        sea.step("work", sea.peers[0], 0, 0)
        sea.step("write", sea.peers[0], 0, 0)
    assert sea.medium.disk[0] == sea.plans.items(PlanKind.MISSION)
    assert len(sea.answered) <= len(script)


def test_such_scripts_do_put_plans_in_force_and_do_refuse_some() -> None:
    sea = Sea()
    for salt in range(1, 4):
        for what in ("upload", "work", "fail late" if salt == 2 else "write"):
            sea.step(what, sea.peers[0], 2, salt)
    assert [result for _, result in sea.answered] == [ACCEPTED, int(PlanResult.ERROR), ACCEPTED]
