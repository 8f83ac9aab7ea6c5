"""Waiting for a time of day."""

import math

import pytest

from companion.mission.tasks import Wait

_DAY_S = 1_795_219_200  # 2026-11-21 00:00:00 UTC
_ANY = -1


def _at(hour: int, minute: int, second: float) -> int:
    return (_DAY_S + hour * 3600 + minute * 60) * 1_000_000_000 + round(second * 1e9)


@pytest.mark.parametrize(
    ("until", "now", "wait_s"),
    [
        ((14, 0, 0), (13, 59, 30.0), 30.0),
        ((14, 0, 0), (13, 59, 59.25), 0.75),
        ((14, 0, 0), (14, 0, 0.0), 0.0),
        ((14, 0, 0), (14, 0, 0.5), 0.0),  # still the second that was meant
        ((14, 0, 0), (14, 0, 5.0), 86395.0),
        ((0, 0, 0), (23, 59, 59.0), 1.0),
        ((_ANY, 0, 0), (13, 20, 0.0), 2400.0),
        ((_ANY, 30, _ANY), (13, 30, 59.0), 0.0),
        ((_ANY, _ANY, 15), (13, 30, 16.0), 59.0),
        ((6, _ANY, _ANY), (5, 0, 0.0), 3600.0),
        ((6, _ANY, 30), (6, 59, 31.0), 86400.0 - (59 * 60 + 1)),
    ],
)
def test_the_next_moment_that_matches(until: tuple[int, int, int], now: tuple[int, int, float], wait_s: float) -> None:
    assert Wait(0, math.inf, until).wait_s(_at(*now)) == pytest.approx(wait_s)


def test_a_plain_duration_needs_no_clock() -> None:
    assert Wait(0, 12.5).wait_s(None) == 12.5


def test_without_a_clock_the_wait_has_no_end() -> None:
    assert Wait(0, math.inf, (14, 0, 0)).wait_s(None) == math.inf
