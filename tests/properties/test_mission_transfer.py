"""Plans over a link that loses, doubles and delays, with clients that keep the timings of the real ones.

What must hold whatever happens: a plan in force was uploaded in full by one client, nothing raises, and each upload
that is taken is answered once.
"""

from __future__ import annotations

import heapq
import math
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.core.decision import ACCEPTED, Home, MissionProgress, MissionState, Outcome
from companion.core.events import EventLog
from companion.core.work import AtOnce
from companion.io.mavlink.transfer.mission_service import MissionService
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Peer
from companion.io.mavlink.wire.personas import ARDUPILOT, PX4, Persona
from companion.loop import NoStorage
from companion.mission.plan import PlanItem, PlanKind, PlanResult, Plans
from companion.params.store import Parameters

TICK_S = 0.1
CLIENT_S = 0.05


def plan(count: int, salt: int = 0) -> list[PlanItem]:
    return [
        PlanItem(seq, 16, 3, 0.0, 0.0, 0.0, math.nan, 634_400_000 + 1000 * seq + salt, 103_989_999 - 777 * seq, 50.0)
        for seq in range(count)
    ]


def essence(items: Iterator[Any] | list[Any] | tuple[Any, ...]) -> tuple[tuple[int, int, int, int], ...]:
    return tuple((item.seq, item.command, item.x, item.y) for item in items)


def endpoint(home_is_item_zero: bool = False) -> Any:
    return FakeEndpoint(ARDUPILOT if home_is_item_zero else PX4)


class FakeEndpoint:
    """Stands for one network address; equal to itself alone."""

    def __init__(self, persona: Persona) -> None:
        self.persona = persona
        self.gone = self.trusted = False


class FakeSupervisor:
    """Home, and a mission item that can be set."""

    def __init__(self, plans: Plans) -> None:
        self._plans = plans
        self._seq = 0
        self.home: Home | None = Home(63.44, 10.4, 2.0)
        self.mission_edits = SimpleNamespace(under_way=False, due=lambda: None)

    def status(self, now_s: float) -> Any:
        count = len(self._plans.items(PlanKind.MISSION))
        return SimpleNamespace(home=self.home, mission=MissionProgress(MissionState.NOT_STARTED, self._seq, count))

    def set_current(self, seq: int, reset: bool, now_s: float) -> Outcome:
        self._seq = seq
        return ACCEPTED


class Water:
    """The vessel, its service, the clients, and the link between them: seeded loss, doubling and delay in each
    direction."""

    def __init__(
        self,
        seed: int = 0,
        loss: float = 0.0,
        doubling: float = 0.0,
        delay_s: float = 0.01,
        jitter_s: float = 0.0,
        storage: Any = None,
        worker: Any = None,
    ) -> None:
        self.random = random.Random(seed)
        self.loss, self.doubling, self.delay_s, self.jitter_s = loss, doubling, delay_s, jitter_s
        self.now_s = 0.0
        self.plans = Plans()
        self.put_in_force: list[tuple[PlanKind, tuple[Any, ...]]] = []
        self.plans.on_change(lambda kind: self.put_in_force.append((kind, essence(self.plans.items(kind)))))
        self.events = EventLog()
        self.supervisor = FakeSupervisor(self.plans)
        self.hub = FakeHub(self)
        config = SimpleNamespace(limits=SimpleNamespace(sway_n=20.0), length_m=3.0, servos=(), relays=(), thrusters=())
        vessel: Any = SimpleNamespace(
            plans=self.plans,
            events=self.events,
            supervisor=self.supervisor,
            config=config,
            parameters=Parameters(),
            storage=storage or NoStorage(),
            worker=worker or AtOnce(),
        )
        hub: Any = self.hub
        self.service = MissionService(hub, vessel)
        self.clients: dict[Peer, Any] = {}
        self.final_acks = 0
        self._queue: list[tuple[float, int, Callable[[], None]]] = []
        self._count = 0

    def later(self, wait_s: float, action: Callable[[], None]) -> None:
        self._count += 1
        heapq.heappush(self._queue, (self.now_s + wait_s, self._count, action))

    def carry(self, action: Callable[[], None]) -> None:
        for _ in range(2 if self.random.random() < self.doubling else 1):
            if self.random.random() >= self.loss:
                self.later(self.delay_s + self.random.random() * self.jitter_s, action)

    def to_vessel(self, peer: Peer, message: Any) -> None:
        handler = self.service.handles[message.id]
        self.carry(lambda: handler(message, peer, self.now_s))

    def to_client(self, peer: Peer, message: Any) -> None:
        assert (message.target_system, message.target_component) == (peer.system, peer.component)
        client = self.clients.get(peer)
        if client is not None:
            self.carry(lambda: client.hear(message))

    def run(self, duration_s: float) -> None:
        end_s = self.now_s + duration_s
        self.later(0.0, lambda: self._every(TICK_S, end_s, lambda: self.service.update(self.now_s)))
        for client in self.clients.values():
            self.later(0.0, lambda client=client: self._every(CLIENT_S, end_s, client.update))  # type: ignore[misc]
        while self._queue and self._queue[0][0] <= end_s:
            self.now_s, _, action = heapq.heappop(self._queue)
            action()
        self._queue.clear()
        self.now_s = end_s

    def _every(self, period_s: float, end_s: float, action: Callable[[], None]) -> None:
        action()
        if self.now_s + period_s <= end_s:
            self.later(period_s, lambda: self._every(period_s, end_s, action))


class FakeHub:
    """Unicast over the water; broadcasts go nowhere, for no transfer depends on them."""

    def __init__(self, water: Water) -> None:
        self._water = water
        self.patience = 1.0

    def send(self, peer: Peer, message: Any) -> None:
        self._water.to_client(peer, message)

    def announce(self, now_s: float, *numbers: int) -> None: ...


@dataclass
class Timing:
    """How long a client waits, and how often it tries."""

    count_s: float
    count_tries: int
    silence_s: float
    read_s: float
    read_tries: int
    same_request_limit: int = 10**9


QGROUNDCONTROL = Timing(count_s=1.5, count_tries=7, silence_s=1.5, read_s=0.25, read_tries=7)
MAVSDK = Timing(count_s=0.5, count_tries=6, silence_s=2.5, read_s=0.5, read_tries=6, same_request_limit=6)


@dataclass
class Uploader:
    """Sends a plan as the client of that timing does."""

    water: Water
    peer: Peer
    items: list[PlanItem]
    timing: Timing
    kind: PlanKind = PlanKind.MISSION
    result: str = "under way"
    acks: list[int] = field(default_factory=list)
    requested: int = -1
    same_requests: int = 0
    tries: int = 0
    deadline_s: float = 0.0

    def update(self) -> None:
        if self.result != "under way" or self.water.now_s < self.deadline_s:
            return
        if self.requested < 0 and self.tries < self.timing.count_tries:
            self.tries += 1
            self.deadline_s = self.water.now_s + self.timing.count_s
            self._tell(mavlink.MAVLink_mission_count_message(1, 1, len(self.items), self.kind))
        else:
            self.result = "timed out"

    def hear(self, message: Any) -> None:
        if isinstance(message, mavlink.MAVLink_mission_ack_message):
            self.acks.append(message.type)
            if self.result == "under way":
                self.result = "accepted" if message.type == PlanResult.ACCEPTED else f"refused {message.type}"
        elif self.result == "under way":
            assert message.mission_type == self.kind
            self.same_requests = self.same_requests + 1 if message.seq == self.requested else 0
            if self.same_requests >= self.timing.same_request_limit:
                self.result = "timed out"
                return
            self.requested = message.seq
            self.deadline_s = self.water.now_s + self.timing.silence_s
            self.send_item(message.seq)

    def send_item(self, seq: int) -> None:
        i = self.items[seq]
        head = (1, 1, i.seq, i.frame, i.command, i.current, i.autocontinue, i.param1, i.param2, i.param3, i.param4)
        self._tell(mavlink.MAVLink_mission_item_int_message(*head, i.x, i.y, i.z, self.kind))

    def cancel(self) -> None:
        self.result = "cancelled"
        self._tell(mavlink.MAVLink_mission_ack_message(1, 1, PlanResult.OPERATION_CANCELLED, self.kind))

    def _tell(self, message: Any) -> None:
        self.water.to_vessel(self.peer, message)


@dataclass
class Downloader:
    """Reads a plan as the client of that timing does."""

    water: Water
    peer: Peer
    timing: Timing
    kind: PlanKind = PlanKind.MISSION
    result: str = "under way"
    count: int | None = None
    items: list[Any] = field(default_factory=list)
    tries: int = 0
    deadline_s: float = 0.0

    def update(self) -> None:
        if self.result != "under way" or self.water.now_s < self.deadline_s:
            return
        self.tries += 1
        if self.tries > (self.timing.count_tries if self.count is None else self.timing.read_tries):
            self.result = "timed out"
        else:
            self._ask()

    def _ask(self) -> None:
        if self.count is None:
            self.deadline_s = self.water.now_s + self.timing.count_s
            self.water.to_vessel(self.peer, mavlink.MAVLink_mission_request_list_message(1, 1, self.kind))
        else:
            self.deadline_s = self.water.now_s + self.timing.read_s
            self.water.to_vessel(
                self.peer, mavlink.MAVLink_mission_request_int_message(1, 1, len(self.items), self.kind)
            )

    def hear(self, message: Any) -> None:
        if self.result != "under way":
            return
        if isinstance(message, mavlink.MAVLink_mission_count_message) and self.count is None:
            self.count = message.count
        elif isinstance(message, mavlink.MAVLink_mission_item_int_message) and message.seq == len(self.items):
            self.items.append(message)
        else:
            return
        self.tries = 1
        if len(self.items) == self.count:
            self.result = "accepted"
            self.water.to_vessel(self.peer, mavlink.MAVLink_mission_ack_message(1, 1, 0, self.kind))
        else:
            self._ask()


def station(system: int = 255, **more: Any) -> Peer:
    return Peer(endpoint(**more), system, 190)


@pytest.mark.parametrize("timing", [QGROUNDCONTROL, MAVSDK], ids=["QGroundControl", "MAVSDK"])
@pytest.mark.parametrize("loss", [0.0, 0.1, 0.2, 0.3])
def test_an_upload_under_loss_is_whole_or_not_at_all(timing: Timing, loss: float) -> None:
    accepted = 0
    for seed in range(20):
        water = Water(seed, loss, doubling=loss / 3, jitter_s=0.04)
        old, new = plan(3, salt=1), plan(25)
        water.plans.replace(PlanKind.MISSION, old)
        peer = station()
        client = water.clients[peer] = Uploader(water, peer, new, timing)
        water.run(60.0)
        in_force = essence(water.plans.items(PlanKind.MISSION))
        assert in_force in (essence(old), essence(new))
        assert client.result in ("accepted", "timed out")
        if client.result == "accepted":
            accepted += 1
            assert in_force == essence(new)
    assert (
        accepted >= {0.0: 20, 0.1: 20, 0.2: 18, 0.3: 13}[loss]
    )  # the final answer is sent again where packets were lost


@pytest.mark.parametrize("timing", [QGROUNDCONTROL, MAVSDK], ids=["QGroundControl", "MAVSDK"])
@pytest.mark.parametrize("loss", [0.0, 0.1, 0.3])
def test_a_download_under_loss_is_the_plan(timing: Timing, loss: float) -> None:
    done = 0
    for seed in range(10):
        water = Water(seed, loss, doubling=loss / 3, jitter_s=0.04)
        water.plans.replace(PlanKind.MISSION, plan(25))
        peer = station()
        client = water.clients[peer] = Downloader(water, peer, timing)
        water.run(40.0)
        assert client.result in ("accepted", "timed out")
        if client.result == "accepted":
            done += 1
            assert essence(client.items) == essence(plan(25))
    assert done >= (10 if loss < 0.3 else 5)


def test_the_first_request_again_comes_soon_enough_for_any_client() -> None:
    water = Water()
    peer = station()
    times: list[float] = []
    water.clients[peer] = SimpleNamespace(hear=lambda message: times.append(water.now_s), update=lambda: None)
    water.to_vessel(peer, mavlink.MAVLink_mission_count_message(1, 1, 3, 0))
    water.run(8.0)
    gaps = [b - a for a, b in pairwise(times)]
    assert max(gaps) < 0.65 and 0.2 < gaps[0] < 0.4
    assert 4.4 < times[-1] < 5.2  # then it gives up
    assert any(event.name == "plan_upload_lost" for event in water.events.drain())


def test_two_ground_stations_at_once() -> None:
    for seed in range(20):
        water = Water(seed, loss=0.15, jitter_s=0.03)
        first, second = station(255), station(254)
        a = water.clients[first] = Uploader(water, first, plan(12, salt=1), QGROUNDCONTROL)
        b = water.clients[second] = Uploader(water, second, plan(9, salt=2), MAVSDK)
        water.run(40.0)
        in_force = essence(water.plans.items(PlanKind.MISSION))
        assert in_force in ((), essence(a.items), essence(b.items))
        assert {f"refused {PlanResult.DENIED:d}", "timed out", "accepted"} >= {a.result, b.result}
        for client in (a, b):
            if client.result == "accepted":
                assert (PlanKind.MISSION, essence(client.items)) in water.put_in_force


def test_the_same_system_id_on_two_links_is_two_ground_stations() -> None:
    water = Water()
    first, second = station(255), station(255)
    a = water.clients[first] = Uploader(water, first, plan(200), QGROUNDCONTROL)
    water.run(0.5)
    b = water.clients[second] = Uploader(water, second, plan(5), QGROUNDCONTROL)
    water.run(20.0)
    assert (a.result, b.result) == ("accepted", f"refused {PlanResult.DENIED:d}")


def test_mission_fence_and_rally_side_by_side() -> None:
    water = Water(loss=0.1, seed=3)
    peers = [station(255) for _ in range(2)]
    mission = water.clients[peers[0]] = Uploader(water, peers[0], plan(20), MAVSDK)
    rally_items = [PlanItem(n, 5100, 3, 0, 0, 0, 0, 634_400_000 + n, 103_000_000, 0.0) for n in range(5)]
    rally = water.clients[peers[1]] = Uploader(water, peers[1], rally_items, MAVSDK, PlanKind.RALLY)
    water.run(40.0)
    assert (mission.result, rally.result) == ("accepted", "accepted")
    assert essence(water.plans.items(PlanKind.RALLY)) == essence(rally_items)


def test_a_client_that_is_killed_and_started_again() -> None:
    water = Water()
    peer = station()
    water.clients[peer] = Uploader(water, peer, plan(300), MAVSDK)
    water.run(1.0)
    again = water.clients[peer] = Uploader(water, peer, plan(7, salt=5), MAVSDK)
    water.run(5.0)
    assert again.result == "accepted" and essence(water.plans.items(PlanKind.MISSION)) == essence(again.items)
    assert len(water.put_in_force) == 1


@given(at_s=st.floats(0.0, 1.5), loss=st.sampled_from([0.0, 0.2]), seed=st.integers(0, 1000))
@settings(deadline=None, derandomize=True, max_examples=40)
def test_a_cancelled_upload_leaves_the_old_plan(at_s: float, loss: float, seed: int) -> None:
    water = Water(seed, loss)
    old = plan(2, salt=9)
    water.plans.replace(PlanKind.MISSION, old)
    peer = station()
    client = water.clients[peer] = Uploader(water, peer, plan(100), QGROUNDCONTROL)
    water.run(at_s)
    client.cancel()
    water.run(8.0)
    assert essence(water.plans.items(PlanKind.MISSION)) == essence(old)
    again = water.clients[peer] = Uploader(water, peer, plan(3), QGROUNDCONTROL)
    water.loss = 0.0
    water.run(8.0)
    assert again.result == "accepted"


# --- anything in any order -----------------------------------------------------------------------------------------

KINDS = st.sampled_from([0, 0, 0, 1, 2, 3, 255])
SEQ = st.integers(-1, 6)
NUMBER = st.sampled_from([0.0, 1.0, -1.0, 3.0, math.nan, math.inf, -math.inf, 1e38, -0.0])
WHOLE = st.sampled_from([0, 634_400_000, 103_989_999, 2**31 - 1, -(2**31), 910_000_000])
COMMAND = st.sampled_from([16, 16, 16, 177, 19, 20, 178, 5001, 5003, 5100, 9999, 0, 65535])


def u16(seq: int) -> int:
    return seq & 0xFFFF


MESSAGES = st.one_of(
    st.builds(
        lambda n, k: mavlink.MAVLink_mission_count_message(1, 1, n, k), st.sampled_from([0, 1, 2, 3, 65535]), KINDS
    ),
    st.builds(lambda q, k: mavlink.MAVLink_mission_request_int_message(1, 1, u16(q), k), SEQ, KINDS),
    st.builds(lambda q, k: mavlink.MAVLink_mission_request_message(1, 1, u16(q), k), SEQ, KINDS),
    st.builds(lambda k: mavlink.MAVLink_mission_request_list_message(1, 1, k), KINDS),
    st.builds(lambda a, b, k: mavlink.MAVLink_mission_write_partial_list_message(1, 1, a, b, k), SEQ, SEQ, KINDS),
    st.builds(lambda a, b, k: mavlink.MAVLink_mission_request_partial_list_message(1, 1, a, b, k), SEQ, SEQ, KINDS),
    st.builds(lambda k: mavlink.MAVLink_mission_clear_all_message(1, 1, k), KINDS),
    st.builds(lambda t, k: mavlink.MAVLink_mission_ack_message(1, 1, t, k), st.integers(0, 255), KINDS),
    st.builds(lambda q: mavlink.MAVLink_mission_set_current_message(1, 1, u16(q)), SEQ),
    st.builds(
        lambda q, f, c, cur, p, x, y, z, k: mavlink.MAVLink_mission_item_int_message(
            1, 1, u16(q), f, c, cur, 1, p, z, p, z, x, y, z, k
        ),
        SEQ,
        st.sampled_from([0, 3, 2, 6, 1, 200]),
        COMMAND,
        st.sampled_from([0, 1, 2]),
        NUMBER,
        WHOLE,
        WHOLE,
        NUMBER,
        KINDS,
    ),
    st.builds(
        lambda q, f, c, p, x, y, k: mavlink.MAVLink_mission_item_message(
            1, 1, u16(q), f, c, 0, 1, p, p, p, p, x, y, p, k
        ),
        SEQ,
        st.sampled_from([0, 3, 2]),
        COMMAND,
        NUMBER,
        NUMBER,
        NUMBER,
        KINDS,
    ),
)


@given(script=st.lists(st.tuples(st.integers(0, 2), MESSAGES, st.sampled_from([0.0, 0.0, 0.0, 0.3, 6.0])), max_size=60))
@settings(deadline=None, derandomize=True, max_examples=100)
def test_any_messages_in_any_order_never_raise_and_a_change_is_answered_once(
    script: list[tuple[int, Any, float]],
) -> None:
    water = Water()
    peers = [station(255), station(254), station(255, home_is_item_zero=True)]
    heard: list[tuple[Peer, Any]] = []
    water.to_client = lambda peer, message: heard.append((peer, message))  # type: ignore[method-assign]
    for number, message, wait_s in script:
        before, already = len(water.put_in_force), len(heard)
        water.service.handles[message.id](message, peers[number], water.now_s)
        if len(water.put_in_force) > before:
            ((peer, answer),) = heard[already:]
            assert peer is peers[number] and _is_final(answer)
        water.now_s += wait_s
        water.service.update(water.now_s)


@dataclass
class Scribe:
    """A client that answers or not, as a script says, and knows each list that it has begun to send."""

    peer: Peer
    salt: int
    asked: int | None = None
    sending: list[PlanItem] = field(default_factory=list)


STEPS = st.tuples(
    st.integers(0, 2),
    st.sampled_from(
        ["answer", "answer", "answer", "answer", "begin", "answer twice", "answer late", "cancel", "list", "silence"]
    ),
    st.integers(1, 5),
)


@given(script=st.lists(STEPS, min_size=20, max_size=120))
@settings(deadline=None, derandomize=True, max_examples=100)
def test_a_plan_in_force_is_one_that_one_client_sent_whole(script: list[tuple[int, str, int]]) -> None:
    water = Water()
    scribes = [Scribe(station(255), 0), Scribe(station(254), 0), Scribe(station(255, home_is_item_zero=True), 0)]
    acks: list[Any] = []

    def hear(peer: Peer, message: Any) -> None:
        scribe = next(s for s in scribes if s.peer is peer)
        if isinstance(message, mavlink.MAVLink_mission_request_int_message):
            scribe.asked = message.seq
        elif _is_final(message):
            acks.append(message)

    water.to_client = hear  # type: ignore[method-assign]
    for step, (number, what, count) in enumerate(script):
        scribe = scribes[number]
        before, taken = len(water.put_in_force), len(acks)
        if what == "begin":
            scribe.sending, scribe.asked = plan(count, salt=1 + step), None
            _hand(water, scribe, mavlink.MAVLink_mission_count_message(1, 1, count, 0))
        elif what == "cancel":
            _hand(water, scribe, mavlink.MAVLink_mission_ack_message(1, 1, PlanResult.OPERATION_CANCELLED, 0))
        elif what == "list":
            _hand(water, scribe, mavlink.MAVLink_mission_request_list_message(1, 1, 0))
        elif what == "silence":
            water.now_s += count * 0.5
            water.service.update(water.now_s)
        elif scribe.asked is not None and scribe.asked < len(scribe.sending):
            seq = max(0, scribe.asked - 1) if what == "answer late" else scribe.asked
            for _ in range(2 if what == "answer twice" else 1):
                i = scribe.sending[seq]
                _hand(
                    water,
                    scribe,
                    mavlink.MAVLink_mission_item_int_message(1, 1, seq, 3, 16, 0, 1, 0, 0, 0, 0, i.x, i.y, 0, 0),
                )
        if len(water.put_in_force) > before:
            shift = scribe.peer.endpoint.persona.first_item
            expected = tuple((i.seq - shift, i.command, i.x, i.y) for i in scribe.sending[shift:])
            assert water.put_in_force[before:] == [(PlanKind.MISSION, expected)]
            assert len(acks) - taken == (
                2 if what == "answer twice" else 1
            )  # the doubled last item has its answer doubled
        elif what == "silence":  # on a link that lost something, an answer given before may come again by itself
            assert all(any(ack is earlier for earlier in acks[:taken]) for ack in acks[taken:])
        elif len(acks) > taken:
            assert what != "begin"  # an answer without a change: the last item again, nothing else
            assert scribe.asked == len(scribe.sending) - 1 or (scribe.asked == 0 and len(scribe.sending) == 1)


def test_scripts_of_that_kind_do_complete_uploads() -> None:
    """The test above would say nothing if no upload in it ever came to its end."""
    water = Water()
    scribe = Scribe(station(), 0)
    water.to_client = lambda peer, message: setattr(scribe, "asked", getattr(message, "seq", None))  # type: ignore[method-assign]
    scribe.sending = plan(5)
    _hand(water, scribe, mavlink.MAVLink_mission_count_message(1, 1, 5, 0))
    while scribe.asked is not None:
        i = scribe.sending[scribe.asked]
        _hand(
            water,
            scribe,
            mavlink.MAVLink_mission_item_int_message(1, 1, i.seq, 3, 16, 0, 1, 0, 0, 0, 0, i.x, i.y, 0, 0),
        )
    assert water.put_in_force == [(PlanKind.MISSION, essence(scribe.sending))]


def _hand(water: Water, scribe: Scribe, message: Any) -> None:
    water.service.handles[message.id](message, scribe.peer, water.now_s)


def _is_final(message: Any) -> bool:
    return isinstance(message, mavlink.MAVLink_mission_ack_message) and message.type == PlanResult.ACCEPTED
