"""Who leaves a link whose slots are all taken."""

from __future__ import annotations

import pytest

from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.personas import DEFAULT_PERSONA
from companion.io.mavlink.wire.slots import IDLE_S, Slot, to_leave

TIMEOUT_S = 15.0


def slot(
    host: str, heard_s: float | None = 100.0, since_s: float = 0.0, asked_s: float | None = None, trusted: bool = False
) -> Slot:
    endpoint = Endpoint(host, DEFAULT_PERSONA, lambda data, now_s: len(data))
    endpoint.last_heard_s, endpoint.asked_s, endpoint.trusted = heard_s, asked_s, trusted
    endpoint.first_heard_s = None if heard_s is None else since_s
    return Slot(host, endpoint)


def leaver(slots: list[Slot], host: str = "new", trusted: bool = False) -> Slot | None:
    return to_leave(slots, host, trusted, 100.0, TIMEOUT_S)


@pytest.mark.parametrize("heard_s", [None, 80.0])
def test_the_silent_leave_first(heard_s: float | None) -> None:
    silent = slot("c", heard_s, asked_s=79.0)
    assert leaver([slot("a"), slot("b"), silent, slot("d")]) is silent


def test_a_crowd_from_one_address_leaves_room_for_others() -> None:
    """Sixteen ports of one computer, each with a heartbeat a second, shut nobody out."""
    crowd = [slot("crowd", since_s=99.0, asked_s=99.5) for _ in range(15)]
    station = slot("station", asked_s=50.0)
    left = leaver([station, *crowd])
    assert left in crowd
    assert leaver([station, *crowd], host="crowd") is None, "not for more of the crowd"


def test_who_asked_for_something_stays_longer_than_who_sent_heartbeats() -> None:
    idle = slot("b", since_s=100.0 - IDLE_S)
    assert leaver([slot("a", asked_s=20.0), idle, slot("c", asked_s=99.0)]) is idle
    assert leaver([slot("a", asked_s=20.0), slot("b", since_s=99.0)]) is None, "it has just come"


def test_an_operator_always_gets_room_and_keeps_it() -> None:
    old, young = slot("a", asked_s=20.0), slot("b", asked_s=99.0)
    operator = slot("c", trusted=True)
    assert leaver([operator, young, old], trusted=True) is old
    assert leaver([operator, slot("c", trusted=True)], trusted=True) is None
