"""Several clients at once on a bad link and a slow medium: they upload missions, fences and rally points side by side,
change single items, clear, read, send nonsense, and vanish in the middle.

What must hold: a plan in force is one that a client sent whole, or the one before with single items changed, or none.
Who stays hears an end. Afterwards nothing of it is left, and the next upload is accepted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import pytest

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Peer
from companion.mission.plan import PlanItem, PlanKind, PlanResult
from tests.properties.test_mission_transfer import CLIENT_S, MAVSDK, QGROUNDCONTROL, TICK_S, Timing, Water, station
from tests.properties.test_plan_storing import Medium
from tests.remembered import remembered
from tests.unit.io.mavlink.slow_storage import SlowWorker

UNDER_WAY, ACCEPTED, TIMED_OUT = "under way", "accepted", "timed out"
GONE = ("vanished", "cancelled")
NOWHERE = 2**31 - 1  # what would be NaN in a float
COMMANDS = {PlanKind.MISSION: 16, PlanKind.FENCE: 5003, PlanKind.RALLY: 5100}
MANNERS = ("plain",) * 6 + ("twice", "ahead", "wrong first", "floats", "old form", "nan", "unknown command")
OLD_REQUESTS = (mavlink.MAVLINK_MSG_ID_MISSION_REQUEST,)
REQUESTS = (*OLD_REQUESTS, mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT)
SPOILT = ("nan", "unknown command")


def items_of(kind: PlanKind, count: int, salt: int) -> list[PlanItem]:
    radius_m = 100.0 if kind is PlanKind.FENCE else 0.0
    return [
        PlanItem(seq, COMMANDS[kind], 3, radius_m, 0, 0, 0, 634_400_000 + 100 * salt + seq, 103_989_999, 0.0)
        for seq in range(count)
    ]


@dataclass
class Upload:
    """One upload, whole or (with `first`) of some items, in a client's `manner`."""

    water: Water
    peer: Peer
    kind: PlanKind
    items: list[PlanItem]
    timing: Timing
    manner: str = "plain"
    first: int | None = None
    result: str = UNDER_WAY
    asked: int = -1
    tries: int = 0
    deadline_s: float = 0.0

    def update(self) -> None:
        if self.result != UNDER_WAY or self.water.now_s < self.deadline_s:
            return
        if self.asked >= 0 or self.tries >= self.timing.count_tries:
            self.result = TIMED_OUT
            return
        self.tries += 1
        self.deadline_s = self.water.now_s + self.timing.count_s
        if self.first is None:
            self._tell(mavlink.MAVLink_mission_count_message(1, 1, len(self.items), self.kind))
        else:
            last = self.first + len(self.items) - 1
            self._tell(mavlink.MAVLink_mission_write_partial_list_message(1, 1, self.first, last, self.kind))

    def hear(self, message: Any) -> None:
        number = message.get_msgId()
        if number == mavlink.MAVLINK_MSG_ID_MISSION_ACK and self.result == UNDER_WAY:
            self.result = ACCEPTED if message.type == PlanResult.ACCEPTED else f"refused {message.type}"
        elif number in (OLD_REQUESTS if self.manner == "old form" else REQUESTS):
            self._answer(message.seq)

    def _answer(self, seq: int) -> None:
        if self.result != UNDER_WAY or not 0 <= seq - (self.first or 0) < len(self.items):
            return
        self.asked = seq
        self.deadline_s = self.water.now_s + self.timing.silence_s
        match self.manner:
            case "twice":
                seqs = [seq, seq]
            case "ahead":
                seqs = [seq, seq + 1, seq + 2]
            case "wrong first":
                seqs = [seq + 7, seq - 1, seq]
            case _:
                seqs = [seq]
        for one in seqs:
            self._tell(self._item(one))

    def _item(self, seq: int) -> Any:
        i = self.items[(seq - (self.first or 0)) % len(self.items)]
        spoilt = seq == len(self.items) // 2
        command = 65000 if spoilt and self.manner == "unknown command" else i.command
        head = (1, 1, seq & 0xFFFF, i.frame, command, 0, 1, i.param1, 0.0, 0.0, 0.0)
        if self.manner in ("floats", "old form"):
            return mavlink.MAVLink_mission_item_message(*head, i.x * 1e-7, i.y * 1e-7, 0.0, self.kind)
        x, y = (NOWHERE, NOWHERE) if spoilt and self.manner == "nan" else (i.x, i.y)
        return mavlink.MAVLink_mission_item_int_message(*head, x, y, math.nan, self.kind)

    def _tell(self, message: Any) -> None:
        self.water.to_vessel(self.peer, message)


@dataclass
class Asking:
    """One message that is answered by MISSION_ACK: a clearing, or a count that the boat has no room for."""

    water: Water
    peer: Peer
    kind: int
    message: Any
    result: str = UNDER_WAY
    tries: int = 0
    deadline_s: float = 0.0

    def update(self) -> None:
        if self.result != UNDER_WAY or self.water.now_s < self.deadline_s:
            return
        self.tries += 1
        self.deadline_s = self.water.now_s + 1.5
        if self.tries > 7:
            self.result = TIMED_OUT
        else:
            self.water.to_vessel(self.peer, self.message)

    def hear(self, message: Any) -> None:
        if message.get_msgId() == mavlink.MAVLINK_MSG_ID_MISSION_ACK and self.result == UNDER_WAY:
            self.result = ACCEPTED if message.type == PlanResult.ACCEPTED else f"refused {message.type}"


@dataclass
class Reading:
    """A download. `whole`: what came, once it has all come."""

    water: Water
    peer: Peer
    kind: PlanKind
    result: str = UNDER_WAY
    count: int | None = None
    items: list[Any] = field(default_factory=list)
    tries: int = 0
    deadline_s: float = 0.0

    def update(self) -> None:
        if self.result != UNDER_WAY or self.water.now_s < self.deadline_s:
            return
        self.tries += 1
        self.deadline_s = self.water.now_s + (1.5 if self.count is None else 0.25)
        if self.tries > 7:
            self.result = TIMED_OUT
        elif self.count is None:
            self.water.to_vessel(self.peer, mavlink.MAVLink_mission_request_list_message(1, 1, self.kind))
        else:
            ask = mavlink.MAVLink_mission_request_int_message(1, 1, len(self.items), self.kind)
            self.water.to_vessel(self.peer, ask)

    def hear(self, message: Any) -> None:
        number = message.get_msgId()
        if number == mavlink.MAVLINK_MSG_ID_MISSION_COUNT and self.count is None:
            self.count = message.count
        elif number == mavlink.MAVLINK_MSG_ID_MISSION_ITEM_INT and message.seq == len(self.items):
            self.items.append(message)
        else:
            return
        self.tries, self.deadline_s = 0, 0.0
        if len(self.items) == self.count:
            self.result = ACCEPTED
        self.update()


Activity = Upload | Asking | Reading


@dataclass
class Station:
    """A ground station: one activity of each kind of plan at a time, as MAVProxy sends mission and fence side by
    side. `hear` and `update` are those of a client of the water."""

    peer: Peer
    under_way: dict[int, Activity] = field(default_factory=dict)
    done: list[Activity] = field(default_factory=list)
    away: bool = False
    rests_until_s: float = 0.0

    def begin(self, activity: Activity) -> None:
        self.under_way[int(activity.kind)] = activity

    def free(self, kind: int, now_s: float) -> bool:
        self._settle()
        return not self.away and kind not in self.under_way and now_s >= self.rests_until_s

    def hear(self, message: Any) -> None:
        activity = self.under_way.get(message.mission_type)
        if activity is not None and not self.away:
            activity.hear(message)

    def update(self) -> None:
        self._settle()
        for activity in self.under_way.values():
            if not self.away:
                activity.update()

    def leave(self, how: str) -> None:
        """In the middle: without a word, or after a cancellation."""
        for kind, activity in self.under_way.items():
            if activity.result == UNDER_WAY:
                activity.result = how
                if how == "cancelled":
                    ack = mavlink.MAVLink_mission_ack_message(1, 1, PlanResult.OPERATION_CANCELLED, kind)
                    activity.water.to_vessel(self.peer, ack)
        self.away = self.away or how == "vanished"

    def _settle(self) -> None:
        """After each thing it rests, longer after what was left unfinished. A late answer would seem to be that of the next thing, and if the boat
        missed the end of one upload and the beginning of the next, it would take items of the next for those of the
        first: nothing in the protocol tells them apart."""
        for kind, activity in list(self.under_way.items()):
            if activity.result != UNDER_WAY:
                self.done.append(self.under_way.pop(kind))
                rest_s = 8.0 if activity.result in (TIMED_OUT, *GONE) else 1.5
                self.rests_until_s = max(self.rests_until_s, activity.water.now_s + rest_s)


class Sea(Water):
    """As Water, with a medium and a worker that take their time and a crowd that begins something every now and then.

    `sent`: every plan that somebody began to send, by kind, as the places of its items. `changes`: of single items:
    where they begin, and their places.
    """

    def __init__(self, seed: int, loss: float) -> None:
        self.medium, self.worker = Medium(), SlowWorker()
        super().__init__(seed, loss, loss / 3, jitter_s=0.04, storage=self.medium, worker=self.worker)
        self.fails = seed % 4 == 3
        self.salt = 0
        self.left: list[Station] = []
        self.sent: dict[PlanKind, set[tuple[int, ...]]] = {kind: {()} for kind in PlanKind}
        self.changes: dict[PlanKind, list[tuple[int, tuple[int, ...]]]] = {kind: [] for kind in PlanKind}
        self.history: dict[PlanKind, list[tuple[int, ...]]] = {kind: [()] for kind in PlanKind}
        self.plans.on_change(self._in_force)
        self.stations: list[Station] = []
        self._end_s = 0.0
        for n in range(self.random.choice((2, 3, 4))):
            self._joins(station(251 + n, home_is_item_zero=n == 3))

    def _joins(self, peer: Peer) -> Station:
        one = self.clients[peer] = Station(peer)
        self.stations.append(one)
        return one

    def _comes_back(self, one: Station) -> None:
        """By the same address, or by another one after its own was forgotten."""
        if not one.peer.endpoint.gone:
            one.away = False
            return
        self.stations.remove(one)
        self.left.append(one)
        rover = one.peer.endpoint.persona.home_is_item_zero
        new = self._joins(station(one.peer.system, home_is_item_zero=rover))
        self.later(0.0, lambda: self._every(CLIENT_S, self._end_s, new.update))

    def _in_force(self, kind: PlanKind) -> None:
        items = self.plans.items(kind)
        assert [item.seq for item in items] == list(range(len(items)))
        assert all(item.command == COMMANDS[kind] for item in items)
        places = tuple(item.x for item in items)
        assert places in self.sent[kind] or places in self._changed(kind), "nobody sent this plan whole"
        self.history[kind].append(places)

    def _changed(self, kind: PlanKind) -> list[tuple[int, ...]]:
        """What single items would make of the plan in force before."""
        before = self.history[kind][-1]
        return [
            (*before[:at], *places, *before[at + len(places) :])[: len(before)] for at, places in self.changes[kind]
        ]

    def sail(self, duration_s: float, crowd_s: float = 0.0) -> None:
        """So long; `crowd_s`: for how long the crowd begins new things. Medium and worker work when it suits them."""
        self._end_s, crowded_s = self.now_s + duration_s, self.now_s + crowd_s
        self.later(0.0, lambda: self._every(TICK_S, self._end_s, lambda: self._step(self.now_s < crowded_s)))
        self.run(duration_s)

    def _step(self, crowded: bool) -> None:
        if self.random.random() < 0.3:
            self.worker.work()
        if self.random.random() < 0.3:
            if self.fails and self.random.random() < 0.2:
                self.medium.fail(self.random.random() < 0.5)
            else:
                self.medium.write()
        if crowded and self.random.random() < 0.6:
            self._something(self.random.choice(self.stations))

    def _something(self, one: Station) -> None:
        chance, kind = self.random.random(), self.random.choice(list(PlanKind))
        if chance < 0.08:
            one.leave("vanished")
            one.peer.endpoint.gone = self.random.random() < 0.7
        elif chance < 0.14:
            one.leave("cancelled")
        elif one.away:
            if chance < 0.5:
                self._comes_back(one)
        elif one.free(int(kind), self.now_s):
            one.begin(self._activity(one, kind))

    def _activity(self, one: Station, kind: PlanKind) -> Activity:
        chance, draws, timing = self.random.random(), self.random, self.random.choice((QGROUNDCONTROL, MAVSDK))
        self.salt += 1
        if chance < 0.55:
            count = draws.choice((1, 2, 3, 12, 40))
            items = items_of(kind, count, self.salt)
            shift = int(kind is PlanKind.MISSION and one.peer.endpoint.persona.home_is_item_zero)
            self.sent[kind].add(tuple(item.x for item in items[shift:]))
            return Upload(self, one.peer, kind, items, timing, draws.choice(MANNERS))
        if chance < 0.7 and not one.peer.endpoint.persona.home_is_item_zero:
            first, items = draws.randrange(5), items_of(kind, draws.choice((1, 1, 3)), self.salt)
            self.changes[kind].append((first, tuple(item.x for item in items)))
            return Upload(self, one.peer, kind, items, timing, draws.choice(("plain", "twice", "ahead")), first)
        if chance < 0.85:
            return Reading(self, one.peer, kind)
        if chance < 0.92:
            return Asking(
                self, one.peer, kind, mavlink.MAVLink_mission_count_message(1, 1, draws.choice((0, 65535)), kind)
            )
        return Asking(self, one.peer, kind, mavlink.MAVLink_mission_clear_all_message(1, 1, kind))


def check(sea: Sea, activity: Activity) -> None:
    """What a client was told is so. On a link that loses packets the answer to something earlier may have come late."""
    assert activity.result != UNDER_WAY
    if sea.loss:
        return
    assert activity.result != TIMED_OUT, activity
    if activity.result != ACCEPTED or not isinstance(activity, Upload):
        return
    shift = int(activity.kind is PlanKind.MISSION and activity.peer.endpoint.persona.home_is_item_zero)
    assert activity.manner not in SPOILT or len(activity.items) // 2 < shift, "home may be anything"
    if activity.first is None:
        assert tuple(item.x for item in activity.items[shift:]) in sea.history[activity.kind]


def ashore(sea: Sea) -> None:
    """Everybody comes to an end; afterwards nothing is left, and an upload is accepted at once."""
    done = [activity for one in (*sea.stations, *sea.left) for activity in one.done]
    assert all(one.away or not one.under_way for one in sea.stations)
    for activity in done:
        if activity.result not in GONE:
            check(sea, activity)
        if (
            isinstance(activity, Reading)
            and activity.result == ACCEPTED
            and not activity.peer.endpoint.persona.home_is_item_zero
        ):
            assert tuple(item.x for item in activity.items) in sea.history[PlanKind(activity.kind)], "of one plan"
    sea.loss, sea.fails = 0.0, False
    last = Station(station(99))
    sea.clients[last.peer] = last
    for kind in PlanKind:
        items = items_of(kind, 3, 9999)
        sea.sent[kind].add(tuple(item.x for item in items))
        last.begin(Upload(sea, last.peer, kind, items, QGROUNDCONTROL))
    sea.sail(6.0)
    assert [activity.result for activity in last.done] == [ACCEPTED] * 3
    for kind in PlanKind:
        assert sea.medium.disk[int(kind)] == sea.plans.items(kind)


# With the last two somebody else began while the whole plan of one who had left was being stored: that stopped the boat.
SEEDS = (*range(6), 126, 147)


@pytest.mark.parametrize(
    "seed", [*SEEDS, *(pytest.param(n, marks=pytest.mark.sweep) for n in range(200) if n not in SEEDS)]
)
def test_a_crowd_leaves_whole_plans_and_nothing_else(seed: int) -> None:
    sea = Sea(seed, (0.0, 0.1, 0.3)[seed % 3])
    before = remembered(sea.service)
    sea.sail(65.0, crowd_s=40.0)
    ashore(sea)
    assert remembered(sea.service) < before + 3000
