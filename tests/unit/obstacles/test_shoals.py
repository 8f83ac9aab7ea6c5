"""Shoals: foreseen by the slope of the bottom, met, and larger when met again."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest

from companion.core.readings import Depth, DepthAhead
from companion.obstacles.shoals import Shoals
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST

LENGTH_M = 2.0


def shoals(least_m: float = 1.5, length_m: float = LENGTH_M) -> Shoals:
    parameters = Parameters()
    parameters.set("CP_DEPTH_MIN", least_m)
    return Shoals(length_m, parameters)


def sail(watch: Shoals, depths: list[float], from_s: float = 0.0) -> None:
    """North at 1 m/s, a depth each half second."""
    for k, depth_m in enumerate(depths):
        t_s = from_s + 0.5 * k
        nav = replace(AT_REST, north_m=0.5 * k, north_mps=1.0, surge_mps=1.0)
        watch.update(Depth(t_s, "sounder", depth_m), nav, t_s)


def test_the_slope_says_when_it_becomes_shallow() -> None:
    watch = shoals()
    sail(watch, [6.0 - 0.1 * k for k in range(20)])  # 0.2 m for each metre; 4.1 m deep at the end
    assert watch.way_m == pytest.approx((4.1 - 1.5) / 0.2 - 0.5 * LENGTH_M, rel=0.05) and not watch.circles


def test_a_long_boat_turns_back_when_its_bow_comes_to_the_shoal() -> None:
    """Below its transducer there is 1 m more than the least. Once it went on until that was gone."""
    depths = [4.7 - 0.1 * k for k in range(23)]
    short, long = shoals(), shoals(length_m=12.0)
    sail(short, depths)
    sail(long, depths)
    assert not short.circles and long.circles
    assert long.shallow_m == pytest.approx(1.5, abs=0.15), "below the bow"


def test_a_boat_that_cannot_stop_meets_a_shoal_while_it_can_turn_away() -> None:
    """It was told at the edge, and drove itself on over the bank while it turned. 1.5 m are left 21.5 m to the north,
    for the transducer half a length later."""
    depths = [6.0 - 0.1 * k for k in range(40)]
    reverses, parameters = shoals(), Parameters()
    parameters.set("CP_DEPTH_MIN", 1.5)
    coasts = Shoals(LENGTH_M, parameters, coasts=True)
    sail(reverses, depths)
    sail(coasts, depths)
    [(north_m, _, radius_m)] = coasts.circles
    assert not reverses.circles and north_m - radius_m == pytest.approx(21.5, abs=0.3)
    assert coasts.shallow_m == 1.5, "the least that is enough"


def test_way_is_left_where_the_bottom_does_not_rise() -> None:
    watch = shoals()
    sail(watch, [3.9 - 0.1 * k for k in range(20)])
    stopped = replace(AT_REST, north_m=9.5)
    watch.update(Depth(10.0, "sounder", 1.9), stopped, 10.0)
    assert watch.way_along_m((1.0, 0.0)) == pytest.approx(1.0, abs=0.1), "at rest too"
    assert watch.way_along_m((math.sqrt(0.5), math.sqrt(0.5))) == pytest.approx(2.0 * math.sqrt(2.0) - 1.0, abs=0.2)
    assert math.isinf(watch.way_along_m((-1.0, 0.0))) and math.isinf(watch.way_along_m((0.0, 1.0)))


def test_a_boat_that_turned_on_a_bank_may_leave_it() -> None:
    """It came round the bank from the east, was set onto it from the west, and lies there with its bow to the west. By
    the depths along its course alone, the bottom would rise to the west as well: it lay there for two minutes."""
    way = (
        (62.8, -7.6), (61.3, -8.0), (59.9, -8.3), (59.3, -8.9), (59.4, -9.9), (60.2, -11.3), (61.4, -12.5), (62.8, -13.2),
        (64.4, -13.6), (65.7, -13.5), (66.7, -13.0), (67.2, -12.5), (66.9, -12.1), (66.6, -11.8), (66.5, -11.5), (66.6, -11.8),
    )  # fmt: skip

    def bottom_m(north_m: float, east_m: float) -> float:
        return 0.48 * math.hypot(north_m - 66.4, east_m + 10.1)

    watch, t_s = shoals(1.2, 1.4), 0.0
    for (n0, e0), (n1, e1) in itertools.pairwise(way):
        for share in (0.0, 0.25, 0.5, 0.75):
            t_s += 0.5
            north_m, east_m = n0 + share * (n1 - n0), e0 + share * (e1 - e0)
            nav = replace(AT_REST, north_m=north_m, east_m=east_m, north_mps=0.5 * (n1 - n0), east_mps=0.5 * (e1 - e0))
            watch.update(Depth(t_s, "sounder", bottom_m(north_m, east_m)), nav, t_s)
    assert watch.shallow_m is not None and math.isinf(watch.way_along_m((0.0, -1.0)))


def test_a_level_bottom_and_a_parameter_of_0_ask_for_nothing() -> None:
    level, off = shoals(), shoals(0.0)
    sail(level, [6.0] * 30)
    sail(off, [0.2] * 30)
    assert math.isinf(level.way_m) and math.isinf(off.way_m) and not level.circles and not off.circles


def test_a_shoal_is_ahead_and_larger_when_it_is_met_again() -> None:
    watch = shoals()
    sail(watch, [3.0, 1.0, 1.0, 1.0])
    [(north_m, east_m, first_m)] = watch.circles
    assert math.hypot(north_m - 1.0, east_m) == pytest.approx(first_m) and north_m > 1.0 + 0.9 * first_m
    sail(watch, [3.0, 1.0, 1.0, 1.0], from_s=10.0)
    assert max(radius_m for _, _, radius_m in watch.circles) > first_m


def test_a_boat_that_turns_at_the_edge_meets_the_shoal_once() -> None:
    """The depth came and went as it stopped. Twice as large within a second, the shoal took a berth that lay beyond."""
    watch = shoals()
    sail(watch, [3.0, 1.0, 1.0, 3.0, 1.0, 1.0, 3.0, 1.0, 1.0])
    assert len({radius_m for _, _, radius_m in watch.circles}) == 1


def test_one_echo_is_no_shoal() -> None:
    watch = shoals()
    sail(watch, [3.0, 0.3, 3.0, 3.0])
    assert not watch.circles


def test_a_sounder_that_looks_ahead_puts_the_shoal_there() -> None:
    watch = shoals()
    nav = replace(AT_REST, yaw_rad=0.5 * math.pi)
    watch.take_ahead(DepthAhead(0.0, "sonar", 1.0, 12.0), nav, 0.0)
    assert not watch.circles
    watch.take_ahead(DepthAhead(0.5, "sonar", 1.1, 12.0), nav, 0.5)
    watch.take_ahead(DepthAhead(1.0, "sonar", 4.0, 12.0), nav, 1.0)
    [(north_m, east_m, _)] = watch.circles
    assert (north_m, east_m) == pytest.approx((0.0, 12.0))


@pytest.mark.parametrize(
    ("depths_m", "every_s", "shoals_found"),
    [
        ((4.0, 1.0, 4.0, 4.0), 1.0, 0),
        ((4.0, 1.0, 1.1, 4.0, 4.0), 0.1, 0),
        ((1.0, 4.0, 1.0, 4.0, 1.0), 1.0, 0),
        ((1.0, 1.0), 6.0, 0),
        ((4.0, 1.0, 1.1, 4.0), 1.0, 2),
    ],
    ids=["one fish", "one fish at 10 Hz", "a fish now and then", "far apart", "a bank"],
)
def test_one_echo_ahead_is_no_shoal(depths_m: tuple[float, ...], every_s: float, shoals_found: int) -> None:
    """The shoal stayed for the whole voyage, and closed narrow water. A bank counts from its first reading."""
    watch = shoals()
    for k, depth_m in enumerate(depths_m):
        nav = replace(AT_REST, north_m=3.0 * k)
        watch.take_ahead(DepthAhead(k * every_s, "sonar", depth_m, 12.0), nav, k * every_s)
    assert len(watch.circles) == shoals_found
    assert not shoals_found or watch.circles[0][:2] == pytest.approx((15.0, 0.0))


def test_echoes_of_two_sounders_do_not_count_together() -> None:
    watch = shoals()
    for t_s, source in ((0.0, "port"), (0.5, "starboard")):
        watch.take_ahead(DepthAhead(t_s, source, 1.0, 12.0), AT_REST, t_s)
    assert not watch.circles


def at_1_hz(watch: Shoals, *depths_m: float) -> None:
    """At rest with ten ticks to each reading."""
    for tick in range(10 * len(depths_m)):
        watch.update(Depth(float(tick // 10), "sounder", depths_m[tick // 10]), AT_REST, 0.1 * tick)


def test_one_reading_of_a_slow_sounder_is_no_shoal() -> None:
    """A fish under the transducer for one reading at 1 Hz: the boat turned back."""
    fish, bank = shoals(), shoals()
    at_1_hz(fish, 5.0, 0.6, 5.0)
    at_1_hz(bank, 5.0, 0.6, 0.7)
    assert not fish.circles and bank.circles


def test_a_shallow_reading_after_which_none_comes_is_a_shoal() -> None:
    watch = shoals()
    for tick in range(30):
        watch.update(Depth(0.0, "sounder", 0.6), AT_REST, 0.1 * tick)
    assert watch.circles


def test_after_a_jump_of_the_position_the_slope_begins_anew() -> None:
    """Depths before it and after it made a slope that is nowhere."""
    watch = shoals()
    sail(watch, [6.0 - 0.1 * k for k in range(20)])
    assert math.isfinite(watch.way_m)
    watch.clear()
    assert math.isinf(watch.way_m) and math.isinf(watch.way_along_m((1.0, 0.0)))
    watch.update(Depth(10.0, "sounder", 4.0), replace(AT_REST, north_m=40.0, north_mps=1.0), 10.0)
    assert math.isinf(watch.way_m)
