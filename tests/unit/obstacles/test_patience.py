"""How long a boat goes to and fro before it gives up."""

from __future__ import annotations

from companion.obstacles.patience import Patience
from companion.params.store import Parameters

STUCK_S = Parameters()["WP_STUCK_T"]


def way(length_m: float) -> list[tuple[float, float]]:
    return [(0.0, 0.0), (0.5 * length_m, 0.0), (length_m, 0.0)]


def test_it_is_over_after_twice_the_time_of_the_way_round_and_some_more() -> None:
    patience = Patience(Parameters())
    assert not patience.look(way(100.0), 0.0)
    patience.laid(way(150.0), 1.0, 0.0)
    for t_s in range(1, 1000):
        left_m = 150.0 - 40.0 * (t_s % 2)  # to and fro, never nearer than it was
        patience.laid(way(left_m), 1.0, t_s)
        if patience.look(way(left_m), t_s):
            break
    assert STUCK_S + 300.0 < t_s < STUCK_S + 303.0


def test_getting_nearer_renews_it() -> None:
    patience = Patience(Parameters())
    patience.look(way(100.0), 0.0)
    for k in range(40):
        patience.laid(way(130.0), 1.0, 100.0 * k)
        assert not patience.look(way(99.0 - 2.0 * k), 100.0 * k + 50.0)


def test_a_way_round_as_long_as_it_may_be_is_sailed() -> None:
    patience = Patience(Parameters())
    patience.look(way(100.0), 0.0)
    patience.laid(way(2000.0), 1.0, 0.0)
    assert not any(patience.look(way(2000.0 - t_s), t_s) for t_s in range(2000))


def test_laps_of_a_mission_are_no_going_to_and_fro() -> None:
    patience = Patience(Parameters())
    for t_s in range(5000):
        left_m = 200.0 - t_s % 100  # the next lap is laid every 100 m
        if t_s == 30:
            patience.laid(way(left_m), 1.0, t_s)
        assert not patience.look(way(left_m), t_s)
