"""A follower that its leader leaves behind says so once, and again when it catches up."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from companion.core.events import EventLog
from companion.following.keeping_up import KeepingUp


class Wake:
    """A follower behind its leader, ten looks a second."""

    def __init__(self) -> None:
        self.events = EventLog()
        self.watch = KeepingUp(self.events)
        self.now_s = 0.0
        self.texts: list[str] = []

    def sail(self, duration_s: float, off_m: Callable[[float], float], wanted_mps: float, made_mps: float) -> list[str]:
        """What is said meanwhile. `off_m`: by the time since the begin of the call."""
        before, begin_s = len(self.texts), self.now_s
        while self.now_s < begin_s + duration_s:
            self.watch.update(off_m(self.now_s - begin_s), wanted_mps, made_mps, self.now_s)
            self.texts.extend(event.text for event in self.events.drain())
            self.now_s += 0.1
        return self.texts[before:]


@pytest.fixture
def wake() -> Wake:
    return Wake()


def test_it_says_so_once_and_when_it_catches_up(wake: Wake) -> None:
    assert wake.sail(60.0, lambda t_s: 0.15 * t_s, 1.2, 0.55) == ["Follow: cannot keep up, 5 m behind"]
    assert wake.sail(60.0, lambda t_s: 9.0 + 0.15 * t_s, 1.2, 0.55) == []
    assert wake.sail(60.0, lambda t_s: 18.0 - 0.2 * t_s, 1.2, 1.15) == ["Follow: catching up"]


@pytest.mark.parametrize(
    ("off_m", "made_mps"),
    [
        (lambda t_s: 20.0 - 0.05 * t_s, 0.55),
        (lambda t_s: 10.0 + 0.15 * t_s, 1.15),
        (lambda t_s: 0.02 * t_s, 0.55),
        (lambda _: 30.0, 0.55),
    ],
    ids=["it draws nearer", "it has the speed that it wants", "it is near", "it stays as far"],
)
def test_a_boat_that_keeps_up_says_nothing(wake: Wake, off_m: Callable[[float], float], made_mps: float) -> None:
    assert wake.sail(90.0, off_m, 1.2, made_mps) == []


def test_a_leader_that_has_just_gone_off_is_no_reason(wake: Wake) -> None:
    assert wake.sail(20.0, lambda t_s: 5.0 + t_s, 6.0, 3.0) == []
    assert wake.sail(60.0, lambda t_s: max(0.0, 25.0 - 0.5 * t_s), 6.0, 5.8) == []


def test_after_a_pause_it_begins_anew(wake: Wake) -> None:
    wake.sail(25.0, lambda t_s: 5.0 + 0.2 * t_s, 1.2, 0.55)
    wake.now_s += 5.0
    assert wake.sail(25.0, lambda t_s: 11.0 + 0.2 * t_s, 1.2, 0.55) == []
