"""The counters of the link at both ends."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.following.link_counter import MOST, AcknowledgedCounter, LinkCounter


def stream(counter: LinkCounter, arrives: list[bool], period_s: float = 0.05, t_s: float = 0.0) -> float:
    """Messages every `period_s`, some of which arrive. Returns the time of the last."""
    lost = 0
    for n, does in enumerate(arrives):
        if does:
            counter.heard(t_s + n * period_s, lost)
            lost = 0
        else:
            lost += 1
    return t_s + (len(arrives) - 1) * period_s


def test_a_good_link_stays_at_zero() -> None:
    counter = LinkCounter()
    end_s = stream(counter, [True] * 100)
    assert counter.value(end_s) == 0 and counter.value(end_s + 0.07) == 0
    assert counter.interval_s == pytest.approx(0.05)


def test_it_follows_the_thesis_message_by_message() -> None:
    """Up with each lost, down with each received, within 0 and 40, as one counts by hand."""
    rng = random.Random(5)
    arrives = [True, True] + [rng.random() < 0.55 for _ in range(400)] + [True]
    by_hand = 0
    for does in arrives:
        by_hand = max(0, by_hand - 1) if does else min(MOST, by_hand + 1)
    counter = LinkCounter()
    end_s = stream(counter, arrives)
    assert abs(counter.value(end_s) - by_hand) <= 1  # cut at 40 message by message, or gap by gap


def test_silence_counts_at_the_usual_rate_and_is_not_counted_twice() -> None:
    counter = LinkCounter()
    end_s = stream(counter, [True] * 50)
    assert [counter.value(end_s + 0.05 * n + 0.04) for n in (0, 1, 2, 10)] == [0, 1, 2, 10]
    assert counter.value(end_s + 60.0) == MOST
    counter.heard(end_s + 0.55, 10)  # the ten of the gap, and this one
    assert counter.value(end_s + 0.55) == 9


def test_sequence_numbers_that_may_have_wrapped_are_not_used() -> None:
    counter = LinkCounter()
    end_s = stream(counter, [True] * 50)
    counter.heard(end_s + 12.8, 0)  # 256 messages later
    assert counter.value(end_s + 12.8) == MOST - 1


@pytest.mark.parametrize("period_s", [0.05, 0.25, 1.0])
def test_the_usual_interval_is_the_senders_also_when_half_is_lost(period_s: float) -> None:
    rng = random.Random(2)
    counter = LinkCounter()
    stream(counter, [True] + [rng.random() < 0.5 for _ in range(200)], period_s)
    assert counter.interval_s == pytest.approx(period_s, rel=0.01)


@given(st.lists(st.tuples(st.floats(0.0, 1e3), st.integers(-300, 300)), max_size=50), st.floats(0.0, 1e6))
def test_it_stays_in_its_range(messages: list[tuple[float, int]], later_s: float) -> None:
    counter, now_s = LinkCounter(), 0.0
    for dt_s, lost in messages:
        now_s += dt_s
        counter.heard(now_s, lost)
        assert 0 <= counter.value(now_s) <= MOST
    assert 0 <= counter.value(now_s + later_s) <= MOST


def report(counter: AcknowledgedCounter, sent: int, received: int) -> int:
    for _ in range(sent):
        counter.sent()
    counter.reported(received)
    return counter.value


def test_the_sender_counts_what_was_not_reported() -> None:
    counter = AcknowledgedCounter(21)
    received = 65530  # comes round
    assert report(counter, 21, received) == 0
    for arrived, expected in ((21, 0), (11, 0), (6, 9), (0, 30), (0, 40), (21, 19), (21, 0)):
        received += arrived
        value = report(counter, 21, received & 0xFFFF)
        assert value == expected, (arrived, value)


def test_without_reports_all_that_is_sent_is_lost() -> None:
    counter = AcknowledgedCounter(21)
    report(counter, 21, 5)
    report(counter, 21, 26)
    values = []
    for _ in range(100):
        counter.sent()
        values.append(counter.value)
    assert values[52] == 0 and values[53] == 1 and values[-1] == MOST
    counter.reported(26 + 100)  # only the reports were lost
    assert counter.value == 0


def test_a_follower_that_restarted_is_no_loss() -> None:
    counter = AcknowledgedCounter(21)
    report(counter, 21, 5000)
    assert report(counter, 21, 3) == 0
    assert report(counter, 21, 24) == 0
