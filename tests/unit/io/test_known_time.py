"""The time counts as known only where nothing speaks against it."""

from __future__ import annotations

import pytest

from companion.io.known_time import KnownTime, host_synchronised

S = 1_000_000_000
NOW = 1_780_000_000 * S


@pytest.mark.parametrize(
    ("synchronised", "host", "satellites", "known"),
    [
        (False, NOW, None, None),
        (True, NOW, None, NOW),
        (False, 0, NOW, NOW),
        (True, NOW, NOW + 2 * S, NOW),
        (True, NOW, NOW + 40 * S, None),  # one of them lies
        (False, NOW, NOW - 1024 * 7 * 86_400 * S, None),  # a receiver whose week number has rolled over
        (True, NOW, NOW - 1024 * 7 * 86_400 * S, NOW),
        (True, 0, NOW, NOW),  # synchronised to nonsense
    ],
)
def test_who_is_believed(synchronised: bool, host: int, satellites: int | None, known: int | None) -> None:
    assert KnownTime(lambda: synchronised, lambda: host, lambda: satellites).unix_ns() == known


def test_a_boat_without_a_receiver() -> None:
    assert KnownTime(lambda: False, lambda: NOW).unix_ns() is None
    assert KnownTime(lambda: True, lambda: NOW).unix_ns() == NOW


def test_the_computer_says_whether_its_clock_is_synchronised() -> None:
    assert host_synchronised() in (True, False)
