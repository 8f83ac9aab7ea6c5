"""Packets received and lost, by their sequence numbers."""

from __future__ import annotations

import random

from hypothesis import given, settings
from hypothesis import strategies as st

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.framer import UnknownMessage, frame, pack
from companion.io.mavlink.wire.link_base import take_in
from companion.io.mavlink.wire.personas import PX4
from companion.io.mavlink.wire.reception import MOST_SOURCES, Reception, Receptions


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.6), st.integers(0, 255), st.integers(0, 4))
def test_what_is_not_received_is_lost_in_whatever_order_it_comes(
    seed: int, loss: float, first: int, swaps: int
) -> None:
    """Sent 400, some lost, some overtaken by a few others, some twice."""
    rng, reception = random.Random(seed), Reception()
    arrived = [n for n in range(400) if n in (0, 399) or rng.random() >= loss]
    order = sorted(arrived, key=lambda n: 0 if n == 0 else n + rng.random() * swaps if n < 390 else n + swaps)
    for n in order:
        reception.take((first + n) & 0xFF)
        if rng.random() < 0.1:
            reception.take((first + n) & 0xFF)
    assert reception.received == len(arrived)
    assert reception.lost == 400 - len(arrived)


def test_sources_are_counted_apart_and_are_not_endless() -> None:
    receptions = Receptions()
    for system in range(1, 200):
        receptions.take(system, 1, 5)
    assert receptions.of(1, 1) is None
    assert sum(receptions.of(system, 1) is not None for system in range(1, 200)) == MOST_SOURCES


def test_messages_of_unknown_ids_count_too() -> None:
    """Their numbers are of the same sequence."""
    endpoint = Endpoint("test", PX4, lambda data, now_s: len(data))
    heartbeat = pack(mavlink.MAVLink_heartbeat_message(6, 8, 192, 0, 4, 3))
    unknown = bytearray(frame(heartbeat, 1, 42, 191))
    unknown[7:10] = (54321).to_bytes(3, "little")
    out: list[tuple[Endpoint, object]] = []
    for data in (
        frame(heartbeat, 0, 42, 191),
        bytes(unknown),
        frame(heartbeat, 2, 42, 191),
        frame(heartbeat, 5, 42, 191),
    ):
        take_in(endpoint, endpoint.framer.feed(data), 0.0, out)  # type: ignore[arg-type]
    assert [type(message) is UnknownMessage for _, message in out] == [False, True, False, False]
    reception = endpoint.receptions.of(42, 191)
    assert reception is not None and (reception.received, reception.lost) == (4, 2)
