"""A radio whose air carries less than its serial port: by its reports the line keeps to what it passes on."""

from __future__ import annotations

import pytest

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import FAST_BYTES_PER_S, Endpoint
from companion.io.mavlink.wire.framer import frame, pack
from companion.io.mavlink.wire.links import MemoryLink
from companion.io.mavlink.wire.personas import PX4
from companion.io.mavlink.wire.radio_flow import RadioFlow

LINE = 5760.0
PACKET = pack(mavlink.MAVLink_heartbeat_message(11, 12, 1, 0, 3, 3))


def report(flow: RadioFlow, free_percent: int, count: int, begin_s: float = 0.0) -> float:
    now_s = begin_s
    for i in range(count):
        now_s = begin_s + 0.5 * i
        flow.take(free_percent, now_s)
    return now_s


def test_a_full_buffer_slows_down_and_an_empty_one_speeds_up() -> None:
    flow = RadioFlow(0.05)
    assert flow.share(0.0) == 1.0 and not flow.reports
    now_s = report(flow, 10, 4)
    assert flow.share(now_s) == pytest.approx(0.75**4) and flow.reports
    now_s = report(flow, 40, 4, now_s + 0.5)
    assert flow.share(now_s) == pytest.approx(0.75**4 * 0.975**4)
    before = flow.share(now_s)
    now_s = report(flow, 70, 1, now_s + 0.5)
    assert flow.share(now_s) == pytest.approx(before * 1.025)
    now_s = report(flow, 99, 30, now_s + 0.5)
    assert flow.share(now_s) == 1.0


def test_a_buffer_about_to_overflow_halves_the_rate() -> None:
    flow = RadioFlow(0.01)
    assert flow.share(report(flow, 5, 5)) == pytest.approx(0.5**5)


def test_it_never_falls_below_its_least() -> None:
    flow = RadioFlow(0.05)
    assert flow.share(report(flow, 0, 60)) == pytest.approx(0.05)
    assert RadioFlow(3.0).share(0.0) == 1.0, "a line that is that slow by itself"


def test_reports_in_quick_succession_are_one_step() -> None:
    flow = RadioFlow(0.05)
    for i in range(10):
        flow.take(10, 0.01 * i)
    assert flow.share(0.1) == pytest.approx(0.75)


def test_a_radio_that_falls_silent_is_gone() -> None:
    flow = RadioFlow(0.05)
    now_s = report(flow, 0, 20)
    assert flow.share(now_s + 9.9) < 0.1
    assert flow.share(now_s + 10.1) == 1.0
    flow.take(10, now_s + 20.0)
    assert flow.share(now_s + 20.0) == pytest.approx(0.75)


def sent_in(endpoint: Endpoint, taken: list[int], begin_s: float, duration_s: float) -> int:
    """Bytes that a line with more to send than it takes puts on the wire."""
    taken.clear()
    for i in range(round(duration_s * 10)):
        for _ in range(100):
            endpoint.send(PACKET, 1, 1)
        endpoint.flush(begin_s + 0.1 * i)
    return sum(taken)


def test_a_line_keeps_to_what_its_radio_passes_on() -> None:
    taken: list[int] = []

    def transmit(data: bytes, now_s: float) -> int:
        taken.append(len(data))
        return len(data)

    endpoint = Endpoint("radio", PX4, transmit, bytes_per_s=LINE)
    assert sent_in(endpoint, taken, 0.0, 10.0) == pytest.approx(10.0 * LINE, rel=0.05)
    for i in range(5):
        endpoint.radio_status(20, 10.0 + 0.5 * i)
    share = 0.75**5
    assert endpoint.bytes_per_s == pytest.approx(share * LINE) and endpoint.line_bytes_per_s == LINE
    assert sent_in(endpoint, taken, 12.5, 9.0) == pytest.approx(9.0 * share * LINE, rel=0.1)
    assert endpoint.backlog <= endpoint.bytes_per_s, "what waits is not older than a second"
    sent_in(endpoint, taken, 21.5, 2.0)
    assert endpoint.bytes_per_s == LINE, "silent for 10 s"


def test_a_network_has_no_such_radio() -> None:
    endpoint = Endpoint("udp", PX4, lambda data, now_s: len(data))
    endpoint.radio_status(0, 0.0)
    assert endpoint.bytes_per_s == FAST_BYTES_PER_S


@pytest.mark.parametrize("signing", ["", "&signing=require"])
def test_the_reports_of_a_link_count_and_stand_in_its_health(signing: str) -> None:
    link = MemoryLink(f"memory:radio?rate=5760{signing}")
    status = mavlink.MAVLink_radio_status_message(200, 190, 15, 20, 20, 0, 0)
    for i in range(3):
        link.to_vessel(frame(pack(status), i, 51, 68))
        link.receive(0.5 * i)
    (endpoint,) = link.endpoints
    assert endpoint.bytes_per_s == pytest.approx(0.75**3 * LINE)
    assert "radio passes on 2430 of 5760 bytes/s" in link.health(1.5).text
    assert endpoint.last_heard_s is None
