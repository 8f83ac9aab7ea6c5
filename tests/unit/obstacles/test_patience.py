"""How long a boat goes to and fro before it gives up."""

from __future__ import annotations

import math

import pytest

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
        patience.laid(way(101.0 - 2.0 * k), 1.0, 300.0 * k)
        assert not patience.look(way(99.0 - 2.0 * k), 300.0 * k + 250.0)


def sails_round(direct_m: float, longer_m: float, won_m: float = 0.0) -> float:
    """How far a boat sails that finds, each time that it has sailed 20 m, that its way is `longer_m` longer, and each
    time has won `won_m`; infinite where that is no reason to give up."""
    patience, t_s, sailed_m, least_m = Patience(Parameters()), 0.0, 0.0, direct_m
    left_m = direct_m + 20.0
    patience.look(way(direct_m), t_s)
    patience.laid(way(left_m), 10.0, t_s)
    while least_m > won_m and sailed_m < 5000.0:
        t_s, sailed_m, left_m = t_s + 2.0, sailed_m + 20.0, left_m - 20.0
        if won_m > 0.0:
            least_m = left_m = least_m - won_m
        if patience.look(way(left_m), t_s):
            return sailed_m
        left_m += longer_m
        patience.laid(way(left_m), 10.0, t_s)
    return math.inf


def test_a_way_that_becomes_longer_and_longer_is_given_up() -> None:
    """Round a harbour that it does not fit, side after side, a boat went to and fro until the operator came."""
    assert sails_round(100.0, 20.0) == pytest.approx(300.0, abs=25.0), "80 m and twice 100 m of surprises"
    assert sails_round(2000.0, 20.0) == pytest.approx(400.0, abs=25.0), "at most 80 m and twice 150 m"
    assert sails_round(10.0, 20.0) == pytest.approx(120.0, abs=25.0)


def test_what_is_won_pays_for_what_is_longer() -> None:
    """Many small ways round on a long route."""
    assert math.isinf(sails_round(1000.0, 15.0, won_m=20.0))


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
