"""Allocation as the loop sees it: what it achieves, how it turns, what it says falls short."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.allocation.allocator import Allocator
from companion.allocation.astray import Astray
from companion.config.devices import ThrusterConfig
from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.core.angles import wrap_pi
from companion.params.store import Parameters
from tests.unit.control.simple_boat import REVOLT

ABOAT = load(find("aboat"))
DT_S = 0.1


def allocator(config: VesselConfig = REVOLT) -> Allocator:
    return Allocator(config, Parameters())


def settle(a: Allocator, wrench: Wrench, cycles: int = 30) -> Allocation:
    for _ in range(cycles):
        result = a.update(wrench, DT_S)
    return result


def wrench_of(config: VesselConfig, allocation: Allocation) -> tuple[float, float, float]:
    x = y = n = 0.0
    for t, command in zip(config.thrusters, allocation.thrusters, strict=True):
        azimuth = t.azimuth_rad if command.azimuth_rad is None else command.azimuth_rad
        c, s = math.cos(azimuth), math.sin(azimuth)
        x, y, n = x + c * command.force_n, y + s * command.force_n, n + (t.x_m * s - t.y_m * c) * command.force_n
    return x, y, n


def axes(wrench: Wrench) -> tuple[float, float, float]:
    return wrench.surge_n, wrench.sway_n, wrench.yaw_nm


@pytest.mark.parametrize("kind", [0, 1])
@pytest.mark.parametrize(
    "demand",
    [
        (30.0, 0.0, 0.0),
        (-30.0, 0.0, 0.0),
        (0.0, 12.0, 0.0),
        (0.0, -10.0, 0.0),
        (0.0, 0.0, 20.0),
        (10.0, 5.0, -10.0),
        (-5.0, -5.0, 5.0),
    ],
)
def test_a_feasible_demand_is_given(kind: int, demand: tuple[float, float, float]) -> None:
    result = settle(Allocator(REVOLT, Parameters({"ALLOC_KIND": kind})), Wrench(*demand))
    assert axes(result.achieved) == pytest.approx(demand, abs=0.15)
    assert axes(result.achieved) == pytest.approx(wrench_of(REVOLT, result), abs=1e-9)
    assert result.limited == (False, False, False)


def test_pods_ahead_and_at_rest_answer_a_sideways_demand_at_once() -> None:
    a = allocator()
    ahead = tuple(ThrusterCommand(0.0, 0.0, 0.0 if t.kind == "azimuth" else None) for t in REVOLT.thrusters)
    a.direct(ahead, dt_s=10.0)
    results = [a.update(Wrench(0.0, 12.0, 0.0), DT_S) for _ in range(10)]
    assert results[2].achieved.sway_n > 6.0
    assert any(abs(r.achieved.sway_n - 12.0) < 0.2 and abs(r.achieved.yaw_nm) < 0.5 for r in results)


def test_least_power_is_used() -> None:
    result = settle(allocator(), Wrench(40.0, 0.0, 0.0), 60)
    port, starboard, bow = result.thrusters
    assert port.force_n == pytest.approx(20.0, abs=0.5) and starboard.force_n == pytest.approx(20.0, abs=0.5)
    assert abs(port.azimuth_rad or 0.0) < math.radians(3.0) and abs(bow.force_n) < 0.3


def test_a_steady_demand_gives_steady_thrusters() -> None:
    for demand in [(-40.0, 0.0, 0.0), (20.0, 8.0, 5.0), (0.0, 0.0, -20.0)]:
        a = allocator()
        settle(a, Wrench(*demand), 60)
        before, after = a.update(Wrench(*demand), DT_S), a.update(Wrench(*demand), DT_S)
        for p, q in zip(before.thrusters, after.thrusters, strict=True):
            assert p.force_n == pytest.approx(q.force_n, abs=0.05)
            assert abs(wrap_pi((p.azimuth_rad or 0.0) - (q.azimuth_rad or 0.0))) < math.radians(1.0)


def test_a_small_reversal_reverses_the_thrust_and_leaves_the_pods() -> None:
    a = allocator()
    first = settle(a, Wrench(10.0, 0.0, 0.0), 60)
    second = settle(a, Wrench(-10.0, 0.0, 0.0), 10)
    for p, q in zip(first.thrusters[:2], second.thrusters[:2], strict=True):
        assert p.force_n > 4.0 and q.force_n < -4.0
        assert abs(wrap_pi((p.azimuth_rad or 0.0) - (q.azimuth_rad or 0.0))) < math.radians(45.0)


def test_beyond_the_limits_the_short_axes_are_marked() -> None:
    result = settle(allocator(), Wrench(0.0, 0.0, 32.0), 40)
    assert result.limited == (False, False, False)
    result = settle(allocator(), Wrench(200.0, 0.0, 0.0), 40)
    assert result.limited[0] and result.achieved.surge_n == pytest.approx(50.0, abs=1.0)


def test_rates_are_kept() -> None:
    a = allocator()
    last = a.update(Wrench(0.0, 0.0, 0.0), DT_S)
    for k in range(60):
        now = a.update(Wrench(50.0 * (-1) ** (k // 5), 20.0 * (-1) ** (k // 3), 30.0 * (-1) ** (k // 4)), DT_S)
        for t, p, q in zip(REVOLT.thrusters, last.thrusters, now.thrusters, strict=True):
            assert t.min_n - 1e-9 <= q.force_n <= t.max_n + 1e-9
            assert abs(q.force_n - p.force_n) <= t.force_rate_nps * DT_S + 1e-9
            if q.azimuth_rad is not None and p.azimuth_rad is not None:
                assert abs(wrap_pi(q.azimuth_rad - p.azimuth_rad)) <= t.azimuth_rate_radps * DT_S + 1e-9
        last = now


def test_past_astern_an_azimuth_takes_the_shorter_way() -> None:
    a = allocator()
    pods = tuple(
        ThrusterCommand(0.0, 0.4, math.radians(179.0) if t.kind == "azimuth" else None) for t in REVOLT.thrusters
    )
    a.direct(pods, dt_s=10.0)
    turned = tuple(replace(c, azimuth_rad=math.radians(-179.0) if c.azimuth_rad is not None else None) for c in pods)
    result = a.direct(turned, dt_s=DT_S)
    assert result.thrusters[0].azimuth_rad == pytest.approx(math.radians(-179.0)), "two degrees in one cycle, not 358"
    force = a.update(Wrench(-8.0, -0.5, 0.7), DT_S)
    assert abs(wrap_pi((force.thrusters[0].azimuth_rad or 0.0) - math.pi)) < math.radians(17.0)


def test_the_others_make_up_for_a_failed_thruster() -> None:
    a = allocator()
    a.set_failed(2, True)
    result = settle(a, Wrench(10.0, 0.0, 5.0))
    assert result.thrusters[2].throttle == 0.0
    assert result.achieved.surge_n == pytest.approx(10.0, abs=0.3) and result.achieved.yaw_nm == pytest.approx(
        5.0, abs=0.3
    )
    a.set_failed(2, False)
    assert settle(a, Wrench(0.0, 10.0, 0.0)).thrusters[2].force_n > 2.0
    a.set_failed(99, True)


def test_neutral_keeps_the_azimuths() -> None:
    a = allocator()
    settle(a, Wrench(0.0, 12.0, 0.0))
    before = a.update(Wrench(0.0, 12.0, 0.0), DT_S)
    rest = a.neutral()
    assert all(t.throttle == 0.0 and t.force_n == 0.0 for t in rest.thrusters)
    assert [t.azimuth_rad for t in rest.thrusters] == [t.azimuth_rad for t in before.thrusters]
    assert rest.achieved == Wrench(0.0, 0.0, 0.0)


def test_direct_takes_throttle_and_azimuth_within_rates() -> None:
    a = allocator()
    demand = tuple(
        ThrusterCommand(0.0, 0.5, math.radians(30.0) if t.kind == "azimuth" else None) for t in REVOLT.thrusters
    )
    first = a.direct(demand)
    assert first.thrusters[0].force_n == pytest.approx(5.0), "50 N/s for one period"
    for _ in range(20):
        result = a.direct(demand)
    assert [t.throttle for t in result.thrusters] == pytest.approx([0.5, 0.5, 0.5])
    assert result.thrusters[0].azimuth_rad == pytest.approx(math.radians(30.0))
    assert axes(result.achieved) == pytest.approx(wrench_of(REVOLT, result))


@pytest.mark.parametrize("demand", [(), (ThrusterCommand(math.nan, math.nan, math.nan),) * 3])
def test_direct_with_non_finite_demands_is_no_thrust(demand: tuple[ThrusterCommand, ...]) -> None:
    assert all(t.throttle == 0.0 for t in allocator().direct(demand).thrusters)


def test_a_non_finite_demand_counts_as_none() -> None:
    result = allocator().update(Wrench(math.nan, 0.0, math.inf), DT_S)
    assert axes(result.achieved) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def azimuth(
    name: str, x_m: float, y_m: float = 0.0, min_n: float = -60.0, sector_deg: float | None = None
) -> ThrusterConfig:
    return ThrusterConfig(
        name, "azimuth", x_m, y_m, 100.0, min_n, 100.0, 100.0, 200.0,
        azimuth_rate_radps=1.0, azimuth_min_rad=None if sector_deg is None else math.radians(-sector_deg),
        azimuth_max_rad=None if sector_deg is None else math.radians(sector_deg),
    )  # fmt: skip


def test_two_azimuths_in_line() -> None:
    boat = replace(
        REVOLT,
        thrusters=(azimuth("stern", -1.6), azimuth("bow", 1.6)),
        limits=replace(REVOLT.limits, surge_n=150.0, sway_n=80.0, yaw_nm=100.0),
    )
    for demand in [(100.0, 0.0, 0.0), (0.0, 40.0, 0.0), (0.0, 0.0, 60.0), (-60.0, 20.0, 10.0)]:
        result = settle(allocator(boat), Wrench(*demand), 80)
        assert axes(result.achieved) == pytest.approx(demand, abs=1.5)


def test_under_way_a_turn_that_changes_sides_does_not_leave_a_thruster_reversed() -> None:
    """A corner: the moment changes sides while the boat hardly needs thrust. Solved tick by tick, the stern's thruster
    reversed for it, and stayed on that side of the demand."""
    a = Allocator(ABOAT, Parameters())
    settle(a, Wrench(80.0, 20.0, 0.0), 40)
    moments = [110.0] * 8 + [110.0 - 22.0 * i for i in range(11)] + [-110.0] * 8 + [0.0] * 20
    for moment in moments:
        result = a.update(Wrench(80.0, 20.0, moment), DT_S, 1.0, planned=True)
        assert all(t.force_n >= -1.0 for t in result.thrusters)
    assert axes(result.achieved) == pytest.approx((80.0, 20.0, 0.0), abs=2.0)
    assert max(t.force_n for t in result.thrusters) < 60.0


def test_under_way_thrusters_on_the_wrong_side_push_while_they_turn_round() -> None:
    """Behind a turn back: both lie far off the demand, where only reverse is of use. They gave nothing until they had
    come round, which took more than two seconds."""
    a = Allocator(ABOAT, Parameters())
    settle(a, Wrench(0.0, -120.0, 0.0), 40)
    turned = [abs(t.azimuth_rad or 0.0) for t in a.update(Wrench(0.0, -120.0, 0.0), DT_S).thrusters]
    assert min(turned) > math.radians(70.0)
    pushes = [a.update(Wrench(40.0, 120.0, 0.0), DT_S, 1.0, planned=True).achieved.sway_n for _ in range(40)]
    assert sum(pushes[:10]) / 10 > 45.0
    assert pushes[-1] == pytest.approx(120.0, abs=15.0)


def test_under_way_thrusters_far_off_their_aim_do_not_push_against_each_other() -> None:
    """A turn against the wind: both lie ahead, hardly any thrust is needed, and a moment with a force aside. One pushed
    astern and one ahead with 90 N each, for 20 N to the side."""
    a = Allocator(ABOAT, Parameters())
    settle(a, Wrench(30.0, -15.0, 0.0), 40)
    for _ in range(12):
        result = a.update(Wrench(-5.0, 45.0, 95.0), DT_S, 1.0, planned=True)
        assert max(abs(t.force_n) for t in result.thrusters) < 75.0
    assert settle(a, Wrench(-5.0, 45.0, 95.0), 40).achieved.yaw_nm == pytest.approx(95.0, abs=5.0)


def test_carried_aside_at_the_start_of_a_path_thrusters_turn_to_the_demand_and_do_not_push_against_each_other() -> None:
    """Wind and current carry the boat to port before it makes way. For the little of the wrench that thrusters ahead
    give at once, the bow's pushed astern and the stern's ahead with 110 and 160 N; then both had to turn round."""
    a = Allocator(ABOAT, Parameters())
    for i in range(16):
        result = a.update(Wrench(26.0 + 6.0 * i, 75.0, -40.0), DT_S, 0.0, planned=True)
        assert min(t.force_n for t in result.thrusters) >= -1.0
    assert axes(result.achieved) == pytest.approx((116.0, 75.0, -40.0), abs=2.0)


def test_slow_in_a_bend_of_a_planned_path_thrusters_may_reverse() -> None:
    """Only a boat that has not made way yet keeps its thrusters aimed without way."""
    a = Allocator(ABOAT, Parameters())
    settle(a, Wrench(20.0, 60.0, 0.0), 40)
    a.update(Wrench(20.0, 60.0, 0.0), DT_S, 1.0, planned=True)
    for _ in range(12):
        result = a.update(Wrench(10.0, -60.0, 0.0), DT_S, 0.0, planned=True)
    assert axes(result.achieved) == pytest.approx((10.0, -60.0, 0.0), abs=1.0)


def test_slow_behind_a_bend_thrusters_that_give_little_turn_to_the_demand() -> None:
    """A boat slow in its current, with one thruster astern and the other aside. Each cycle's solution left them there:
    for eight seconds they gave a tenth of the demand."""
    a = Allocator(ABOAT, Parameters())
    a.update(Wrench(60.0, -160.0, 0.0), DT_S, 1.0, planned=True)
    aside = ThrusterCommand(0.0, 0.0, math.radians(-98.0)), ThrusterCommand(0.0, 0.0, math.radians(66.0))
    a.direct(aside, dt_s=10.0)
    for i in range(35):
        result = a.update(Wrench(140.0, -50.0 - 3.0 * i, 40.0 - i), DT_S, 0.2, planned=True)
    assert axes(result.achieved) == pytest.approx((140.0, -152.0, 6.0), abs=5.0)


def test_a_thruster_that_cannot_reverse_turns_round() -> None:
    boat = replace(REVOLT, thrusters=(azimuth("port", -1.0, -0.5, 0.0), azimuth("starboard", -1.0, 0.5, 0.0)))
    a = allocator(boat)
    settle(a, Wrench(30.0, 0.0, 0.0))
    result = settle(a, Wrench(-30.0, 0.0, 0.0), 80)
    assert result.achieved.surge_n == pytest.approx(-30.0, abs=1.0)


def test_a_single_nozzle_steers_inside_its_sector_and_ignores_sway() -> None:
    boat = replace(
        REVOLT,
        thrusters=(azimuth("jet", -1.6, 0.0, 0.0, 24.0),),
        limits=replace(REVOLT.limits, surge_n=100.0, sway_n=0.0, yaw_nm=40.0),
    )
    a = allocator(boat)
    result = settle(a, Wrench(60.0, 0.0, 20.0), 40)
    assert result.achieved.surge_n == pytest.approx(60.0, abs=2.0) and result.achieved.yaw_nm == pytest.approx(
        20.0, abs=1.0
    )
    assert not result.limited[1]
    hard = settle(a, Wrench(20.0, 0.0, 40.0), 40)
    assert abs(hard.thrusters[0].azimuth_rad or 0.0) <= math.radians(24.0) + 1e-9
    assert hard.achieved.yaw_nm > 20.0


def alone(sector_deg: float | None) -> Allocator:
    thrusters = (azimuth("pod", -1.6, sector_deg=sector_deg),)
    limits = replace(REVOLT.limits, surge_n=90.0, sway_n=0.0, yaw_nm=90.0)
    return allocator(replace(REVOLT, thrusters=thrusters, limits=limits))


def test_a_single_pod_that_lies_astern_turns_round_where_it_is_too_weak() -> None:
    a = alone(None)
    a.direct((ThrusterCommand(0.0, 0.0, math.pi),), dt_s=10.0)
    assert settle(a, Wrench(50.0, 0.0, 0.0)).thrusters[0].force_n == pytest.approx(-50.0, abs=2.0)
    assert settle(a, Wrench(88.0, 0.0, 0.0), 250).achieved.surge_n == pytest.approx(88.0, abs=2.0)


def test_an_outboard_that_is_to_brake_does_not_push_ahead_for_its_moment() -> None:
    """The stop nearest to the force that is asked for lies 120° off it: there it pushed ahead, for as long as the boat
    braked and turned."""
    a = alone(35.0)
    settle(a, Wrench(60.0, 0.0, 60.0), 40)
    result = settle(a, Wrench(-90.0, 0.0, 90.0), 40)
    assert result.achieved.surge_n < -30.0 and result.achieved.yaw_nm > 0.0


def test_strong_pods_across_at_their_stops_turn_round_for_a_small_force_astern() -> None:
    """Thrusters of 1374 N gave none of 65 N astern, for ever: so little was not worth a turn."""
    sides = (("bow", 2.124), ("stern", -2.389))
    pods = tuple(
        replace(azimuth(name, x_m, sector_deg=90.0), max_n=1374.0, min_n=-962.0, force_rate_nps=1e4)
        for name, x_m in sides
    )
    limits = replace(REVOLT.limits, surge_n=2473.0, sway_n=2336.0, yaw_nm=5581.0)
    a = allocator(replace(REVOLT, thrusters=pods, limits=limits))
    across = ThrusterCommand(20.0, 0.0, math.pi / 2)
    a.direct((across, across), dt_s=10.0)
    settle(a, Wrench(0.0, 50.0, -28.0), 20)
    assert settle(a, Wrench(-65.0, 35.0, -10.0), 100).achieved.surge_n == pytest.approx(-65.0, abs=6.0)


def test_an_outboard_that_steers_astern_comes_to_push_ahead() -> None:
    a = alone(40.0)
    settle(a, Wrench(-40.0, 0.0, 60.0), 40)
    result = settle(a, Wrench(80.0, 0.0, 60.0), 60)
    assert result.thrusters[0].force_n > 60.0 and result.achieved.yaw_nm > 40.0


def across(mirrored_deg: float) -> Allocator:
    """The azimuths of ÅBOAT mirrored across the hull, without thrust."""
    a = Allocator(ABOAT, Parameters())
    a.direct(
        (ThrusterCommand(0.0, 0.0, -math.radians(mirrored_deg)), ThrusterCommand(0.0, 0.0, math.radians(mirrored_deg))),
        dt_s=10.0,
    )
    return a


@pytest.mark.parametrize(
    "moment_nm",
    [
        lambda _: -10.0,
        lambda t_s: -4.0 - 13.0 * math.sin(math.tau * t_s / 1.3),
        lambda t_s: 15.0 * math.sin(math.tau * t_s / 1.1),
    ],
    ids=["steady", "a mean in waves", "waves"],
)
def test_across_the_hull_thrusters_turn_to_push_astern_though_there_they_give_the_moment_at_once(
    moment_nm: Callable[[float], float],
) -> None:
    """A boat that slows down before a fence: for the moment its thrusters stayed across, and gave nothing of the force
    for as long as it changed sides, and for eight seconds of a steady one."""
    a = across(57.0)
    turn_s = math.radians(57.0 + 30.0) / ABOAT.thrusters[0].azimuth_rate_radps
    given = [a.update(Wrench(-30.0, 0.0, moment_nm(DT_S * k)), DT_S).achieved.surge_n for k in range(60)]
    late = given[round((turn_s + 0.8) / DT_S) :]
    assert sum(late) / len(late) < -25.0 and max(late) < -12.0


def test_one_thruster_that_is_left_is_not_turned_to_demands_that_it_cannot_give(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of force and moment one azimuth gives a mixture. Turned to that of each moment it swung four times as much, and
    the boat was driven off further."""

    def turns(*_: object) -> bool:
        raise AssertionError("it turns to an aim")

    monkeypatch.setattr(Astray, "update", turns)
    a = across(57.0)
    a.set_failed(0, True)
    settle(a, Wrench(-30.0, 20.0, 15.0), 30)
    a.set_failed(0, False)
    with pytest.raises(AssertionError, match="an aim"):
        settle(a, Wrench(-30.0, 0.0, -10.0), 30)


def test_one_thruster_that_is_left_gives_way_and_moment_though_far_more_is_asked_sideways() -> None:
    """For a force that it did not have, it stayed at its stop for half a minute and gave neither: a boat that turned
    its bow to the weather was driven out of its alarm circle."""
    a = Allocator(ABOAT, Parameters())
    settle(a, Wrench(1.0, 15.0, 2.0), 50)
    a.set_failed(0, True)
    settle(a, Wrench(0.0, 150.0, 12.0), 100)
    settle(a, Wrench(-16.0, 250.0, 30.0), 60)
    achieved = settle(a, Wrench(50.0, 315.0, 35.0), 60).achieved
    assert achieved.surge_n == pytest.approx(50.0, abs=5.0)
    assert achieved.yaw_nm == pytest.approx(35.0, abs=5.0)


def test_on_a_planned_path_the_moment_goes_before_a_force_aside_that_hinders_it() -> None:
    """ReVolt's bow thruster pushes 6 N to port; its stern must push to starboard to turn it there. Of both demands
    together it gave a third of the moment and none of the force, while a stream set it aside."""
    a = allocator()
    given = [a.update(Wrench(38.0, -25.0, -40.0), DT_S, 0.1, planned=True) for _ in range(40)]
    assert all(result.achieved.yaw_nm < -36.0 for result in given[20:]), "and it stays so while both are demanded"
    assert given[-1].limited[1]
    for _ in range(30):
        last = a.update(Wrench(38.0, -16.0, 10.0), DT_S, 0.1, planned=True)
    assert last.achieved.sway_n == pytest.approx(-16.0, abs=1.0)
