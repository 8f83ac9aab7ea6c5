"""Power of the allocation in light weather, where a turn of one thruster pays."""

from __future__ import annotations

import math

import pytest

from companion.allocation.allocator import Allocator
from companion.allocation.geometry import thrusters_of
from companion.allocation.thrift import Thrift
from companion.config.vessel import find, load
from companion.core.actuation import Allocation, Wrench
from companion.params.store import Parameters

ABOAT = load(find("aboat"))
DT_S = 0.1


def power(allocation: Allocation) -> float:
    return sum((abs(one.force_n) / 240.0) ** 1.5 for one in allocation.thrusters)


def sailed(econ: float, *stretches: tuple[Wrench, float]) -> list[Allocation]:
    """The allocations of the last stretch, each (demand, seconds)."""
    allocator = Allocator(ABOAT, Parameters({**ABOAT.parameters, "ALLOC_ECON": econ}))
    found: list[Allocation] = []
    for demand, seconds in stretches:
        found = [allocator.update(demand, DT_S) for _ in range(round(seconds / DT_S))]
    return found


def test_pods_that_push_against_each_other_are_turned_round() -> None:
    """After a turn the stern pushes ahead while the bow pushes astern; a steady demand does not part them."""
    stretches = (Wrench(8.0, -12.0, 10.0), 40.0), (Wrench(-11.0, -15.0, -4.0), 90.0)
    usual, thrifty = sailed(0.0, *stretches), sailed(1.0, *stretches)
    assert power(thrifty[-1]) < 0.7 * power(usual[-1])
    assert sum(any(one.limited) for one in thrifty) < 5.0 / DT_S  # while one of them turns


def test_pods_that_waste_much_are_turned_round_without_being_asked_to() -> None:
    """Hold in wind 6 m/s: the bow pushed astern, the stern ahead and aside, for ten minutes, with 1.55 times the power
    that the demand needs."""
    demand = Wrench(-21.0, -30.0, 12.0)
    least = sum((math.hypot(-10.5, -15.0 + side * 12.0 / 3.2) / 240.0) ** 1.5 for side in (1.0, -1.0))
    found = sailed(0.0, (Wrench(8.0, -12.0, 10.0), 40.0), (demand, 60.0))
    assert power(found[50]) > 1.45 * least
    assert power(found[-1]) < 1.05 * least


def test_a_steady_demand_turns_nothing_round() -> None:
    for demand in (Wrench(-13.0, 47.0, -12.0), Wrench(20.0, 3.0, 0.0)):
        found = sailed(1.0, (demand, 60.0), (demand, 60.0))
        azimuths = [[one.azimuth_rad for one in allocation.thrusters] for allocation in found]
        assert max(abs((a[i] or 0.0) - (azimuths[0][i] or 0.0)) for a in azimuths for i in (0, 1)) < 0.02


def test_it_never_costs_the_wrench() -> None:
    for sway_n in (-60.0, -20.0, 0.0, 20.0, 60.0):
        last = sailed(1.0, (Wrench(-11.0, 5.0, 0.0), 40.0), (Wrench(-11.0, sway_n, 5.0), 40.0))[-1]
        assert not any(last.limited)
        assert last.achieved.sway_n == pytest.approx(sway_n, abs=0.5)


def test_a_thruster_rests_between_two_turns() -> None:
    thrift = Thrift(thrusters_of(ABOAT))
    for _ in range(600):
        thrift.see([(-5.0, -5.0), (-5.0, -5.0)], [-8.0, 8.0], [0.8, -1.1], DT_S)
    assert thrift.pays(1, True) and not thrift.pays(0, True)
    thrift.turned_round(1)
    assert not thrift.pays(1, True)
    thrift.reset()
    assert not thrift.pays(1, True)


def test_a_pod_that_turns_round_leaves_the_boat_most_of_the_wrench() -> None:
    """It turned without thrust, and the other one kept the yaw moment by pushing the wrong way: the boat was driven off
    by half a metre."""
    allocator = Allocator(ABOAT, Parameters({**ABOAT.parameters, "ALLOC_ECON": 1.0}))
    for _ in range(round(60.0 / DT_S)):
        allocator.update(Wrench(14.2, -13.2, -3.3), DT_S)
    demand, missing_ns = Wrench(17.8, 7.2, -1.5), 0.0
    for _ in range(round(60.0 / DT_S)):
        achieved = allocator.update(demand, DT_S).achieved
        missing_ns += DT_S * math.hypot(demand.surge_n - achieved.surge_n, demand.sway_n - achieved.sway_n)
    assert missing_ns < 26.0


def test_it_turns_in_a_lull() -> None:
    """In a gust the other one has to leave out all sideways force, which would turn the boat: it lost its heading."""
    thrift = Thrift(thrusters_of(ABOAT))
    for _ in range(600):
        thrift.see([(-5.0, -5.0), (-5.0, -5.0)], [-8.0, 8.0], [0.8, -1.1], DT_S)
    thrift.see([(-15.0, -20.0), (-15.0, -20.0)], [-20.0, 20.0], [0.8, -1.1], DT_S)
    assert not thrift.pays(1, True)
    thrift.see([(-5.0, -5.0), (-5.0, -5.0)], [-8.0, 8.0], [0.8, -1.1], DT_S)
    assert thrift.pays(1, True)
