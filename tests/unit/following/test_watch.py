"""When data count as lost: the rule by itself, and how often chance alone trips it."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from companion.core.readings import LeaderState, Wish
from companion.following.watch import LeaderWatch, Rhythm
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST


def state(t_s: float, wish: Wish | None = None, system: int = 7, placed: bool = True) -> LeaderState:
    return LeaderState(t_s, t_s, "mavlink:7", system, 63.0 if placed else None, 10.0 if placed else None, wish=wish)


def leads(_system_id: int) -> bool:
    return True


def lost_after_s(interval_s: float, wish: Wish | None, tick_s: float, **parameters: float) -> float:
    """From the last position of a leader that fell silent to the tick at which that counts."""
    watch = LeaderWatch(Parameters(parameters), leads)
    sent = 0
    for n in range(1, 1000):
        now_s = n * tick_s
        while sent * interval_s <= min(now_s, 10.0):
            watch.heard(state(sent * interval_s, wish))
            sent += 1
        nav = replace(AT_REST, t_s=now_s)
        watch.update(nav, now_s)
        if now_s > 10.0 and watch.fault(nav, now_s) is not None:
            return now_s - (sent - 1) * interval_s
    raise AssertionError("never")


@pytest.mark.parametrize("tick_s", [0.05, 0.1, 0.2])
@pytest.mark.parametrize(
    ("interval_s", "wish", "at_most_s"),
    [(0.05, Wish.NONE, 0.9), (0.05, None, 0.9), (0.25, None, 0.9), (1.0, None, 3.0), (1.0, Wish.AUTONOMOUS, 0.9)],
)
def test_lost_in_time_whatever_the_control_rate(
    tick_s: float, interval_s: float, wish: Wish | None, at_most_s: float
) -> None:
    assert at_most_s - 2.0 * tick_s - 1e-9 <= lost_after_s(interval_s, wish, tick_s) <= at_most_s + 1e-9


def test_no_parameter_makes_half_a_second_a_loss() -> None:
    assert lost_after_s(0.05, Wish.NONE, 0.1, FOLL_LOSS_T=0.5) > 0.5


def test_the_rhythm_is_that_of_the_source_not_of_its_losses() -> None:
    draws = random.Random(1)
    rhythm = Rhythm()
    for n in range(2000):
        if draws.random() < 0.5:
            rhythm.see(n * 0.25)
        if n > 40:
            assert rhythm.interval_s is not None and rhythm.interval_s <= 0.5 + 1e-9
    rhythm.see(rhythm.last_s - 1.0)  # overtaken
    assert rhythm.interval_s is not None and rhythm.interval_s > 0.0


def test_two_that_come_together_do_not_shorten_it() -> None:
    rhythm = Rhythm()
    for t_s in (0.0, 1.0, 2.0, 2.02, 3.0, 4.0, 4.01, 5.0, 6.0, 6.03, 7.0):  # MAVSDK, a new target every 2 s
        rhythm.see(t_s)
        assert rhythm.interval_s is None or rhythm.interval_s > 0.9


def test_a_slow_own_receiver_is_no_loss() -> None:
    """SBAS at 1 Hz: its position is nearly a second old before the next comes."""
    watch = LeaderWatch(Parameters(), leads)
    for n in range(1, 400):
        now_s = n * 0.1
        watch.heard(state(now_s, Wish.NONE))
        nav = replace(AT_REST, t_s=now_s, position_age_s=(n % 10) * 0.1)
        watch.update(nav, now_s)
        assert n < 25 or watch.fault(nav, now_s) is None
    nav = replace(AT_REST, t_s=now_s, position_age_s=math.inf)
    assert watch.fault(nav, now_s) == "own position not known"


def test_a_tick_that_comes_late_does_not_make_the_leader_silent() -> None:
    watch = LeaderWatch(Parameters(), leads)
    now_s = 0.0
    for n in range(1, 60):
        now_s += 0.7 if n % 10 == 0 else 0.1
        nav = replace(AT_REST, t_s=now_s, position_age_s=0.0)
        watch.update(nav, now_s)
        assert n < 3 or watch.fault(nav, now_s) is None, "the packets of the delay are read after the tick"
        watch.heard(state(now_s, Wish.NONE))
    for _ in range(12):
        now_s += 0.1
        watch.update(replace(AT_REST, t_s=now_s), now_s)
    assert watch.fault(replace(AT_REST, t_s=now_s), now_s) == "leader silent for 1.2 s"


def test_another_leader_begins_anew() -> None:
    watch = LeaderWatch(Parameters(), leads)
    for n in range(20):
        watch.heard(state(n * 0.05, Wish.AUTONOMOUS))
    watch.heard(state(1.0, None, system=8))
    assert (watch.system_id, watch.wish) == (8, None)
    assert watch.fault(replace(AT_REST, t_s=1.0), 1.0) == "leader has only just been heard"


def trips(limit_s: float, tick_s: float, duration_s: float, seed: int) -> int:
    """Onsets of a fault in so long a time at 20 Hz with half of all messages lost."""
    draws, watch = random.Random(seed), LeaderWatch(Parameters({"FOLL_LOSS_T": limit_s}), leads)
    sent, count, lost = 0, 0, True
    for n in range(1, round(duration_s / tick_s)):
        now_s = n * tick_s
        while sent * 0.05 + 0.02 <= now_s:
            if draws.random() < 0.5:
                watch.heard(state(sent * 0.05 + 0.02, Wish.NONE))
            sent += 1
        nav = replace(AT_REST, t_s=now_s)
        watch.update(nav, now_s)
        before, lost = lost, watch.fault(nav, now_s) is not None
        count += lost and not before
    return count


def expected_trips(limit_s: float, tick_s: float, duration_s: float) -> float:
    """Closed form: after a message received, the run of messages lost must last until the first tick at which the age
    exceeds the rule's."""
    threshold_s = max(0.5, limit_s - tick_s)
    chances = []
    for phase in (0.02, 0.07):  # of the message within 0.1 s
        first_tick_s = next(k * tick_s - phase for k in range(1, 100) if k * tick_s - phase > threshold_s + 1e-9)
        chances.append(0.5 ** math.floor(first_tick_s / 0.05 + 1e-9))
    return 0.5 * 20.0 * duration_s * sum(chances) / 2.0


def test_how_often_half_of_all_messages_lost_trip_it() -> None:
    """As often as runs of losses of that length come by chance, and no more: at the least threshold, where that can be
    counted."""
    counted, expected = trips(0.6, 0.1, 4000.0, seed=5), expected_trips(0.6, 0.1, 4000.0)
    assert 20.0 < expected < 60.0
    assert abs(counted - expected) < 3.0 * math.sqrt(expected)


def test_ten_minutes_of_half_of_all_messages_lost() -> None:
    """At the default, by chance 7 runs in 100 of 10 minutes see one onset at 10 Hz, 5 at the 20 Hz of RescueRunner; no
    more can be had of 1.0 s: 19 losses in a row come in 1 run of 90. These seeds see none."""
    assert expected_trips(0.9, 0.1, 600.0) == pytest.approx(0.0687, abs=2e-3)
    assert expected_trips(0.9, 0.05, 600.0) == pytest.approx(0.0458, abs=2e-3)
    assert sum(trips(0.9, 0.1, 600.0, seed) for seed in range(4)) == 0
