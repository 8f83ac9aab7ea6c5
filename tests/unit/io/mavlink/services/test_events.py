"""The numbers of events: what is kept, what is sent again, and how a client that loses half of it comes by the rest."""

from __future__ import annotations

import random
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.io.mavlink.services.events import KEPT, MOST_AT_ONCE, EventBuffer, EventService
from companion.io.mavlink.telemetry.arming_events import EventContent
from companion.io.mavlink.wire import messages as mavlink
from tests.unit.io.mavlink.conftest import Desk


def content(number: int) -> EventContent:
    return EventContent(number, 0x33, number.to_bytes(4, "little").ljust(40, b"\0"))


class Telemetry:
    def set_event_sequence(self, latest: int) -> None:
        self.latest = latest


@pytest.fixture
def service(desk: Desk) -> EventService:
    desk.hub.telemetry = Telemetry()
    made: EventService = desk.serve(EventService(desk.hub, EventBuffer()))
    return made


def ask(desk: Desk, first: int, last: int) -> list[Any]:
    desk.heard()
    desk.tell(mavlink.MAVLink_request_event_message(1, 1, first, last))
    return desk.replies()


@given(st.integers(0, 3 * KEPT), st.integers(0, 65535), st.lists(st.integers(0, 65535), max_size=20))
def test_the_newest_events_are_kept_under_their_numbers(count: int, latest: int, asked: list[int]) -> None:
    buffer = EventBuffer(latest)
    sent = {buffer.add(content(i), 1.0).sequence: i for i in range(count)}
    kept = list(sent)[-KEPT:]
    assert [buffer.get(sequence).id for sequence in kept] == [sent[sequence] for sequence in kept]
    assert (buffer.oldest == kept[0]) if kept else (buffer.oldest == (latest + 1) % 65536)
    for sequence in asked:
        assert (buffer.get(sequence) is None) == (sequence not in kept)


def test_events_go_to_those_who_may_know_them(desk: Desk, service: EventService) -> None:
    service.send([content(1), content(2)], 2.5)
    heard = desk.heard()
    assert [(to.name, message.sequence, message.id) for to, message in heard] == [
        ("qgc", 1, 1),
        ("other", 1, 1),
        ("qgc", 2, 2),
        ("other", 2, 2),
    ]
    message = heard[0][1]
    assert (message.event_time_boot_ms, message.log_levels, message.destination_system) == (2500, 0x33, 0)
    assert desk.hub.telemetry.latest == 2
    assert desk.hub.announced == [mavlink.MAVLINK_MSG_ID_CURRENT_EVENT_SEQUENCE]


def test_what_was_missed_is_sent_again_to_who_asks(desk: Desk, service: EventService) -> None:
    service.send(map(content, range(10)), 1.0)
    assert [message.sequence for message in ask(desk, 3, 5)] == [3, 4, 5]
    desk.tell(mavlink.MAVLink_request_event_message(1, 1, 7, 7), desk.peer("other"))
    ((to, event),) = desk.heard()
    assert to == desk.peer("other") and event.sequence == 7
    assert len(ask(desk, 1, 0)) == len(ask(desk, 1, 11))  # up to the first that there is not


def test_what_is_gone_is_answered_with_what_there_is(desk: Desk, service: EventService) -> None:
    (error,) = ask(desk, 4, 4)
    assert error.get_type() == "RESPONSE_EVENT_ERROR"
    assert (error.sequence, error.sequence_oldest_available, error.target_system) == (4, 1, 255)
    service.send(map(content, range(KEPT + 7)), 1.0)
    (error,) = ask(desk, 3, 5)
    assert (error.sequence, error.sequence_oldest_available) == (3, 8)
    assert len(ask(desk, 8, KEPT)) == MOST_AT_ONCE


def test_a_busy_line_is_not_filled(desk: Desk, service: EventService) -> None:
    for endpoint in desk.hub.endpoints:
        endpoint.send_bytes(bytes(60_000))
    service.send([content(1)], 1.0)
    assert desk.heard() == [] and ask(desk, 1, 1) == []


@pytest.mark.parametrize("start", [0, 65_500])
def test_half_of_everything_may_be_lost(desk: Desk, start: int) -> None:
    """A client that asks for one number at a time, as libevents does, gets every event once and in order."""
    chance = random.Random(start)
    desk.hub.telemetry = Telemetry()
    service = desk.serve(EventService(desk.hub, EventBuffer(start)))
    client = SimpleNamespace(latest=start, got=[])
    lost = lambda: chance.random() < 0.5  # noqa: E731

    def deliver() -> None:
        for to, message in desk.heard():
            mine = to in (desk.peer("qgc"), desk.peer("qgc").endpoint)
            if (
                mine
                and message.get_type() == "EVENT"
                and not lost()
                and message.sequence == (client.latest + 1) % 65536
            ):
                client.latest = message.sequence
                client.got.append(message.id)

    for number in range(100):
        service.send([content(number)], 1.0)
        deliver()
        if not lost():
            desk.tell(mavlink.MAVLink_request_event_message(1, 1, *[(client.latest + 1) % 65536] * 2))
            deliver()
    rounds = 0
    while len(client.got) < 100 and (rounds := rounds + 1) < 1000:
        desk.tell(mavlink.MAVLink_request_event_message(1, 1, *[(client.latest + 1) % 65536] * 2))
        deliver()
    assert client.got == list(range(100))
