"""Thrusters that point where the planned path will need them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.allocation.allocator import Allocator
from companion.allocation.foresight import Foresight, ThrusterPlan
from companion.allocation.geometry import thrusters_of
from companion.allocation.pseudo_inverse import PseudoInverse
from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import Allocation, Wrench
from companion.core.setpoint import PATH_STEP_S
from companion.params.store import Parameters

ABOAT, REVOLT = load(find("aboat")), load(find("revolt"))
DT_S, STEPS, SPEED_MPS = 0.1, 10, 0.7
BEFORE, BEND, AFTER = Wrench(144.0, 20.0, -7.0), Wrench(39.0, -160.0, -149.0), Wrench(85.0, -12.0, 43.0)
# The corner of 90° that ÅBOAT's plan asks for with the wind behind: the bow is pushed out of the turn at first.
CORNER = [
    (0.0, BEFORE),
    (2.0, BEFORE),
    (4.0, Wrench(151.0, 65.0, -24.0)),
    (5.5, Wrench(50.0, 44.0, -75.0)),
    (7.3, BEND),
    (8.5, Wrench(62.0, -95.0, -59.0)),
    (10.3, AFTER),
    (14.0, Wrench(82.0, -27.0, 17.0)),
]


def corner(t_s: float) -> Wrench:
    """The demand at that time; the last one for good."""
    times = [t for t, _ in CORNER]
    values = [(w.surge_n, w.sway_n, w.yaw_nm) for _, w in CORNER]
    x, y, n = (float(np.interp(t_s, times, [value[i] for value in values])) for i in range(3))
    return Wrench(x, y, n)


def ahead_of(t_s: float) -> tuple[Wrench, ...]:
    return tuple(corner(t_s + k * PATH_STEP_S) for k in range(1, STEPS + 1))


def sailed(ahead: Callable[[float], tuple[Wrench, ...]]) -> list[tuple[Wrench, Allocation]]:
    allocator = Allocator(ABOAT, Parameters(ABOAT.parameters))
    found = []
    for i in range(160):
        t_s = i * DT_S
        wanted = corner(t_s)
        found.append((wanted, allocator.update(wanted, DT_S, SPEED_MPS, True, ahead(t_s))))
    return found[10:]


def worst_miss(run: list[tuple[Wrench, Allocation]]) -> float:
    """The largest part of the wrench that was not given, as a share of the limits."""
    x, y, n = ABOAT.limits.surge_n, ABOAT.limits.sway_n, ABOAT.limits.yaw_nm
    return max(
        math.hypot(
            (w.surge_n - a.achieved.surge_n) / x, (w.sway_n - a.achieved.sway_n) / y, (w.yaw_nm - a.achieved.yaw_nm) / n
        )
        for w, a in run
    )


def moved_n(run: list[tuple[Wrench, Allocation]]) -> float:
    """How much all forces change."""
    return sum(
        abs(late.force_n - early.force_n)
        for (_, before), (_, after) in itertools.pairwise(run)
        for early, late in zip(before.thrusters, after.thrusters, strict=True)
    )


def test_a_corner_gets_more_of_its_wrench_by_quieter_thrust() -> None:
    blind, seeing = sailed(lambda _: ()), sailed(ahead_of)
    assert worst_miss(seeing) < 0.7 * worst_miss(blind)
    assert moved_n(seeing) < 0.95 * moved_n(blind)


def test_on_a_leg_there_is_nothing_to_foresee() -> None:
    foresight, inverse = foresight_of(ABOAT)
    assert foresight.update([BEFORE] * 11, inverse, (), [72.0, 73.0], [0.08, 0.16], DT_S) is None


def foresight_of(config: VesselConfig, failed: frozenset[int] = frozenset()) -> tuple[Foresight, PseudoInverse]:
    thrusters = thrusters_of(config)
    scales = config.limits.surge_n, config.limits.sway_n, config.limits.yaw_nm
    inverse = PseudoInverse(thrusters, scales)
    inverse.refresh(failed)
    return Foresight(thrusters, scales, PATH_STEP_S), inverse


def test_a_thruster_that_has_failed_is_given_nothing_to_do() -> None:
    failed = frozenset({1})
    foresight, inverse = foresight_of(ABOAT, failed)
    for i in range(10):
        demands = [corner(5.0 + i * DT_S), *ahead_of(5.0 + i * DT_S)]
        found = foresight.update(demands, inverse, failed, [40.0, 0.0], [0.1, 0.3], DT_S)
        assert found is not None
        assert found.forces_n[1] == pytest.approx(0.0, abs=1.0e-6)


finite = st.floats(-1.0, 1.0)
demand = st.builds(lambda x, y, n: Wrench(400.0 * x, 300.0 * y, 350.0 * n), finite, finite, finite)


@given(st.lists(demand, min_size=2, max_size=11), st.lists(st.floats(-3.1, 3.1), min_size=3, max_size=3), st.booleans())
def test_whatever_is_demanded_limits_and_rates_are_kept(
    demands: list[Wrench], azimuths_rad: list[float], of_revolt: bool
) -> None:
    config = REVOLT if of_revolt else ABOAT
    thrusters = thrusters_of(config)
    foresight, inverse = foresight_of(config)
    forces_n = [0.0] * len(thrusters)
    azimuths = [
        t.sectors.nearest(a, 0.0) if t.turns else t.rest_rad for a, t in zip(azimuths_rad, thrusters, strict=False)
    ]
    for _ in range(3):
        found = foresight.update(demands, inverse, (), forces_n, azimuths, DT_S)
        if found is None:
            return
        for i, t in enumerate(thrusters):
            assert t.min_n - 1.0e-6 <= found.forces_n[i] <= t.max_n + 1.0e-6
            if t.turns:
                assert abs(found.azimuths_rad[i] - azimuths[i]) <= t.azimuth_rate_radps * DT_S + 1.0e-6
                assert t.sectors.low_rad - 1.0e-6 <= found.azimuths_rad[i] <= t.sectors.high_rad + 1.0e-6
            else:
                assert found.azimuths_rad[i] == azimuths[i]
        forces_n, azimuths = list(found.forces_n), list(found.azimuths_rad)


def test_a_solution_that_is_moved_on_stays_near_the_next() -> None:
    """Each cycle begins at the last one's solution: from a steady demand ahead it does not wander."""
    foresight, inverse = foresight_of(ABOAT)
    last: ThrusterPlan | None = None
    forces_n, azimuths = [30.0, 30.0], [0.0, 0.0]
    for _ in range(80):
        found = foresight.update([BEND] * 11, inverse, (), forces_n, azimuths, DT_S)
        if found is None:
            break
        last = found
        forces_n, azimuths = list(found.forces_n), list(found.azimuths_rad)
    assert last is not None
    ideal = inverse.forces_n((BEND.surge_n, BEND.sway_n, BEND.yaw_nm))
    for (x, y), azimuth in zip(ideal, last.azimuths_rad, strict=True):
        assert abs(math.remainder(math.atan2(y, x) - azimuth, math.tau)) < 0.35
